//! Draws coarse triangles by a refinement pattern (BS05), and by its rivals: a static buffer and hardware tessellation.

mod attributes;
mod coefficients;
mod detail;
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
use crate::pattern::detail::MOST;
use crate::pattern::{CoarseMesh, Control, Detail, Displacement, Evaluator, NormalField, RefinementPattern};
use ash::vk;
use attributes::{Attributes, Block, PatternPush, FLAT, STAGES};
use detail::{DetailDraws, Patterns};
use glam::DVec3;
use refined::refined;
use std::rc::Rc;

pub use detail::EvaluatedTriangle;

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
    /// One indirect draw for each level of detail, its triangles chosen on the device.
    Indirect,
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
    /// Levels of detail instead of one pattern: with [`PatternMethod::Instanced`] and [`PatternMethod::Indirect`].
    pub detail: Option<Detail>,
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
    /// The pattern; hardware tessellation takes its level, levels of detail have their own.
    pub pattern: &'a RefinementPattern,
    /// What the coefficients were made of, if the device is to make them anew.
    pub coarse: Option<(&'a CoarseMesh, NormalField)>,
}

impl PatternScene<'_> {
    /// Flat triangles just as they are, which need little of their attributes.
    fn flat(&self) -> bool {
        self.evaluator == Evaluator::Linear && *self.displacement == Displacement::None
    }
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
    detail: Option<DetailDraws>,
    push: PatternPush,
    pipeline: vk::Pipeline,
    triangles: u32,
    // Indices of the pattern.
    indices: u32,
    flat: bool,
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
        let count = scene.controls.len();
        let by_device = frame.method == PatternMethod::Indirect;
        let lists = match &frame.detail {
            None => None,
            Some(detail) => {
                let list = detail::list(context, count, detail, by_device, readback)?;
                Some((*detail, Patterns::new(detail.most)?, list))
            }
        };
        let mut records = (32 * count * scene.pattern.weights.len()) as u64;
        if let (true, Some((detail, ..))) = (readback, &lists) {
            // As many as there can be at the most.
            let side = (1u64 << detail.most) + 1;
            records = 32 * count as u64 * side * (side + 1) / 2;
        }
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
        let controls = match scene.coarse {
            Some((mesh, field)) => Some(coefficients::make(context, &shared, mesh, scene.evaluator, field)?),
            None => None,
        };
        let list = lists.as_ref().map(|(_, _, list)| list);
        let mut made = PreparedPattern {
            attributes: Attributes::new(context, scene, controls, shared.records.as_ref(), list)?,
            shared,
            context: Rc::clone(context),
            frame: frame.clone(),
            buffers: Vec::new(),
            detail: None,
            push: PatternPush::new(frame, scene),
            pipeline: vk::Pipeline::null(),
            triangles: count as u32,
            indices: scene.pattern.indices.len() as u32,
            flat: scene.flat(),
        };
        made.pipeline = made.pipeline(passes, scene)?;
        let (vertices, indices): (Vec<u8>, Vec<u32>) = match (frame.method, &lists) {
            (_, Some((_, patterns, _))) => (bytes_of(&patterns.weights).to_vec(), patterns.indices.clone()),
            (PatternMethod::Static, _) => refined(scene),
            (PatternMethod::Hardware, _) => (bytes_of(&(0..made.triangles).collect::<Vec<u32>>()).to_vec(), Vec::new()),
            _ => (bytes_of(&scene.pattern.weights).to_vec(), scene.pattern.indices.clone()),
        };
        let mut parts = vec![("pattern vertices", &vertices[..], vk::BufferUsageFlags::VERTEX_BUFFER)];
        if !indices.is_empty() {
            parts.push(("pattern indices", bytes_of(&indices), vk::BufferUsageFlags::INDEX_BUFFER));
        }
        made.buffers = made.shared.upload(&parts)?;
        if let Some((detail, patterns, list)) = lists {
            let controls = by_device.then_some(&made.attributes.controls);
            let mut draws = DetailDraws::new(context, &detail, frame.bounds, &patterns, list, controls, readback)?;
            draws.look(&frame.camera, frame.height, scene.controls)?;
            made.detail = Some(draws);
        }
        Ok(made)
    }

    fn pipeline(&self, passes: &Passes, scene: &PatternScene) -> Result<vk::Pipeline, GpuError> {
        let method = self.frame.method;
        let readback = self.shared.records.is_some();
        let detail = self.frame.detail.is_some();
        let by_instance = method == PatternMethod::Instanced && !detail && self.flat;
        let vertex = match method {
            _ if detail && readback => shader::PATTERN_DETAIL_READBACK,
            _ if detail => shader::PATTERN_DETAIL,
            _ if by_instance && readback => shader::PATTERN_FLAT_READBACK,
            _ if readback => shader::PATTERN_READBACK,
            PatternMethod::Draws => shader::PATTERN_UNIFORM,
            PatternMethod::Instanced if by_instance => shader::PATTERN_FLAT,
            PatternMethod::Instanced | PatternMethod::Indirect => shader::PATTERN_VERTEX,
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
            instances: by_instance.then_some((size_of::<Block>() as u32, &FLAT)),
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
        let lists = self.detail.as_ref().map_or(0, DetailDraws::bytes);
        self.buffers.iter().map(|buffer| buffer.size).sum::<u64>() + attributes + lists
    }

    /// Looks from elsewhere in the next run. `scene`: the one that was prepared.
    ///
    /// # Errors
    /// The host cannot see the memory of the lists of levels.
    pub fn look(&mut self, camera: Camera, scene: &PatternScene) -> Result<(), GpuError> {
        self.frame.camera = camera;
        self.push = PatternPush::new(&self.frame, scene);
        match &mut self.detail {
            Some(draws) => draws.look(&camera, self.frame.height, scene.controls),
            None => Ok(()),
        }
    }

    /// Draws the frame and waits for it. With `read`, the picture is copied to the host, for [`PreparedPattern::pixels`].
    ///
    /// # Errors
    /// A call failed, or the device was lost.
    pub fn run(&self, read: bool) -> Result<FrameTimes, GpuError> {
        self.shared.run(read, |commands| self.record_choice(commands), |commands| self.record(commands))
    }

    /// Draws the frame under a pipeline-statistics query, which disturbs timing.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] without the feature; or as [`PreparedPattern::run`].
    pub fn statistics(&self) -> Result<Statistics, GpuError> {
        self.shared.statistics(|commands| self.record_choice(commands), |commands| self.record(commands))
    }

    fn record_choice(&self, commands: vk::CommandBuffer) {
        if let Some(draws) = &self.detail {
            draws.record_choice(commands);
        }
    }

    fn record(&self, commands: vk::CommandBuffer) {
        let device = &self.context.device;
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: recording, in a render pass; buffers, set, pipeline and layout belong together (`new`), the indices are
        // those of a pattern, and all of them outlive the submission, which is waited for.
        unsafe {
            device.cmd_bind_pipeline(commands, graphics, self.pipeline);
            // The second is read only where attributes change with the instance.
            let vertices = [self.buffers[0].handle, self.attributes.controls.handle];
            device.cmd_bind_vertex_buffers(commands, 0, &vertices, &[0; 2]);
            if let Some(indices) = self.buffers.get(1) {
                device.cmd_bind_index_buffer(commands, indices.handle, 0, vk::IndexType::UINT32);
            }
            let send = |push: &PatternPush| {
                let bytes = bytes_of(std::slice::from_ref(push));
                device.cmd_push_constants(commands, self.attributes.layout, STAGES, 0, bytes);
            };
            send(&self.push);
            let bind = |offset: u32| {
                let sets = [self.attributes.set()];
                device.cmd_bind_descriptor_sets(commands, graphics, self.attributes.layout, 0, &sets, &[offset]);
            };
            bind(0);
            if let Some(draws) = &self.detail {
                draws.record(commands, &self.push, send);
                return;
            }
            match self.frame.method {
                PatternMethod::Draws => {
                    for t in 0..self.triangles {
                        bind(t * size_of::<Block>() as u32);
                        device.cmd_draw_indexed(commands, self.indices, 1, 0, 0, 0);
                    }
                }
                PatternMethod::Instanced | PatternMethod::Indirect => {
                    device.cmd_draw_indexed(commands, self.indices, self.triangles, 0, 0, 0);
                }
                PatternMethod::Static | PatternMethod::Hardware => {
                    let step = (MOST_VERTICES / self.push.vertices as usize).max(1) as u32;
                    for first in (0..self.triangles).step_by(step as usize) {
                        let count = step.min(self.triangles - first);
                        match self.frame.method {
                            PatternMethod::Hardware => device.cmd_draw(commands, count, 1, first, 0),
                            _ => {
                                let indices = count * self.indices;
                                device.cmd_draw_indexed(commands, indices, 1, first * self.indices, 0, 0);
                            }
                        }
                    }
                }
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
        Ok(bytes.chunks_exact(32).map(record).collect())
    }

    /// Every triangle between levels of detail.
    pub(super) fn detail_records(&mut self) -> Result<Vec<EvaluatedTriangle>, GpuError> {
        if let Some(draws) = &mut self.detail {
            draws.take_choice(&self.shared)?;
        }
        let Some(draws) = &self.detail else { return Ok(Vec::new()) };
        self.shared.run(false, |_| (), |commands| self.record(commands))?;
        let bytes = self.shared.records.as_ref().map_or(Ok(&[][..]), Buffer::bytes)?;
        let mut rest = bytes.chunks_exact(32);
        let mut all: Vec<EvaluatedTriangle> = draws
            .triangles()?
            .into_iter()
            .map(|(triangle, levels, count)| EvaluatedTriangle {
                triangle,
                levels,
                points: rest.by_ref().take(count).map(record).collect(),
            })
            .collect();
        all.sort_by_key(|t| t.triangle);
        Ok(all)
    }
}

/// Position and normal of 32 bytes.
fn record(b: &[u8]) -> [[f32; 3]; 2] {
    let float = |i: usize| f32::from_le_bytes([b[4 * i], b[4 * i + 1], b[4 * i + 2], b[4 * i + 3]]);
    [[float(0), float(1), float(2)], [float(4), float(5), float(6)]]
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
    let draws_detail = matches!(frame.method, PatternMethod::Instanced | PatternMethod::Indirect);
    match &frame.detail {
        None if frame.method == PatternMethod::Indirect => {
            return fault("--method indirect draws levels of detail; give --lod triangle or --lod mesh".to_owned());
        }
        Some(_) if !draws_detail => {
            return fault("levels of detail go with --method instanced and indirect; use one of these".to_owned());
        }
        Some(detail) if detail.most > MOST || !(detail.segment.is_finite() && detail.segment > 0.0) => {
            return fault(format!("levels of detail go to {MOST}, and segments have more than 0 pixels"));
        }
        _ => {}
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
