//! Surface formats: colours of the scene and of the widgets are sRGB already, and none may be converted on its way to
//! the screen.

use super::error::GpuError;
use crate::image::Picture;
use ash::vk;

/// How widgets get into the swapchain's images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// They are drawn there.
    Straight,
    /// Byte for byte out of an image of this format, which differs from theirs in how bytes are read only.
    Copied(vk::Format),
    /// Out of an image of this format, value for value.
    Blitted(vk::Format),
}

/// A surface format, and how colours get there as they are, for they are sRGB already: drawn at best; else drawn in a
/// format without conversion and copied, or blitted where the device `blits` to the format.
pub(super) fn choose_format(
    formats: &[vk::SurfaceFormatKHR],
    converting: bool,
    blits: impl Fn(vk::Format) -> bool,
) -> Result<(vk::SurfaceFormatKHR, Way), GpuError> {
    use vk::Format as F;
    let straight = [
        F::B8G8R8A8_UNORM,
        F::R8G8B8A8_UNORM,
        F::A8B8G8R8_UNORM_PACK32,
        F::A2B10G10R10_UNORM_PACK32,
        F::A2R10G10B10_UNORM_PACK32,
        F::R5G6B5_UNORM_PACK16,
    ];
    let twins = [
        (F::B8G8R8A8_SRGB, F::B8G8R8A8_UNORM),
        (F::R8G8B8A8_SRGB, F::R8G8B8A8_UNORM),
        (F::A8B8G8R8_SRGB_PACK32, F::A8B8G8R8_UNORM_PACK32),
    ];
    if let Some(any) = formats.iter().find(|f| f.format == F::UNDEFINED) {
        let format = if converting { twins[0].0 } else { straight[0] };
        let way = if converting { Way::Copied(twins[0].1) } else { Way::Straight };
        return Ok((vk::SurfaceFormatKHR { format, color_space: any.color_space }, way));
    }
    let plain = || formats.iter().filter(|f| f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR);
    let find = |wanted: F| plain().find(|f| f.format == wanted).copied();
    if !converting {
        if let Some(found) = straight.into_iter().find_map(find) {
            return Ok((found, Way::Straight));
        }
    }
    if let Some((found, unorm)) = twins.into_iter().find_map(|(srgb, unorm)| Some((find(srgb)?, unorm))) {
        return Ok((found, Way::Copied(unorm)));
    }
    // Values are converted between number types, not between colour spaces.
    let rest = plain().find(|f| !straight.contains(&f.format) && blits(f.format));
    rest.map(|&found| (found, Way::Blitted(F::R8G8B8A8_UNORM))).ok_or_else(|| {
        GpuError::Request("the window takes no surface format of sRGB colours; choose another device".to_owned())
    })
}

/// Whether a format's bytes are blue, green, red, alpha (true) or red, green, blue, alpha; `None` for others.
pub(super) fn bytes_order(format: vk::Format) -> Option<bool> {
    match format {
        vk::Format::B8G8R8A8_UNORM => Some(true),
        vk::Format::R8G8B8A8_UNORM | vk::Format::A8B8G8R8_UNORM_PACK32 => Some(false),
        _ => None,
    }
}

pub(super) fn picture(bytes: &[u8], [width, height]: [u32; 2], format: vk::Format) -> Picture {
    let mut rgba = bytes.to_vec();
    for pixel in rgba.chunks_exact_mut(4) {
        if bytes_order(format) == Some(true) {
            pixel.swap(0, 2);
        }
        // Windows are opaque.
        pixel[3] = 255;
    }
    Picture { width, height, rgba }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(format: vk::Format) -> vk::SurfaceFormatKHR {
        vk::SurfaceFormatKHR { format, color_space: vk::ColorSpaceKHR::SRGB_NONLINEAR }
    }

    #[test]
    fn colours_are_never_converted() {
        let choose = |formats: &[vk::Format], converting| {
            let formats: Vec<_> = formats.iter().map(|&f| surface(f)).collect();
            let found = choose_format(&formats, converting, |f| f == vk::Format::R16G16B16A16_SFLOAT);
            found.map(|(f, way)| (f.format, way))
        };
        use vk::Format as F;
        let both = [F::B8G8R8A8_SRGB, F::R8G8B8A8_UNORM];
        assert_eq!(choose(&both, false).unwrap(), (F::R8G8B8A8_UNORM, Way::Straight));
        assert_eq!(choose(&both, true).unwrap(), (F::B8G8R8A8_SRGB, Way::Copied(F::B8G8R8A8_UNORM)));
        let two = [F::R8G8B8A8_UNORM, F::B8G8R8A8_UNORM];
        assert_eq!(choose(&two, false).unwrap(), (F::B8G8R8A8_UNORM, Way::Straight));
        assert!(choose(&two, true).unwrap_err().is_request());
        assert_eq!(choose(&[F::UNDEFINED], false).unwrap(), (F::B8G8R8A8_UNORM, Way::Straight));
        assert_eq!(choose(&[F::R8G8B8A8_SRGB], false).unwrap().1, Way::Copied(F::R8G8B8A8_UNORM));
        let float = choose(&[F::R16G16B16A16_SFLOAT], false).unwrap();
        assert_eq!(float, (F::R16G16B16A16_SFLOAT, Way::Blitted(F::R8G8B8A8_UNORM)));
        assert!(choose(&[F::R8G8_UNORM], false).unwrap_err().is_request());
        assert_eq!(picture(&[1, 2, 3, 4], [1, 1], F::B8G8R8A8_UNORM).rgba, [3, 2, 1, 255]);
        assert_eq!(picture(&[1, 2, 3, 4], [1, 1], F::R8G8B8A8_UNORM).rgba, [1, 2, 3, 255]);
    }
}
