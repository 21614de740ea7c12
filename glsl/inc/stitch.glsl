// Stitched sides. Needs: control_a[], control_b[], bezier.glsl. CPU twin: src/patch/stitched.rs, which explains them.

// Control point of corner i, which side i leaves.
int corner_slot(int i)
{
    return i == 0 ? 0 : i == 1 ? 3 : i == 2 ? 15 : 12;
}

// The four points of the face along side i, from its corner on.
ivec4 side_slots(int i)
{
    int start = corner_slot(i);
    int step = i == 0 ? 1 : i == 1 ? 4 : i == 2 ? -1 : -4;
    return ivec4(start, start + step, start + 2 * step, start + 3 * step);
}

bool is_stitched(int i)
{
    int inner = i == 0 ? 5 : i == 1 ? 6 : i == 2 ? 10 : 9;
    return control_a[inner].z == 1.0;
}

// Number j of side i, 0 to 23.
float stitch_number(int i, int j)
{
    int point = 16 + 4 * i + j / 6;
    int channel = j % 6;
    return channel < 2 ? control_a[point][2 + channel] : control_b[point][channel - 2];
}

// Level of a stitched side.
float stitch_level(int i)
{
    return abs(stitch_number(i, 1) - stitch_number(i, 0));
}

// Number on the curve of vertex k of side i. CPU twin: Stitch::number.
float stitch_at(int i, float k)
{
    float first = stitch_number(i, 0);
    return stitch_number(i, 1) > first ? first + k : first - k;
}

// 1 - t and t of number k on the curve of side i. CPU twin: Stitch::parameter.
vec2 stitch_parameter(int i, float k)
{
    float n = stitch_number(i, 2);
    int knots = int(stitch_number(i, 3));
    if (knots == 0) {
        precise vec2 even = vec2((n - k) / n, k / n);
        return even;
    }
    int at = 0;
    for (int j = 1; j < knots; j++) {
        if (stitch_number(i, 4 + 2 * j) <= k) {
            at = j;
        }
    }
    float k0 = stitch_number(i, 4 + 2 * at);
    float t0 = stitch_number(i, 5 + 2 * at);
    precise vec2 result = vec2(1.0 - t0, t0);
    if (k != k0 && at + 1 < knots) {
        float k1 = stitch_number(i, 6 + 2 * at);
        float t1 = stitch_number(i, 7 + 2 * at);
        precise float d = k1 - k0;
        precise float t = (t0 * (k1 - k) + t1 * (k - k0)) / d;
        result = vec2(1.0 - t, t);
    }
    return result;
}

// Point with number k of the curve of side i.
vec2 stitch_point(int i, float k)
{
    vec2 st = stitch_parameter(i, k);
    vec4 w = bernstein(st.x, st.y);
    int p = 16 + 4 * i;
    return cubic(w, vec4(control_a[p].xy, 0.0, 0.0), vec4(control_a[p + 1].xy, 0.0, 0.0),
                 vec4(control_a[p + 2].xy, 0.0, 0.0), vec4(control_a[p + 3].xy, 0.0, 0.0)).xy;
}
