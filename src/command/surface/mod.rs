//! What the commands do with scenes of technique `surface`.

pub mod bench;
pub mod check;
pub mod flags;
pub mod mesh;
pub mod open;
pub mod render;
pub mod sample;
pub mod stats;
