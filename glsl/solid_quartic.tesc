#version 450
#extension GL_GOOGLE_include_directive : require
// Copies the control points of a triangle of a surface in space and sets the levels: one for all edges but those beside
// finer patches. Compiled for GREGORY 0 and 1, TRANSITION 0 and 1.
#include "inc/solid.glsl"

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 0) out vec4 out_a[];
layout(location = 1) out vec4 out_b[];

#if TRANSITION
layout(vertices = 30) out;
#elif GREGORY
layout(vertices = 18) out;
#else
layout(vertices = 15) out;
#endif

void main()
{
    out_a[gl_InvocationID] = control_a[gl_InvocationID];
    out_b[gl_InvocationID] = control_b[gl_InvocationID];
    if (gl_InvocationID == 0) {
#if TRANSITION
        uint finer = uint(control_a[29].x);
#else
        uint finer = 0u;
#endif
        for (int i = 0; i < 3; i++) {
            // Outer level i is opposite to corner i: side i + 1.
            bool is_finer = ((finer >> uint(i == 2 ? 0 : i + 1)) & 1u) == 1u;
            gl_TessLevelOuter[i] = is_finer ? 2.0 * push.finer : push.tess;
        }
        gl_TessLevelInner[0] = push.tess;
    }
}
