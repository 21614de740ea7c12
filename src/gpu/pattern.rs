//! Draws coarse triangles by a refinement pattern (BS05), and by its rivals: a static buffer and hardware tessellation.

use super::context::{Commands, Context};
use super::draw::{straighten, to_byte, FrameTimes, Pixels};
use super::error::{GpuError, Named};
use super::memory::{bytes_of, Buffer, Plain};
use super::query::{Scope, Timestamps};
use super::shader::{self, Module, Spv};
use super::target::{PassKey, Passes, Target};
use crate::camera::Camera;
use crate::pattern::evaluate::evaluate;
use crate::pattern::{Control, Displacement, Evaluator, RefinementPattern};
use ash::vk;
use glam::{DVec3, Vec3, Vec4};
use gpu_allocator::MemoryLocation;
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

/// Twin of `Triangle` in `glsl/inc/pattern.glsl`.
#[repr(C)]
#[derive(Clone, Copy)]
struct Block([[f32; 4]; 32]);

const _: () = assert!(size_of::<Block>() == 512);
// SAFETY: repr(C), 4-byte fields only, without padding.
unsafe impl Plain for Block {}
// SAFETY: as above.
unsafe impl Plain for PatternPush {}

impl Block {
    fn new(c: &Control) -> Block {
        let mut block = [[0.0; 4]; 32];
        let three = |v: &DVec3| v.as_vec3().extend(1.0).to_array();
        let vectors = c.points.iter().chain(&c.normals).chain(&c.directions);
        for (slot, v) in block.iter_mut().zip(vectors) {
            *slot = three(v);
        }
        for i in 0..3 {
            block[22 + i] = c.colours[i].as_vec4().to_array();
        }
        let uv = c.uv.map(|uv| uv.as_vec2());
        block[25] = [uv[0].x, uv[0].y, uv[1].x, uv[1].y];
        block[26] = [uv[2].x, uv[2].y, 0.0, 0.0];
        block[27] = three(&c.uv_gradient[0]);
        block[28] = three(&c.uv_gradient[1]);
        Block(block)
    }
}

/// Twin of `Push` in `glsl/inc/pattern.glsl`.
#[repr(C)]
#[derive(Clone, Copy)]
struct PatternPush {
    clip: [f32; 16],
    light: [f32; 4],
    shape: [f32; 4],
    drift: f32,
    octaves: u32,
    seed: u32,
    show: u32,
    vertices: u32,
    unused: [u32; 3],
}

const _: () = assert!(size_of::<PatternPush>() == 128);

impl PatternPush {
    fn new(frame: &PatternFrame, scene: &PatternScene) -> PatternPush {
        let aspect = f64::from(frame.width) / f64::from(frame.height);
        let [right, up, back] = frame.camera.axes();
        let light: Vec3 = (back + 0.6 * up + 0.4 * right).normalize().as_vec3();
        let single = |x: f64| x as f32;
        let (shape, drift, octaves, seed) = match scene.displacement {
            Displacement::None => ([0.0; 4], 0.0, 0, 0),
            Displacement::Sine(s) => ([single(s.amplitude), single(s.frequency), 0.0, 0.0], 0.0, 0, 0),
            Displacement::Noise(n) => (
                [n.amplitude, n.frequency, n.gain, n.lacunarity].map(single),
                single(n.speed * n.time),
                n.octaves,
                n.seed,
            ),
            Displacement::Height(h) => ([single(h.amplitude), single(h.middle), 0.0, 0.0], 0.0, 0, 0),
        };
        PatternPush {
            clip: frame.camera.matrix(aspect, frame.bounds).as_mat4().to_cols_array(),
            light: Vec4::from((light, scene.pattern.level as f32)).to_array(),
            shape,
            drift,
            octaves,
            seed,
            show: match frame.show {
                PatternShow::Shaded => 0,
                PatternShow::Normals => 1,
                PatternShow::Wire => 2,
            },
            vertices: scene.pattern.weights.len() as u32,
            unused: [0; 3],
        }
    }
}

/// Stages that read push constants and descriptors.
const STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::ALL_GRAPHICS;

/// Vertices of one draw call that llvmpipe can number: see `most_patches` in `draw`.
const MOST_VERTICES: usize = 0xffff;

