//! What a picture of a scene in space needs whatever is drawn: target with a depth buffer, commands, queries.

use super::context::{Commands, Context};
use super::draw::{straighten, to_byte, FrameTimes, Pixels};
use super::error::GpuError;
use super::memory::Buffer;
use super::query::{GpuTimes, Scope, Statistics, StatisticsQuery, Timestamps};
use super::target::{PassKey, Passes, Target};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// Target, commands and queries of a picture in space, or of the read-back of what it is made of.
pub(super) struct DepthFrame {
    context: Rc<Context>,
    name: &'static str,
    pub pass: PassKey,
    background: Option<[f32; 4]>,
    target: Target,
    commands: Commands,
    timestamps: Option<Timestamps>,
    /// What shaders write to where nothing is rasterised.
    pub records: Option<Buffer>,
}

impl DepthFrame {
    /// `background`: straight alpha; `None`: transparent black.
    pub fn new(
        context: &Rc<Context>,
        passes: &Passes,
        name: &'static str,
        size: [u32; 2],
        samples: u32,
        background: Option<[f32; 4]>,
    ) -> Result<DepthFrame, GpuError> {
        DepthFrame::of_pass(
            context,
            passes,
            name,
            size,
            background,
            PassKey::Depth { format: format(background), samples },
        )
    }

