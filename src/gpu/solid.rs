//! Draws scenes in space: triangles, lines and patches with a depth buffer, coloured pixel by pixel.

use super::context::Context;
use super::depth_frame::DepthFrame;
use super::draw::{FrameTimes, Pixels};
use super::error::{GpuError, Named};
use super::graphics::Recipe;
use super::memory::{bytes_of, Buffer, Plain};
use super::query::Statistics;
use super::shader;
use super::stencil;
use super::target::Passes;
use crate::camera::{Camera, Projection};
use crate::patch::solid::{Primitive, Segments, SolidTable};
use ash::vk;
use glam::{DMat4, DVec3};
use std::rc::Rc;

/// What a picture of a surface in space shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolidShow {
    /// Lit, seen from either side.
    #[default]
    Shaded,
    /// Stripes by the normal's angle to a fixed direction of the picture: highlight lines, isophotes.
    Highlight,
    /// Stripes by the direction of the mirrored view.
    Reflection,
    /// The normal as a colour, half of it and one half.
    Normals,
    /// Blend weight from blue (0) to red (1).
    Weights,
    /// The colour that vertices have instead of a normal.
    Plain,
    /// White seen from the front, red from the back.
    Sides,
}

/// Which normals patches are coloured by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolidNormals {
    /// N_B.
    #[default]
    Blended,
    /// N_L, by the derivatives.
    Geometric,
    /// N_S.
    Subdivided,
}

/// How patches are drawn; triangles do not care.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tessellation {
    /// Segments of edges, from 1 to 64; a side with finer neighbours may have as many, too.
    pub segments: Segments,
    /// Normals.
    pub normals: SolidNormals,
    /// Exponent of the blend weight.
    pub power: f32,
}

impl Default for Tessellation {
    fn default() -> Self {
        Tessellation { segments: Segments::Fixed(16), normals: SolidNormals::default(), power: 1.0 }
    }
}

/// A picture of a scene in space.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidFrame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Where it is seen from.
    pub camera: Camera,
    /// What is shown.
    pub show: SolidShow,
    /// Stripes a radian, of highlight and reflection lines: the argument of the sine for a unit of the cosine.
    pub stripes: f32,
    /// Colour under everything, straight alpha; `None`: transparent black.
    pub background: Option<[f32; 4]>,
    /// Samples a pixel, 1 or 4.
    pub samples: u32,
    /// Of patches.
    pub tessellation: Tessellation,
}

/// Twin of `Push` in `glsl/inc/solid.glsl`.
#[repr(C)]
#[derive(Clone, Copy)]
struct SolidPush {
    clip: [f32; 16],
    eye: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    show: u32,
    normals: u32,
    tess: f32,
    finer: f32,
}

const _: () = assert!(size_of::<SolidPush>() == 128);
// SAFETY: repr(C), 4-byte fields only, 128 bytes without padding.
unsafe impl Plain for SolidPush {}

impl SolidPush {
    fn new(frame: &SolidFrame, table: &SolidTable) -> SolidPush {
        let aspect = f64::from(frame.width) / f64::from(frame.height);
        let clip = frame.camera.matrix(aspect, table.bounds) * DMat4::from_translation(table.centre);
        let [right, up, back] = frame.camera.axes();
        let vec4 = |v: DVec3, w: f64| v.extend(w).as_vec4().to_array();
        SolidPush {
            clip: clip.as_mat4().to_cols_array(),
            eye: match frame.camera.projection {
                Projection::Perspective { .. } => vec4(frame.camera.eye - table.centre, 1.0),
                Projection::Orthographic { .. } => vec4(back, 0.0),
            },
            right: vec4(right, f64::from(frame.stripes)),
            up: vec4(up, f64::from(frame.tessellation.power)),
            show: match frame.show {
                SolidShow::Shaded => 0,
                SolidShow::Highlight => 1,
                SolidShow::Reflection => 2,
                SolidShow::Normals => 3,
                SolidShow::Weights => 4,
                SolidShow::Plain => 5,
                SolidShow::Sides => 6,
            },
            normals: match frame.tessellation.normals {
                SolidNormals::Blended => 0,
                SolidNormals::Geometric => 1,
                SolidNormals::Subdivided => 2,
            },
            tess: 1.0,
            finer: 1.0,
        }
    }
}

