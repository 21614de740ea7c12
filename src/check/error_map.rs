//! The error of a picture as a picture: the plasma colour map of the paper's figures 8, 9, 13 and 14.

use super::picture_error::{BACKGROUND, EDGE};
use crate::image::Picture;

/// Magnification of the paper's difference pictures.
pub const GAIN: f64 = 200.0;

/// Background of the map.
const NOTHING: [u8; 4] = [255, 255, 255, 255];
/// Pixels of silhouettes and sharp edges.
const EDGES: [u8; 4] = [150, 150, 150, 255];

/// A map (per cent of the cube's diagonal, [`BACKGROUND`] or [`EDGE`]) with each distance magnified `gain` times: at
/// [`GAIN`] the brightest colour stands for half a per cent and more.
pub fn picture(map: &[f32], [width, height]: [u32; 2], gain: f64) -> Picture {
    let colour = |&percent: &f32| match percent {
        BACKGROUND => NOTHING,
        EDGE => EDGES,
        _ => {
            let c = colorous::PLASMA.eval_continuous((f64::from(percent) / 100.0 * gain).clamp(0.0, 1.0));
            [c.r, c.g, c.b, 255]
        }
    };
    Picture { width, height, rgba: map.iter().flat_map(colour).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_ends_at_half_a_per_cent() {
        let p = picture(&[BACKGROUND, EDGE, 0.0, 0.5, 0.25, 9.0], [3, 2], GAIN);
        assert_eq!((p.pixel(0, 0), p.pixel(1, 0)), (NOTHING, EDGES));
        assert_eq!(p.pixel(0, 1), p.pixel(2, 1));
        assert_ne!(p.pixel(0, 1), p.pixel(1, 1));
        // Ends of matplotlib's plasma.
        assert!(p.pixel(2, 0)[2] > 100 && p.pixel(0, 1)[0] > 230 && p.pixel(0, 1)[2] < 60);
    }
}
