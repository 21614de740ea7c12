//! Draws a patch table into an off-screen target: prepared once, run as often as wanted.

use super::context::{Commands, Context};
use super::error::GpuError;
use super::layout::{part_codes, Push};
use super::memory::bytes_of;
use super::pipeline::{Fill, PipelineKey, Pipelines, PUSH_STAGES};
use super::query::{GpuSpan, GpuTimes, Scope, Statistics, StatisticsQuery, Timestamps};
use super::show::{level_colour, patch_colour, Show, WIRE_COLOUR};
use super::table::DeviceTable;
use super::target::{PassKey, Target};
use crate::image::Picture;
use crate::patch::space::Interpolation;
use crate::patch::tess::{greatest, quad_vertices, TessRule, MAX_LEVEL};
use crate::patch::{DrawRange, Kind};
use ash::vk;
use std::rc::Rc;

/// What the pixels of a picture are stored as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Four bytes a pixel, clamped to [0, 1].
    #[default]
    Rgba8,
    /// Four f32 a pixel, not clamped: for measuring.
    Rgba32f,
}

/// A picture to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Model rectangle x0, y0, x1, y1 that fills the picture: y1 at the top. Pixel (i, j) samples
    /// x = x0 + (i + 1/2) (x1 - x0) / width, y = y1 - (j + 1/2) (y1 - y0) / height.
    pub view: [f64; 4],
    /// How finely to tessellate.
    pub tess: TessRule,
    /// What to show.
    pub show: Show,
    /// Colour under everything, straight alpha; `None`: transparent black.
    pub background: Option<[f32; 4]>,
    /// Samples a pixel, 1 or 4.
    pub samples: u32,
    /// What the pixels are stored as.
    pub format: Format,
    /// Draw a second time, under a pipeline-statistics query.
    pub statistics: bool,
}

impl Frame {
    /// Pixels a model unit in x and y.
    pub fn scale(&self) -> [f64; 2] {
        let [x0, y0, x1, y1] = self.view;
        [f64::from(self.width) / (x1 - x0), f64::from(self.height) / (y1 - y0)]
    }

    fn check(&self) -> Result<(), GpuError> {
        self.tess.check().map_err(GpuError::Request)?;
        let [x0, y0, x1, y1] = self.view;
        if !(self.view.iter().all(|x| x.is_finite()) && x1 > x0 && y1 > y0) {
            return Err(GpuError::Request(format!(
                "the view {x0},{y0},{x1},{y1} is empty; give X0,Y0,X1,Y1 with X0 < X1 and Y0 < Y1"
            )));
        }
        if self.background.is_some_and(|colour| colour.iter().any(|c| !c.is_finite())) {
            return Err(GpuError::Request("the background colour is not finite".to_owned()));
        }
        Ok(())
    }

    /// True when the picture may have transparent pixels.
    fn translucent(&self) -> bool {
        self.background.is_none_or(|colour| colour[3] < 1.0)
    }

    /// The format that is rendered into. Premultiplied 8-bit colours could not be turned back into straight ones, so
    /// a translucent picture is rendered in f32 and rounded once, at the end.
    fn target_format(&self) -> vk::Format {
        if self.format == Format::Rgba32f || self.translucent() {
            vk::Format::R32G32B32A32_SFLOAT
        } else {
            vk::Format::R8G8B8A8_UNORM
        }
    }
}

/// Pixels, rows from the top, straight alpha; `width * height * 4` numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// [`Format::Rgba8`].
    Rgba8(Vec<u8>),
    /// [`Format::Rgba32f`].
    Rgba32f(Vec<f32>),
}

/// Times of one run of a frame, ns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTimes {
    /// On the device.
    pub gpu: GpuTimes,
    /// Recording the command buffer.
    pub record_ns: u64,
    /// Handing it to the queue.
    pub submit_ns: u64,
    /// Waiting until it was done.
    pub wait_ns: u64,
}

