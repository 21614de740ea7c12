//! Draws scenes in space: triangles and lines with a depth buffer, coloured pixel by pixel.

use super::context::{Commands, Context};
use super::draw::{to_byte, FrameTimes, Pixels};
use super::error::{GpuError, Named};
use super::memory::{bytes_of, Buffer, Plain};
use super::query::{Scope, Statistics, StatisticsQuery, Timestamps};
use super::shader::{self, Module};
use super::target::{PassKey, Passes, Target};
use crate::camera::{Camera, Projection};
use crate::patch::solid::{Primitive, SolidTable};
use ash::vk;
use glam::{DMat4, DVec3};
use gpu_allocator::MemoryLocation;
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
    /// Segments of every edge, a whole number from 1 to 64.
    pub level: u32,
    /// Normals.
    pub normals: SolidNormals,
    /// Exponent of the blend weight.
    pub power: f32,
}

impl Default for Tessellation {
    fn default() -> Self {
        Tessellation { level: 16, normals: SolidNormals::default(), power: 1.0 }
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
    unused: u32,
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
            tess: frame.tessellation.level as f32,
            unused: 0,
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
}

/// A frame with its table on the device; the camera may change from run to run.
pub struct PreparedSolid {
    context: Rc<Context>,
    frame: SolidFrame,
    pass: PassKey,
    target: Target,
    commands: Commands,
    timestamps: Option<Timestamps>,
    push: SolidPush,
    buffers: Option<[Buffer; 2]>,
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
        let pass = PassKey::Depth { format: format(frame), samples: frame.samples };
        let llvmpipe = context.info.name.contains("llvmpipe");
        let mut made = PreparedSolid {
            target: Target::new(context, passes, pass, [frame.width, frame.height])?,
            commands: Commands::new(context, "solid frame")?,
            timestamps: Timestamps::new(context, vec![Scope::Frame])?,
            push: SolidPush::new(frame, table),
            context: Rc::clone(context),
            frame: frame.clone(),
            pass,
            buffers: None,
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
                Primitive::Bicubic | Primitive::Gregory => {
                    (MOST_INDICES / (frame.tessellation.level + 1).pow(2)).max(1) * points
                }
            };
            made.steps.push(Step { pipeline, first: part.first, count: part.count * points, most });
        }
        made.upload(table)?;
        Ok(made)
    }

    fn upload(&mut self, table: &SolidTable) -> Result<(), GpuError> {
        if table.vertices.is_empty() || table.indices.is_empty() {
            return Ok(());
        }
        let context = &self.context;
        let from = [
            Buffer::staging(context, "solid vertices staging", &table.vertices)?,
            Buffer::staging(context, "solid indices staging", &table.indices)?,
        ];
        let on_device = |name, size, usage| {
            Buffer::new(context, name, size, usage | vk::BufferUsageFlags::TRANSFER_DST, MemoryLocation::GpuOnly)
        };
        let to = [
            on_device("solid vertices", from[0].size, vk::BufferUsageFlags::VERTEX_BUFFER)?,
            on_device("solid indices", from[1].size, vk::BufferUsageFlags::INDEX_BUFFER)?,
        ];
        self.commands.run(|commands| {
            for (from, to) in from.iter().zip(&to) {
                let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.size };
                // SAFETY: recording; both buffers have this size, and no submission uses either.
                unsafe { context.device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]) };
            }
            // The fence that is waited for makes the copies visible to every later submission.
            Ok(())
        })?;
        self.buffers = Some(to);
        Ok(())
    }

    fn pipeline(&mut self, passes: &Passes, primitive: Primitive) -> Result<vk::Pipeline, GpuError> {
        if let Some((_, made)) = self.pipelines.iter().find(|(p, _)| *p == primitive) {
            return Ok(*made);
        }
        let name = format!("solid {primitive:?} pipeline");
        let vertex = if primitive.is_patch() { &shader::VERTEX } else { &shader::SOLID_VERTEX };
        let mut modules = vec![
            (vk::ShaderStageFlags::VERTEX, Module::new(&self.context, vertex)?),
            (vk::ShaderStageFlags::FRAGMENT, Module::new(&self.context, &shader::SOLID_FRAGMENT)?),
        ];
        if let Some([control, evaluation]) = shader::solid(primitive) {
            modules.push((vk::ShaderStageFlags::TESSELLATION_CONTROL, Module::new(&self.context, &control)?));
            modules.push((vk::ShaderStageFlags::TESSELLATION_EVALUATION, Module::new(&self.context, &evaluation)?));
        }
        let stages: Vec<vk::PipelineShaderStageCreateInfo> = modules
            .iter()
            .map(|(stage, module)| {
                vk::PipelineShaderStageCreateInfo::builder().stage(*stage).module(module.handle).name(c"main").build()
            })
            .collect();
        let bindings = [vk::VertexInputBindingDescription {
            binding: 0,
            stride: size_of::<[f32; 8]>() as u32,
            input_rate: vk::VertexInputRate::VERTEX,
        }];
        let attributes = [0, 1].map(|i| vk::VertexInputAttributeDescription {
            location: i,
            binding: 0,
            format: vk::Format::R32G32B32A32_SFLOAT,
            offset: 16 * i,
        });
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::builder()
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::builder().topology(match primitive {
            Primitive::Triangles => vk::PrimitiveTopology::TRIANGLE_LIST,
            Primitive::Lines => vk::PrimitiveTopology::LINE_LIST,
            Primitive::Bicubic | Primitive::Gregory => vk::PrimitiveTopology::PATCH_LIST,
        });
        let tessellation =
            vk::PipelineTessellationStateCreateInfo::builder().patch_control_points(primitive.points() as u32);
        let viewport = vk::PipelineViewportStateCreateInfo::builder().viewport_count(1).scissor_count(1);
        // Lines lie in faces: the faces step back a little.
        let behind = primitive == Primitive::Triangles && self.frame.show == SolidShow::Plain;
        let raster = vk::PipelineRasterizationStateCreateInfo::builder()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(vk::CullModeFlags::NONE)
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .depth_bias_enable(behind)
            .depth_bias_constant_factor(1.0)
            .depth_bias_slope_factor(1.0)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::builder().rasterization_samples(self.pass.samples());
        let attachments =
            [vk::PipelineColorBlendAttachmentState::builder().color_write_mask(vk::ColorComponentFlags::RGBA).build()];
        let blend = vk::PipelineColorBlendStateCreateInfo::builder().attachments(&attachments);
        let depth = vk::PipelineDepthStencilStateCreateInfo::builder()
            .depth_test_enable(true)
            .depth_write_enable(true)
            .depth_compare_op(vk::CompareOp::LESS_OR_EQUAL);
        let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::builder().dynamic_states(&states);
        let mut info = vk::GraphicsPipelineCreateInfo::builder()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&multisample)
            .color_blend_state(&blend)
            .depth_stencil_state(&depth)
            .dynamic_state(&dynamic)
            .layout(self.layout)
            .render_pass(passes.get(self.pass)?);
        if primitive.is_patch() {
            info = info.tessellation_state(&tessellation);
        }
        // SAFETY: every pointer in `info` lives until the call returns.
        let made =
            unsafe { self.context.device.create_graphics_pipelines(vk::PipelineCache::null(), &[info.build()], None) };
        let pipeline = made.map_err(|(_, result)| result).named("vkCreateGraphicsPipelines", &name)?[0];
        self.context.name(pipeline, &name);
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
        let submission = self.commands.run(|commands| {
            if let Some(timestamps) = &self.timestamps {
                timestamps.record_reset(commands);
                timestamps.record_begin(commands, 0);
            }
            self.record(commands);
            if let Some(timestamps) = &self.timestamps {
                timestamps.record_end(commands, 0);
            }
            if read {
                self.target.record_copy(commands);
            }
            Ok(())
        })?;
        Ok(FrameTimes {
            gpu: self.timestamps.as_ref().map_or(Ok(super::GpuTimes::default()), Timestamps::read)?,
            record_ns: submission.record_ns,
            submit_ns: submission.submit_ns,
            wait_ns: submission.wait_ns,
        })
    }

    /// Draws the frame under a pipeline-statistics query, which disturbs timing.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] without the feature; or as [`PreparedSolid::run`].
    pub fn statistics(&self) -> Result<Statistics, GpuError> {
        let query = StatisticsQuery::new(&self.context)?;
        self.commands.run(|commands| {
            query.record_begin(commands);
            self.record(commands);
            query.record_end(commands);
            Ok(())
        })?;
        query.read()
    }

    fn record(&self, commands: vk::CommandBuffer) {
        let device = &self.context.device;
        let [width, height] = self.target.extent;
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let [r, g, b, a] = self.frame.background.unwrap_or([0.0; 4]);
        let clear = Target::clear_values(self.pass, [r * a, g * a, b * a, a]);
        let begin = vk::RenderPassBeginInfo::builder()
            .render_pass(self.target.pass)
            .framebuffer(self.target.framebuffer)
            .render_area(area)
            .clear_values(&clear);
        let viewport =
            vk::Viewport { x: 0.0, y: 0.0, width: width as f32, height: height as f32, min_depth: 0.0, max_depth: 1.0 };
        self.context.begin_label(commands, "solid frame");
        // SAFETY: recording; pass, target, buffers, pipelines and layout belong together (`new`), the indices were
        // checked there, and all of them outlive the submission, which is waited for.
        unsafe {
            device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            if let Some([vertices, indices]) = &self.buffers {
                device.cmd_bind_vertex_buffers(commands, 0, &[vertices.handle], &[0]);
                device.cmd_bind_index_buffer(commands, indices.handle, 0, vk::IndexType::UINT32);
                let push = bytes_of(std::slice::from_ref(&self.push));
                device.cmd_push_constants(commands, self.layout, STAGES, 0, push);
                for step in &self.steps {
                    device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, step.pipeline);
                    for from in (0..step.count).step_by(step.most as usize) {
                        let count = step.most.min(step.count - from);
                        device.cmd_draw_indexed(commands, count, 1, step.first + from, 0, 0);
                    }
                }
            }
            device.cmd_end_render_pass(commands);
        }
        self.context.end_label(commands);
    }

    /// The picture of the last `run(true)`, straight alpha, 8 bits.
    ///
    /// # Errors
    /// The host cannot see the memory.
    pub fn pixels(&self) -> Result<Pixels, GpuError> {
        let bytes = self.target.pixels()?;
        if format(&self.frame) == vk::Format::R8G8B8A8_UNORM {
            return Ok(Pixels::Rgba8(bytes.to_vec()));
        }
        let mut floats: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        super::draw::straighten(&mut floats);
        Ok(Pixels::Rgba8(floats.into_iter().map(to_byte).collect()))
    }
}

