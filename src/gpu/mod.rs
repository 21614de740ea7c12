//! The GPU room: uploads a [`PatchTable`], draws it with the fixed-function tessellator, and reads back pictures, times
//! and evaluated points. The only room with `unsafe`, because Vulkan is a C interface.
//!
//! ```text
//!   PatchTable --pack--> DeviceTable --Frame--> PreparedFrame --run--> FrameTimes, Pixels
//!                             \--- evaluate --> EvaluatedPoint
//! ```
//!
//! Rules of the room:
//! * Every call that submits work waits for it, so nothing is in use when it is dropped.
//! * Every object holds the device alive, carries a name, and is destroyed by its own `Drop`.
//! * No shader asks for `gl_PrimitiveID`; what differs from patch to patch travels in its control points.
//! * Errors name the call and the object ([`GpuError`]).
#![allow(unsafe_code)] // Vulkan is a C interface; every block says why it is sound.

mod calibrate;
mod canary;
mod close_button;
mod compute;
mod context;
mod depth_frame;
mod descriptors;
mod device;
mod draw;
mod error;
mod fault;
mod graphics;
mod hand_over;
mod instance;
mod layout;
mod memory;
mod partial;
mod pattern;
mod pipeline;
mod query;
mod readback;
mod shader;
mod show;
mod solid;
mod stencil;
mod surface_format;
mod swapchain;
mod table;
mod target;
mod window;

pub use calibrate::Calibration;
pub use canary::{Canary, CANARIES};
pub use close_button::CloseButton;
pub use context::SharedAllocator;
pub use device::{DeviceInfo, Limits};
pub use draw::{Canvas, Format, Frame, FrameTimes, Pixels, PreparedFrame, Rendered};
pub use error::GpuError;
pub use instance::Message;
pub use partial::Uploaded;
pub use pattern::{EvaluatedTriangle, PatternFrame, PatternMethod, PatternScene, PatternShow, PreparedPattern};
pub use query::{GpuSpan, GpuTimes, Statistics};
pub use readback::EvaluatedPoint;
pub use show::{level_colour, patch_colour, Show, WIRE_COLOUR};
pub use solid::{PreparedSolid, SolidFrame, SolidNormals, SolidShow, Tessellation};
pub use table::DeviceTable;
pub use window::{Outcome, Screen};

use crate::patch::solid::SolidTable;
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use context::Context;
use instance::Instance;
use pipeline::Pipelines;
use std::ops::Range;
use std::rc::Rc;

/// How to open a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GpuOptions {
    /// Index or part of the name (any case); `None`: the usable device that is probably fastest.
    pub device: Option<String>,
    /// Load the validation layer with synchronisation checks, and collect what it says.
    pub validate: bool,
}

/// An open device.
pub struct Gpu {
    // Before the context, of which it holds a reference.
    pipelines: Pipelines,
    context: Rc<Context>,
}