impl Pixels {
    /// The picture in 8 bits a channel; floats are clamped and rounded.
    pub fn into_picture(self, width: u32, height: u32) -> Picture {
        let rgba = match self {
            Pixels::Rgba8(bytes) => bytes,
            Pixels::Rgba32f(floats) => floats.into_iter().map(to_byte).collect(),
        };
        Picture { width, height, rgba }
    }
}

/// A drawn picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The picture.
    pub pixels: Pixels,
    /// How long it took.
    pub times: FrameTimes,
    /// Counts, when the frame asked for them.
    pub statistics: Option<Statistics>,
}

/// A draw of one range.
struct Step {
    scope: usize,
    pipeline: vk::Pipeline,
    push: Push,
    first: u32,
    count: u32,
    // Most indices in one draw call, a whole number of patches.
    most: u32,
}

/// What a frame needs whatever the table: target, commands, queries. [`PreparedFrame::into_canvas`] gets it back, for the
/// frame's next table.
pub struct Canvas {
    context: Rc<Context>,
    frame: Frame,
    pass: PassKey,
    target: Target,
    commands: Commands,
    timestamps: Option<Timestamps>,
    // The pass that draws each scope after the first, when scopes are kept apart.
    over: Option<vk::RenderPass>,
}

impl Canvas {
    /// The frame that it draws.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// What the frame shows from now on; the size and what is rendered into stay.
    ///
    /// # Errors
    /// The frame is senseless, or needs another canvas.
    pub fn reframe(&mut self, frame: &Frame) -> Result<(), GpuError> {
        frame.check()?;
        if !self.fits(frame) {
            return Err(GpuError::Request("a frame of another size needs another canvas".to_owned()));
        }
        self.frame = frame.clone();
        Ok(())
    }

    /// Whether [`Canvas::reframe`] takes a frame.
    pub fn fits(&self, frame: &Frame) -> bool {
        let same = |f: &Frame| (f.width, f.height, f.samples, f.target_format());
        same(frame) == same(&self.frame)
    }

    pub(super) fn view(&self) -> vk::ImageView {
        self.target.view()
    }

    pub(super) fn new(
        context: &Rc<Context>,
        pipelines: &Pipelines,
        frame: &Frame,
        isolated: bool,
    ) -> Result<Canvas, GpuError> {
        frame.check()?;
        let format = frame.target_format();
        let pass = PassKey::Colour { format, samples: frame.samples };
        if isolated && frame.samples != 1 {
            return Err(GpuError::Request("kinds are kept apart at one sample a pixel only; use 1 sample".to_owned()));
        }
        Ok(Canvas {
            target: Target::new(context, &pipelines.passes, pass, [frame.width, frame.height])?,
            commands: Commands::new(context, "frame")?,
            timestamps: Timestamps::new(context, vec![Scope::Frame])?,
            over: if isolated { Some(pipelines.passes.get(PassKey::Over { format })?) } else { None },
            context: Rc::clone(context),
            frame: frame.clone(),
            pass,
        })
    }
}

/// A frame with everything that can be made beforehand: pipelines, target, queries, push constants.
pub struct PreparedFrame<'t> {
    canvas: Canvas,
    table: &'t DeviceTable,
    steps: Vec<Step>,
    // Of each run of steps; the frame's own pair of timestamps is the last.
    scopes: Vec<Scope>,
    layout: vk::PipelineLayout,
}

