#version 450
#extension GL_GOOGLE_include_directive : require
// Colour of a pixel: straight alpha in, premultiplied out (the blend unit and the resolve need it).
#include "inc/layout.glsl"
#include "inc/space.glsl"

layout(location = 0) in vec4 colour;
layout(location = 0) out vec4 pixel;

void main()
{
    vec4 c = push.flat_colour;
    if (push.show == 0u) {
        c = colour;
        if ((push.clamped & 2u) != 0u) {
            c.rgb = c.a > 0.0 ? c.rgb / c.a : vec3(0.0);
        }
        c.rgb = to_srgb(push.clamped >> 4u, c.rgb);
    }
    if ((push.clamped & 1u) != 0u) {
        c = clamp(c, 0.0, 1.0);
    }
    pixel = vec4(c.rgb * c.a, c.a);
}
