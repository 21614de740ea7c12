//! Editing a scene, without a window: handles and where they are, what dragging and painting them does to the scene,
//! what that changes, undo, and the journal that survives a crash (ZHHK22 5).
//!
//! ```text
//!   Scene --Model--> Refinement, PatchTable            what is drawn
//!     |        \---> Overlay: handles, control mesh    what is seen of a level (view-dependent)
//!     |
//!   drag, paint, sharpen, modelling  write the Scene;  History and Journal keep its Changes
//! ```
//!
//! A step of a drag costs what it touches, unless it changes what is refined: the model and the fold watch's copy of it
//! follow in place, and only patches that changed are tested.
//!
//! Gradient meshes of technique `ferguson` have operations of their own, in [`gradient`], and a journal of those.
//!
//! Everything here is plain data and functions of it. The window is in `crate::app`.

pub mod brush;
pub mod change;
pub mod drag;
pub mod folds;
pub mod gradient;
pub mod handle;
pub mod history;
pub mod influence;
pub mod journal;
pub mod journal_file;
pub mod model;
pub mod overlay;
pub mod paint;
pub mod place;
pub mod shape;
pub mod together;

use crate::mesh::MeshError;
use crate::refine::RefineError;
use thiserror::Error;

/// Why an edit was not done. The scene is as it was.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum EditError {
    /// The polygons would not form a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The scene cannot be refined.
    #[error(transparent)]
    Refine(#[from] RefineError),
    /// The edit makes no sense here.
    #[error("{0}")]
    Refused(String),
}

impl EditError {
    fn refused(what: impl std::fmt::Display) -> EditError {
        EditError::Refused(what.to_string())
    }
}
