//! Generic mesh refinement (BS05): one refinement pattern, drawn for every triangle of a coarse mesh and evaluated there.
//!
//! ```text
//!   CoarseMesh --control--> Control of each triangle --+
//!                                                      +--evaluate--> Point --displace--> Point
//!   RefinementPattern (barycentric weights, indices) --+
//! ```
//!
//! Weights are (w, u, v) = (1 - u - v, u, v) and belong to corners 0, 1, 2 of a triangle, as in BS05 3.2. The Bezier
//! points of a curved triangle come in this order:
//!
//! ```text
//!                 2
//!               /   \           0 1 2   corners
//!              7     6          3 4     edge 01: the point near 0, then that near 1
//!             /       \         5 6     edge 12
//!            8    9    5        7 8     edge 20
//!           /           \       9       centre
//!          0 --- 3 - 4 - 1
//! ```

pub mod control;
pub mod detail;
pub mod displace;
pub mod evaluate;
pub mod lattice;
pub mod mesh;

pub use control::{Control, Evaluator, NormalField};
pub use detail::Detail;
pub use displace::Displacement;
pub use evaluate::Point;
pub use lattice::RefinementPattern;
pub use mesh::{CoarseMesh, Tag};

use thiserror::Error;

/// What a coarse mesh or a request for a pattern can have wrong with it.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PatternError {
    /// A level that is not in 1..=128.
    #[error("level {0} is out of range; refinement patterns have levels 1 to {max}", max = lattice::MAX_LEVEL)]
    Level(u32),
    /// A triangle with three deviation vectors.
    #[error("vertex {vertex} is the third with a deviation vector in triangle {triangle}; at most two may have one, so set one of vertices {others:?} back to null")]
    ThreeDeviations {
        /// The third vertex, from 0.
        vertex: u32,
        /// Triangle, from 0.
        triangle: u32,
        /// The other two.
        others: [u32; 2],
    },
    /// Two creases through one vertex.
    #[error("vertex {vertex} is tagged twice, and at most one crease may pass through it; keep one of the tags")]
    TwoCreases {
        /// The vertex, from 0.
        vertex: u32,
    },
    /// A tag's number that makes no sense.
    #[error("the {what} {value} of vertex {vertex} is out of range; give {range}")]
    Tag {
        /// The vertex, from 0.
        vertex: u32,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is possible.
        range: &'static str,
    },
}
