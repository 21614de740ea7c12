// Where vertices of a pattern go between levels of detail. CPU twin: src/pattern/detail.rs (`place`).
struct Placed {
    vec4 level;  // of edges 01, 12, 20, and of the inside
    uvec4 which; // triangle; bit e: edge e is counted from its second corner
};

// Part of the way that is left, and that is gone, of vertex k of n on an edge; gathered towards the nearer end.
vec2 along(uint k, uint n, float level)
{
    bool far = 2u * k > n;
    precise float up = ceil(level);
    uint m = min(1u << uint(up), n);
    uint j = (far ? n - k : k) / (n / m);
    precise float x = float(j);
    if (m > 1u && (j & 1u) == 1u) {
        precise float part = level - up + 1.0;
        x = float(j - 1u) + part;
    }
    precise float left = (float(m) - x) / float(m);
    precise float gone = x / float(m);
    return far ? vec2(gone, left) : vec2(left, gone);
}

vec3 border(uvec3 c, uint n, Placed placed)
{
    uint e = c.z == 0u ? 0u : (c.x == 0u ? 1u : 2u);
    uint from = e;
    uint to = (e + 1u) % 3u;
    if (((placed.which.y >> e) & 1u) == 1u) {
        from = to;
        to = e;
    }
    vec2 ends = along(c[to], n, placed.level[e]);
    vec3 weights = vec3(0.0);
    weights[from] = ends.x;
    weights[to] = ends.y;
    return weights;
}

vec3 place(vec3 weights, uint n, Placed placed)
{
    uvec3 c = uvec3(weights * float(n) + 0.5);
    if (min(min(c.x, c.y), c.z) == 0u) {
        return border(c, n, placed);
    }
    vec3 here = vec3(c) / float(n);
    uvec3 odd = c & 1u;
    if (odd == uvec3(0u)) {
        return here;
    }
    // Two weights are odd: i and the next.
    uint i = odd.z == 0u ? 0u : (odd.x == 0u ? 1u : 2u);
    uint next = (i + 1u) % 3u;
    uvec3 to = c;
    to[i] += 1u;
    to[next] -= 1u;
    uvec3 other = c;
    other[next] += 1u;
    other[i] -= 1u;
    // Rather inwards: those on the border may have been gathered far away.
    if (to[next] == 0u && other[i] != 0u) {
        to = other;
    }
    vec3 there = vec3(to) / float(n);
    if (min(min(to.x, to.y), to.z) == 0u) {
        there = border(to, n, placed);
    }
    float g = placed.level.w - ceil(placed.level.w) + 1.0;
    return there * (1.0 - g) + here * g;
}
