// Push constants of every stage. CPU twin: src/gpu/layout.rs, `Push`.
layout(push_constant, std430) uniform Push {
    vec4 view;        // ndc = xy * view.xy + view.zw
    vec4 flat_colour; // straight alpha; used when show is 1
    vec4 tess;        // level of Full sides, of Half sides, of Inner sides; w: pixels a segment (x: the greatest level), or 0
    vec2 pixels;      // pixels a model unit in x and y
    uint corners;     // part corner i in bits 4i to 4i+3: u + 4 v, in halves
    uint sides;       // side i in bits 4i to 4i+3: 0 Inner, 4 + e Full(e), 8 + h Half(h)
    uint show;        // 0 interpolated colour, 1 flat_colour
    uint clamped;     // bit 0: clamp the colour to [0, 1] at output; bit 1: colours are premultiplied; bits 4 on: space
    uint range;       // read-back only: number of the draw range
    uint patch_index; // read-back only: number of the patch in the range
} push;
