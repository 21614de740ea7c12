#version 450
#extension GL_GOOGLE_include_directive : require
// A vertex of hardware tessellation, evaluated as a refinement pattern's.
#include "inc/pattern.glsl"

layout(triangles, equal_spacing, ccw) in;
layout(set = 0, binding = 0, std430) readonly buffer All {
    Triangle all[];
};
layout(location = 0) patch in uint triangle;
layout(location = 0) out vec3 normal;
layout(location = 1) out vec4 colour;

void main()
{
    // Snapped to k / T, as the pattern's weights: both triangles of an edge then have the same.
    vec3 at = round(gl_TessCoord * push.light.w) / push.light.w;
    // Inner rings are not on that lattice.
    if (min(min(gl_TessCoord.x, gl_TessCoord.y), gl_TessCoord.z) > 0.0) {
        at = gl_TessCoord;
    }
    vec3 position;
    evaluate(all[triangle], at, position, normal, colour);
    precise vec4 clip = push.clip * vec4(position, 1.0);
    gl_Position = clip;
}
