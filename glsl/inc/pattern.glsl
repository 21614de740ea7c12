// Evaluation of a coarse triangle (BS05). CPU twins: src/gpu/pattern/attributes.rs (`PatternPush`), src/pattern/evaluate.rs,
// src/pattern/displace.rs. Sums are grouped as there: on an edge exactly two terms of each group
// are left, and a sum of two does not depend on their order, so both triangles of an edge get the same bits.
layout(constant_id = 0) const uint EVALUATOR = 1u;    // 0 linear, 1 cubic
layout(constant_id = 1) const uint DISPLACEMENT = 0u; // 0 none, 1 sine, 2 noise, 3 height map

#include "inc/triangle.glsl"

layout(push_constant, std430) uniform Push {
    mat4 clip;       // from model to clip space
    vec4 light;      // xyz: towards the light; w: level of the hardware's tessellation
    vec4 shape;      // sine: a, f. noise: a, f, gain, lacunarity. height: a, middle
    float drift;     // noise: cells that have gone by
    uint octaves;
    uint seed;
    uint show;       // 0 lit, 1 normals, 2 flat
    uint vertices;   // read-back: vertices of the pattern
    uint list;       // levels of detail: first instance of the pattern
    uint record;     // read-back: first record
    uint level;      // levels of detail: segments of the pattern
} push;

layout(set = 0, binding = 2, std430) readonly buffer Heights {
    uvec4 size;
    float texel[];
} heights;

vec3 lattice_gradient(ivec3 at, uint seed)
{
    uvec3 v = uvec3(at) + seed * 0x9E3779B9u;
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return vec3(v >> 16u) / 32767.5 - 1.0;
}

// xyz: gradient; w: value.
vec4 gradient_noise(vec3 p, uint seed)
{
    vec3 cell = floor(p);
    vec3 f = p - cell;
    ivec3 base = ivec3(cell);
    vec3 s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    vec3 d = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    vec4 sum = vec4(0.0);
    for (int corner = 0; corner < 8; ++corner) {
        ivec3 at = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        vec3 g = lattice_gradient(base + at, seed);
        float ramp = dot(g, f - vec3(at));
        vec3 w = mix(1.0 - s, s, equal(at, ivec3(1)));
        vec3 r = mix(-d, d, equal(at, ivec3(1)));
        float all = w.x * w.y * w.z;
        sum += vec4(g * all + vec3(r.x * w.y * w.z, w.x * r.y * w.z, w.x * w.y * r.z) * ramp, all * ramp);
    }
    return sum;
}

vec4 octaves_at(vec3 p)
{
    const vec3 ways[4] = vec3[4](vec3(1.0, 0.5, 0.25), vec3(-0.75, 0.5, -1.0), vec3(0.5, -1.0, 0.75), vec3(-0.5, -0.75, 1.0));
    vec4 sum = vec4(0.0);
    float amplitude = push.shape.x;
    float frequency = push.shape.y;
    for (uint octave = 0u; octave < push.octaves; ++octave) {
        vec4 n = gradient_noise(p * frequency + ways[octave & 3u] * push.drift, push.seed + octave);
        sum += vec4(n.xyz * (amplitude * frequency), amplitude * n.w);
        amplitude *= push.shape.z;
        frequency *= push.shape.w;
    }
    return sum;
}

float texel(uvec2 at)
{
    at = min(at, heights.size.xy - 1u);
    return heights.texel[at.y * heights.size.x + at.x];
}

// xy: derivatives by s and t; z: height.
vec3 height_at(vec2 uv)
{
    vec2 size = vec2(heights.size.xy);
    vec2 q = clamp(vec2(uv.x, 1.0 - uv.y) * size - 0.5, vec2(0.0), size - 1.0);
    vec2 cell = floor(q);
    vec2 f = q - cell;
    uvec2 at = uvec2(cell);
    float a = texel(at), b = texel(at + uvec2(1u, 0u)), c = texel(at + uvec2(0u, 1u)), d = texel(at + uvec2(1u));
    float top = a + (b - a) * f.x;
    float bottom = c + (d - c) * f.x;
    float across = (b - a) * (1.0 - f.y) + (d - c) * f.y;
    return vec3(across * size.x, (top - bottom) * size.y, top + (bottom - top) * f.y);
}