/// Layouts, descriptors and the buffers they name.
struct Attributes {
    context: Rc<Context>,
    set_layout: vk::DescriptorSetLayout,
    layout: vk::PipelineLayout,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    // Coefficients, heights, records.
    buffers: Vec<Buffer>,
}

impl Attributes {
    fn new(context: &Rc<Context>, scene: &PatternScene, records: u64) -> Result<Attributes, GpuError> {
        let mut made = Attributes {
            context: Rc::clone(context),
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            buffers: Vec::new(),
        };
        let kinds = [
            vk::DescriptorType::STORAGE_BUFFER,
            vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC,
            vk::DescriptorType::STORAGE_BUFFER,
            vk::DescriptorType::STORAGE_BUFFER,
        ];
        let bindings: Vec<vk::DescriptorSetLayoutBinding> = (0..)
            .zip(kinds)
            .map(|(i, kind)| {
                vk::DescriptorSetLayoutBinding::builder()
                    .binding(i)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(STAGES)
                    .build()
            })
            .collect();
        let device = &context.device;
        let info = vk::DescriptorSetLayoutCreateInfo::builder().bindings(&bindings);
        // SAFETY: the device is alive, the infos valid; 128 bytes of push constants are within every device's limit.
        unsafe {
            made.set_layout = device
                .create_descriptor_set_layout(&info, None)
                .named("vkCreateDescriptorSetLayout", "pattern attributes")?;
            let sets = [made.set_layout];
            let ranges =
                [vk::PushConstantRange { stage_flags: STAGES, offset: 0, size: size_of::<PatternPush>() as u32 }];
            let info = vk::PipelineLayoutCreateInfo::builder().set_layouts(&sets).push_constant_ranges(&ranges);
            made.layout = device.create_pipeline_layout(&info, None).named("vkCreatePipelineLayout", "pattern")?;
            let sizes = [
                vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: 3 },
                vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, descriptor_count: 1 },
            ];
            let info = vk::DescriptorPoolCreateInfo::builder().max_sets(1).pool_sizes(&sizes);
            made.pool = device.create_descriptor_pool(&info, None).named("vkCreateDescriptorPool", "pattern")?;
            let info = vk::DescriptorSetAllocateInfo::builder().descriptor_pool(made.pool).set_layouts(&sets);
            made.set = device.allocate_descriptor_sets(&info).named("vkAllocateDescriptorSets", "pattern")?[0];
        }
        let blocks: Vec<Block> = scene.controls.iter().map(Block::new).collect();
        let mut heights: Vec<u8> = Vec::new();
        match scene.displacement {
            Displacement::Height(map) => {
                heights.extend(bytes_of(&[map.size[0], map.size[1], 0, 0]));
                heights.extend(bytes_of(&map.heights));
            }
            _ => heights.resize(32, 0),
        }
        let most = u64::from(context.info.limits.max_storage_buffer);
        if [size_of_val(&blocks[..]) as u64, heights.len() as u64, records].iter().any(|&n| n > most) {
            return Err(GpuError::Request("the scene is too large for one buffer; ask for less".to_owned()));
        }
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let filled = |name, bytes: &[u8], usage| {
            let mut buffer = Buffer::new(context, name, bytes.len() as u64, usage, MemoryLocation::CpuToGpu)?;
            buffer.write(bytes)?;
            Ok::<Buffer, GpuError>(buffer)
        };
        made.buffers.push(filled(
            "coarse triangles",
            bytes_of(&blocks),
            storage | vk::BufferUsageFlags::UNIFORM_BUFFER,
        )?);
        made.buffers.push(filled("heights", &heights, storage)?);
        made.buffers.push(Buffer::new(context, "pattern records", records.max(32), storage, MemoryLocation::GpuToCpu)?);
        let of =
            |buffer: usize, range| [vk::DescriptorBufferInfo { buffer: made.buffers[buffer].handle, offset: 0, range }];
        let infos =
            [of(0, vk::WHOLE_SIZE), of(0, size_of::<Block>() as u64), of(1, vk::WHOLE_SIZE), of(2, vk::WHOLE_SIZE)];
        let writes: Vec<vk::WriteDescriptorSet> = (0..)
            .zip(kinds)
            .map(|(i, kind)| {
                vk::WriteDescriptorSet::builder()
                    .dst_set(made.set)
                    .dst_binding(i)
                    .descriptor_type(kind)
                    .buffer_info(&infos[i as usize])
                    .build()
            })
            .collect();
        // SAFETY: the set is not in use; the buffers live as long as it.
        unsafe { device.update_descriptor_sets(&writes, &[]) };
        Ok(made)
    }
}

