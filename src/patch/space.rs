//! Colour spaces to interpolate in (BLHK18 App. A, and Oklab): what the colour channels of control points are coordinates
//! of. They are interpolated as they are, and only a pixel is turned into sRGB. Twin of `glsl/inc/space.glsl`.

use glam::{DMat3, DVec3, DVec4};

/// A colour space to interpolate in. White is D65 everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    /// sRGB with its gamma, 0 to 1: the paper's default.
    #[default]
    Srgb,
    /// sRGB without gamma.
    Linear,
    /// CIE XYZ, Y of white 1.
    Xyz,
    /// CIELAB, L from 0 to 100.
    Lab,
    /// CIELUV, L from 0 to 100.
    Luv,
    /// Oklab, L from 0 to 1.
    Oklab,
}

/// All spaces with their names in files and on the command line.
pub const SPACES: [(Space, &str); 6] = [
    (Space::Srgb, "srgb"),
    (Space::Linear, "linear"),
    (Space::Xyz, "xyz"),
    (Space::Lab, "lab"),
    (Space::Luv, "luv"),
    (Space::Oklab, "oklab"),
];

/// Columns of linear sRGB to XYZ (IEC 61966-2-1).
const TO_XYZ: DMat3 = DMat3::from_cols_array(&[
    0.412_390_799_265_959_5,
    0.212_639_005_871_510_36,
    0.019_330_818_715_591_85,
    0.357_584_339_383_877_96,
    0.715_168_678_767_755_9,
    0.119_194_779_794_625_99,
    0.180_480_788_401_834_3,
    0.072_192_315_360_733_71,
    0.950_532_152_249_660_6,
]);
/// Columns of XYZ to linear sRGB.
const FROM_XYZ: DMat3 = DMat3::from_cols_array(&[
    3.240_969_941_904_521_3,
    -0.969_243_636_280_879_8,
    0.055_630_079_696_993_61,
    -1.537_383_177_570_093_5,
    1.875_967_501_507_720_7,
    -0.203_976_958_888_976_57,
    -0.498_610_760_293_003_3,
    0.041_555_057_407_175_61,
    1.056_971_514_242_878_6,
]);
/// Linear sRGB to the cone responses of Oklab (Ottosson 2020), rows.
const TO_CONES: [[f64; 3]; 3] = [
    [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
    [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
    [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
];
const TO_OKLAB: [[f64; 3]; 3] = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];
/// CIE constants: (6/29)^3 and (29/3)^3.
const EPSILON: f64 = 216.0 / 24389.0;
const KAPPA: f64 = 24389.0 / 27.0;

fn matrix(rows: &[[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(rows).transpose()
}

fn white() -> DVec3 {
    TO_XYZ * DVec3::ONE
}

/// sRGB to linear; odd about 0, so that every number has an image.
pub fn linear_of(x: f64) -> f64 {
    let a = x.abs();
    (if a <= 0.040_45 { a / 12.92 } else { ((a + 0.055) / 1.055).powf(2.4) }).copysign(x)
}

/// Linear to sRGB.
pub fn srgb_of(x: f64) -> f64 {
    let a = x.abs();
    (if a <= 0.003_130_8 { 12.92 * a } else { 1.055 * a.powf(1.0 / 2.4) - 0.055 }).copysign(x)
}

/// u', v' of CIELUV; those of white for black, so that black is no pole.
fn chroma(xyz: DVec3) -> [f64; 2] {
    let d = xyz.x + 15.0 * xyz.y + 3.0 * xyz.z;
    if d.abs() > 1e-12 {
        [4.0 * xyz.x / d, 9.0 * xyz.y / d]
    } else {
        chroma(white())
    }
}

fn lightness(y: f64) -> f64 {
    if y > EPSILON {
        116.0 * y.cbrt() - 16.0
    } else {
        KAPPA * y
    }
}

fn luminance(l: f64) -> f64 {
    if l > 8.0 {
        ((l + 16.0) / 116.0).powi(3)
    } else {
        l / KAPPA
    }
}

/// What the colour channels of a table mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Interpolation {
    /// Space of the first three.
    pub space: Space,
    /// Whether they are multiplied by alpha, the fourth.
    pub premultiplied: bool,
}

impl Interpolation {
    /// [`Space::decode`].
    pub fn decode(self, c: DVec4) -> DVec4 {
        self.space.decode(c, self.premultiplied)
    }
}

impl Space {
    /// The space of a name.
    pub fn named(name: &str) -> Option<Space> {
        SPACES.iter().find(|(_, n)| *n == name).map(|(space, _)| *space)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        SPACES[self as usize].1
    }

    /// Coordinates of an sRGB colour.
    pub fn of_srgb(self, rgb: DVec3) -> DVec3 {
        if self == Space::Srgb {
            return rgb;
        }
        let linear = DVec3::from(rgb.to_array().map(linear_of));
        match self {
            Space::Srgb => rgb,
            Space::Linear => linear,
            Space::Xyz => TO_XYZ * linear,
            Space::Lab => {
                let f = (TO_XYZ * linear / white()).to_array().map(|x| (lightness(x) + 16.0) / 116.0);
                DVec3::new(116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2]))
            }
            Space::Luv => {
                let xyz = TO_XYZ * linear;
                let ([u, v], [un, vn]) = (chroma(xyz), chroma(white()));
                let l = lightness(xyz.y);
                DVec3::new(l, 13.0 * l * (u - un), 13.0 * l * (v - vn))
            }
            Space::Oklab => {
                let cones = (matrix(&TO_CONES) * linear).to_array().map(f64::cbrt);
                matrix(&TO_OKLAB) * DVec3::from(cones)
            }
        }
    }

    /// The sRGB colour of coordinates, not clamped.
    pub fn to_srgb(self, c: DVec3) -> DVec3 {
        let linear = match self {
            Space::Srgb => return c,
            Space::Linear => c,
            Space::Xyz => FROM_XYZ * c,
            Space::Lab => {
                let fy = (c.x + 16.0) / 116.0;
                let f = [fy + c.y / 500.0, fy, fy - c.z / 200.0];
                FROM_XYZ * (DVec3::from(f.map(|f| luminance(116.0 * f - 16.0))) * white())
            }
            Space::Luv => {
                if c.x <= 0.0 {
                    return DVec3::ZERO;
                }
                let [un, vn] = chroma(white());
                let (u, v) = (c.y / (13.0 * c.x) + un, c.z / (13.0 * c.x) + vn);
                let y = luminance(c.x);
                let v = v.max(1e-6);
                FROM_XYZ * DVec3::new(y * 9.0 * u / (4.0 * v), y, y * (12.0 - 3.0 * u - 20.0 * v) / (4.0 * v))
            }
            Space::Oklab => {
                let cones = (matrix(&TO_OKLAB).inverse() * c).to_array().map(|x| x * x * x);
                matrix(&TO_CONES).inverse() * DVec3::from(cones)
            }
        };
        DVec3::from(linear.to_array().map(srgb_of))
    }

    /// Coordinates of an sRGB colour with straight alpha, multiplied by alpha where the mesh wants that.
    pub fn encode(self, rgba: DVec4, premultiplied: bool) -> DVec4 {
        let c = self.of_srgb(rgba.truncate());
        (if premultiplied { c * rgba.w } else { c }).extend(rgba.w)
    }

    /// sRGB with straight alpha of coordinates, not clamped. Without alpha, black.
    pub fn decode(self, c: DVec4, premultiplied: bool) -> DVec4 {
        let rgb = match premultiplied {
            true if c.w <= 0.0 => return DVec4::ZERO,
            true => c.truncate() / c.w,
            false => c.truncate(),
        };
        self.to_srgb(rgb).extend(c.w)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_come_back() {
        for (space, name) in SPACES {
            assert_eq!(Space::named(name), Some(space));
            for rgb in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.01, 0.99, 0.03]] {
                let rgb = DVec3::from(rgb);
                let back = space.to_srgb(space.of_srgb(rgb));
                // Oklab's published matrices have ten digits.
                assert!((back - rgb).abs().max_element() < 1e-7, "{name}: {rgb} {back}");
            }
        }
    }

    #[test]
    fn known_coordinates() {
        let close = |a: DVec3, b: [f64; 3], by: f64| (a - DVec3::from(b)).abs().max_element() < by;
        let red = DVec3::X;
        assert!(close(Space::Lab.of_srgb(red), [53.241, 80.092, 67.203], 0.02));
        assert!(close(Space::Luv.of_srgb(red), [53.241, 175.015, 37.756], 0.03));
        assert!(close(Space::Oklab.of_srgb(red), [0.62796, 0.22486, 0.12585], 1e-4));
        assert!(close(Space::Xyz.of_srgb(DVec3::ONE), [0.9505, 1.0, 1.0891], 1e-3));
        for space in [Space::Lab, Space::Luv] {
            assert!(close(space.of_srgb(DVec3::ONE), [100.0, 0.0, 0.0], 1e-9));
        }
    }

    #[test]
    fn premultiplied_colours_come_back() {
        let c = DVec4::new(0.2, 0.4, 0.6, 0.5);
        for premultiplied in [false, true] {
            let back = Space::Luv.decode(Space::Luv.encode(c, premultiplied), premultiplied);
            assert!((back - c).abs().max_element() < 1e-12);
        }
    }
}