    /// Nothing is rasterised: shaders write to [`DepthFrame::records`], of so many bytes.
    pub fn read_back(
        context: &Rc<Context>,
        passes: &Passes,
        name: &'static str,
        bytes: u64,
    ) -> Result<DepthFrame, GpuError> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let records = Buffer::new(context, "records", bytes, usage, MemoryLocation::GpuToCpu)?;
        let made = DepthFrame::of_pass(context, passes, name, [1, 1], None, PassKey::Empty)?;
        Ok(DepthFrame { records: Some(records), ..made })
    }

    fn of_pass(
        context: &Rc<Context>,
        passes: &Passes,
        name: &'static str,
        size: [u32; 2],
        background: Option<[f32; 4]>,
        pass: PassKey,
    ) -> Result<DepthFrame, GpuError> {
        Ok(DepthFrame {
            target: Target::new(context, passes, pass, size)?,
            commands: Commands::new(context, name)?,
            timestamps: Timestamps::new(context, vec![Scope::Frame])?,
            context: Rc::clone(context),
            name,
            pass,
            background,
            records: None,
        })
    }

    /// Copies bytes into buffers on the device and waits. None of them may be empty.
    pub fn upload(&self, parts: &[(&str, &[u8], vk::BufferUsageFlags)]) -> Result<Vec<Buffer>, GpuError> {
        let context = &self.context;
        let mut pairs = Vec::with_capacity(parts.len());
        for &(name, bytes, usage) in parts {
            let from = Buffer::staging(context, &format!("{name} staging"), bytes)?;
            let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
            let to = Buffer::new(context, name, from.size, usage, MemoryLocation::GpuOnly)?;
            pairs.push((from, to));
        }
        self.commands.run(|commands| {
            for (from, to) in &pairs {
                let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.size };
                // SAFETY: recording; both buffers have this size, and no submission uses either.
                unsafe { context.device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]) };
            }
            // The fence that is waited for makes the copies visible to every later submission.
            Ok(())
        })?;
        Ok(pairs.into_iter().map(|(_, to)| to).collect())
    }

    /// Records and waits for something that draws nothing.
    pub fn compute(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<(), GpuError> {
        self.commands.run(|commands| {
            record(commands);
            Ok(())
        })?;
        Ok(())
    }

    /// Draws the frame and waits for it: `before` records outside of the render pass, `draw` within it. With `read`, the
    /// picture is copied to the host, for [`DepthFrame::pixels`].
    pub fn run(
        &self,
        read: bool,
        before: impl FnOnce(vk::CommandBuffer),
        draw: impl FnOnce(vk::CommandBuffer),
    ) -> Result<FrameTimes, GpuError> {
        let submission = self.commands.run(|commands| {
            if let Some(timestamps) = &self.timestamps {
                timestamps.record_reset(commands);
                timestamps.record_begin(commands, 0);
            }
            self.record(commands, before, draw);
            if let Some(timestamps) = &self.timestamps {
                timestamps.record_end(commands, 0);
            }
            if read {
                self.target.record_copy(commands);
            }
            Ok(())
        })?;
        Ok(FrameTimes {
            gpu: self.timestamps.as_ref().map_or(Ok(GpuTimes::default()), Timestamps::read)?,
            record_ns: submission.record_ns,
            submit_ns: submission.submit_ns,
            wait_ns: submission.wait_ns,
        })
    }

    /// Draws the frame under a pipeline-statistics query, which disturbs timing.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] without the feature; or as [`DepthFrame::run`].
    pub fn statistics(
        &self,
        before: impl FnOnce(vk::CommandBuffer),
        draw: impl FnOnce(vk::CommandBuffer),
    ) -> Result<Statistics, GpuError> {
        let query = StatisticsQuery::new(&self.context)?;
        self.commands.run(|commands| {
            query.record_begin(commands);
            self.record(commands, before, draw);
            query.record_end(commands);
            Ok(())
        })?;
        query.read()
    }

    fn record(
        &self,
        commands: vk::CommandBuffer,
        before: impl FnOnce(vk::CommandBuffer),
        draw: impl FnOnce(vk::CommandBuffer),
    ) {
        let device = &self.context.device;
        let [width, height] = self.target.extent;
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let [r, g, b, a] = self.background.unwrap_or([0.0; 4]);
        let clear = Target::clear_values(self.pass, [r * a, g * a, b * a, a]);
        let mut begin = vk::RenderPassBeginInfo::builder()
            .render_pass(self.target.pass)
            .framebuffer(self.target.framebuffer)
            .render_area(area);
        let pictured = self.pass != PassKey::Empty;
        if pictured {
            begin = begin.clear_values(&clear);
        }
        let viewport =
            vk::Viewport { x: 0.0, y: 0.0, width: width as f32, height: height as f32, min_depth: 0.0, max_depth: 1.0 };
        self.context.begin_label(commands, self.name);
        before(commands);
        // SAFETY: recording; pass and target belong together and outlive the submission, which is waited for.
        unsafe {
            device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
            if pictured {
                device.cmd_set_viewport(commands, 0, &[viewport]);
                device.cmd_set_scissor(commands, 0, &[area]);
            }
        }
        draw(commands);
        // SAFETY: recording, within the pass.
        unsafe { device.cmd_end_render_pass(commands) };
        if let Some(records) = &self.records {
            let stages = vk::PipelineStageFlags::ALL_GRAPHICS;
            records.record_to_host(commands, stages, vk::AccessFlags::SHADER_WRITE);
        }
        self.context.end_label(commands);
    }

    /// The picture of the last `run(true)`, straight alpha, 8 bits.
    ///
    /// # Errors
    /// The host cannot see the memory.
    pub fn pixels(&self) -> Result<Pixels, GpuError> {
        let bytes = self.target.pixels()?;
        if format(self.background) == vk::Format::R8G8B8A8_UNORM {
            return Ok(Pixels::Rgba8(bytes.to_vec()));
        }
        let floats = self.floats()?;
        Ok(Pixels::Rgba8(floats.into_iter().map(to_byte).collect()))
    }

    /// The same as numbers, where the background is transparent: four a pixel.
    ///
    /// # Errors
    /// The frame is one of bytes, or as [`DepthFrame::pixels`].
    pub fn floats(&self) -> Result<Vec<f32>, GpuError> {
        if format(self.background) == vk::Format::R8G8B8A8_UNORM {
            return Err(GpuError::Request("a frame over an opaque background holds bytes".to_owned()));
        }
        let bytes = self.target.pixels()?;
        let mut floats: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        straighten(&mut floats);
        Ok(floats)
    }
}

/// Edges of several samples over a transparent ground are premultiplied: floats keep their colours.
fn format(background: Option<[f32; 4]>) -> vk::Format {
    match background {
        Some([.., a]) if a >= 1.0 => vk::Format::R8G8B8A8_UNORM,
        _ => vk::Format::R32G32B32A32_SFLOAT,
    }
}
