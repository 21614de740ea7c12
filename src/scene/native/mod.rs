//! The native scene format: versioned JSON, described by `scenes/schema.json`.
//!
//! All numbers count from 0 and all reals are doubles; what is written reads back bit for bit. Keys the format does
//! not know are errors, so that a typing mistake never changes a picture silently.

mod document;
mod read;
mod write;

pub(super) use read::read;
pub use write::write;

/// Version of the format, the value of the key `gradtess`.
pub const VERSION: u64 = 1;
