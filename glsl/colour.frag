#version 450
#extension GL_GOOGLE_include_directive : require
// Colour of a pixel: straight alpha in, premultiplied out (the blend unit and the resolve need it).
#include "inc/layout.glsl"

layout(location = 0) in vec4 colour;
layout(location = 0) out vec4 pixel;

void main()
{
    vec4 c = push.show == 0u ? colour : push.flat_colour;
    if (push.clamped != 0u) {
        c = clamp(c, 0.0, 1.0);
    }
    pixel = vec4(c.rgb * c.a, c.a);
}
