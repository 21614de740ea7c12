//! What the commands do with scenes of technique `ferguson`.

pub mod check;
pub mod convert;
pub mod list;
pub mod open;
pub mod render;
pub mod stats;
