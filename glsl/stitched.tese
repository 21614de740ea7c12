#version 450
#extension GL_GOOGLE_include_directive : require
// Evaluates stitched patches. On the sides the parameter is a whole number of segments, or of 1/65536, counted along the
// curve that the neighbours share, so that they get the same bits. CPU twin: stitched::vertex.
// With READBACK the point goes to a buffer too.
#include "inc/layout.glsl"

layout(quads, fractional_even_spacing, ccw) in;

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];

#define GREGORY 0
#include "inc/bezier.glsl"
#include "inc/face.glsl"
#include "inc/stitch.glsl"

#ifdef READBACK
#include "inc/record.glsl"
#else
layout(location = 0) out vec4 colour;
#endif

// Where the corner that side i leaves lies: on the curve of the side that has it strictly inside, if one does.
vec2 corner_place(int i)
{
    int before = (i + 3) & 3;
    if (is_stitched(i)) {
        float k = stitch_at(i, 0.0);
        if (k > 0.0 && k < stitch_number(i, 2)) {
            return stitch_point(i, k);
        }
    }
    if (is_stitched(before)) {
        float k = stitch_at(before, stitch_level(before));
        if (k > 0.0 && k < stitch_number(before, 2)) {
            return stitch_point(before, k);
        }
    }
    return control_a[corner_slot(i)].xy;
}

Value vertex(vec2 c)
{
    bvec4 on = bvec4(c.y == 0.0, c.x == 1.0, c.y == 1.0, c.x == 0.0);
    precise vec4 along = vec4(c.x, c.y, 1.0 - c.x, 1.0 - c.y);
    int side = -1;
    for (int i = 0; i < 4; i++) {
        if (on[i] && on[(i + 3) & 3]) {
            return Value(vec4(corner_place(i), 0.0, 0.0), control_b[corner_slot(i)]);
        }
        if (on[i]) {
            side = i;
        }
    }
    if (side < 0) {
        Value v = surface(c);
        return Value(vec4(v.a.xy, 0.0, 0.0), v.b);
    }
    ivec4 q = side_slots(side);
    precise vec2 local;
    vec2 at;
    if (is_stitched(side)) {
        float n = stitch_level(side);
        float k = floor(along[side] * n + 0.5);
        float number = stitch_at(side, k);
        at = stitch_point(side, number);
        local.y = k / n;
        if (stitch_number(side, 3) > 0.0) {
            float t = stitch_parameter(side, number).y;
            float a = stitch_parameter(side, stitch_number(side, 0)).y;
            float b = stitch_parameter(side, stitch_number(side, 1)).y;
            local.y = (t - a) / (b - a);
        }
        local.x = 1.0 - local.y;
    } else {
        float k = floor(along[side] * 65536.0 + 0.5);
        local = vec2((65536.0 - k) / 65536.0, k / 65536.0);
        at = cubic(bernstein(local.x, local.y), control_a[q.x], control_a[q.y], control_a[q.z], control_a[q.w]).xy;
    }
    vec4 w = bernstein(local.x, local.y);
    return Value(vec4(at, 0.0, 0.0), cubic(w, control_b[q.x], control_b[q.y], control_b[q.z], control_b[q.w]));
}

void main()
{
    Value v = vertex(gl_TessCoord.xy);
#ifdef READBACK
    uint i = atomicAdd(count, 1u);
    if (i < capacity) {
        vec4 outer = vec4(gl_TessLevelOuter[1], gl_TessLevelOuter[2], gl_TessLevelOuter[3], gl_TessLevelOuter[0]);
        records[i] = Record(uvec4(push.range, push.patch_index, 0u, 0u), vec4(gl_TessCoord, 0.0), outer, v.a, v.b);
    }
#else
    colour = v.b;
#endif
    precise vec2 ndc = v.a.xy * push.view.xy + push.view.zw;
    gl_Position = vec4(ndc, 0.0, 1.0);
}