impl Drop for Attributes {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns. The set goes with its pool.
        unsafe {
            self.context.device.destroy_descriptor_pool(self.pool, None);
            self.context.device.destroy_pipeline_layout(self.layout, None);
            self.context.device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// A frame with everything on the device, to be run as often as wanted.
pub struct PreparedPattern {
    context: Rc<Context>,
    frame: PatternFrame,
    pass: PassKey,
    target: Target,
    commands: Commands,
    timestamps: Option<Timestamps>,
    attributes: Attributes,
    // Vertices and indices; hardware tessellation has no indices.
    buffers: Vec<Buffer>,
    push: PatternPush,
    pipeline: vk::Pipeline,
    triangles: u32,
    // Indices of the pattern, and vertices.
    indices: u32,
    readback: bool,
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
        let triangles = scene.controls.len() as u32;
        let pass = match readback {
            true => PassKey::Empty,
            false => PassKey::Depth { format: format(frame), samples: frame.samples },
        };
        let records = if readback { 32 * scene.controls.len() * scene.pattern.weights.len() } else { 0 };
        let size = if readback { [1, 1] } else { [frame.width, frame.height] };
        let mut made = PreparedPattern {
            target: Target::new(context, passes, pass, size)?,
            commands: Commands::new(context, "pattern frame")?,
            timestamps: Timestamps::new(context, vec![Scope::Frame])?,
            attributes: Attributes::new(context, scene, records as u64)?,
            context: Rc::clone(context),
            frame: frame.clone(),
            pass,
            buffers: Vec::new(),
            push: PatternPush::new(frame, scene),
            pipeline: vk::Pipeline::null(),
            triangles,
            indices: scene.pattern.indices.len() as u32,
            readback,
        };
        made.pipeline = made.pipeline(passes, scene)?;
        made.upload(scene)?;
        Ok(made)
    }

    fn upload(&mut self, scene: &PatternScene) -> Result<(), GpuError> {
        let (vertices, indices): (Vec<u8>, Vec<u32>) = match self.frame.method {
            PatternMethod::Static => refined(scene),
            PatternMethod::Hardware => (bytes_of(&(0..self.triangles).collect::<Vec<u32>>()).to_vec(), Vec::new()),
            _ => (bytes_of(&scene.pattern.weights).to_vec(), scene.pattern.indices.clone()),
        };
        let context = &self.context;
        let mut pairs = vec![(
            Buffer::staging(context, "pattern vertices staging", &vertices)?,
            vk::BufferUsageFlags::VERTEX_BUFFER,
        )];
        if !indices.is_empty() {
            pairs.push((
                Buffer::staging(context, "pattern indices staging", &indices)?,
                vk::BufferUsageFlags::INDEX_BUFFER,
            ));
        }
        for (from, usage) in &pairs {
            let usage = *usage | vk::BufferUsageFlags::TRANSFER_DST;
            self.buffers.push(Buffer::new(context, "pattern", from.size, usage, MemoryLocation::GpuOnly)?);
        }
        self.commands.run(|commands| {
            for ((from, _), to) in pairs.iter().zip(&self.buffers) {
                let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.size };
                // SAFETY: recording; both buffers have this size, and no submission uses either.
                unsafe { context.device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]) };
            }
            // The fence that is waited for makes the copies visible to every later submission.
            Ok(())
        })?;
        Ok(())
    }

    fn pipeline(&self, passes: &Passes, scene: &PatternScene) -> Result<vk::Pipeline, GpuError> {
        let method = self.frame.method;
        let name = format!("pattern {method:?} pipeline");
        let vertex: Spv = match method {
            _ if self.readback => shader::PATTERN_READBACK,
            PatternMethod::Draws => shader::PATTERN_UNIFORM,
            PatternMethod::Instanced => shader::PATTERN_VERTEX,
            PatternMethod::Static => shader::PATTERN_STATIC,
            PatternMethod::Hardware => shader::PATTERN_PATCH,
        };
        let mut modules = vec![(vk::ShaderStageFlags::VERTEX, Module::new(&self.context, &vertex)?)];
        if method == PatternMethod::Hardware {
            let control = Module::new(&self.context, &shader::PATTERN_CONTROL)?;
            modules.push((vk::ShaderStageFlags::TESSELLATION_CONTROL, control));
            let evaluation = Module::new(&self.context, &shader::PATTERN_EVALUATION)?;
            modules.push((vk::ShaderStageFlags::TESSELLATION_EVALUATION, evaluation));
        }
        if !self.readback {
            modules.push((vk::ShaderStageFlags::FRAGMENT, Module::new(&self.context, &shader::PATTERN_FRAGMENT)?));
        }
        let constants = [
            u32::from(scene.evaluator != Evaluator::Linear),
            match scene.displacement {
                Displacement::None => 0,
                Displacement::Sine(_) => 1,
                Displacement::Noise(_) => 2,
                Displacement::Height(_) => 3,
            },
        ];
        let entries = [0, 1].map(|i| vk::SpecializationMapEntry { constant_id: i, offset: 4 * i, size: 4 });
        let special = vk::SpecializationInfo::builder().map_entries(&entries).data(bytes_of(&constants));
        let stages: Vec<vk::PipelineShaderStageCreateInfo> = modules
            .iter()
            .map(|(stage, module)| {
                vk::PipelineShaderStageCreateInfo::builder()
                    .stage(*stage)
                    .module(module.handle)
                    .name(c"main")
                    .specialization_info(&special)
                    .build()
            })
            .collect();
        let (stride, formats): (u32, &[vk::Format]) = match method {
            PatternMethod::Static => (48, &[vk::Format::R32G32B32A32_SFLOAT; 3]),
            PatternMethod::Hardware => (4, &[vk::Format::R32_UINT]),
            _ => (12, &[vk::Format::R32G32B32_SFLOAT]),
        };
        let bindings =
            [vk::VertexInputBindingDescription { binding: 0, stride, input_rate: vk::VertexInputRate::VERTEX }];
        let attributes: Vec<vk::VertexInputAttributeDescription> = (0..)
            .zip(formats)
            .map(|(i, &format)| vk::VertexInputAttributeDescription { location: i, binding: 0, format, offset: 16 * i })
            .collect();
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::builder()
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::builder().topology(match method {
            PatternMethod::Hardware => vk::PrimitiveTopology::PATCH_LIST,
            _ => vk::PrimitiveTopology::TRIANGLE_LIST,
        });
        let tessellation = vk::PipelineTessellationStateCreateInfo::builder().patch_control_points(1);
        let viewport = vk::PipelineViewportStateCreateInfo::builder().viewport_count(1).scissor_count(1);
        let wire = self.frame.show == PatternShow::Wire;
        let raster = vk::PipelineRasterizationStateCreateInfo::builder()
            .rasterizer_discard_enable(self.readback)
            .polygon_mode(if wire { vk::PolygonMode::LINE } else { vk::PolygonMode::FILL })
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::builder().rasterization_samples(self.pass.samples());
        let blending =
            [vk::PipelineColorBlendAttachmentState::builder().color_write_mask(vk::ColorComponentFlags::RGBA).build()];
        let blend = vk::PipelineColorBlendStateCreateInfo::builder().attachments(&blending);
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
            .rasterization_state(&raster)
            .layout(self.attributes.layout)
            .render_pass(passes.get(self.pass)?);
        if method == PatternMethod::Hardware {
            info = info.tessellation_state(&tessellation);
        }
        if !self.readback {
            info = info
                .viewport_state(&viewport)
                .multisample_state(&multisample)
                .color_blend_state(&blend)
                .depth_stencil_state(&depth)
                .dynamic_state(&dynamic);
        }
        // SAFETY: every pointer in `info` lives until the call returns; the features used were found on the device.
        let made =
            unsafe { self.context.device.create_graphics_pipelines(vk::PipelineCache::null(), &[info.build()], None) };
        let pipeline = made.map_err(|(_, result)| result).named("vkCreateGraphicsPipelines", &name)?[0];
        self.context.name(pipeline, &name);
        Ok(pipeline)
    }

    /// Bytes on the device: vertices, indices, and the coefficients where the method reads them.
    pub fn bytes(&self) -> u64 {
        let attributes = if self.frame.method == PatternMethod::Static { 0 } else { self.attributes.buffers[0].size };
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

    fn record(&self, commands: vk::CommandBuffer) {
        let device = &self.context.device;
        let [width, height] = self.target.extent;
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let [r, g, b, a] = self.frame.background.unwrap_or([0.0; 4]);
        let clear = Target::clear_values(self.pass, [r * a, g * a, b * a, a]);
        let mut begin = vk::RenderPassBeginInfo::builder()
            .render_pass(self.target.pass)
            .framebuffer(self.target.framebuffer)
            .render_area(area);
        if !self.readback {
            begin = begin.clear_values(&clear);
        }
        let viewport =
            vk::Viewport { x: 0.0, y: 0.0, width: width as f32, height: height as f32, min_depth: 0.0, max_depth: 1.0 };
        let graphics = vk::PipelineBindPoint::GRAPHICS;
        self.context.begin_label(commands, "pattern frame");
        // SAFETY: recording; pass, target, buffers, set, pipeline and layout belong together (`new`), the indices are those
        // of a pattern, and all of them outlive the submission, which is waited for.
        unsafe {
            device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
            device.cmd_bind_pipeline(commands, graphics, self.pipeline);
            if !self.readback {
                device.cmd_set_viewport(commands, 0, &[viewport]);
                device.cmd_set_scissor(commands, 0, &[area]);
            }
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
            device.cmd_end_render_pass(commands);
            if self.readback {
                let barrier = vk::BufferMemoryBarrier::builder()
                    .src_access_mask(vk::AccessFlags::SHADER_WRITE)
                    .dst_access_mask(vk::AccessFlags::HOST_READ)
                    .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .buffer(self.attributes.buffers[2].handle)
                    .size(vk::WHOLE_SIZE);
                device.cmd_pipeline_barrier(
                    commands,
                    vk::PipelineStageFlags::VERTEX_SHADER,
                    vk::PipelineStageFlags::HOST,
                    vk::DependencyFlags::empty(),
                    &[],
                    &[barrier.build()],
                    &[],
                );
            }
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
        straighten(&mut floats);
        Ok(Pixels::Rgba8(floats.into_iter().map(to_byte).collect()))
    }

    /// Position and normal of every vertex, coarse triangle by coarse triangle in the pattern's order.
    pub(super) fn records(&self) -> Result<Vec<[[f32; 3]; 2]>, GpuError> {
        self.run(false)?;
        let bytes = self.attributes.buffers[2].bytes()?;
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

/// The whole refined mesh: position, normal and colour of each vertex, and indices.
fn refined(scene: &PatternScene) -> (Vec<u8>, Vec<u32>) {
    let each = scene.pattern.weights.len() as u32;
    let mut vertices: Vec<[f32; 12]> = Vec::with_capacity(scene.controls.len() * each as usize);
    let mut indices = Vec::with_capacity(scene.controls.len() * scene.pattern.indices.len());
    for (t, control) in (0..).zip(scene.controls) {
        for w in &scene.pattern.weights {
            let point = evaluate(control, scene.evaluator, scene.displacement, w.map(f64::from));
            let (p, n, c) = (point.position.as_vec3(), point.normal.as_vec3(), point.colour.as_vec4());
            vertices.push([p.x, p.y, p.z, 1.0, n.x, n.y, n.z, 0.0, c.x, c.y, c.z, c.w]);
        }
        indices.extend(scene.pattern.indices.iter().map(|i| t * each + i));
    }
    (bytes_of(&vertices).to_vec(), indices)
}

/// Edges of several samples over a transparent ground are premultiplied: floats keep their colours.
fn format(frame: &PatternFrame) -> vk::Format {
    match frame.background {
        Some([.., a]) if a >= 1.0 => vk::Format::R8G8B8A8_UNORM,
        _ => vk::Format::R32G32B32A32_SFLOAT,
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
