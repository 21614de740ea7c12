// Quartic Bezier curves and triangles. CPU twin: src/patch/quartic.rs, which has the picture of the point order.
// `precise` and the pairing make (s, t) on p0..p4 and (t, s) on p4..p0 the same bits.
// Needs: GREGORY (0: 15 points, 1: 18), control_a[], control_b[].

// The eight channels of a point.
struct Value {
    vec4 a;
    vec4 b;
};

// The five points of side i, from corner i on.
const int SIDES[15] = int[](0, 1, 2, 3, 4, 4, 8, 11, 13, 14, 14, 12, 9, 5, 0);

// Point of a quartic curve, s + t = 1. CPU twin: quartic::curve.
vec4 quartic(float s, float t, vec4 p0, vec4 p1, vec4 p2, vec4 p3, vec4 p4)
{
    precise float ss = s * s;
    precise float tt = t * t;
    precise float st = s * t;
    precise float w0 = ss * ss;
    precise float w1 = 4.0 * (ss * st);
    precise float w2 = 6.0 * (ss * tt);
    precise float w3 = 4.0 * (tt * st);
    precise float w4 = tt * tt;
    precise vec4 r = ((w0 * p0 + w4 * p4) + (w1 * p1 + w3 * p3)) + w2 * p2;
    return r;
}

#if GREGORY
// Inner point of a corner: (x f+ + y f-) / (x + y), f+ where both vanish. CPU twin: eval::gregory_inner.
Value gregory_inner(float x, float y, int plus, int minus)
{
    float d = x + y;
    float wx = d > 0.0 ? x / d : 1.0;
    float wy = d > 0.0 ? y / d : 0.0;
    return Value(wx * control_a[plus] + wy * control_a[minus], wx * control_b[plus] + wy * control_b[minus]);
}
#endif

// Point of the triangle at barycentric (x, y, z) with the derivatives of its position from corner A towards B and C.
// By de Casteljau: 15 points, 10, 6, 3, 1. CPU twin: quartic::sample.
Value triangle(vec3 c, out vec3 du, out vec3 dv)
{
    vec4 a[15];
    vec4 b[15];
    for (int i = 0; i < 15; i++) {
        a[i] = control_a[i];
        b[i] = control_b[i];
    }
#if GREGORY
    // Distances from the two sides that meet in the corner.
    Value fa = gregory_inner(c.y, c.z, 6, 15);
    Value fb = gregory_inner(c.z, c.x, 7, 16);
    Value fc = gregory_inner(c.x, c.y, 10, 17);
    a[6] = fa.a;
    b[6] = fa.b;
    a[7] = fb.a;
    b[7] = fb.b;
    a[10] = fc.a;
    b[10] = fc.b;
#endif
    for (int degree = 4; degree > 1; degree--) {
        // Rows of the old and the new net begin at `from` and `to`; every new point is before the old ones it needs.
        int from = 0;
        int to = 0;
        for (int row = 0; row < degree; row++) {
            int above = from + degree - row + 1;
            for (int i = 0; i < degree - row; i++) {
                a[to] = c.x * a[from + i] + c.y * a[from + i + 1] + c.z * a[above + i];
                b[to] = c.x * b[from + i] + c.y * b[from + i + 1] + c.z * b[above + i];
                to++;
            }
            from = above;
        }
    }
    du = 4.0 * (a[1] - a[0]).xyz;
    dv = 4.0 * (a[2] - a[0]).xyz;
#if GREGORY
    // The inner points move: d of y / (y + z) is (y' z - y z') / (y + z)^2.
    vec2 xy[3] = vec2[](c.yz, c.zx, c.xy);
    vec2 along_u[3] = vec2[](vec2(1.0, 0.0), vec2(0.0, -1.0), vec2(-1.0, 1.0));
    vec2 along_v[3] = vec2[](vec2(0.0, 1.0), vec2(1.0, -1.0), vec2(-1.0, 0.0));
    int plus[3] = int[](6, 7, 10);
    for (int i = 0; i < 3; i++) {
        float d = xy[i].x + xy[i].y;
        if (d > 0.0) {
            // Weight of the point: 12 times the three coordinates and once more the corner's own.
            float w = 12.0 * c.x * c.y * c.z * c[i] / (d * d);
            vec3 move = w * (control_a[plus[i]] - control_a[15 + i]).xyz;
            du += (along_u[i].x * xy[i].y - xy[i].x * along_u[i].y) * move;
            dv += (along_v[i].x * xy[i].y - xy[i].x * along_v[i].y) * move;
        }
    }
#endif
    return Value(c.x * a[0] + c.y * a[1] + c.z * a[2], c.x * b[0] + c.y * b[1] + c.z * b[2]);
}
