//! What the commands do with scenes of technique `surface`.

pub mod flags;
pub mod mesh;
pub mod open;
pub mod stats;
