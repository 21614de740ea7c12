//! How wrong a picture is, in numbers.

pub mod cracks;
pub mod exact;
pub mod folds;
