// Evaluated vertices, read back. CPU twin: src/gpu/layout.rs, `Record`.
struct Record {
    uvec4 place; // range, patch, 0, 0
    vec4 coord;  // gl_TessCoord, 0
    vec4 outer;  // level of sides 0 to 3
    vec4 a;
    vec4 b;
};
layout(set = 0, binding = 0, std430) buffer Records {
    uint count;
    uint capacity;
    uint pad0;
    uint pad1;
    Record records[];
};