/// Edges of several samples over a transparent ground are premultiplied: floats keep their colours.
fn format(frame: &SolidFrame) -> vk::Format {
    match frame.background {
        Some([.., a]) if a >= 1.0 => vk::Format::R8G8B8A8_UNORM,
        _ => vk::Format::R32G32B32A32_SFLOAT,
    }
}

/// The GPU follows indices blindly, so nothing that points outside gets there.
fn check(context: &Context, table: &SolidTable, frame: &SolidFrame) -> Result<(), GpuError> {
    let fault = |what: String| Err(GpuError::Request(what));
    let most = u64::from(context.info.limits.max_index).min(u64::from(u32::MAX));
    if table.vertices.len() as u64 > most || table.indices.len() as u64 > u64::from(u32::MAX) {
        return fault(format!(
            "{} vertices and {} indices are more than the device counts; ask for a lower level",
            table.vertices.len(),
            table.indices.len()
        ));
    }
    if let Some(index) = table.indices.iter().find(|&&i| i as usize >= table.vertices.len()) {
        return fault(format!("solid table: index {index} of {} vertices", table.vertices.len()));
    }
    for part in &table.parts {
        let end = u64::from(part.first) + u64::from(part.count) * part.primitive.points() as u64;
        if end > table.indices.len() as u64 {
            return fault(format!("solid table: {part:?} runs past the {} indices", table.indices.len()));
        }
    }
    if !(1..=64).contains(&frame.tessellation.level) {
        return fault(format!("{} segments an edge; give 1 to 64", frame.tessellation.level));
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
