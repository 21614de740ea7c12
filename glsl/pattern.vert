#version 450
#extension GL_GOOGLE_include_directive : require
// A vertex of a refinement pattern, moved to its place on a coarse triangle (BS05 3.2). The triangle's attributes are
// looked up by the instance; SOURCE 1: they are uniforms, as in the paper; SOURCE 2: those of a flat triangle come as
// vertex attributes that change with the instance. DETAIL: instances are triangles of one level of detail. READBACK:
// written to a buffer.
#include "inc/pattern.glsl"
#include "inc/detail.glsl"

#if SOURCE == 1
layout(set = 0, binding = 1, std140) uniform One {
    Triangle one;
};
#elif SOURCE == 2
layout(location = 1) in vec4 corner[3];
layout(location = 4) in vec4 vector[3];
layout(location = 7) in vec4 tint[3];
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
#if DETAIL
layout(set = 0, binding = 4, std430) readonly buffer List {
    Placed list[];
};
#endif

layout(location = 0) in vec3 weights;
layout(location = 0) out vec3 normal;
layout(location = 1) out vec4 colour;

void main()
{
    vec3 position;
#if DETAIL
    Placed placed = list[push.list + uint(gl_InstanceIndex)];
    vec3 at = place(weights, push.level, placed);
    evaluate(all[placed.which.x], at, position, normal, colour);
#elif SOURCE == 1
    evaluate(one, weights, position, normal, colour);
#elif SOURCE == 2
    Triangle flat_one;
    for (int i = 0; i < 3; ++i) {
        flat_one.point[i] = corner[i];
        flat_one.normal[i] = vector[i];
        flat_one.colour[i] = tint[i];
    }
    evaluate(flat_one, weights, position, normal, colour);
#else
    evaluate(all[gl_InstanceIndex], weights, position, normal, colour);
#endif
#if READBACK
    uint row = 2u * (push.record + uint(gl_InstanceIndex) * push.vertices + uint(gl_VertexIndex));
    record[row] = vec4(position, 1.0);
    record[row + 1u] = vec4(normal, 0.0);
#endif
    precise vec4 clip = push.clip * vec4(position, 1.0);
    gl_Position = clip;
}