impl<'t> PreparedFrame<'t> {
    pub(super) fn new(
        mut canvas: Canvas,
        pipelines: &Pipelines,
        table: &'t DeviceTable,
    ) -> Result<PreparedFrame<'t>, GpuError> {
        let frame = &canvas.frame;
        let greatest = greatest(&table.ranges);
        frame.tess.check_to(greatest).map_err(GpuError::Request)?;
        let fills: &[Fill] = match frame.show {
            Show::Wire => &[Fill::Wire],
            Show::SurfaceWire => &[Fill::Surface, Fill::Wire],
            _ => &[Fill::Surface],
        };
        let mut steps = Vec::new();
        let mut scopes: Vec<Scope> = Vec::new();
        for (layer, &fill) in fills.iter().enumerate() {
            for range in table.ranges.iter().filter(|range| range.count > 0) {
                let scope = if layer > 0 { Scope::Overlay } else { scope_of(range) };
                if scopes.last() != Some(&scope) {
                    scopes.push(scope);
                }
                steps.push(Step {
                    scope: scopes.len() - 1,
                    pipeline: pipelines.get(PipelineKey::of(range, fill, canvas.pass))?,
                    push: push_of(frame, table.colour, range, fill, greatest),
                    first: range.first,
                    count: range.count * range.stride() as u32,
                    most: most_patches(&canvas.context, frame.tess, range).saturating_mul(range.stride() as u32),
                });
            }
        }
        let mut pairs = scopes.clone();
        pairs.push(Scope::Frame);
        canvas.timestamps = match canvas.timestamps.take() {
            Some(timestamps) => timestamps.again(pairs)?,
            None => None,
        };
        Ok(PreparedFrame { canvas, table, steps, scopes, layout: pipelines.layout })
    }

    /// Lets go of the table and keeps the rest.
    pub fn into_canvas(self) -> Canvas {
        self.canvas
    }

    /// When each kind was drawn in the last run, the whole frame last; empty on a device without timestamps.
    ///
    /// # Errors
    /// A call failed.
    pub fn spans(&self) -> Result<Vec<GpuSpan>, GpuError> {
        self.canvas.timestamps.as_ref().map_or(Ok(Vec::new()), Timestamps::spans)
    }

    /// Draws the frame and waits for it. With `read`, the picture is copied to the host, for [`PreparedFrame::pixels`];
    /// the copy is not part of the GPU times but of the wait.
    ///
    /// # Errors
    /// A call failed, or the device was lost.
    pub fn run(&self, read: bool) -> Result<FrameTimes, GpuError> {
        self.run_and(|commands| {
            if read {
                self.canvas.target.record_copy(commands);
            }
        })
    }

    /// As [`PreparedFrame::run`], and leaves the picture for a window to show ([`super::Screen::texture`]).
    ///
    /// # Errors
    /// As [`PreparedFrame::run`].
    pub fn run_to_show(&self) -> Result<FrameTimes, GpuError> {
        self.run_and(|commands| self.canvas.target.record_for_sampling(commands))
    }

    fn run_and(&self, then: impl FnOnce(vk::CommandBuffer)) -> Result<FrameTimes, GpuError> {
        let submission = self.canvas.commands.run(|commands| {
            let timestamps = self.canvas.timestamps.as_ref();
            let whole = self.scopes.len();
            if let Some(timestamps) = timestamps {
                timestamps.record_reset(commands);
                timestamps.record_begin(commands, whole);
            }
            self.record_pass(commands, timestamps);
            if let Some(timestamps) = timestamps {
                timestamps.record_end(commands, whole);
            }
            then(commands);
            Ok(())
        })?;
        let mut gpu = match &self.canvas.timestamps {
            Some(timestamps) => timestamps.read()?,
            None => GpuTimes::default(),
        };
        gpu.upload_ns = self.table.upload_ns;
        Ok(FrameTimes {
            gpu,
            record_ns: submission.record_ns,
            submit_ns: submission.submit_ns,
            wait_ns: submission.wait_ns,
        })
    }

    /// Draws the frame under a pipeline-statistics query, which disturbs timing: never the frame that is timed.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] without the feature; or as [`PreparedFrame::run`].
    pub fn statistics(&self) -> Result<Statistics, GpuError> {
        let query = StatisticsQuery::new(&self.canvas.context)?;
        self.canvas.commands.run(|commands| {
            query.record_begin(commands);
            self.record_pass(commands, None);
            query.record_end(commands);
            Ok(())
        })?;
        query.read()
    }

    /// The picture of the last `run(true)`.
    ///
    /// # Errors
    /// The host cannot see the memory.
    pub fn pixels(&self) -> Result<Pixels, GpuError> {
        let bytes = self.canvas.target.pixels()?;
        if self.canvas.frame.target_format() == vk::Format::R8G8B8A8_UNORM {
            return Ok(Pixels::Rgba8(bytes.to_vec()));
        }
        let mut floats: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        if self.canvas.frame.translucent() {
            straighten(&mut floats);
        }
        Ok(match self.canvas.frame.format {
            Format::Rgba8 => Pixels::Rgba8(floats.into_iter().map(to_byte).collect()),
            Format::Rgba32f => Pixels::Rgba32f(floats),
        })
    }

    fn record_pass(&self, commands: vk::CommandBuffer, timestamps: Option<&Timestamps>) {
        let context = &self.canvas.context;
        let [width, height] = self.canvas.target.extent;
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let [r, g, b, a] = self.canvas.frame.background.unwrap_or([0.0; 4]);
        let clear = Target::clear_values(self.canvas.pass, [r * a, g * a, b * a, a]);
        let begin_pass = |pass| {
            let begin = vk::RenderPassBeginInfo::builder()
                .render_pass(pass)
                .framebuffer(self.canvas.target.framebuffer)
                .render_area(area)
                .clear_values(&clear);
            // SAFETY: recording; pass and framebuffer are compatible and outlive the submission, which is waited for.
            unsafe { context.device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE) };
        };
        // SAFETY: recording, in a render pass.
        let end_pass = || unsafe { context.device.cmd_end_render_pass(commands) };
        let viewport =
            vk::Viewport { x: 0.0, y: 0.0, width: width as f32, height: height as f32, min_depth: 0.0, max_depth: 1.0 };
        context.begin_label(commands, "frame");
        // SAFETY: recording; buffers, pipelines and layout belong together (`new`), the index ranges were checked when
        // the table was uploaded, and all of them outlive the submission, which is waited for.
        unsafe {
            context.device.cmd_set_viewport(commands, 0, &[viewport]);
            context.device.cmd_set_scissor(commands, 0, &[area]);
            if let Some(buffers) = &self.table.buffers {
                context.device.cmd_bind_vertex_buffers(commands, 0, &[buffers.control.handle], &[0]);
                context.device.cmd_bind_index_buffer(commands, buffers.indices.handle, 0, vk::IndexType::UINT32);
            }
        }
        // Kept apart, every scope has a pass of its own between two barriers.
        let over = self.canvas.over;
        if over.is_none() || self.scopes.is_empty() {
            begin_pass(self.canvas.target.pass);
        }
        let mut bound = vk::Pipeline::null();
        for (scope, kind) in self.scopes.iter().enumerate() {
            context.begin_label(commands, kind.label());
            if let Some(timestamps) = timestamps {
                timestamps.record_begin(commands, scope);
            }
            if let Some(over) = over {
                begin_pass(if scope == 0 { self.canvas.target.pass } else { over });
            }
            for step in self.steps.iter().filter(|step| step.scope == scope) {
                // SAFETY: as above.
                unsafe {
                    if bound != step.pipeline {
                        context.device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, step.pipeline);
                        bound = step.pipeline;
                    }
                    let push = bytes_of(std::slice::from_ref(&step.push));
                    context.device.cmd_push_constants(commands, self.layout, PUSH_STAGES, 0, push);
                    for from in (0..step.count).step_by(step.most as usize) {
                        let count = step.most.min(step.count - from);
                        context.device.cmd_draw_indexed(commands, count, 1, step.first + from, 0, 0);
                    }
                }
            }
            if over.is_some() {
                end_pass();
                full_barrier(context, commands);
            }
            if let Some(timestamps) = timestamps {
                timestamps.record_end(commands, scope);
            }
            context.end_label(commands);
        }
        if over.is_none() || self.scopes.is_empty() {
            end_pass();
        }
        context.end_label(commands);
    }
}

