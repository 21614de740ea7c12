//! Frame timings as plain data: what a frame took ([`record`]), by what protocol ([`protocol`]), what that amounts to
//! ([`statistics`], [`pair`]), on what machine ([`host`]), and the three files of a run folder ([`record`], [`run`],
//! [`trace`]). Nothing here knows Vulkan; `command::bench` does the measuring.
//!
//! ```text
//!   FrameRecord --> frames.csv            one row a frame, `NA` for what was not taken
//!        |   \----> trace.json            the same as spans, for Perfetto
//!        v
//!   Summary, Ratio --> run.json           with device, host, protocol and caveats
//! ```

pub mod compare;
pub mod host;
pub mod pair;
pub mod protocol;
pub mod random;
pub mod record;
pub mod run;
pub mod statistics;
pub mod trace;
pub mod triangles;
