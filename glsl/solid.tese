#version 450
#extension GL_GOOGLE_include_directive : require
// Evaluates a patch of a surface in space: position, geometric normal by the derivatives, subdivided normal, weight.
// On sides, positions come from the side's own cubic at k/L, so that neighbours get the same bits; beside finer patches,
// from the cubics of those. Compiled for GREGORY 0 and 1, TRANSITION 0 and 1. CPU twin: src/surface/patch_eval.rs.
#include "inc/solid.glsl"

layout(quads, equal_spacing, cw) in;

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 0) out vec3 normal;
layout(location = 1) out vec3 position;
layout(location = 2) out float weight;

#include "inc/bezier.glsl"
#include "inc/face.glsl"
#include "inc/shade.glsl"

// Nearer than this to a side means on it.
const float ON_SIDE = 1.0 / 512.0;

vec4 slope(float s, float t)
{
    return 3.0 * vec4(-s * s, s * (s - 2.0 * t), t * (2.0 * s - t), t * t);
}

// Rows of the net that the face is at uv, positions only.
vec3 net(int i, vec3 fa, vec3 fb, vec3 fc, vec3 fd)
{
    return i == 5 ? fa : i == 6 ? fb : i == 10 ? fc : i == 9 ? fd : control_a[i].xyz;
}

// Derivatives along u and v; a Gregory face's inner points move, which the sides do not feel.
void derivatives(vec2 uv, out vec3 du, out vec3 dv)
{
    vec2 st = vec2(1.0) - uv;
    vec4 wu = bernstein(st.x, uv.x);
    vec4 wv = bernstein(st.y, uv.y);
    vec4 su = slope(st.x, uv.x);
    vec4 sv = slope(st.y, uv.y);
#if GREGORY
    vec3 fa = gregory_inner(uv.x, uv.y, 5, 16).a.xyz;
    vec3 fb = gregory_inner(uv.y, st.x, 6, 17).a.xyz;
    vec3 fc = gregory_inner(st.x, st.y, 10, 18).a.xyz;
    vec3 fd = gregory_inner(st.y, uv.x, 9, 19).a.xyz;
#else
    vec3 fa = control_a[5].xyz, fb = control_a[6].xyz, fc = control_a[10].xyz, fd = control_a[9].xyz;
#endif
    du = vec3(0.0);
    dv = vec3(0.0);
    for (int r = 0; r < 4; r++) {
        for (int c = 0; c < 4; c++) {
            vec3 p = net(4 * r + c, fa, fb, fc, fd);
            du += su[c] * wv[r] * p;
            dv += wu[c] * sv[r] * p;
        }
    }
#if GREGORY
    // d/dz of x / (x + y) is (x' y - x y') / (x + y)^2. Per corner: x, y, their derivatives along u and v.
    vec2 xy[4] = vec2[](vec2(uv.x, uv.y), vec2(uv.y, st.x), vec2(st.x, st.y), vec2(st.y, uv.x));
    vec2 dx[4] = vec2[](vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(-1.0, 0.0), vec2(0.0, -1.0));
    vec2 dy[4] = vec2[](vec2(0.0, 1.0), vec2(-1.0, 0.0), vec2(0.0, -1.0), vec2(1.0, 0.0));
    int plus[4] = int[](5, 6, 10, 9);
    for (int i = 0; i < 4; i++) {
        float d = xy[i].x + xy[i].y;
        if (d > 0.0) {
            float w = wu[plus[i] % 4] * wv[plus[i] / 4] / (d * d);
            vec2 along = w * (dx[i] * xy[i].y - xy[i].x * dy[i]);
            vec3 move = control_a[plus[i]].xyz - control_a[16 + i].xyz;
            du += along.x * move;
            dv += along.y * move;
        }
    }
#endif
}

void main()
{
    vec2 c = gl_TessCoord.xy;
    Value v;
    int side = c.y < ON_SIDE ? 0 : c.x > 1.0 - ON_SIDE ? 1 : c.y > 1.0 - ON_SIDE ? 2 : c.x < ON_SIDE ? 3 : -1;
    vec2 uv = c;
    if (side >= 0) {
        float at = side == 0 ? c.x : side == 1 ? c.y : side == 2 ? 1.0 - c.x : 1.0 - c.y;
        const ivec4 sides[4] = ivec4[](ivec4(0, 1, 2, 3), ivec4(3, 7, 11, 15), ivec4(15, 14, 13, 12), ivec4(12, 8, 4, 0));
        ivec4 q = sides[side];
        float level = push.tess;
        float k = floor(at * level + 0.5);
#if TRANSITION
        uint finer = uint(control_a[31].x);
        if (((finer >> uint(side)) & 1u) == 1u) {
            level = push.finer;
            k = floor(at * 2.0 * level + 0.5);
            uv.x = k / (2.0 * level);
            int first = 16 + 5 * bitCount(finer & ((1u << uint(side)) - 1u));
            if (k < level) {
                q = ivec4(q.x, first, first + 1, first + 2);
            } else {
                k -= level;
                q = ivec4(first + 2, first + 3, first + 4, q.w);
            }
        } else {
            uv.x = k / level;
        }
#else
        uv.x = k / level;
#endif
        precise float t = k / level;
        precise float s = (level - k) / level;
        // A corner is its control point.
        vec4 w = k <= 0.0 ? vec4(1.0, 0.0, 0.0, 0.0) : k >= level ? vec4(0.0, 0.0, 0.0, 1.0) : bernstein(s, t);
        v = Value(cubic(w, control_a[q.x], control_a[q.y], control_a[q.z], control_a[q.w]),
                  cubic(w, control_b[q.x], control_b[q.y], control_b[q.z], control_b[q.w]));
        float along = uv.x;
        uv = side == 0 ? vec2(along, 0.0) : side == 1 ? vec2(1.0, along)
           : side == 2 ? vec2(1.0 - along, 1.0) : vec2(0.0, 1.0 - along);
    } else {
        v = surface(uv);
    }
    vec3 du, dv;
    derivatives(uv, du, dv);
    vec3 across = cross(du, dv);
    if (dot(across, across) <= 1e-10 * dot(du, du) * dot(dv, dv)) {
        // The boundary turns round the corner of its only face: both derivatives are along it.
        derivatives(mix(uv, vec2(0.5), 1.0 / 256.0), du, dv);
        across = cross(du, dv);
    }
    shade(v.a, v.b, across);
}
