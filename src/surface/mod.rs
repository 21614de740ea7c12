//! Subdivision surfaces in space with semi-sharp creases, and their subdivision shading (ZBK23).
//!
//! ```text
//!   SurfaceScene --Level::new--> level 0 --refine--> level 1 ... level n
//!                                   \---- weights, normals ----\--- shade --> N_L, N_S, b, N_B
//! ```
//!
//! * **Rules.** One set of stencils ([`stencil`]) serves positions, normals and weights: [`stencil::Value`] is what they
//!   have in common. Creases and corners follow DKT98: a sharpness above 1 uses the sharp rule, one between 0 and 1
//!   blends the two, every step takes 1 off. Boundary edges are sharp for ever.
//! * **Regions.** A vertex has one normal in each region between sharp edges ([`region`]); a *wedge* is such a pair of
//!   vertex and region. Most vertices have one wedge, whose number is the vertex's own.
//! * **Decay.** The wedges of level k are those that the step from k - 1 to k has kept apart, so a crease of sharpness s
//!   is drawn sharp up to level s and smooth from level s + 1 on (Fig. 4). The first smooth step starts from the mean of
//!   the regions' normals, which prefers neither side.
//! * **Patches** ([`adaptive`], [`patches`]) are those of the limit: bicubic ones of Catmull-Clark, quartic triangles of
//!   Loop. There a crease counts as smooth as soon as its
//!   sharpness is used up, and N_S is normalised on the levels before the first that is drawn and then at the end only.
//! * **Control points** of patches are weighted sums of vertices of levels. All masks are linear, so position, N_S (not
//!   normalised on drawn levels) and b have the same weights; these are written down by [`term`] and summed on the device
//!   ([`crate::patch::stencil`]), or for `sample` and `check` on the CPU in double precision.
//! * **Numbers.** Vertices of a level: those of the level before, then the face points (Catmull-Clark), then the edge
//!   points. A vertex keeps its number for ever.
//!
//! # Patches of irregular faces
//!
//! * **Catmull-Clark**: Gregory patches as LSNC09 has them.
//! * **Loop**: Gregory triangles on quartics. LSNC09's triangles stand for triangles of a Catmull-Clark mesh; here their idea
//!   (cubic edges, tangent planes that agree all along them) is taken over to Loop's stencils, and edges between regular
//!   vertices are Loop's own quartics, so that regular neighbours fit them exactly. Error on the last level, off the surface:
//!   less than 2e-3 of the size at level 1 and 2e-7 at level 10 on the meshes of the tests.
//! * **Spikes**: Loop's rules make a spike of a sharp vertex inside a smooth surface, and of one with three faces or more
//!   between sharp edges. There is no tangent plane there; patches keep the direction of the spike.
//!
//! # Where this departs from the authors' tool
//!
//! Positions, N_L of the mesh ([`shade::Geometric::Mesh`]) and N_S agree with it to the digits that it writes, except:
//!
//! * **After a crease has decayed** the tool starts the smooth rule from one region's normal; here it is the mean. (Their
//!   cube of sharpness 2: 219 of 386 normals of level 3 differ, by up to 27.1 degrees.)
//! * **Weights on creases** are exactly 0 in variant B, as Fig. 4 has them. The tool's last stencil is the smooth one
//!   there, too, and gives up to 0.0417 on their tetrahedron.
//! * **N_L** is by default the normal of the limit surface, as the text says; the tool takes means of face normals.
//! * **`vn` lines** of a file are control normals ("if not specified by the user", 3.4); the tool ignores them.
//! * **Boundary vertices** get their weight once, at the first level, and subdivide it; the tool sets it again each time.
//! * **At a dart**, the crease's far end counts by the mean of its two sides; the tool takes one.
//! * **At sharpness 1** the tool's stencils of level 1 already take a crease vertex's mean normal, from 2 on its region's;
//!   here regions count as long as the step keeps them apart, whatever the sharpness. (Their cubes of sharpness 1 and 2
//!   differ by up to 31 degrees at face points of level 1.)
//! * **N_S is chained** from its first level to the last, as the text says. In the tool that depends on the order of clicks:
//!   raising the level first and then asking for subdivided normals applies one stencil to N_L of the level before.
//! * **Creases that meet the boundary**, fractional sharpness and sharp corners, which the tool has not, follow DKT98.
//! * **Weights above 1** are cut at 1; the tool lets those up to 1.05 stand.
//! * **Counts** of section 5 are higher by Spot's four vertices of valence 6, which the paper leaves out.

pub mod accuracy;
pub mod adaptive;
mod control_points;
pub mod drawing;
pub mod exact;
pub mod level;
pub mod limit;
mod loop_patches;
pub mod normal;
pub mod part;
pub mod patch_eval;
pub mod patches;
pub mod refine;
pub mod region;
pub mod shade;
pub mod stencil;
pub mod term;
pub mod triangulate;
pub mod weight;

use thiserror::Error;

/// Why there is no such level of a surface. Numbers in the text count from 1 as in OBJ files, those of tags from 0.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum SurfaceError {
    /// A tag makes an edge sharp that is none.
    #[error("vertices {a} and {b} of the tag are not joined by an edge; name the ends of an edge, from 0")]
    NoSuchEdge {
        /// One end, from 0.
        a: u32,
        /// Other end, from 0.
        b: u32,
        /// Source line.
        line: u32,
    },
    /// Loop subdivision of a polygon.
    #[error("a face has {corners} corners, and Loop subdivision takes triangles; add --triangulate or use --scheme catmull-clark")]
    NotATriangle {
        /// Its corners.
        corners: u32,
        /// Source line.
        line: u32,
    },
    /// More half-edges than memory and 32-bit numbers leave room for.
    #[error("level {level} has more than {limit} half-edges; ask for a lower level")]
    TooLarge {
        /// The level asked for.
        level: u32,
        /// The limit.
        limit: u64,
    },
}

impl SurfaceError {
    /// The line of the scene that is at fault, where there is one.
    pub fn line(&self) -> Option<u32> {
        match *self {
            SurfaceError::NoSuchEdge { line, .. } | SurfaceError::NotATriangle { line, .. } => Some(line),
            SurfaceError::TooLarge { .. } => None,
        }
    }
}
