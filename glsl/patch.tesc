#version 450
#extension GL_GOOGLE_include_directive : require
// Copies the control points and sets the levels. Compiled for GREGORY 0, 1 and SHAPE 0, 1, 2.
#include "inc/layout.glsl"

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 0) out vec4 out_a[];
layout(location = 1) out vec4 out_b[];

#include "inc/bezier.glsl"
#include "inc/face.glsl"
#include "inc/part.glsl"
#include "inc/levels.glsl"

layout(vertices = POINTS) out;

void main()
{
    out_a[gl_InvocationID] = control_a[gl_InvocationID];
    out_b[gl_InvocationID] = control_b[gl_InvocationID];
    if (gl_InvocationID == 0) {
        float level[4];
        level[3] = 1.0;
        for (int i = 0; i < SIDES; i++) {
            level[i] = side_level(i);
        }
#if SHAPE == 1
        gl_TessLevelOuter[0] = level[1];
        gl_TessLevelOuter[1] = level[2];
        gl_TessLevelOuter[2] = level[0];
        gl_TessLevelOuter[3] = 1.0;
        gl_TessLevelInner[0] = max(max(level[0], level[1]), level[2]);
        gl_TessLevelInner[1] = 1.0;
#else
        gl_TessLevelOuter[0] = level[3];
        gl_TessLevelOuter[1] = level[0];
        gl_TessLevelOuter[2] = level[1];
        gl_TessLevelOuter[3] = level[2];
        gl_TessLevelInner[0] = max(level[0], level[2]);
        gl_TessLevelInner[1] = max(level[1], level[3]);
#endif
    }
}
