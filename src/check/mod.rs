//! How wrong a picture is, in numbers.

pub mod coverage;
pub mod cracks;
pub mod error_map;
pub mod exact;
pub mod flight;
pub mod folds;
pub mod limit_picture;
pub mod locate;
pub mod picture_error;
pub mod seams;
pub mod sections;
pub mod sheet;
pub mod solid_cracks;
