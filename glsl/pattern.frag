#version 450
#extension GL_GOOGLE_include_directive : require
// Colour of a pixel of a refined mesh: the same light from either side.
#include "inc/pattern.glsl"

layout(location = 0) in vec3 normal;
layout(location = 1) in vec4 colour;
layout(location = 0) out vec4 pixel;

void main()
{
    vec3 n = normalize(normal);
    vec3 c = colour.rgb;
    if (push.show == 0u) {
        float half_way = 0.5 + 0.5 * dot(n, push.light.xyz);
        c *= 0.1 + 0.9 * half_way * half_way;
    } else if (push.show == 1u) {
        c = 0.5 + 0.5 * n;
    }
    pixel = vec4(clamp(c, 0.0, 1.0), 1.0);
}
