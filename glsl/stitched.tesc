#version 450
#extension GL_GOOGLE_include_directive : require
// Control shader of stitched patches: levels of free sides by length or fixed, of stitched sides as the table says.
#include "inc/layout.glsl"

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 0) out vec4 out_a[];
layout(location = 1) out vec4 out_b[];

#include "inc/bezier.glsl"
#include "inc/stitch.glsl"
#include "inc/polygon.glsl"

layout(vertices = 32) out;

// CPU twin: ferguson::fit::free_level.
float level_of(int i)
{
    if (is_stitched(i)) {
        return stitch_level(i);
    }
    precise float level = push.tess.x;
    if (push.tess.w > 0.0) {
        ivec4 q = side_slots(i);
        level = polygon_pixels(control_a[q.x].xy, control_a[q.y].xy, control_a[q.z].xy, control_a[q.w].xy) / push.tess.w;
    }
    // The comparison is false for NaN, which becomes the greatest level.
    return level <= 64.0 ? max(level, 2.0) : 64.0;
}

void main()
{
    out_a[gl_InvocationID] = control_a[gl_InvocationID];
    out_b[gl_InvocationID] = control_b[gl_InvocationID];
    if (gl_InvocationID == 0) {
        float level[4] = float[4](level_of(0), level_of(1), level_of(2), level_of(3));
        gl_TessLevelOuter[0] = level[3];
        gl_TessLevelOuter[1] = level[0];
        gl_TessLevelOuter[2] = level[1];
        gl_TessLevelOuter[3] = level[2];
        gl_TessLevelInner[0] = max(level[0], level[2]);
        gl_TessLevelInner[1] = max(level[1], level[3]);
    }
}
