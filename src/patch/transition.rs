//! Transition faces: five constellations, seventeen parts (NLMD12 section 4).
//!
//! A face whose edge neighbours are refined once more is drawn as parts that meet the finer vertices at the
//! edges' midpoints. The face is turned so that its transition edges form one of five constellations:
//!
//! ```text
//!  C1: edge 0      C2: 0, 1        C3: 0, 2       C4: 0, 1, 2     C5: all
//!  D-------C       D-------C       D---M2--C      D---M2--C       D---M2--C
//!  |\     /|       |\   .-'|       |   |   |      |   | \ |       |   |   |
//!  | \   / |       | \.'  M1       |   |   |      |   |  M1       M3--+---M1
//!  |  \ /  |       |  \ .' |       |   |   |      |   | / |       |   |   |
//!  A---M0--B       A---M0--B       A---M0--B      A---M0--B       A---M0--B
//! ```

/// Control points that a part has beside those of its face: four corners, then two inner points for each of two half edges.
pub const EXTRA_POINTS: usize = 8;

/// What lies along one edge of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Inside the face: shared by two parts of the same face, a straight line in the domain.
    Inner,
    /// A whole edge (number given) of the face; the part runs along it from edge corner i to i + 1.
    Full(u8),
    /// Half of a transition edge: first (0) or second (1) pair of the inner points.
    Half(u8),
}

/// One part of a constellation.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// 1 to 5.
    pub constellation: u8,
    /// Corners of the part in the face's domain, in units of one half (0, 1, 2), counter-clockwise. Three for a
    /// triangle (the fourth repeats the third), four for a quad.
    pub corners: [[u8; 2]; 4],
    /// True: triangle domain; corner 0, 1, 2 are barycentric x, y, z.
    pub triangle: bool,
    /// What lies along the edge from part corner i to i + 1.
    pub sides: [Side; 4],
}

const A: [u8; 2] = [0, 0];
const B: [u8; 2] = [2, 0];
const C: [u8; 2] = [2, 2];
const D: [u8; 2] = [0, 2];
const M0: [u8; 2] = [1, 0];
const M1: [u8; 2] = [2, 1];
const M2: [u8; 2] = [1, 2];
const M3: [u8; 2] = [0, 1];
const MID: [u8; 2] = [1, 1];
use Side::{Full, Half, Inner};

const fn tri(constellation: u8, c: [[u8; 2]; 3], s: [Side; 3]) -> Part {
    Part { constellation, corners: [c[0], c[1], c[2], c[2]], triangle: true, sides: [s[0], s[1], s[2], Inner] }
}

const fn quad(constellation: u8, corners: [[u8; 2]; 4], sides: [Side; 4]) -> Part {
    Part { constellation, corners, triangle: false, sides }
}

/// All parts, constellation by constellation; [`parts_of`] gives the run of one constellation.
pub const PARTS: [Part; 17] = [
    tri(1, [A, M0, D], [Half(0), Inner, Full(3)]),
    tri(1, [D, M0, C], [Inner, Inner, Full(2)]),
    tri(1, [M0, B, C], [Half(0), Full(1), Inner]),
    tri(2, [A, M0, D], [Half(0), Inner, Full(3)]),
    tri(2, [D, M0, M1], [Inner, Inner, Inner]),
    tri(2, [M0, B, M1], [Half(0), Half(1), Inner]),
    tri(2, [M1, C, D], [Half(0), Full(2), Inner]),
    quad(3, [A, M0, M2, D], [Half(0), Inner, Half(1), Full(3)]),
    quad(3, [M0, B, C, M2], [Half(0), Full(1), Half(1), Inner]),
    quad(4, [A, M0, M2, D], [Half(0), Inner, Half(1), Full(3)]),
    tri(4, [M0, B, M1], [Half(0), Half(1), Inner]),
    tri(4, [M1, C, M2], [Half(0), Half(1), Inner]),
    tri(4, [M0, M1, M2], [Inner, Inner, Inner]),
    quad(5, [A, M0, MID, M3], [Half(0), Inner, Inner, Half(1)]),
    quad(5, [M0, B, M1, MID], [Half(0), Half(1), Inner, Inner]),
    quad(5, [MID, M1, C, M2], [Inner, Half(0), Half(1), Inner]),
    quad(5, [M3, MID, M2, D], [Inner, Inner, Half(0), Half(1)]),
];

/// Parts of a constellation (1 to 5) as a range into [`PARTS`].
pub const fn parts_of(constellation: u8) -> std::ops::Range<usize> {
    match constellation {
        1 => 0..3,
        2 => 3..7,
        3 => 7..9,
        4 => 9..13,
        _ => 13..17,
    }
}

/// Constellation of a transition mask (bit i: edge i) that was turned into standard position, 0 for none.
pub const fn constellation(mask: u8) -> u8 {
    match mask {
        0b0001 => 1,
        0b0011 => 2,
        0b0101 => 3,
        0b0111 => 4,
        0b1111 => 5,
        _ => 0,
    }
}

/// Constellation of a transition mask and by how many edges the face must be turned so that the mask stands in
/// standard position; (0, 0) without a transition edge.
///
/// The authors' order: from the face's first edge the first one without transition, then the first with.
pub const fn standard_position(mask: u8) -> (u8, u8) {
    let mut turn = 0;
    if mask == 0 || mask == 0b1111 {
        return (constellation(mask), 0);
    }
    while mask >> turn & 1 == 1 {
        turn += 1;
    }
    while mask >> (turn % 4) & 1 == 0 {
        turn += 1;
    }
    turn %= 4;
    (constellation((mask >> turn | mask << (4 - turn)) & 0b1111), turn)
}
