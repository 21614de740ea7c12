//! The one seam of the project: techniques make a [`PatchTable`], the GPU, the CPU evaluator and the
//! statistics read it. Nothing here knows half-edges or Vulkan.
//!
//! # Corners, domain and control points
//!
//! ```text
//!   v
//!   ^   D(0,1) 12---13---14---15 C(1,1)      corner 0 = A, 1 = B, 2 = C, 3 = D
//!   |           |    |    |    |             edge 0 = A-B, 1 = B-C, 2 = C-D, 3 = D-A
//!   |           8----9---10---11             control point index = 4 * row + column,
//!   |           |    |    |    |             column along u, row along v
//!   |           4----5----6----7
//!   |           |    |    |    |             inner point of corner A 5, B 6, C 10, D 9
//!   |   A(0,0)  0----1----2----3 B(1,0)
//!   +------> u
//! ```
//!
//! * **Bicubic**: 16 Bezier points as drawn.
//! * **Gregory** (LSNC09): 20 points. 0 to 15 as drawn, where the inner point of corner i is `f_i+` (the one
//!   that belongs to edge i, which leaves corner i); 16 + i is `f_i-` (edge i - 1, which ends in corner i).
//!   `F_A = (u f0+ + v f0-) / (u + v)`, and its three rotations.
//! * **Stitched** (BLHK18 6.2): 32 points, 0 to 15 as drawn and then the curves that its sides run along, see [`stitched`].
//! * **Remapped** (OpenSubdiv): 32 points, a transition face in one piece, see [`remap`].
//! * **Transition parts** (NLMD12 section 4): a face with finer neighbours is drawn as two to four parts, see
//!   [`transition`]. A part has the face's 16 or 20 points and then 8 more: the part's own four corners (a
//!   triangle repeats its third), then two inner points for each of up to two half edges (see
//!   [`transition::Part`]). The half edge from part corner i to i + 1 is the cubic (corner i, first, second,
//!   corner i + 1), and these four are the very control points of the finer neighbour's edge. That is what makes
//!   the seam watertight: both sides evaluate the same four numbers.
//!
//! Two patches that share an edge of one level share its four control points by index.

pub mod build;
pub mod cull;
pub mod eval;
pub(crate) mod gregory;
pub mod pack;
pub mod points;
pub mod pool;
pub mod quartic;
pub mod remap;
mod runs;
pub mod solid;
pub mod space;
pub mod stencil;
pub mod stitched;
pub mod tess;
pub mod tessellator;
pub mod transition;

/// Channels of a control point: two vec4. `subdivision`: x, y, 0, 0 and r, g, b, a.
pub type ControlPoint = [f64; 8];

/// What a range draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Tensor-product bicubic in Bezier form, 16 points.
    Bicubic,
    /// Gregory patch LSNC09, 20 points.
    Gregory,
    /// Bicubic whose sides may have T-sections, 32 points: see [`stitched`].
    Stitched,
    /// Bicubic transition face in one piece, 32 points: see [`remap`].
    RemappedBicubic,
    /// Gregory transition face in one piece, 32 points: see [`remap`].
    RemappedGregory,
}

impl Kind {
    /// Control points of a whole patch.
    pub const fn points(self) -> usize {
        match self {
            Kind::Bicubic => 16,
            Kind::Gregory => 20,
            Kind::Stitched | Kind::RemappedBicubic | Kind::RemappedGregory => 32,
        }
    }
}

/// A run of patches drawn with one pipeline and one set of push constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawRange {
    /// What is drawn.
    pub kind: Kind,
    /// `None`: whole patches. `Some(i)`: part `i` of [`transition::PARTS`].
    pub part: Option<u8>,
    /// Subdivision level the faces live at.
    pub level: u32,
    /// First entry in [`PatchTable::indices`].
    pub first: u32,
    /// Patches in the range; each takes [`DrawRange::stride`] indices.
    pub count: u32,
}

impl DrawRange {
    /// Indices (control points) for each patch of this range.
    pub const fn stride(&self) -> usize {
        self.kind.points() + if self.part.is_some() { transition::EXTRA_POINTS } else { 0 }
    }
}

/// One drawn face: where it comes from. A transition face is one entry however many parts draw it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// Level the face lives at.
    pub level: u32,
    /// Name of the face: its number in M^0, or the slot one level up that it grew from
    /// (`subdiv::index_map`, which turns it into the numbers of ZHHK22 App. A).
    pub name: u64,
    /// Edges from the face's own first half-edge to the one that leaves corner A (0 to 3): transition faces are turned.
    pub turn: u8,
    /// Bicubic or Gregory.
    pub kind: Kind,
    /// Whether the face is irregular; drawn as a bicubic all the same where LS08 stands in for Gregory patches.
    pub irregular: bool,
    /// Bit i: edge i from corner A is a transition edge. 0: not a transition face.
    pub transition: u8,
    /// First of the face's 16 or 20 entries in [`PatchTable::indices`].
    pub first: u32,
}

/// Patches ready to draw.
#[derive(Clone, Debug, Default)]
pub struct PatchTable {
    /// Control points, shared between patches through the indices.
    pub control: Vec<ControlPoint>,
    /// Index arrays of all ranges, one after another.
    pub indices: Vec<u32>,
    /// Draw ranges in draw order: plain bicubic, plain Gregory, then the parts of constellations C1 to C5 bicubic, then Gregory.
    pub ranges: Vec<DrawRange>,
    /// One entry a drawn face.
    pub faces: Vec<Face>,
    /// What the colour channels mean.
    pub colour: space::Interpolation,
}
