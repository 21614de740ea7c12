// Corners and sides of the drawn domain: the whole face, or one part of a transition face.
// Needs: SHAPE (0 whole face, 1 triangle part, 2 quad part), layout.glsl, face.glsl.
// CPU twin: src/patch/eval.rs; the tables arrive in push.corners and push.sides (src/gpu/layout.rs).

#if SHAPE == 1
const int SIDES = 3;
#else
const int SIDES = 4;
#endif

#if SHAPE == 0
const int POINTS = FACE_POINTS;
#else
const int POINTS = FACE_POINTS + 8;
#endif

int next_corner(int i)
{
    return i + 1 == SIDES ? 0 : i + 1;
}

// Control point of face corner i.
int face_corner(int i)
{
    return i == 0 ? 0 : i == 1 ? 3 : i == 2 ? 15 : 12;
}

// Control point of domain corner i.
int corner_point(int i)
{
#if SHAPE == 0
    return face_corner(i);
#else
    return FACE_POINTS + i;
#endif
}

// Domain corner i in the face's domain.
vec2 corner_uv(int i)
{
    uint c = push.corners >> uint(4 * i);
    return 0.5 * vec2(float(c & 3u), float((c >> 2) & 3u));
}

uint side_code(int i)
{
    return (push.sides >> uint(4 * i)) & 15u;
}

bool is_inner(int i)
{
    return side_code(i) == 0u;
}

// The four control points of the cubic along side i (not an Inner one), from corner i on. CPU twin: eval::side_points.
ivec4 side_points(int i)
{
    uint code = side_code(i);
    if (code >= 8u) {
        int pair = FACE_POINTS + 4 + 2 * int(code - 8u);
        return ivec4(corner_point(i), pair, pair + 1, corner_point(next_corner(i)));
    }
    int e = int(code & 3u);
    int start = face_corner(e);
    int step = e == 0 ? 1 : e == 1 ? 4 : e == 2 ? -1 : -4;
    return ivec4(start, start + step, start + 2 * step, start + 3 * step);
}

// Point (s, t) of the straight line from domain corner i to the next, in the face's domain.
vec2 inner_uv(int i, float s, float t)
{
    precise vec2 uv = s * corner_uv(i) + t * corner_uv(next_corner(i));
    return uv;
}

// Index of side i in gl_TessLevelOuter. Quad: 0 is u = 0 (side 3), 1 is v = 0 (side 0), and on. Triangle: i is
// opposite to corner i.
int outer_of(int i)
{
#if SHAPE == 1
    return i == 0 ? 2 : i - 1;
#else
    return i == 3 ? 0 : i + 1;
#endif
}