vec3 position_at(Triangle t, vec3 at)
{
    precise float w = at.x, u = at.y, v = at.z;
    precise vec3 sum;
    if (EVALUATOR == 0u) {
        sum = (t.point[0].xyz * w + t.point[1].xyz * u) + t.point[2].xyz * v;
        return sum;
    }
    precise float www = w * w * w, uuu = u * u * u, vvv = v * v * v;
    precise vec3 corners = (t.point[0].xyz * www + t.point[1].xyz * uuu) + t.point[2].xyz * vvv;
    precise float wwu = w * w * u, uuw = u * u * w, uuv = u * u * v, vvu = v * v * u, vvw = v * v * w, wwv = w * w * v;
    precise vec3 e01 = t.point[3].xyz * wwu + t.point[4].xyz * uuw;
    precise vec3 e12 = t.point[5].xyz * uuv + t.point[6].xyz * vvu;
    precise vec3 e20 = t.point[7].xyz * vvw + t.point[8].xyz * wwv;
    precise float centre = 6.0 * (u * v * w);
    sum = (corners + ((e01 + e12) + e20) * 3.0) + t.point[9].xyz * centre;
    return sum;
}

vec3 field_at(vec4 n[6], vec3 at)
{
    precise float w = at.x, u = at.y, v = at.z;
    if (EVALUATOR == 0u) {
        precise vec3 even = (n[0].xyz * w + n[1].xyz * u) + n[2].xyz * v;
        return even;
    }
    precise float ww = w * w, uu = u * u, vv = v * v, wu = w * u, uv = u * v, vw = v * w;
    precise vec3 corners = (n[0].xyz * ww + n[1].xyz * uu) + n[2].xyz * vv;
    precise vec3 middles = (n[3].xyz * wu + n[4].xyz * uv) + n[5].xyz * vw;
    precise vec3 sum = corners + middles;
    return sum;
}

vec3 unit(vec3 n)
{
    precise float square = (n.x * n.x + n.y * n.y) + n.z * n.z;
    return square > 0.0 ? n / sqrt(square) : vec3(0.0, 0.0, 1.0);
}

void evaluate(Triangle t, vec3 at, out vec3 position, out vec3 normal, out vec4 colour)
{
    precise vec3 base = position_at(t, at);
    normal = unit(field_at(t.normal, at));
    colour = (t.colour[0] * at.x + t.colour[1] * at.y) + t.colour[2] * at.z;
    position = base;
    if (DISPLACEMENT == 0u) {
        return;
    }
    precise vec3 direction = unit(field_at(t.direction, at));
    precise float height = 0.0;
    vec3 gradient = vec3(0.0);
    if (DISPLACEMENT == 1u) {
        precise float r = sqrt((base.x * base.x + base.y * base.y) + base.z * base.z);
        precise float phase = push.shape.y * r;
        height = push.shape.x * sin(phase);
        gradient = r > 0.0 ? base * (push.shape.x * push.shape.y * cos(phase) / r) : vec3(0.0);
    } else if (DISPLACEMENT == 2u) {
        precise vec4 n = octaves_at(base);
        height = n.w;
        gradient = n.xyz;
    } else {
        precise vec2 uv = (t.uv01.xy * at.x + t.uv01.zw * at.y) + t.uv2.xy * at.z;
        precise vec3 h = height_at(uv);
        height = (h.z - push.shape.y) * push.shape.x;
        gradient = (t.gradient_s.xyz * h.x + t.gradient_t.xyz * h.y) * push.shape.x;
    }
    precise vec3 moved = base + direction * height;
    position = moved;
    normal = unit(normal - (gradient - normal * dot(gradient, normal)));
}
