//! One row of `frames.csv`.

use std::fmt::Write;

/// Version of the columns; the first field of every row.
pub const SCHEMA: &str = "gradtess.frames/1";

/// Why a frame was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// To get there; counts for nothing.
    Warmup,
    /// To be timed.
    Measure,
    /// To be counted, under a statistics query, which disturbs times.
    Stats,
}

impl Phase {
    fn name(self) -> &'static str {
        match self {
            Phase::Warmup => "warmup",
            Phase::Measure => "measure",
            Phase::Stats => "stats",
        }
    }
}

macro_rules! fields {
    ($($(#[$doc:meta])* $name:ident: $kind:ty,)*) => {
        /// Everything a frame may have been measured by; `None` is `NA`. Times are ms unless the name says otherwise.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Fields { $($(#[$doc])* pub $name: Option<$kind>,)* }

        /// Columns of `frames.csv` in order.
        pub const COLUMNS: &[&str] =
            &["schema", "run_id", "repeat", "frame", "phase", $(stringify!($name)),*];

        impl Fields {
            fn write(&self, line: &mut String) {
                $( line.push(','); match self.$name { Some(x) => x.cell(line), None => line.push_str("NA") } )*
            }
        }
    };
}

trait Cell {
    fn cell(self, line: &mut String);
}

impl Cell for u64 {
    fn cell(self, line: &mut String) {
        let _ = write!(line, "{self}");
    }
}

impl Cell for f64 {
    fn cell(self, line: &mut String) {
        let _ = write!(line, "{self:.6}");
    }
}

fields! {
    /// Start on the host's clock, ns since the run began.
    cpu_start_ns: u64,
    /// Start of the GPU's work on the same clock, ns.
    gpu_start_ns: u64,
    /// The whole frame, from the edit until the GPU is done and what the frame made is dropped.
    cpu_frame_ms: f64,
    /// Changing the scene.
    cpu_edit_ms: f64,
    /// Refinement.
    cpu_refine_ms: f64,
    /// Patch table.
    cpu_patch_ms: f64,
    /// Casting to f32, copying to the device, and waiting for the copy.
    cpu_upload_ms: f64,
    /// Recording commands.
    cpu_record_ms: f64,
    /// Submitting them.
    cpu_submit_ms: f64,
    /// Waiting for the GPU.
    cpu_wait_ms: f64,
    /// Inside the present call.
    in_present_ms: f64,
    /// Between two presents.
    between_presents_ms: f64,
    /// From the start of the frame on the host to its start on the GPU.
    gpu_latency_ms: f64,
    /// The whole frame on the GPU, without the upload.
    gpu_frame_ms: f64,
    /// The copies to the device.
    gpu_upload_ms: f64,
    /// Whole bicubic patches.
    gpu_regular_ms: f64,
    /// Parts of transition faces of either kind.
    gpu_transition_ms: f64,
    /// Whole Gregory patches.
    gpu_gregory_ms: f64,
    /// Refinement patterns.
    gpu_pattern_ms: f64,
    /// Wireframe over the surface.
    gpu_overlay_ms: f64,
    /// Edits applied anew in this frame.
    edits: u64,
    /// Those of them that were followed in place; the others made everything anew.
    edits_in_place: u64,
    /// Faces refined, on all levels.
    faces_affected: u64,
    /// Drawn faces made anew for the frame: all of them after a rebuild.
    faces_touched: u64,
    /// Patches that draw those.
    patches_changed: u64,
    /// Deepest level drawn.
    max_level: u64,
    /// Faces drawn as bicubics, transition faces included, as in Table 1.
    patches_bicubic: u64,
    /// Transition faces among them.
    patches_transition: u64,
    /// Faces drawn as Gregory patches, transition faces included.
    patches_gregory: u64,
    /// Transition faces among them.
    patches_gregory_transition: u64,
    /// T of the tessellation rule.
    tess_factor: f64,
    /// Control points on the device.
    control_points: u64,
    /// Bytes copied to the device in this frame.
    upload_bytes: u64,
    /// Bytes of control points and indices on the device.
    gpu_bytes: u64,
    /// Patches assembled.
    ia_primitives: u64,
    /// Vertex shader runs.
    vs_invocations: u64,
    /// Patches through the control shader.
    tcs_patches: u64,
    /// Evaluation shader runs.
    tes_invocations: u64,
    /// Triangles into clipping.
    clip_invocations: u64,
    /// Triangles out of clipping.
    clip_primitives: u64,
    /// Fragment shader runs.
    fs_invocations: u64,
    /// Clock of the GPU.
    gpu_clock_mhz: f64,
    /// Its temperature, degrees Celsius.
    gpu_temp_c: f64,
    /// Its power, W.
    gpu_power_w: f64,
}

/// One frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRecord {
    /// Repeat, from 0.
    pub repeat: u32,
    /// Number within repeat and phase, from 0.
    pub frame: u32,
    /// Why it was drawn.
    pub phase: Phase,
    /// What was taken.
    pub fields: Fields,
}

impl FrameRecord {
    /// Appends the row and a line feed.
    pub fn write(&self, run_id: &str, out: &mut String) {
        let _ = write!(out, "{SCHEMA},{run_id},{},{},{}", self.repeat, self.frame, self.phase.name());
        self.fields.write(out);
        out.push('\n');
    }
}

/// The header line with its line feed.
pub fn header() -> String {
    COLUMNS.join(",") + "\n"
}

/// A scope of `results` in `run.json`: the name of its column without `_ms`, and how to get it.
pub type Scope = (&'static str, fn(&Fields) -> Option<f64>);

/// All scopes, the frame first.
pub const SCOPES: &[Scope] = &[
    ("cpu_frame", |f| f.cpu_frame_ms),
    ("cpu_edit", |f| f.cpu_edit_ms),
    ("cpu_refine", |f| f.cpu_refine_ms),
    ("cpu_patch", |f| f.cpu_patch_ms),
    ("cpu_upload", |f| f.cpu_upload_ms),
    ("cpu_record", |f| f.cpu_record_ms),
    ("cpu_submit", |f| f.cpu_submit_ms),
    ("cpu_wait", |f| f.cpu_wait_ms),
    ("gpu_latency", |f| f.gpu_latency_ms),
    ("gpu_frame", |f| f.gpu_frame_ms),
    ("gpu_upload", |f| f.gpu_upload_ms),
    ("gpu_regular", |f| f.gpu_regular_ms),
    ("gpu_transition", |f| f.gpu_transition_ms),
    ("gpu_gregory", |f| f.gpu_gregory_ms),
    ("gpu_pattern", |f| f.gpu_pattern_ms),
    ("gpu_overlay", |f| f.gpu_overlay_ms),
];
