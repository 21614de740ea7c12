//! Locally refinable gradient meshes (technique `ferguson`, BLHK18): bicubic Hermite patches with their own colours, split
//! exactly and locally, with T-sections, branches, holes and sharp colours.
//!
//! ```text
//!   file --read--> Mesh --split, move, colour...--> Mesh --fit--> Mesh --table--> PatchTable
//!                    |  <------------- undo ----------             \
//!                    +--> inspect, traditional                      sides short enough for 64 segments
//!                    +--Journal--> LiveTable: the same table, changed where the mesh changed
//! ```

pub mod blend;
pub mod edit;
pub mod fit;
pub mod hermite;
pub mod inherit;
pub mod inspect;
pub mod live;
pub mod merge;
pub mod mesh;
pub mod new;
pub mod split;
pub mod table;
pub mod traditional;

pub use mesh::Mesh;

/// Why an operation on a mesh cannot be done. The mesh is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FergusonError {
    /// No patch of this number, or it is gone.
    #[error("patch {0} does not exist; use the number of a patch that is drawn")]
    NoPatch(u32),
    /// No point of this number, or it is gone.
    #[error("point {0} does not exist; use the number of a point in the mesh")]
    NoPoint(u32),
    /// No curve of this number, or it is gone.
    #[error("curve {0} does not exist; use the number of a curve in the mesh")]
    NoCurve(u32),
    /// A split at or beyond a side.
    #[error("a split at {0} is not inside the patch; use a parameter between 0 and 1")]
    SplitOutside(f64),
    /// A T-section's data come from its curve.
    #[error("point {0} is a T-section, which takes this from its curve; edit the curve")]
    Section(u32),
    /// A coordinate or a colour that is no number.
    #[error("a value is not finite; use ordinary numbers")]
    NotFinite,
    /// What was asked to go is no split.
    #[error("curve {curve} cannot be removed: {why}")]
    NotRemovable {
        /// The curve.
        curve: u32,
        /// What stands in the way, and what to do.
        why: &'static str,
    },
    /// The patches do not make a mesh.
    #[error("patch {patch}: {what}")]
    Topology {
        /// A patch at the place.
        patch: u32,
        /// What is wrong and what to do.
        what: String,
    },
}
