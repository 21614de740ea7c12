// Sides of the tessellator's domain. Needs: SHAPE as in part.glsl. CPU twin: eval::side_of.

// Nearer than this to a side means on it: interior vertices are at least 1/100 away, rounding at most 1e-6.
const float ON_SIDE = 1.0 / 512.0;

// The side that the vertex lies on, or -1.
int side_of(vec3 c)
{
#if SHAPE == 1
    return c.z < ON_SIDE ? 0 : c.x < ON_SIDE ? 1 : c.y < ON_SIDE ? 2 : -1;
#else
    return c.y < ON_SIDE ? 0 : c.x > 1.0 - ON_SIDE ? 1 : c.y > 1.0 - ON_SIDE ? 2 : c.x < ON_SIDE ? 3 : -1;
#endif
}

// Parameter along a side, from its corner on.
float along(int side, vec3 c)
{
#if SHAPE == 1
    return side == 0 ? c.y : side == 1 ? c.z : c.x;
#else
    return side == 0 ? c.x : side == 1 ? c.y : side == 2 ? 1.0 - c.x : 1.0 - c.y;
#endif
}