/// Most indices of a draw call on llvmpipe, a whole number of triangles and lines: see `most_patches` in `draw`.
const MOST_INDICES: u32 = 60_000;

const STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::VERTEX.as_raw()
        | vk::ShaderStageFlags::TESSELLATION_CONTROL.as_raw()
        | vk::ShaderStageFlags::TESSELLATION_EVALUATION.as_raw()
        | vk::ShaderStageFlags::FRAGMENT.as_raw(),
);

/// A draw of one part.
struct Step {
    pipeline: vk::Pipeline,
    first: u32,
    count: u32,
    /// Most indices in one draw call.
    most: u32,
    /// Level of patches.
    level: u32,
}

/// A frame with its table on the device; the camera may change from run to run.
pub struct PreparedSolid {
    context: Rc<Context>,
    frame: SolidFrame,
    shared: DepthFrame,
    push: SolidPush,
    // Vertices and indices; none of an empty table.
    buffers: Vec<Buffer>,
    // Whether the device made the vertices.
    points_made: bool,
    steps: Vec<Step>,
    pipelines: Vec<(Primitive, vk::Pipeline)>,
    layout: vk::PipelineLayout,
}

impl PreparedSolid {
    pub(super) fn new(
        context: &Rc<Context>,
        passes: &Passes,
        table: &SolidTable,
        frame: &SolidFrame,
    ) -> Result<PreparedSolid, GpuError> {
        check(context, table, frame)?;
        let llvmpipe = context.info.name.contains("llvmpipe");
        let mut made = PreparedSolid {
            shared: DepthFrame::new(
                context,
                passes,
                "solid frame",
                [frame.width, frame.height],
                frame.samples,
                frame.background,
            )?,
            push: SolidPush::new(frame, table),
            context: Rc::clone(context),
            frame: frame.clone(),
            buffers: Vec::new(),
            points_made: false,
            steps: Vec::new(),
            pipelines: Vec::new(),
            layout: vk::PipelineLayout::null(),
        };
        let ranges = [vk::PushConstantRange { stage_flags: STAGES, offset: 0, size: size_of::<SolidPush>() as u32 }];
        let info = vk::PipelineLayoutCreateInfo::builder().push_constant_ranges(&ranges);
        // SAFETY: the info is valid; 128 bytes of push constants are within every device's limit.
        made.layout =
            unsafe { context.device.create_pipeline_layout(&info, None) }.named("vkCreatePipelineLayout", "solid")?;
        for part in table.parts.iter().filter(|part| part.count > 0) {
            let pipeline = made.pipeline(passes, part.primitive)?;
            let points = part.primitive.points() as u32;
            let most = match part.primitive {
                _ if !llvmpipe => u32::MAX / points * points,
                Primitive::Triangles | Primitive::Lines => MOST_INDICES,
                // As many patches as make so many vertices.
                _ => (MOST_INDICES / (frame.tessellation.segments.at(part.level) + 1).pow(2)).max(1) * points,
            };
            let (first, count) = (part.first, part.count * points);
            made.steps.push(Step { pipeline, first, count, most, level: part.level });
        }
        if table.points() == 0 || table.indices.is_empty() {
            return Ok(made);
        }
        let indices = ("solid indices", bytes_of(&table.indices), vk::BufferUsageFlags::INDEX_BUFFER);
        let upload = |vertices: &[[f32; 8]]| {
            let vertices = ("solid vertices", bytes_of(vertices), vk::BufferUsageFlags::VERTEX_BUFFER);
            made.shared.upload(&[vertices, indices])
        };
        let most = context.info.limits.max_storage_buffer;
        made.buffers = match &table.stencils {
            None => upload(&table.vertices)?,
            Some(stencils) if stencil::fits(stencils, table.vertices.len(), most) => {
                let points = stencil::make(context, &made.shared, stencils, &table.vertices)?;
                let indices = made.shared.upload(&[indices])?;
                made.points_made = true;
                std::iter::once(points).chain(indices).collect()
            }
            Some(stencils) => upload(&stencils.points_of(&table.vertices))?,
        };
        Ok(made)
    }

