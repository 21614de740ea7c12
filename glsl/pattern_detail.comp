#version 450
#extension GL_GOOGLE_include_directive : require
// Levels of detail of every coarse triangle, and the lists of those that each pattern draws. CPU twin:
// src/pattern/detail.rs (`levels`). The same sums from both triangles of an edge: edges are looked at from one end.
#include "inc/triangle.glsl"
#include "inc/detail.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer All {
    Triangle all[];
};
layout(set = 0, binding = 1, std430) writeonly buffer List {
    Placed list[];
};
// Five words a pattern, as draws have them; the second counts.
layout(set = 0, binding = 2, std430) buffer Commands {
    uint command[];
};
layout(push_constant, std430) uniform View {
    vec4 eye;        // w: pixels a unit
    float segment;
    float most;
    float whole;     // the level of the mesh; -1: each edge has its own
    uint flags;      // 1: orthographic, 2: no levels between whole ones
    uint count;
} view;

bool after(vec3 a, vec3 b)
{
    return a.x != b.x ? a.x > b.x : (a.y != b.y ? a.y > b.y : a.z > b.z);
}

float size_of(vec3 v)
{
    precise float square = (v.x * v.x + v.y * v.y) + v.z * v.z;
    return sqrt(square);
}

float level_of(float pixels)
{
    float level = log2(pixels / view.segment);
    if ((view.flags & 2u) == 2u) {
        level = ceil(level);
    }
    return min(level > 0.0 ? level : 0.0, view.most);
}

void main()
{
    uint t = gl_GlobalInvocationID.x;
    if (t >= view.count) {
        return;
    }
    Placed placed;
    placed.which = uvec4(t, 0u, 0u, 0u);
    for (uint e = 0u; e < 3u; ++e) {
        vec3 p = all[t].point[e].xyz, q = all[t].point[3u + 2u * e].xyz;
        vec3 r = all[t].point[4u + 2u * e].xyz, s = all[t].point[(e + 1u) % 3u].xyz;
        if (after(p, s)) {
            placed.which.y |= 1u << e;
            vec3 swap = p;
            p = s;
            s = swap;
            swap = q;
            q = r;
            r = swap;
        }
        precise float stretch = (size_of(q - p) + size_of(r - q)) + size_of(s - r);
        precise vec3 middle = (p + s) * 0.5;
        precise float pixels = stretch * view.eye.w;
        if ((view.flags & 1u) == 0u) {
            precise float far = size_of(middle - view.eye.xyz) - 0.5 * stretch;
            pixels = pixels / max(far, 0.05 * stretch);
        }
        placed.level[e] = view.whole >= 0.0 ? view.whole : level_of(pixels);
    }
    placed.level.w = max(max(placed.level.x, placed.level.y), placed.level.z);
    uint group = uint(ceil(placed.level.w));
    uint slot = atomicAdd(command[5u * group + 1u], 1u);
    list[group * view.count + slot] = placed;
}
