#version 450
#extension GL_GOOGLE_include_directive : require
// Evaluates a triangle of a surface in space: position, geometric normal by the derivatives, subdivided normal, weight.
// On sides, positions come from the side's own quartic at k/L, so that neighbours get the same bits; beside finer
// patches, from the quartics of those. Compiled for GREGORY 0 and 1, TRANSITION 0 and 1.
// CPU twin: src/surface/patch_eval.rs.
#include "inc/solid.glsl"

layout(triangles, equal_spacing, cw) in;

layout(location = 0) in vec4 control_a[];
layout(location = 1) in vec4 control_b[];
layout(location = 0) out vec3 normal;
layout(location = 1) out vec3 position;
layout(location = 2) out float weight;

#include "inc/quartic.glsl"
#include "inc/shade.glsl"

// Nearer than this to a side means on it.
const float ON_SIDE = 1.0 / 512.0;

void main()
{
    vec3 c = gl_TessCoord;
    int side = c.z < ON_SIDE ? 0 : c.x < ON_SIDE ? 1 : c.y < ON_SIDE ? 2 : -1;
    Value on_side;
    if (side >= 0) {
        // From the side's first corner on.
        float at = side == 0 ? c.y : side == 1 ? c.z : c.x;
        int q[5];
        for (int i = 0; i < 5; i++) {
            q[i] = SIDES[5 * side + i];
        }
        float level = push.tess;
        float k = floor(at * level + 0.5);
        float along = k / level;
#if TRANSITION
        uint finer = uint(control_a[29].x);
        if (((finer >> uint(side)) & 1u) == 1u) {
            level = push.finer;
            k = floor(at * 2.0 * level + 0.5);
            along = k / (2.0 * level);
            int first = 15 + 7 * bitCount(finer & ((1u << uint(side)) - 1u));
            if (k < level) {
                q = int[](q[0], first, first + 1, first + 2, first + 3);
            } else {
                k -= level;
                q = int[](first + 3, first + 4, first + 5, first + 6, q[4]);
            }
        }
#endif
        precise float t = k / level;
        precise float s = (level - k) / level;
        if (k <= 0.0 || k >= level) {
            // A corner is its control point.
            int i = k <= 0.0 ? q[0] : q[4];
            on_side = Value(control_a[i], control_b[i]);
        } else {
            on_side = Value(quartic(s, t, control_a[q[0]], control_a[q[1]], control_a[q[2]], control_a[q[3]], control_a[q[4]]),
                            quartic(s, t, control_b[q[0]], control_b[q[1]], control_b[q[2]], control_b[q[3]], control_b[q[4]]));
        }
        c = side == 0 ? vec3(1.0 - along, along, 0.0) : side == 1 ? vec3(0.0, 1.0 - along, along)
          : vec3(along, 0.0, 1.0 - along);
    }
    vec3 du, dv;
    Value v = triangle(c, du, dv);
    if (side >= 0) {
        v = on_side;
    }
    vec3 across = cross(du, dv);
    if (dot(across, across) <= 1e-10 * dot(du, du) * dot(dv, dv)) {
        // The boundary turns round the corner of its only face, or the corner is a spike: both derivatives are along it.
        triangle(mix(c, vec3(1.0 / 3.0), 1.0 / 256.0), du, dv);
        across = cross(du, dv);
    }
    shade(v.a, v.b, across);
}