    fn pipeline(&mut self, passes: &Passes, primitive: Primitive) -> Result<vk::Pipeline, GpuError> {
        if let Some((_, made)) = self.pipelines.iter().find(|(p, _)| *p == primitive) {
            return Ok(*made);
        }
        let name = format!("solid {primitive:?} pipeline");
        let vertex = if primitive.is_patch() { shader::VERTEX } else { shader::SOLID_VERTEX };
        let mut stages =
            vec![(vk::ShaderStageFlags::VERTEX, vertex), (vk::ShaderStageFlags::FRAGMENT, shader::SOLID_FRAGMENT)];
        if let Some([control, evaluation]) = shader::solid(primitive) {
            stages.push((vk::ShaderStageFlags::TESSELLATION_CONTROL, control));
            stages.push((vk::ShaderStageFlags::TESSELLATION_EVALUATION, evaluation));
        }
        let recipe = Recipe {
            name: &name,
            stages,
            constants: &[],
            stride: size_of::<[f32; 8]>() as u32,
            formats: &[vk::Format::R32G32B32A32_SFLOAT; 2],
            instances: None,
            topology: match primitive {
                Primitive::Triangles => vk::PrimitiveTopology::TRIANGLE_LIST,
                Primitive::Lines => vk::PrimitiveTopology::LINE_LIST,
                _ => vk::PrimitiveTopology::PATCH_LIST,
            },
            patch_points: if primitive.is_patch() { primitive.points() as u32 } else { 0 },
            wire: false,
            // Lines lie in faces: the faces step back a little.
            behind: primitive == Primitive::Triangles && self.frame.show == SolidShow::Plain,
            blended: false,
            discard: false,
            layout: self.layout,
            pass: self.shared.pass,
        };
        let pipeline = recipe.make(&self.context, passes)?;
        self.pipelines.push((primitive, pipeline));
        Ok(pipeline)
    }

    /// Looks from elsewhere in the next run. `table`: the one that was prepared.
    pub fn look(&mut self, camera: Camera, table: &SolidTable) {
        self.frame.camera = camera;
        self.push = SolidPush::new(&self.frame, table);
    }

    /// Draws the frame and waits for it. With `read`, the picture is copied to the host, for [`PreparedSolid::pixels`].
    ///
    /// # Errors
    /// A call failed, or the device was lost.
    pub fn run(&self, read: bool) -> Result<FrameTimes, GpuError> {
        self.shared.run(read, |_| (), |commands| self.record(commands))
    }

    /// Draws the frame under a pipeline-statistics query, which disturbs timing.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] without the feature; or as [`PreparedSolid::run`].
    pub fn statistics(&self) -> Result<Statistics, GpuError> {
        self.shared.statistics(|_| (), |commands| self.record(commands))
    }

