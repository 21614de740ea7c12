// Push constants of scenes in space. CPU twin: src/gpu/solid.rs, `SolidPush`.
layout(push_constant, std430) uniform Push {
    mat4 clip;        // from model to clip space
    vec4 eye;         // xyz: the eye (w = 1), or the direction towards it of a parallel projection (w = 0)
    vec4 right;       // xyz: to the right in the picture; w: stripes a radian of highlight and reflection lines
    vec4 up;          // xyz: upwards in the picture; w: exponent of the blend weight
    uint show;        // 0 shaded, 1 highlight lines, 2 reflection lines, 3 normals, 4 weights, 5 plain colours, 6 sides
    uint normals;     // patches: 0 blended, 1 geometric, 2 subdivided
    float tess;       // patches: level of their edges
    float finer;      // patches: the same on the next level
} push;
