//! Draws coarse triangles by a refinement pattern (BS05), and by its rivals: a static buffer and hardware tessellation.

mod attributes;
mod refined;

use super::context::Context;
use super::depth_frame::DepthFrame;
use super::draw::{FrameTimes, Pixels};
use super::error::GpuError;
use super::graphics::Recipe;
use super::memory::{bytes_of, Buffer};
use super::query::Statistics;
use super::shader;
use super::target::Passes;
use crate::camera::Camera;
use crate::pattern::{Control, Displacement, Evaluator, RefinementPattern};
use ash::vk;
use attributes::{Attributes, Block, PatternPush, STAGES};
use glam::DVec3;
use refined::refined;
use std::rc::Rc;

/// How a refined mesh is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatternMethod {
    /// One draw for each coarse triangle with its attributes as uniforms: the paper's way.
    Draws,
    /// One draw with an instance for each coarse triangle.
    Instanced,
    /// The whole refined mesh in a vertex buffer: the paper's rival.
    Static,
    /// Hardware tessellation, levels to 64.
    Hardware,
}

/// What a picture of a refined mesh shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatternShow {
    /// Colours, lit.
    #[default]
    Shaded,
    /// The normal as a colour, half of it and one half.
    Normals,
    /// Edges of the refined triangles in their colours.
    Wire,
}

/// A picture of a refined mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct PatternFrame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Where it is seen from.
    pub camera: Camera,
    /// Least and greatest corner of what is drawn.
    pub bounds: [DVec3; 2],
    /// What is shown.
    pub show: PatternShow,
    /// How it is drawn.
    pub method: PatternMethod,
    /// Colour under everything, straight alpha; `None`: transparent black.
    pub background: Option<[f32; 4]>,
    /// Samples a pixel, 1 or 4.
    pub samples: u32,
}

/// What is drawn: coefficients of all coarse triangles, and the pattern.
#[derive(Clone, Copy, Debug)]
pub struct PatternScene<'a> {
    /// One a coarse triangle.
    pub controls: &'a [Control],
    /// What they become.
    pub evaluator: Evaluator,
    /// Displacement.
    pub displacement: &'a Displacement,
    /// The pattern; hardware tessellation takes its level.
    pub pattern: &'a RefinementPattern,
}

/// Vertices of one draw call that llvmpipe can number: see `most_patches` in `draw`.
const MOST_VERTICES: usize = 0xffff;

/// A frame with everything on the device, to be run as often as wanted.
pub struct PreparedPattern {
    context: Rc<Context>,
    frame: PatternFrame,
    shared: DepthFrame,
    attributes: Attributes,
    // Vertices and indices; hardware tessellation has no indices.
    buffers: Vec<Buffer>,
    push: PatternPush,
    pipeline: vk::Pipeline,
    triangles: u32,
    // Indices of the pattern.
    indices: u32,
}

impl PreparedPattern {
    pub(super) fn new(
        context: &Rc<Context>,
        passes: &Passes,
        scene: &PatternScene,
        frame: &PatternFrame,
        readback: bool,
    ) -> Result<PreparedPattern, GpuError> {
        check(context, scene, frame, readback)?;
        let records = (32 * scene.controls.len() * scene.pattern.weights.len()) as u64;
        let shared = match readback {
            true => DepthFrame::read_back(context, passes, "pattern read-back", records)?,
            false => DepthFrame::new(
                context,
                passes,
                "pattern frame",
                [frame.width, frame.height],
                frame.samples,
                frame.background,
            )?,
        };
        let mut made = PreparedPattern {
            attributes: Attributes::new(context, scene, shared.records.as_ref())?,
            shared,
            context: Rc::clone(context),
            frame: frame.clone(),
            buffers: Vec::new(),
            push: PatternPush::new(frame, scene),
            pipeline: vk::Pipeline::null(),
            triangles: scene.controls.len() as u32,
            indices: scene.pattern.indices.len() as u32,
        };
        made.pipeline = made.pipeline(passes, scene)?;
        let (vertices, indices): (Vec<u8>, Vec<u32>) = match frame.method {
            PatternMethod::Static => refined(scene),
            PatternMethod::Hardware => (bytes_of(&(0..made.triangles).collect::<Vec<u32>>()).to_vec(), Vec::new()),
            _ => (bytes_of(&scene.pattern.weights).to_vec(), scene.pattern.indices.clone()),
        };
        let mut parts = vec![("pattern vertices", &vertices[..], vk::BufferUsageFlags::VERTEX_BUFFER)];
        if !indices.is_empty() {
            parts.push(("pattern indices", bytes_of(&indices), vk::BufferUsageFlags::INDEX_BUFFER));
        }
        made.buffers = made.shared.upload(&parts)?;
        Ok(made)
    }

