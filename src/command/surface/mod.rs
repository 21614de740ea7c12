//! What the commands do with scenes of technique `surface`.

pub mod open;
pub mod stats;
