// The surface of a whole face. Needs: GREGORY (0 bicubic, 1 Gregory), control_a[], control_b[], bezier.glsl.
// CPU twin: src/patch/eval.rs. Point order and pictures: src/patch/mod.rs.

#if GREGORY
const int FACE_POINTS = 20;
#else
const int FACE_POINTS = 16;
#endif

// The eight channels of a point.
struct Value {
    vec4 a;
    vec4 b;
};

#if GREGORY
// Inner point of a corner: (x f+ + y f-) / (x + y), f+ where both distances vanish. CPU twin: eval::gregory_inner.
Value gregory_inner(float x, float y, int plus, int minus)
{
    precise float d = x + y;
    precise float wx = d > 0.0 ? x / d : 1.0;
    precise float wy = d > 0.0 ? y / d : 0.0;
    precise vec4 a = wx * control_a[plus] + wy * control_a[minus];
    precise vec4 b = wx * control_b[plus] + wy * control_b[minus];
    return Value(a, b);
}
#endif

// Point of the face at uv: along u in every row, then along v. CPU twin: eval::face.
Value surface(vec2 uv)
{
    precise vec2 st = vec2(1.0) - uv;
    vec4 wu = bernstein(st.x, uv.x);
    vec4 wv = bernstein(st.y, uv.y);
#if GREGORY
    Value fa = gregory_inner(uv.x, uv.y, 5, 16);
    Value fb = gregory_inner(uv.y, st.x, 6, 17);
    Value fc = gregory_inner(st.x, st.y, 10, 18);
    Value fd = gregory_inner(st.y, uv.x, 9, 19);
#else
    Value fa = Value(control_a[5], control_b[5]);
    Value fb = Value(control_a[6], control_b[6]);
    Value fc = Value(control_a[10], control_b[10]);
    Value fd = Value(control_a[9], control_b[9]);
#endif
    vec4 a0 = cubic(wu, control_a[0], control_a[1], control_a[2], control_a[3]);
    vec4 a1 = cubic(wu, control_a[4], fa.a, fb.a, control_a[7]);
    vec4 a2 = cubic(wu, control_a[8], fd.a, fc.a, control_a[11]);
    vec4 a3 = cubic(wu, control_a[12], control_a[13], control_a[14], control_a[15]);
    vec4 b0 = cubic(wu, control_b[0], control_b[1], control_b[2], control_b[3]);
    vec4 b1 = cubic(wu, control_b[4], fa.b, fb.b, control_b[7]);
    vec4 b2 = cubic(wu, control_b[8], fd.b, fc.b, control_b[11]);
    vec4 b3 = cubic(wu, control_b[12], control_b[13], control_b[14], control_b[15]);
    return Value(cubic(wv, a0, a1, a2, a3), cubic(wv, b0, b1, b2, b3));
}
