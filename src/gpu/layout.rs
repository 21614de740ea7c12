//! Structures that both sides of the bus know, with their GLSL twins.

use super::memory::Plain;
use crate::patch::transition::{Side, PARTS};

/// Push constants. Twin of `Push` in `glsl/inc/layout.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Push {
    /// Scale and offset from model to normalised device coordinates: `ndc = xy * view.xy + view.zw`.
    pub view: [f32; 4],
    /// Straight alpha; used when `show` is 1.
    pub flat_colour: [f32; 4],
    /// Level of Full, Half and Inner sides; pixels a segment (then the first is the greatest level), 0 for the fixed levels.
    pub tess: [f32; 4],
    /// Pixels a model unit in x and y.
    pub pixels: [f32; 2],
    /// Part corner i in bits 4i to 4i+3: u + 4 v, in halves.
    pub corners: u32,
    /// Side i in bits 4i to 4i+3: 0 Inner, 4 + e Full(e), 8 + h Half(h).
    pub sides: u32,
    /// 0 interpolated colour, 1 `flat_colour`.
    pub show: u32,
    /// Bit 0: clamp the colour to [0, 1] at output; bit 1: colours are premultiplied; bits 4 on: number of the space.
    pub clamped: u32,
    /// Read-back only: number of the draw range.
    pub range: u32,
    /// Read-back only: number of the patch in the range.
    pub patch: u32,
}

const _: () = assert!(size_of::<Push>() == 80 && size_of::<Push>() <= 128);
const _: () = assert!(std::mem::offset_of!(Push, pixels) == 48 && std::mem::offset_of!(Push, patch) == 76);
// SAFETY: repr(C), 4-byte fields only, 80 bytes without padding.
unsafe impl Plain for Push {}

/// An evaluated vertex as the read-back shader writes it. Twin of `Record` in `glsl/patch.tese`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Range, patch, 0, 0.
    pub place: [u32; 4],
    /// `gl_TessCoord`, 0.
    pub coord: [f32; 4],
    /// Level of sides 0 to 3.
    pub outer: [f32; 4],
    /// The eight channels.
    pub value: [f32; 8],
}

const _: () = assert!(size_of::<Record>() == 80);

/// Bytes before the records: count, capacity, two pads.
pub const RECORDS_AT: usize = 16;

impl Record {
    /// Reads a record from its 80 bytes.
    pub fn read(bytes: &[u8]) -> Record {
        let word = |i: usize| [0, 1, 2, 3].map(|b| bytes[4 * i + b]);
        let int = |i| u32::from_le_bytes(word(i));
        let float = |i| f32::from_le_bytes(word(i));
        Record {
            place: std::array::from_fn(int),
            coord: std::array::from_fn(|i| float(4 + i)),
            outer: std::array::from_fn(|i| float(8 + i)),
            value: std::array::from_fn(|i| float(12 + i)),
        }
    }
}

/// `Push::corners` and `Push::sides` of a drawn patch: the whole face, or a part of [`PARTS`].
pub fn part_codes(part: Option<u8>) -> (u32, u32) {
    let Some(number) = part else {
        // A (0,0), B (2,0), C (2,2), D (0,2) and Full(0) to Full(3).
        return (0x8A20, 0x7654);
    };
    let part = &PARTS[number as usize];
    let (mut corners, mut sides) = (0, 0);
    for i in 0..4 {
        let [u, v] = part.corners[i].map(u32::from);
        corners |= (u + 4 * v) << (4 * i);
        let code = match part.sides[i] {
            Side::Inner => 0,
            Side::Full(e) => 4 + u32::from(e),
            Side::Half(pair) => 8 + u32::from(pair),
        };
        sides |= code << (4 * i);
    }
    (corners, sides)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_hold_the_tables() {
        // C1, part 0: A (0,0), M0 (1,0), D (0,2), D again; Half(0), Inner, Full(3).
        assert_eq!(part_codes(Some(0)), (0x8810, 0x0708));
        assert_eq!(part_codes(None).0 >> 8 & 15, 2 + 4 * 2);
    }
}
