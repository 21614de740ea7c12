//! The model format of the authors of ZHHK22: lines of `v`, `f`, `ve` and `ce`, numbers in single precision.
//!
//! ```text
//! v X Y                                      input vertex; further numbers are ignored
//! f V1 V2 V3 ...                             input face, vertex numbers from 1; V/T/N takes the V
//! ve LEVEL VERTEX HALFEDGE A B BOUNDARY      geometry edit; BOUNDARY is 0 (sector) or 1 (beyond the boundary)
//! ce LEVEL HALFEDGE R G B                    colour edit
//! ```
//!
//! Other lines are skipped. A later edit with the same (level, vertex) or (level, half-edge) replaces the earlier one.

mod read;
mod write;

pub(super) use read::read;
pub use write::{write, Written};
