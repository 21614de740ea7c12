//! Colours as people write them: hex, HSV, Oklab.

use glam::{DVec3, DVec4};

/// Swatches to begin with.
pub fn first_swatches() -> Vec<DVec4> {
    ["#ffffff", "#1d1d22", "#e8695c", "#f5d69e", "#299985", "#8cbfe6", "#8a5aa8", "#b01c2e"]
        .iter()
        .filter_map(|hex| from_hex(hex))
        .collect()
}

/// `#rrggbb` or `#rrggbbaa`, with or without the sign; `None` for anything else.
pub fn from_hex(text: &str) -> Option<DVec4> {
    let text = text.trim().trim_start_matches('#');
    if !matches!(text.len(), 6 | 8) || !text.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let byte = |i: usize| u8::from_str_radix(text.get(2 * i..2 * i + 2)?, 16).ok().map(|b| f64::from(b) / 255.0);
    Some(DVec4::new(byte(0)?, byte(1)?, byte(2)?, if text.len() == 8 { byte(3)? } else { 1.0 }))
}

/// `#rrggbb`, with alpha where it is not 1.
pub fn to_hex(c: DVec4) -> String {
    let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    let alpha = if byte(c.w) == 255 { String::new() } else { format!("{:02x}", byte(c.w)) };
    format!("#{:02x}{:02x}{:02x}{alpha}", byte(c.x), byte(c.y), byte(c.z))
}

fn decode(x: f64) -> f64 {
    if x <= 0.04045 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

fn encode(x: f64) -> f64 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// Oklab (L, a, b) of an sRGB colour (B. Ottosson: A perceptual color space for image processing, 2020).
pub fn to_oklab(c: DVec3) -> DVec3 {
    let [r, g, b] = [decode(c.x), decode(c.y), decode(c.z)];
    let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
    let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
    let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
    DVec3::new(
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    )
}

/// The sRGB colour of an Oklab one; may lie outside [0, 1].
pub fn from_oklab(c: DVec3) -> DVec3 {
    let l = (c.x + 0.396_337_777_4 * c.y + 0.215_803_757_3 * c.z).powi(3);
    let m = (c.x - 0.105_561_345_8 * c.y - 0.063_854_172_8 * c.z).powi(3);
    let s = (c.x - 0.089_484_177_5 * c.y - 1.291_485_548_0 * c.z).powi(3);
    DVec3::new(
        encode(4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s),
        encode(-1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s),
        encode(-0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s),
    )
}

/// Hue (turns), saturation and value of an sRGB colour.
pub fn to_hsv(c: DVec3) -> DVec3 {
    let (most, least) = (c.max_element(), c.min_element());
    let d = most - least;
    let hue = if d == 0.0 {
        0.0
    } else if most == c.x {
        ((c.y - c.z) / d).rem_euclid(6.0)
    } else if most == c.y {
        (c.z - c.x) / d + 2.0
    } else {
        (c.x - c.y) / d + 4.0
    };
    DVec3::new(hue / 6.0, if most > 0.0 { d / most } else { 0.0 }, most)
}

/// The sRGB colour of hue (turns), saturation and value.
pub fn from_hsv(c: DVec3) -> DVec3 {
    let at = |n: f64| {
        let k = (n + c.x * 6.0).rem_euclid(6.0);
        c.z - c.z * c.y * k.min(4.0 - k).clamp(0.0, 1.0)
    };
    DVec3::new(at(5.0), at(3.0), at(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_space_comes_back() {
        for i in 0..512 {
            let c = DVec3::new(f64::from(i & 7), f64::from(i >> 3 & 7), f64::from(i >> 6)) / 7.0;
            assert!((from_hsv(to_hsv(c)) - c).length() < 1e-12);
            // The published matrices are rounded; near black that counts 13-fold. Far below an eighth bit.
            assert!((from_oklab(to_oklab(c)) - c).length() < 1e-4, "{c}");
        }
        // White is (1, 0, 0), as the author of the space has it.
        assert!((to_oklab(DVec3::ONE) - DVec3::X).length() < 1e-6);
    }

    #[test]
    fn hex_is_read_and_written() {
        assert_eq!(to_hex(from_hex("#12aBff").unwrap()), "#12abff");
        assert_eq!(to_hex(from_hex("00000080").unwrap()), "#00000080");
        for wrong in ["", "#12", "#gggggg", "ééé", "#1234567"] {
            assert_eq!(from_hex(wrong), None, "{wrong}");
        }
    }
}