/// The devices there are, usable or not, in the order of their indices.
///
/// # Errors
/// There is no Vulkan loader, or it failed.
pub fn devices() -> Result<Vec<DeviceInfo>, GpuError> {
    let instance = Instance::new(false, &[])?;
    Ok(device::list(&instance)?.into_iter().map(|candidate| candidate.info).collect())
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// No loader, no validation layer (when asked for), no such device, or one that lacks what is needed.
    pub fn new(options: &GpuOptions) -> Result<Gpu, GpuError> {
        let instance = Instance::new(options.validate, &[])?;
        let candidate = device::choose(device::list(&instance)?, options.device.as_deref())?;
        let context = Rc::new(Context::new(instance, candidate, false)?);
        Ok(Gpu { pipelines: Pipelines::new(&context)?, context })
    }

    /// The device that was opened.
    pub fn device(&self) -> &DeviceInfo {
        &self.context.info
    }

    /// Whatever the validation layer has reported so far, oldest first. Always empty without validation.
    pub fn messages(&self) -> Vec<Message> {
        self.context.instance.messages()
    }

    /// Makes a deliberate mistake and returns what the validation layer said to it: nothing means that it does not
    /// listen. These messages do not count in [`Gpu::messages`].
    ///
    /// # Errors
    /// A call failed that should not have.
    pub fn canary(&self, canary: Canary) -> Result<Vec<Message>, GpuError> {
        canary::sing(&self.context, canary)
    }

    /// Bytes of device memory in use: buffers and images of this room, without what widgets take.
    pub fn allocated(&self) -> u64 {
        self.context.faults.allocated()
    }

    /// From now on at most so many bytes may be allocated at a time; what passes the limit fails like memory that ran out.
    pub fn limit_memory(&self, bytes: Option<u64>) {
        self.context.faults.limit_memory(bytes);
    }

    /// From now on every submission fails as on a device that is lost, or no more. For tests.
    pub fn pretend_lost(&self, lost: bool) {
        self.context.faults.lose(lost);
    }

    /// Casts a table to f32 and copies it to the device.
    ///
    /// # Errors
    /// The table contradicts itself or is too large, or memory ran out.
    pub fn upload(&self, table: &PatchTable) -> Result<DeviceTable, GpuError> {
        table::upload(&self.context, table, false)
    }

    /// As [`Gpu::upload`], into buffers a quarter larger: for a table that edits will add patches to.
    ///
    /// # Errors
    /// As [`Gpu::upload`].
    pub fn upload_with_room(&self, table: &PatchTable) -> Result<DeviceTable, GpuError> {
        table::upload(&self.context, table, true)
    }

    /// Makes everything a frame needs, to run it as often as wanted.
    ///
    /// # Errors
    /// The frame is senseless or too large, the device lacks a feature it needs, or memory ran out.
    pub fn prepare<'t>(&self, table: &'t DeviceTable, frame: &Frame) -> Result<PreparedFrame<'t>, GpuError> {
        PreparedFrame::new(Canvas::new(&self.context, &self.pipelines, frame, false)?, &self.pipelines, table)
    }

    /// As [`Gpu::prepare`], with every kind of patch in a render pass of its own and a full barrier after it, so that the
    /// GPU times of the kinds do not overlap. Slower than the frame it stands for.
    ///
    /// # Errors
    /// As [`Gpu::prepare`]; or the frame has more than one sample a pixel.
    pub fn prepare_isolated<'t>(&self, table: &'t DeviceTable, frame: &Frame) -> Result<PreparedFrame<'t>, GpuError> {
        PreparedFrame::new(Canvas::new(&self.context, &self.pipelines, frame, true)?, &self.pipelines, table)
    }

    /// The frame of `canvas` with another table, or with the same one after [`Gpu::update`].
    ///
    /// # Errors
    /// As [`Gpu::prepare`].
    pub fn prepare_again<'t>(&self, canvas: Canvas, table: &'t DeviceTable) -> Result<PreparedFrame<'t>, GpuError> {
        PreparedFrame::new(canvas, &self.pipelines, table)
    }

    /// Puts another table into the buffers of `into`, which grow when they have to: what a frame after an edit does.
    ///
    /// # Errors
    /// As [`Gpu::upload`]. When memory for a larger table runs out, or the table contradicts itself, `into` is what it was
    /// and can be drawn; when the copy fails, it is empty. Another update makes it good again either way, unless the device
    /// is lost.
    pub fn update(&self, into: &mut DeviceTable, table: &PatchTable) -> Result<(), GpuError> {
        table::update(&self.context, table, into)
    }

    /// Copies the control points `changed` (numbers, ascending) of a table whose other numbers are on the device: what a
    /// frame after an edit in place does. Waits for nothing but the upload three before.
    ///
    /// # Errors
    /// `into` holds a table of another shape, or memory ran out; a whole [`Gpu::update`] is then to be made.
    pub fn update_points(
        &self,
        into: &mut DeviceTable,
        table: &PatchTable,
        changed: &[u32],
    ) -> Result<Uploaded, GpuError> {
        partial::update_points(&self.context, table, changed, into)
    }

    /// Copies what changed in a table whose patches came and went in place: control points (numbers, ascending), stretches
    /// of indices (ascending) and all ranges. As [`Gpu::update_points`], it waits for nothing but the upload three before;
    /// for a table that has outgrown its buffers, the device copies what is there into larger ones first, and is waited for.
    ///
    /// # Errors
    /// `into` holds a table that differs in more, or memory ran out. `into` is then what it was, unless it was empty and
    /// [`Gpu::update`] failed; a whole [`Gpu::update`] is to be made.
    pub fn update_parts(
        &self,
        into: &mut DeviceTable,
        table: &PatchTable,
        control: &[u32],
        indices: &[Range<u32>],
    ) -> Result<Uploaded, GpuError> {
        partial::update_parts(&self.context, table, control, indices, into)
    }

    /// The table as it is on the device: control points and indices, byte by byte. For tests.
    ///
    /// # Errors
    /// Memory ran out, or the device is lost.
    pub fn read_table(&self, table: &mut DeviceTable) -> Result<(Vec<u8>, Vec<u8>), GpuError> {
        partial::read_back(&self.context, table)
    }

    /// Where the device's timestamps stand on the host's clock; `None` where the driver cannot say.
    ///
    /// # Errors
    /// A call failed.
    pub fn calibrate(&self) -> Result<Option<Calibration>, GpuError> {
        self.context.calibrate()
    }

    /// Draws a picture: [`Gpu::prepare`], one run, and the statistics if asked for.
    ///
    /// # Errors
    /// As [`Gpu::prepare`] and [`PreparedFrame::run`].
    pub fn render(&self, table: &DeviceTable, frame: &Frame) -> Result<Rendered, GpuError> {
        let prepared = self.prepare(table, frame)?;
        let times = prepared.run(true)?;
        Ok(Rendered {
            width: frame.width,
            height: frame.height,
            pixels: prepared.pixels()?,
            times,
            statistics: if frame.statistics { Some(prepared.statistics()?) } else { None },
        })
    }

    /// Puts a scene in space on the device with everything that its picture needs, to draw it as often as wanted.
    ///
    /// # Errors
    /// The table contradicts itself, the frame is senseless or too large, or memory ran out.
    pub fn prepare_solid(&self, table: &SolidTable, frame: &SolidFrame) -> Result<PreparedSolid, GpuError> {
        PreparedSolid::new(&self.context, &self.pipelines.passes, table, frame)
    }

    /// Puts coarse triangles and a refinement pattern on the device with everything that their picture needs, to draw it as
    /// often as wanted.
    ///
    /// # Errors
    /// The frame is senseless or too large, the device lacks what it needs, or memory ran out.
    pub fn prepare_pattern(&self, scene: &PatternScene, frame: &PatternFrame) -> Result<PreparedPattern, GpuError> {
        PreparedPattern::new(&self.context, &self.pipelines.passes, scene, frame, false)
    }

    /// Position and normal of every vertex that the device makes of refinement patterns, coarse triangle by coarse triangle
    /// in the pattern's order. Of `frame`, nothing but its method counts, which has to be [`PatternMethod::Instanced`].
    ///
    /// # Errors
    /// [`GpuError::Lacks`] on devices without stores in vertex stages; or a call failed.
    pub fn evaluate_pattern(&self, scene: &PatternScene, frame: &PatternFrame) -> Result<Vec<[[f32; 3]; 2]>, GpuError> {
        let frame = PatternFrame { method: PatternMethod::Instanced, detail: None, ..frame.clone() };
        PreparedPattern::new(&self.context, &self.pipelines.passes, scene, &frame, true)?.records()
    }

    /// Position and normal of every vertex that the device makes between levels of detail, with the levels that the host
    /// ([`PatternMethod::Instanced`]) or the device ([`PatternMethod::Indirect`]) chose, ordered by triangle. Of `frame`,
    /// method, detail, camera and height count.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] on devices without stores in vertex stages; the frame has no levels of detail; or a call failed.
    pub fn evaluate_detail(
        &self,
        scene: &PatternScene,
        frame: &PatternFrame,
    ) -> Result<Vec<EvaluatedTriangle>, GpuError> {
        PreparedPattern::new(&self.context, &self.pipelines.passes, scene, frame, true)?.detail_records()
    }

    /// Every vertex that the device makes of a table, sorted by range, patch and coordinate. `scale` is pixels a model
    /// unit along x and y ([`Frame::scale`]); it matters for [`TessRule::Pixels`] only.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] on devices without stores in vertex stages; or a call failed.
    pub fn evaluate(
        &self,
        table: &DeviceTable,
        tess: TessRule,
        scale: [f64; 2],
    ) -> Result<Vec<EvaluatedPoint>, GpuError> {
        readback::evaluate(&self.context, &self.pipelines, table, tess, scale)
    }
}