/// Everything before is finished and visible before anything after begins. Outside a render pass.
fn full_barrier(context: &Context, commands: vk::CommandBuffer) {
    let all = vk::MemoryBarrier::builder()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE);
    // SAFETY: recording, outside a render pass.
    unsafe {
        context.device.cmd_pipeline_barrier(
            commands,
            vk::PipelineStageFlags::ALL_COMMANDS,
            vk::PipelineStageFlags::ALL_COMMANDS,
            vk::DependencyFlags::empty(),
            &[all.build()],
            &[],
            &[],
        );
    }
}

fn scope_of(range: &DrawRange) -> Scope {
    match (range.kind, range.part) {
        // Stitched patches are bicubics too.
        (Kind::Bicubic, None) | (Kind::Stitched, _) => Scope::Bicubic,
        (Kind::Bicubic, Some(_)) | (Kind::RemappedBicubic, _) => Scope::BicubicTransition,
        (Kind::Gregory, None) => Scope::Gregory,
        (Kind::Gregory, Some(_)) | (Kind::RemappedGregory, _) => Scope::GregoryTransition,
    }
}

/// Patches that one draw call may hold.
///
/// llvmpipe numbers the vertices of a draw call in 16 bits once a triangle has to be clipped (Mesa 22.3.6): past 65,536
/// whole patches vanish from views that do not show everything. There a range is drawn in pieces.
fn most_patches(context: &Context, tess: TessRule, range: &DrawRange) -> u32 {
    if !context.info.name.contains("llvmpipe") {
        return range.count;
    }
    let levels = tess.levels(range.level);
    // The table says how fine stitched sides are; a split edge may have twice the greatest level.
    let stitched = if range.kind.points() == 32 { MAX_LEVEL } else { 1.0 };
    let level = levels.full.max(levels.half).max(levels.inner).max(stitched) as u64;
    (0xffff / quad_vertices(level)) as u32
}

