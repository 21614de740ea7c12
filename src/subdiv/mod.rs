//! Subdivision rules of ZHHK22 3: the ternary step, Catmull-Clark for positions and colours, limits.

pub mod catmull_clark;
pub mod edit;
pub mod fan;
pub mod gather;
pub mod index_map;
pub mod level;
pub mod limit;
pub mod ternary;
