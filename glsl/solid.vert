#version 450
#extension GL_GOOGLE_include_directive : require
// A vertex of a surface in space.
#include "inc/solid.glsl"

layout(location = 0) in vec4 place;  // position; blend weight
layout(location = 1) in vec4 vector; // normal, or colour when `show` is 5
layout(location = 0) out vec3 normal;
layout(location = 1) out vec3 position;
layout(location = 2) out float weight;

void main()
{
    normal = vector.xyz;
    position = place.xyz;
    weight = place.w;
    gl_Position = push.clip * vec4(place.xyz, 1.0);
}
