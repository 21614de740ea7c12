// Lengths on the screen. Needs: layout.glsl.

// Length in pixels of the polygon p0 p1 p2 p3; the same bits from either end.
float polygon_pixels(vec2 p0, vec2 p1, vec2 p2, vec2 p3)
{
    precise vec2 d0 = (p1 - p0) * push.pixels;
    precise vec2 d1 = (p2 - p1) * push.pixels;
    precise vec2 d2 = (p3 - p2) * push.pixels;
    precise float l0 = sqrt(d0.x * d0.x + d0.y * d0.y);
    precise float l1 = sqrt(d1.x * d1.x + d1.y * d1.y);
    precise float l2 = sqrt(d2.x * d2.x + d2.y * d2.y);
    precise float l = (l0 + l2) + l1;
    return l;
}