    fn pipeline(&self, passes: &Passes, scene: &PatternScene) -> Result<vk::Pipeline, GpuError> {
        let method = self.frame.method;
        let readback = self.shared.records.is_some();
        let vertex = match method {
            _ if readback => shader::PATTERN_READBACK,
            PatternMethod::Draws => shader::PATTERN_UNIFORM,
            PatternMethod::Instanced => shader::PATTERN_VERTEX,
            PatternMethod::Static => shader::PATTERN_STATIC,
            PatternMethod::Hardware => shader::PATTERN_PATCH,
        };
        let mut stages = vec![(vk::ShaderStageFlags::VERTEX, vertex)];
        let hardware = method == PatternMethod::Hardware;
        if hardware {
            stages.push((vk::ShaderStageFlags::TESSELLATION_CONTROL, shader::PATTERN_CONTROL));
            stages.push((vk::ShaderStageFlags::TESSELLATION_EVALUATION, shader::PATTERN_EVALUATION));
        }
        if !readback {
            stages.push((vk::ShaderStageFlags::FRAGMENT, shader::PATTERN_FRAGMENT));
        }
        let (stride, formats): (u32, &[vk::Format]) = match method {
            PatternMethod::Static => (48, &[vk::Format::R32G32B32A32_SFLOAT; 3]),
            PatternMethod::Hardware => (4, &[vk::Format::R32_UINT]),
            _ => (12, &[vk::Format::R32G32B32_SFLOAT]),
        };
        let recipe = Recipe {
            name: &format!("pattern {method:?} pipeline"),
            stages,
            constants: &[
                u32::from(scene.evaluator != Evaluator::Linear),
                match scene.displacement {
                    Displacement::None => 0,
                    Displacement::Sine(_) => 1,
                    Displacement::Noise(_) => 2,
                    Displacement::Height(_) => 3,
                },
            ],
            stride,
            formats,
            topology: match hardware {
                true => vk::PrimitiveTopology::PATCH_LIST,
                false => vk::PrimitiveTopology::TRIANGLE_LIST,
            },
            patch_points: u32::from(hardware),
            wire: self.frame.show == PatternShow::Wire,
            behind: false,
            blended: false,
            discard: readback,
            layout: self.attributes.layout,
            pass: self.shared.pass,
        };
        recipe.make(&self.context, passes)
    }

    /// Bytes on the device: vertices, indices, and the coefficients where the method reads them.
    pub fn bytes(&self) -> u64 {
        let attributes = if self.frame.method == PatternMethod::Static { 0 } else { self.attributes.controls.size };
        self.buffers.iter().map(|buffer| buffer.size).sum::<u64>() + attributes
    }

    /// Looks from elsewhere in the next run. `scene`: the one that was prepared.
    pub fn look(&mut self, camera: Camera, scene: &PatternScene) {
        self.frame.camera = camera;
        self.push = PatternPush::new(&self.frame, scene);
    }

    /// Draws the frame and waits for it. With `read`, the picture is copied to the host, for [`PreparedPattern::pixels`].
    ///
    /// # Errors
    /// A call failed, or the device was lost.
    pub fn run(&self, read: bool) -> Result<FrameTimes, GpuError> {
        self.shared.run(read, |_| (), |commands| self.record(commands))
    }

    /// Draws the frame under a pipeline-statistics query, which disturbs timing.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] without the feature; or as [`PreparedPattern::run`].
    pub fn statistics(&self) -> Result<Statistics, GpuError> {
        self.shared.statistics(|_| (), |commands| self.record(commands))
    }

