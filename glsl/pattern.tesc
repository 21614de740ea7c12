#version 450
#extension GL_GOOGLE_include_directive : require
// Levels of a coarse triangle in hardware tessellation.
#include "inc/pattern.glsl"

layout(vertices = 1) out;
layout(location = 0) in uint number[];
layout(location = 0) patch out uint triangle;

void main()
{
    triangle = number[0];
    for (int i = 0; i < 3; ++i) {
        gl_TessLevelOuter[i] = push.light.w;
    }
    gl_TessLevelInner[0] = push.light.w;
}
