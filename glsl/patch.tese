#version 450
#extension GL_GOOGLE_include_directive : require
// Evaluates the face. On the sides of the domain the parameter is snapped to k/L and the side's own cubic is
// evaluated from its four control points, so that neighbours get the same bits. CPU twin: eval::vertex.
// Compiled for GREGORY 0, 1 and SHAPE 0, 1, 2; with READBACK the point goes to a buffer too.
#include "inc/layout.glsl"

#if SHAPE == 1
layout(triangles, equal_spacing, ccw) in;
#else
layout(quads, equal_spacing, ccw) in;
#endif

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];

#include "inc/bezier.glsl"
#include "inc/face.glsl"
#include "inc/part.glsl"
#include "inc/side.glsl"

#ifdef READBACK
#include "inc/record.glsl"
#else
layout(location = 0) out vec4 colour;
#endif

// Inside of the drawn domain, mapped into the face's.
vec2 inside_uv(vec3 c)
{
#if SHAPE == 0
    return c.xy;
#elif SHAPE == 1
    return c.x * corner_uv(0) + c.y * corner_uv(1) + c.z * corner_uv(2);
#else
    vec2 low = mix(corner_uv(0), corner_uv(1), c.x);
    vec2 high = mix(corner_uv(3), corner_uv(2), c.x);
    return mix(low, high, c.y);
#endif
}

Value vertex(vec3 c)
{
    int side = side_of(c);
    vec2 uv = inside_uv(c);
    if (side >= 0) {
        float level = gl_TessLevelOuter[outer_of(side)];
        float k = floor(along(side, c) * level + 0.5);
        precise float t = k / level;
        precise float s = (level - k) / level;
        bool at_corner = k <= 0.0 || k >= level;
        if (at_corner || !is_inner(side)) {
            // A corner is its control point: weight 1 on it, and 0 on it three times more.
            ivec4 q = at_corner ? ivec4(corner_point(k <= 0.0 ? side : next_corner(side))) : side_points(side);
            vec4 w = at_corner ? vec4(1.0, 0.0, 0.0, 0.0) : bernstein(s, t);
            return Value(cubic(w, control_a[q.x], control_a[q.y], control_a[q.z], control_a[q.w]),
                         cubic(w, control_b[q.x], control_b[q.y], control_b[q.z], control_b[q.w]));
        }
        uv = inner_uv(side, s, t);
    }
    return surface(uv);
}

void main()
{
    Value v = vertex(gl_TessCoord);
#ifdef READBACK
    uint i = atomicAdd(count, 1u);
    if (i < capacity) {
        vec4 outer = vec4(1.0);
        for (int k = 0; k < SIDES; k++) {
            outer[k] = gl_TessLevelOuter[outer_of(k)];
        }
        records[i] = Record(uvec4(push.range, push.patch_index, 0u, 0u), vec4(gl_TessCoord, 0.0), outer, v.a, v.b);
    }
#else
    colour = v.b;
#endif
    precise vec2 ndc = v.a.xy * push.view.xy + push.view.zw;
    gl_Position = vec4(ndc, 0.0, 1.0);
}
