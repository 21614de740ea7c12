// Tessellation levels. Needs: part.glsl. CPU twin: src/patch/tess.rs (fixed levels) and eval::pixel_level.

#include "inc/polygon.glsl"

// Level of a side with this polygon by the screen-space rule: an integer from 1 to the greatest, which is push.tess.x.
float polygon_level(vec2 p0, vec2 p1, vec2 p2, vec2 p3)
{
    precise float level = ceil(polygon_pixels(p0, p1, p2, p3) / push.tess.w);
    // The comparison is false for NaN, which becomes the greatest level.
    return level <= push.tess.x ? max(level, 1.0) : push.tess.x;
}

// Level of side i by the screen-space rule.
float pixel_level(int i)
{
    vec2 p[4];
    if (is_inner(i)) {
        p[0] = control_a[corner_point(i)].xy;
        p[1] = surface(inner_uv(i, 2.0 / 3.0, 1.0 / 3.0)).a.xy;
        p[2] = surface(inner_uv(i, 1.0 / 3.0, 2.0 / 3.0)).a.xy;
        p[3] = control_a[corner_point(next_corner(i))].xy;
    } else {
        ivec4 q = side_points(i);
        p[0] = control_a[q.x].xy;
        p[1] = control_a[q.y].xy;
        p[2] = control_a[q.z].xy;
        p[3] = control_a[q.w].xy;
    }
    return polygon_level(p[0], p[1], p[2], p[3]);
}

// Level of side i: one of the three fixed levels, or by length in pixels.
float side_level(int i)
{
    if (push.tess.w > 0.0) {
        return pixel_level(i);
    }
    uint code = side_code(i);
    return code == 0u ? push.tess.z : code >= 8u ? push.tess.y : push.tess.x;
}
