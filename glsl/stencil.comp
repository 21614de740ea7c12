#version 450
// Control points of patches in space, weighted sums of the vertices of refined meshes; one an invocation. CPU twin:
// `PackedStencils::points_of` in src/patch/stencil.rs.

layout(local_size_x = 64) in;

// Two vec4 each: position and weight, vector.
layout(set = 0, binding = 0, std430) readonly buffer Sources {
    vec4 source[];
};
// Source, and the bits of its weight.
layout(set = 0, binding = 1, std430) readonly buffer Terms {
    uvec2 term[];
};
// First term and end of the row of the first vec4, and of that of the second.
layout(set = 0, binding = 2, std430) readonly buffer Points {
    uvec4 point[];
};
layout(set = 0, binding = 3, std430) writeonly buffer Made {
    vec4 made[];
};
layout(push_constant, std430) uniform Run {
    uint first;
    uint end;
} run;

// The weights have the sum 1: what the first one's is does not matter. Sums in the order of the terms, so that the same row
// gives the same bits everywhere.
vec4 sum(uvec2 row, uint part)
{
    vec4 base = source[2u * term[row.x].x + part];
    precise vec4 moved = vec4(0.0);
    for (uint k = row.x + 1u; k < row.y; ++k) {
        moved += uintBitsToFloat(term[k].y) * (source[2u * term[k].x + part] - base);
    }
    precise vec4 total = base + moved;
    return total;
}

void main()
{
    uint i = run.first + gl_GlobalInvocationID.x;
    if (i >= run.end) {
        return;
    }
    made[2u * i] = sum(point[i].xy, 0u);
    made[2u * i + 1u] = sum(point[i].zw, 1u);
}
