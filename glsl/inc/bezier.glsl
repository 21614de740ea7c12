// Cubic Bezier curves. CPU twin: src/patch/eval.rs.
// `precise` and the pairing make (s, t) on p0..p3 and (t, s) on p3..p0 the same bits.

// Bernstein weights for s + t = 1. CPU twin: eval::bernstein.
vec4 bernstein(float s, float t)
{
    precise float ss = s * s;
    precise float tt = t * t;
    precise vec4 w = vec4(ss * s, (3.0 * ss) * t, (3.0 * tt) * s, tt * t);
    return w;
}

// Point of a cubic. CPU twin: eval::cubic.
vec4 cubic(vec4 w, vec4 p0, vec4 p1, vec4 p2, vec4 p3)
{
    precise vec4 r = (w.x * p0 + w.y * p1) + (w.z * p2 + w.w * p3);
    return r;
}
