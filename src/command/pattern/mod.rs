//! What the commands do with scenes of technique `pattern`.

pub mod flags;
pub mod open;
pub mod sample;
pub mod stats;