fn push_of(frame: &Frame, colour: Interpolation, range: &DrawRange, fill: Fill, greatest: f32) -> Push {
    let flat = match (fill, frame.show) {
        (Fill::Wire, _) => Some(WIRE_COLOUR),
        (_, Show::Patches) => Some(patch_colour(range.kind, range.part)),
        (_, Show::Levels) => Some(level_colour(range.level)),
        _ => None,
    };
    let [x0, y0, x1, y1] = frame.view;
    let mut push = tess_push(frame.tess, frame.scale(), range, greatest);
    // x0 goes to -1 and x1 to 1; y1 to -1, which is the top row, and y0 to 1.
    push.view = [
        (2.0 / (x1 - x0)) as f32,
        (-2.0 / (y1 - y0)) as f32,
        (-(x0 + x1) / (x1 - x0)) as f32,
        ((y0 + y1) / (y1 - y0)) as f32,
    ];
    push.flat_colour = flat.unwrap_or_default();
    push.show = u32::from(flat.is_some());
    push.clamped =
        u32::from(frame.format == Format::Rgba8) | u32::from(colour.premultiplied) << 1 | (colour.space as u32) << 4;
    push
}

/// Push constants that decide the levels of a range; `scale` is pixels a model unit, `greatest` that of the table.
pub(super) fn tess_push(tess: TessRule, scale: [f64; 2], range: &DrawRange, greatest: f32) -> Push {
    // Neighbours of different levels share free sides of stitched patches, so those have one level.
    let levels = tess.levels_to(if range.kind == Kind::Stitched { 0 } else { range.level }, greatest);
    let (corners, sides) = part_codes(range.part);
    Push {
        tess: [levels.full, levels.half, levels.inner, levels.pixels],
        pixels: scale.map(|x| x as f32),
        corners,
        sides,
        ..Push::default()
    }
}

/// Premultiplied to straight alpha, in place. A pixel without alpha becomes all zero.
pub(super) fn straighten(floats: &mut [f32]) {
    for pixel in floats.chunks_exact_mut(4) {
        let alpha = pixel[3];
        for c in &mut pixel[..3] {
            *c = if alpha > 0.0 { *c / alpha } else { 0.0 };
        }
    }
}

/// Nearest of the 256 steps; NaN is 0.
pub(super) fn to_byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_colours_come_back() {
        let mut pixels = [0.25, 0.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0];
        straighten(&mut pixels);
        assert_eq!(pixels, [0.5, 1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!([-1.0, 0.5, 2.0, f32::NAN].map(to_byte), [0, 128, 255, 0]);
    }
}