    fn record(&self, commands: vk::CommandBuffer) {
        let [vertices, indices] = &self.buffers[..] else { return };
        let device = &self.context.device;
        // SAFETY: recording, in a render pass; buffers, pipelines and layout belong together (`new`), the indices were
        // checked there, and all of them outlive the submission, which is waited for.
        unsafe {
            device.cmd_bind_vertex_buffers(commands, 0, &[vertices.handle], &[0]);
            device.cmd_bind_index_buffer(commands, indices.handle, 0, vk::IndexType::UINT32);
            for step in &self.steps {
                let segments = |level| self.frame.tessellation.segments.at(level) as f32;
                let push = SolidPush { tess: segments(step.level), finer: segments(step.level + 1), ..self.push };
                device.cmd_push_constants(commands, self.layout, STAGES, 0, bytes_of(std::slice::from_ref(&push)));
                device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, step.pipeline);
                for from in (0..step.count).step_by(step.most as usize) {
                    let count = step.most.min(step.count - from);
                    device.cmd_draw_indexed(commands, count, 1, step.first + from, 0, 0);
                }
            }
        }
    }

    /// The points that the device has made by the table's stencils; none if it has not made any.
    ///
    /// # Errors
    /// A call failed, the device was lost, or the host cannot see the memory.
    pub fn points(&self) -> Result<Vec<[f32; 8]>, GpuError> {
        match &self.buffers[..] {
            [points, _] if self.points_made => stencil::read(&self.context, &self.shared, points),
            _ => Ok(Vec::new()),
        }
    }

    /// The picture of the last `run(true)`, straight alpha, 8 bits.
    ///
    /// # Errors
    /// The host cannot see the memory.
    pub fn pixels(&self) -> Result<Pixels, GpuError> {
        self.shared.pixels()
    }

    /// The same as numbers, where the background is transparent: four a pixel.
    ///
    /// # Errors
    /// The frame's background is opaque, or as [`PreparedSolid::pixels`].
    pub fn floats(&self) -> Result<Vec<f32>, GpuError> {
        self.shared.floats()
    }
}

/// The GPU follows indices blindly, so nothing that points outside gets there.
fn check(context: &Context, table: &SolidTable, frame: &SolidFrame) -> Result<(), GpuError> {
    let fault = |what: String| Err(GpuError::Request(what));
    let most = u64::from(context.info.limits.max_index).min(u64::from(u32::MAX));
    let points = table.points();
    if points as u64 > most || table.indices.len() as u64 > u64::from(u32::MAX) {
        return fault(format!(
            "{points} vertices and {} indices are more than the device counts; ask for a lower level",
            table.indices.len()
        ));
    }
    if let Some(index) = table.indices.iter().find(|&&i| i as usize >= points) {
        return fault(format!("solid table: index {index} of {points} vertices"));
    }
    if let Some(what) = table.stencils.as_ref().and_then(|s| stencil::fault(s, &table.vertices)) {
        return fault(what);
    }
    for part in &table.parts {
        let end = u64::from(part.first) + u64::from(part.count) * part.primitive.points() as u64;
        if end > table.indices.len() as u64 {
            return fault(format!("solid table: {part:?} runs past the {} indices", table.indices.len()));
        }
    }
    for part in table.parts.iter().filter(|part| part.count > 0 && part.primitive.is_patch()) {
        let n = frame.tessellation.segments.at(part.level);
        if !(1..=64).contains(&n) {
            return fault(format!("{n} segments an edge; give 1 to 64"));
        }
        let finer = frame.tessellation.segments.at(part.level + 1);
        if part.primitive.is_transition() && finer > 32 {
            return fault(format!(
                "{finer} segments an edge beside coarser patches, which have room for 32 of each of two; give fewer"
            ));
        }
    }
    let finite = table.vertices.iter().flatten().all(|x| x.is_finite());
    let aspect = f64::from(frame.width) / f64::from(frame.height.max(1));
    if !finite || !frame.camera.matrix(aspect, table.bounds).as_mat4().is_finite() {
        return fault("the scene's coordinates are too large or too close together to draw; scale them".to_owned());
    }
    Ok(())
}

impl Drop for PreparedSolid {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe {
            for (_, pipeline) in self.pipelines.drain(..) {
                self.context.device.destroy_pipeline(pipeline, None);
            }
            self.context.device.destroy_pipeline_layout(self.layout, None);
        }
    }
}
