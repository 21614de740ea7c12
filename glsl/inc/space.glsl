// Colour spaces: coordinates to sRGB, not clamped. CPU twin: src/patch/space.rs, `Space::to_srgb`; the numbers of the
// spaces are those of the enum there.

const vec3 WHITE = vec3(0.9504559270516716, 1.0, 1.0890577507598784);
const mat3 XYZ_TO_LINEAR = mat3(3.2409699419045213, -0.9692436362808798, 0.05563007969699361,
                                -1.5373831775700935, 1.8759675015077207, -0.20397695888897657,
                                -0.4986107602930033, 0.04155505740717561, 1.0569715142428786);
const mat3 LAB_TO_CONES = mat3(1.0, 1.0, 1.0,
                               0.3963377774, -0.1055613458, -0.0894841775,
                               0.2158037573, -0.0638541728, -1.2914855480);
const mat3 CONES_TO_LINEAR = mat3(4.0767416621, -1.2684380046, -0.0041960863,
                                  -3.3077115913, 2.6097574011, -0.7034186147,
                                  0.2309699292, -0.3413193965, 1.7076147010);

float gamma_of(float x)
{
    float a = abs(x);
    return sign(x) * (a <= 0.0031308 ? 12.92 * a : 1.055 * pow(a, 1.0 / 2.4) - 0.055);
}

// Relative luminance of lightness L.
float luminance(float l)
{
    float f = (l + 16.0) / 116.0;
    return l > 8.0 ? f * f * f : l * (27.0 / 24389.0);
}

vec3 linear_of(uint space, vec3 c)
{
    if (space == 2u) {
        return XYZ_TO_LINEAR * c;
    }
    if (space == 3u) {
        float fy = (c.x + 16.0) / 116.0;
        vec3 f = vec3(fy + c.y / 500.0, fy, fy - c.z / 200.0);
        vec3 y = vec3(luminance(116.0 * f.x - 16.0), luminance(116.0 * f.y - 16.0), luminance(116.0 * f.z - 16.0));
        return XYZ_TO_LINEAR * (y * WHITE);
    }
    if (space == 4u) {
        if (c.x <= 0.0) {
            return vec3(0.0);
        }
        float sum = WHITE.x + 15.0 * WHITE.y + 3.0 * WHITE.z;
        float u = c.y / (13.0 * c.x) + 4.0 * WHITE.x / sum;
        float v = max(c.z / (13.0 * c.x) + 9.0 * WHITE.y / sum, 1e-6);
        float y = luminance(c.x);
        return XYZ_TO_LINEAR * vec3(y * 9.0 * u / (4.0 * v), y, y * (12.0 - 3.0 * u - 20.0 * v) / (4.0 * v));
    }
    if (space == 5u) {
        vec3 cones = LAB_TO_CONES * c;
        return CONES_TO_LINEAR * (cones * cones * cones);
    }
    return c;
}

vec3 to_srgb(uint space, vec3 c)
{
    if (space == 0u) {
        return c;
    }
    vec3 l = linear_of(space, c);
    return vec3(gamma_of(l.x), gamma_of(l.y), gamma_of(l.z));
}
