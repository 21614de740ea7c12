#version 450
#extension GL_GOOGLE_include_directive : require
// Colour of a pixel of a surface in space, seen from either side.
#include "inc/solid.glsl"

layout(location = 0) in vec3 normal;
layout(location = 1) in vec3 position;
layout(location = 2) in float weight;
layout(location = 0) out vec4 pixel;

// 0 and 1 in turns along x, with edges a pixel wide.
float stripes(float x)
{
    float s = sin(x);
    float w = clamp(fwidth(s), 1e-4, 1.0);
    return smoothstep(-w, w, s);
}

void main()
{
    vec3 n = normalize(normal);
    if (!gl_FrontFacing) {
        n = -n;
    }
    vec3 back = cross(push.right.xyz, push.up.xyz);
    vec3 v = push.eye.w > 0.0 ? normalize(push.eye.xyz - position) : push.eye.xyz;
    mat3 to_eye = transpose(mat3(push.right.xyz, push.up.xyz, back));
    vec3 n_eye = to_eye * n;
    vec3 r_eye = to_eye * reflect(-v, n);
    // Both before the branches: derivatives need them in every pixel.
    float highlight = stripes(push.right.w * dot(n_eye, vec3(0.57735027)));
    float reflection = stripes(push.right.w * r_eye.x);
    vec3 c = normal;
    if (push.show == 0u) {
        const vec3 light = normalize(vec3(0.5, 0.6, 0.8));
        float diffuse = max(dot(n_eye, light), 0.0);
        float glance = pow(max(dot(r_eye, light), 0.0), 20.0);
        c = vec3(0.53, 0.80, 0.87) * (0.22 + 0.68 * diffuse) + 0.25 * glance;
    } else if (push.show == 1u) {
        c = mix(vec3(0.0, 0.0, 0.6), vec3(0.4, 1.0, 1.0), highlight);
    } else if (push.show == 2u) {
        c = mix(vec3(0.12, 0.12, 0.15), vec3(0.95), reflection);
    } else if (push.show == 3u) {
        c = 0.5 + 0.5 * n;
    } else if (push.show == 4u) {
        c = vec3(weight, 0.0, 1.0 - weight);
    } else if (push.show == 6u) {
        c = gl_FrontFacing ? vec3(1.0) : vec3(1.0, 0.0, 0.0);
    }
    pixel = vec4(clamp(c, 0.0, 1.0), 1.0);
}
