#version 450
#extension GL_GOOGLE_include_directive : require
// A vertex of a refinement pattern, moved to its place on a coarse triangle (BS05 3.2). UNIFORM: the triangle's attributes
// are uniforms, as in the paper; else they are looked up by the instance. READBACK: written to a buffer.
#include "inc/pattern.glsl"

#if UNIFORM
layout(set = 0, binding = 1, std140) uniform One {
    Triangle one;
};
#else
layout(set = 0, binding = 0, std430) readonly buffer All {
    Triangle all[];
};
#endif
#if READBACK
layout(set = 0, binding = 3, std430) writeonly buffer Records {
    vec4 record[];
};
#endif

layout(location = 0) in vec3 weights;
layout(location = 0) out vec3 normal;
layout(location = 1) out vec4 colour;

void main()
{
    vec3 position;
#if UNIFORM
    evaluate(one, weights, position, normal, colour);
#else
    evaluate(all[gl_InstanceIndex], weights, position, normal, colour);
#endif
#if READBACK
    uint at = 2u * (uint(gl_InstanceIndex) * push.vertices + uint(gl_VertexIndex));
    record[at] = vec4(position, 1.0);
    record[at + 1u] = vec4(normal, 0.0);
#endif
    precise vec4 clip = push.clip * vec4(position, 1.0);
    gl_Position = clip;
}
