// Transition faces in one piece. Needs: SHAPE 0, part.glsl and what it needs. CPU twin: src/patch/remap.rs, which
// explains them.

// Whether edge e has finer neighbours.
bool is_split(int e)
{
    return ((uint(control_a[12].z) >> uint(e)) & 1u) == 1u;
}

// Whether split edges follow the face's own curve.
bool on_own_curve()
{
    return uint(control_a[12].z) >= 16u;
}

// Number n of the 120 that hold the finer neighbours' points. CPU twin: remap::place.
float packed_number(int n)
{
    int point = n < 96 ? 20 + n / 8 : (n - 96) / 2;
    int channel = n < 96 ? n % 8 : 2 + n % 2;
    return channel < 4 ? control_a[point][channel] : control_b[point][channel - 4];
}

// Point p of split edge e: inner points of the first half, its end in the middle, inner points of the second half.
Value split_point(int e, int p)
{
    int n = 30 * e + 6 * p;
    return Value(vec4(packed_number(n), packed_number(n + 1), 0.0, 0.0),
                 vec4(packed_number(n + 2), packed_number(n + 3), packed_number(n + 4), packed_number(n + 5)));
}

// Control point q of the face without what is packed into it.
Value face_point(int q)
{
    return Value(vec4(control_a[q].xy, 0.0, 0.0), control_b[q]);
}

// The cubic along half h of split edge e, in the edge's direction. CPU twin: remap::half.
void half_points(int e, int h, out Value q[4])
{
    q[0] = h == 0 ? face_point(face_corner(e)) : split_point(e, 2);
    q[1] = split_point(e, 3 * h);
    q[2] = split_point(e, 3 * h + 1);
    q[3] = h == 0 ? split_point(e, 2) : face_point(face_corner(next_corner(e)));
}
