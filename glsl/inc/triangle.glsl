// A coarse triangle's attributes. CPU twin: src/gpu/pattern/attributes.rs (`Block`).
struct Triangle {
    vec4 point[10];
    vec4 normal[6];
    vec4 direction[6];
    vec4 colour[3];
    vec4 uv01;      // texture coordinates of corners 0 and 1
    vec4 uv2;       // of corner 2
    vec4 gradient_s;
    vec4 gradient_t;
    vec4 unused[3];
};
