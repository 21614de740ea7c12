#version 450
#extension GL_GOOGLE_include_directive : require
// Copies the control points of a surface in space and sets one level for all edges. Compiled for GREGORY 0 and 1.
#include "inc/solid.glsl"

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 0) out vec4 out_a[];
layout(location = 1) out vec4 out_b[];

#if GREGORY
layout(vertices = 20) out;
#else
layout(vertices = 16) out;
#endif

void main()
{
    out_a[gl_InvocationID] = control_a[gl_InvocationID];
    out_b[gl_InvocationID] = control_b[gl_InvocationID];
    if (gl_InvocationID == 0) {
        for (int i = 0; i < 4; i++) {
            gl_TessLevelOuter[i] = push.tess;
        }
        gl_TessLevelInner[0] = push.tess;
        gl_TessLevelInner[1] = push.tess;
    }
}
