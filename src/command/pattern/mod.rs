//! What the commands do with scenes of technique `pattern`.

pub mod bench;
pub mod check;
pub mod flags;
pub mod flight;
pub mod open;
pub mod render;
pub mod sample;
pub mod stats;
pub mod twin;
