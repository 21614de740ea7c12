#version 450
#extension GL_GOOGLE_include_directive : require
// A vertex of a whole refined mesh in a static buffer, the rival in BS05 Fig. 7.
#include "inc/pattern.glsl"

layout(location = 0) in vec4 place;
layout(location = 1) in vec4 vector;
layout(location = 2) in vec4 tint;
layout(location = 0) out vec3 normal;
layout(location = 1) out vec4 colour;

void main()
{
    normal = vector.xyz;
    colour = tint;
    precise vec4 clip = push.clip * vec4(place.xyz, 1.0);
    gl_Position = clip;
}