    fn record(&self, commands: vk::CommandBuffer) {
        let device = &self.context.device;
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: recording, in a render pass; buffers, set, pipeline and layout belong together (`new`), the indices are
        // those of a pattern, and all of them outlive the submission, which is waited for.
        unsafe {
            device.cmd_bind_pipeline(commands, graphics, self.pipeline);
            device.cmd_bind_vertex_buffers(commands, 0, &[self.buffers[0].handle], &[0]);
            if let Some(indices) = self.buffers.get(1) {
                device.cmd_bind_index_buffer(commands, indices.handle, 0, vk::IndexType::UINT32);
            }
            let push = bytes_of(std::slice::from_ref(&self.push));
            device.cmd_push_constants(commands, self.attributes.layout, STAGES, 0, push);
            let bind = |offset: u32| {
                let sets = [self.attributes.set];
                device.cmd_bind_descriptor_sets(commands, graphics, self.attributes.layout, 0, &sets, &[offset]);
            };
            bind(0);
            match self.frame.method {
                PatternMethod::Draws => {
                    for t in 0..self.triangles {
                        bind(t * size_of::<Block>() as u32);
                        device.cmd_draw_indexed(commands, self.indices, 1, 0, 0, 0);
                    }
                }
                PatternMethod::Instanced => device.cmd_draw_indexed(commands, self.indices, self.triangles, 0, 0, 0),
                PatternMethod::Static => {
                    let step = (MOST_VERTICES / self.push.vertices as usize).max(1) as u32;
                    for first in (0..self.triangles).step_by(step as usize) {
                        let count = step.min(self.triangles - first) * self.indices;
                        device.cmd_draw_indexed(commands, count, 1, first * self.indices, 0, 0);
                    }
                }
                PatternMethod::Hardware => device.cmd_draw(commands, self.triangles, 1, 0, 0),
            }
        }
    }

    /// The picture of the last `run(true)`, straight alpha, 8 bits.
    ///
    /// # Errors
    /// The host cannot see the memory.
    pub fn pixels(&self) -> Result<Pixels, GpuError> {
        self.shared.pixels()
    }

    /// Position and normal of every vertex, coarse triangle by coarse triangle in the pattern's order.
    pub(super) fn records(&self) -> Result<Vec<[[f32; 3]; 2]>, GpuError> {
        self.run(false)?;
        let bytes = self.shared.records.as_ref().map_or(Ok(&[][..]), Buffer::bytes)?;
        let float = |b: &[u8], i: usize| f32::from_le_bytes([b[4 * i], b[4 * i + 1], b[4 * i + 2], b[4 * i + 3]]);
        let read = |b: &[u8]| [[float(b, 0), float(b, 1), float(b, 2)], [float(b, 4), float(b, 5), float(b, 6)]];
        Ok(bytes.chunks_exact(32).map(read).collect())
    }
}

impl Drop for PreparedPattern {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe { self.context.device.destroy_pipeline(self.pipeline, None) };
    }
}

fn check(context: &Context, scene: &PatternScene, frame: &PatternFrame, readback: bool) -> Result<(), GpuError> {
    let fault = |what: String| Err(GpuError::Request(what));
    let lacks = |missing: &str| Err(GpuError::Lacks { device: context.info.name.clone(), missing: missing.to_owned() });
    if scene.controls.is_empty() {
        return fault("the scene has no triangle to draw".to_owned());
    }
    let all = scene.controls.len() as u64 * scene.pattern.indices.len() as u64;
    if frame.method == PatternMethod::Static && all > u64::from(context.info.limits.max_index) {
        return fault(format!("{all} indices are more than the device counts; ask for a lower --level"));
    }
    if frame.method == PatternMethod::Hardware && scene.pattern.level > context.info.limits.max_tessellation_level {
        return fault(format!(
            "level {} is beyond the {} of the device's tessellator; use another --method",
            scene.pattern.level, context.info.limits.max_tessellation_level
        ));
    }
    if frame.show == PatternShow::Wire && !context.optional.wire {
        return lacks("fillModeNonSolid (wireframe)");
    }
    if readback && !context.optional.readback {
        return lacks("vertexPipelineStoresAndAtomics (read-back)");
    }
    let aspect = f64::from(frame.width) / f64::from(frame.height.max(1));
    let finite = scene.controls.iter().all(|c| Block::new(c).0.iter().flatten().all(|x| x.is_finite()));
    if !finite || !frame.camera.matrix(aspect, frame.bounds).as_mat4().is_finite() {
        return fault("the scene's coordinates are too large or too close together to draw; scale them".to_owned());
    }
    Ok(())
}
