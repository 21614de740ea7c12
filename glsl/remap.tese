#version 450
#extension GL_GOOGLE_include_directive : require
// Evaluates transition faces in one piece. Vertices of a split edge are numbered along both finer neighbours, and each is
// evaluated on the neighbour's own four points, so that both sides get the same bits. CPU twin: remap::vertex.
// Compiled for GREGORY 0, 1; with READBACK the point goes to a buffer too.
#include "inc/layout.glsl"

layout(quads, equal_spacing, ccw) in;

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 2) patch in vec4 first_half;

#define SHAPE 0
#include "inc/bezier.glsl"
#include "inc/face.glsl"
#include "inc/part.glsl"
#include "inc/side.glsl"
#include "inc/remap.glsl"

#ifdef READBACK
#include "inc/record.glsl"
#else
layout(location = 0) out vec4 colour;
#endif

// Vertex k of n along a cubic; its ends are their control points.
Value on_cubic(Value q[4], float k, float n)
{
    if (k <= 0.0) {
        return q[0];
    }
    if (k >= n) {
        return q[3];
    }
    precise float t = k / n;
    precise float s = (n - k) / n;
    vec4 w = bernstein(s, t);
    return Value(cubic(w, q[0].a, q[1].a, q[2].a, q[3].a), cubic(w, q[0].b, q[1].b, q[2].b, q[3].b));
}

Value vertex(vec3 c)
{
    int side = side_of(c);
    if (side < 0) {
        Value v = surface(c.xy);
        return Value(vec4(v.a.xy, 0.0, 0.0), v.b);
    }
    float level = gl_TessLevelOuter[outer_of(side)];
    float k = floor(along(side, c) * level + 0.5);
    Value q[4];
    if (is_split(side)) {
        float first = floor(first_half[side] + 0.5);
        if (on_own_curve()) {
            // The number of a vertex among `level` that lies at the mapped parameter; no whole one.
            precise float t = k <= first ? 0.5 * (k / first) : 0.5 + 0.5 * ((k - first) / (level - first));
            k = t * level;
        } else if (k <= first) {
            half_points(side, 0, q);
            return on_cubic(q, k, first);
        } else {
            half_points(side, 1, q);
            return on_cubic(q, k - first, level - first);
        }
    }
    ivec4 p = side_points(side);
    q = Value[4](face_point(p.x), face_point(p.y), face_point(p.z), face_point(p.w));
    return on_cubic(q, k, level);
}

void main()
{
    Value v = vertex(gl_TessCoord);
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
