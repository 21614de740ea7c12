#version 450
#extension GL_GOOGLE_include_directive : require
// Coefficients of curved and scalar tagged triangles (BS05 App. A, B), one triangle an invocation. CPU twin:
// src/pattern/control.rs.
#include "inc/triangle.glsl"

layout(local_size_x = 64) in;

struct Vertex {
    vec4 position;  // w: tension
    vec4 normal;    // w: sharpness
    vec4 deviation; // w: bias
    vec4 colour;
    vec4 uv;
};

layout(set = 0, binding = 0, std430) readonly buffer Vertices {
    Vertex vertex[];
};
layout(set = 0, binding = 1, std430) readonly buffer Corners {
    uvec4 corner[];
};
layout(set = 0, binding = 2, std430) writeonly buffer All {
    Triangle all[];
};
layout(push_constant, std430) uniform Settings {
    uint count;
    uint evaluator; // 0 linear, 1 PN, 2 ST
    uint field;     // 0 Vlachos, 1 Boubekeur, 2 linear
} settings;

float product(vec3 a, vec3 b)
{
    precise float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

// `other` where a vector has no direction.
vec3 unit_or(vec3 v, vec3 other)
{
    float most = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if (!(most > 0.0)) {
        return other;
    }
    precise vec3 scaled = v / most;
    precise vec3 made = scaled / sqrt(product(scaled, scaled));
    return made;
}

bool is_crease(Vertex v)
{
    return settings.evaluator == 2u && any(notEqual(v.deviation.xyz, vec3(0.0)));
}

vec3 sharp_normal(Vertex v, float side)
{
    vec3 n = v.normal.xyz;
    if (!is_crease(v) || v.normal.w == 0.0 || side == 0.0) {
        return n;
    }
    precise vec3 moved = n + v.deviation.xyz * (v.normal.w * side);
    return unit_or(moved, n);
}

vec3 rise(vec3 from, vec3 d, vec3 x)
{
    precise vec3 risen = d + x * -product(x, d - from);
    return risen;
}

// The tangent coefficient near j on the way to k (eq. 3).
vec3 tangent(Vertex j, Vertex k)
{
    vec3 pj = j.position.xyz, pk = k.position.xyz, n = j.normal.xyz;
    if (settings.evaluator == 0u) {
        precise vec3 third = pj + (pk - pj) / 3.0;
        return third;
    }
    float tension = settings.evaluator == 2u ? j.position.w : 0.0;
    precise vec3 d = pj + (pk - pj) * ((1.0 - tension) / 3.0);
    if (!is_crease(j)) {
        return rise(pj, d, n);
    }
    if (is_crease(k)) {
        precise vec3 leant = n + j.deviation.xyz * j.deviation.w;
        return rise(pj, d, unit_or(leant, n));
    }
    vec3 sharp = sharp_normal(j, sign(product(j.deviation.xyz, pk - pj)));
    if (sharp == n) {
        return rise(pj, d, n);
    }
    precise vec3 blended = n * (1.0 - j.normal.w) + sharp;
    return rise(pj, d, unit_or(blended, n));
}

// The same bits from either side.
vec3 middle_normal(vec3 p, vec3 q, vec3 m, vec3 n)
{
    precise vec3 edge = q - p;
    precise vec3 sum = m + n;
    if (settings.field == 2u || settings.evaluator == 0u) {
        return sum;
    }
    float square = product(edge, edge);
    precise float t = square > 0.0 ? (settings.field == 0u ? 2.0 : 4.0) * (product(edge, sum) / square) : 0.0;
    precise vec3 reflected = sum - edge * t;
    return settings.field == 0u ? unit_or(reflected, reflected) : reflected;
}

vec4 one(vec3 v)
{
    return vec4(v, 1.0);
}

void main()
{
    uint t = gl_GlobalInvocationID.x;
    if (t >= settings.count) {
        return;
    }
    Vertex v[3] = Vertex[3](vertex[corner[t].x], vertex[corner[t].y], vertex[corner[t].z]);
    vec3 p[3] = vec3[3](v[0].position.xyz, v[1].position.xyz, v[2].position.xyz);
    vec3 n[3] = vec3[3](v[0].normal.xyz, v[1].normal.xyz, v[2].normal.xyz);
    precise vec3 edges = vec3(0.0);
    for (int e = 0; e < 3; ++e) {
        int f = (e + 1) % 3;
        vec3 near = tangent(v[e], v[f]), far = tangent(v[f], v[e]);
        all[t].point[e] = one(p[e]);
        all[t].point[3 + 2 * e] = one(near);
        all[t].point[4 + 2 * e] = one(far);
        edges += near;
        edges += far;
        all[t].colour[e] = v[e].colour;
    }
    precise vec3 centre = edges / 4.0 - ((p[0] + p[1]) + p[2]) / 6.0;
    all[t].point[9] = one(centre);
    vec3 s[3];
    for (int e = 0; e < 3; ++e) {
        precise vec3 across = (p[(e + 1) % 3] - p[e]) + (p[(e + 2) % 3] - p[e]);
        s[e] = sharp_normal(v[e], sign(product(v[e].deviation.xyz, across)));
    }
    for (int e = 0; e < 3; ++e) {
        int f = (e + 1) % 3;
        all[t].normal[e] = one(s[e]);
        all[t].normal[3 + e] = one(middle_normal(p[e], p[f], s[e], s[f]));
        all[t].direction[e] = one(n[e]);
        all[t].direction[3 + e] = one(middle_normal(p[e], p[f], n[e], n[f]));
    }
    all[t].uv01 = vec4(v[0].uv.xy, v[1].uv.xy);
    all[t].uv2 = vec4(v[2].uv.xy, 0.0, 0.0);
    precise vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
    float a = product(e1, e1), b = product(e1, e2), c = product(e2, e2);
    // Of a triangle without area, single precision leaves no more than this.
    precise vec3 cross_product = cross(e1, e2);
    float det = product(cross_product, cross_product);
    vec3 gradient_s = vec3(0.0), gradient_t = vec3(0.0);
    if (det > 1e-12 * a * c) {
        vec2 f1 = v[1].uv.xy - v[0].uv.xy, f2 = v[2].uv.xy - v[0].uv.xy;
        gradient_s = (e1 * (c * f1.x - b * f2.x) + e2 * (a * f2.x - b * f1.x)) / det;
        gradient_t = (e1 * (c * f1.y - b * f2.y) + e2 * (a * f2.y - b * f1.y)) / det;
    }
    all[t].gradient_s = one(gradient_s);
    all[t].gradient_t = one(gradient_t);
}
