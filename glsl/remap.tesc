#version 450
#extension GL_GOOGLE_include_directive : require
// Control shader of transition faces in one piece: a split edge has the segments of both finer neighbours together.
// Compiled for GREGORY 0, 1.
#include "inc/layout.glsl"

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 0) out vec4 out_a[];
layout(location = 1) out vec4 out_b[];
// Segments of the first half of each split edge.
layout(location = 2) patch out vec4 first_half;

#define SHAPE 0
#include "inc/bezier.glsl"
#include "inc/face.glsl"
#include "inc/part.glsl"
#include "inc/levels.glsl"
#include "inc/remap.glsl"

layout(vertices = 32) out;

// Level that the finer neighbour along half h of split edge e gives its own edge.
float half_level(int e, int h)
{
    if (push.tess.w <= 0.0) {
        return push.tess.y;
    }
    Value q[4];
    half_points(e, h, q);
    return polygon_level(q[0].a.xy, q[1].a.xy, q[2].a.xy, q[3].a.xy);
}

void main()
{
    out_a[gl_InvocationID] = control_a[gl_InvocationID];
    out_b[gl_InvocationID] = control_b[gl_InvocationID];
    if (gl_InvocationID == 0) {
        float level[4];
        vec4 halves = vec4(0.0);
        for (int i = 0; i < 4; i++) {
            if (is_split(i)) {
                halves[i] = half_level(i, 0);
                level[i] = halves[i] + half_level(i, 1);
            } else {
                level[i] = side_level(i);
            }
        }
        first_half = halves;
        gl_TessLevelOuter[0] = level[3];
        gl_TessLevelOuter[1] = level[0];
        gl_TessLevelOuter[2] = level[1];
        gl_TessLevelOuter[3] = level[2];
        gl_TessLevelInner[0] = max(level[0], level[2]);
        gl_TessLevelInner[1] = max(level[1], level[3]);
    }
}
