// What a vertex of a surface in space hands on, with its normal blended. Needs: solid.glsl, the three outputs.
// CPU twin: src/surface/patch_eval.rs, `shaded`.
void shade(vec4 a, vec4 b, vec3 across)
{
    vec3 limit = normalize(across);
    vec3 subdivided = dot(b.xyz, b.xyz) > 0.0 ? normalize(b.xyz) : limit;
    float w = clamp(a.w, 0.0, 1.0);
    float blend = push.normals == 1u ? 0.0 : push.normals == 2u ? 1.0 : w > 0.0 ? pow(w, push.up.w) : 0.0;
    normal = mix(limit, subdivided, blend);
    position = a.xyz;
    weight = w;
    gl_Position = push.clip * vec4(position, 1.0);
}
