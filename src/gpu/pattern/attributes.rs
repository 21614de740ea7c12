//! Attributes of coarse triangles on the device, and what one draw says beside them.

use super::{PatternFrame, PatternScene, PatternShow};
use crate::gpu::context::Context;
use crate::gpu::error::{GpuError, Named};
use crate::gpu::memory::{bytes_of, Buffer, Plain};
use crate::pattern::{Control, Displacement};
use ash::vk;
use glam::{DVec3, Vec3, Vec4};
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// Twin of `Triangle` in `glsl/inc/pattern.glsl`.
#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct Block(pub [[f32; 4]; 32]);

const _: () = assert!(size_of::<Block>() == 512);
// SAFETY: repr(C), 4-byte fields only, without padding.
unsafe impl Plain for Block {}
// SAFETY: as above.
unsafe impl Plain for PatternPush {}

impl Block {
    pub fn new(c: &Control) -> Block {
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
pub(super) struct PatternPush {
    clip: [f32; 16],
    light: [f32; 4],
    shape: [f32; 4],
    drift: f32,
    octaves: u32,
    seed: u32,
    show: u32,
    pub vertices: u32,
    unused: [u32; 3],
}

const _: () = assert!(size_of::<PatternPush>() == 128);

impl PatternPush {
    pub fn new(frame: &PatternFrame, scene: &PatternScene) -> PatternPush {
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
pub(super) const STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::ALL_GRAPHICS;

/// Layouts, descriptors and the buffers they name.
pub(super) struct Attributes {
    context: Rc<Context>,
    set_layout: vk::DescriptorSetLayout,
    pub layout: vk::PipelineLayout,
    pool: vk::DescriptorPool,
    pub set: vk::DescriptorSet,
    /// Coefficients.
    pub controls: Buffer,
    // Named by the set.
    _heights: Buffer,
}

/// What stands at bindings 0 to 3: coefficients, one triangle of them, heights, records.
const KINDS: [vk::DescriptorType; 4] = [
    vk::DescriptorType::STORAGE_BUFFER,
    vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC,
    vk::DescriptorType::STORAGE_BUFFER,
    vk::DescriptorType::STORAGE_BUFFER,
];

impl Attributes {
    /// `records`: what the read-back writes to.
    pub fn new(context: &Rc<Context>, scene: &PatternScene, records: Option<&Buffer>) -> Result<Attributes, GpuError> {
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
        let sizes = [size_of_val(&blocks[..]) as u64, heights.len() as u64, records.map_or(0, |r| r.size)];
        if sizes.iter().any(|&n| n > most) {
            return Err(GpuError::Request("the scene is too large for one buffer; ask for less".to_owned()));
        }
        let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let filled = |name, bytes: &[u8], usage| {
            let mut buffer = Buffer::new(context, name, bytes.len() as u64, usage, MemoryLocation::CpuToGpu)?;
            buffer.write(bytes)?;
            Ok::<Buffer, GpuError>(buffer)
        };
        let uniform = vk::BufferUsageFlags::UNIFORM_BUFFER;
        let mut made = Attributes {
            context: Rc::clone(context),
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            controls: filled("coarse triangles", bytes_of(&blocks), storage | uniform)?,
            _heights: filled("heights", &heights, storage)?,
        };
        made.layouts()?;
        let of = |buffer: &Buffer, range| [vk::DescriptorBufferInfo { buffer: buffer.handle, offset: 0, range }];
        let all = vk::WHOLE_SIZE;
        let infos = [
            of(&made.controls, all),
            of(&made.controls, size_of::<Block>() as u64),
            of(&made._heights, all),
            // Without a read-back nothing writes there.
            of(records.unwrap_or(&made._heights), all),
        ];
        let writes: Vec<vk::WriteDescriptorSet> = (0..)
            .zip(KINDS)
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
        unsafe { context.device.update_descriptor_sets(&writes, &[]) };
        Ok(made)
    }

    /// Makes the layouts, the pool and its one set.
    fn layouts(&mut self) -> Result<(), GpuError> {
        let bindings: Vec<vk::DescriptorSetLayoutBinding> = (0..)
            .zip(KINDS)
            .map(|(i, kind)| {
                vk::DescriptorSetLayoutBinding::builder()
                    .binding(i)
                    .descriptor_type(kind)
                    .descriptor_count(1)
                    .stage_flags(STAGES)
                    .build()
            })
            .collect();
        let device = &self.context.device;
        let info = vk::DescriptorSetLayoutCreateInfo::builder().bindings(&bindings);
        // SAFETY: the device is alive, the infos valid; 128 bytes of push constants are within every device's limit.
        unsafe {
            self.set_layout = device
                .create_descriptor_set_layout(&info, None)
                .named("vkCreateDescriptorSetLayout", "pattern attributes")?;
            let sets = [self.set_layout];
            let ranges =
                [vk::PushConstantRange { stage_flags: STAGES, offset: 0, size: size_of::<PatternPush>() as u32 }];
            let info = vk::PipelineLayoutCreateInfo::builder().set_layouts(&sets).push_constant_ranges(&ranges);
            self.layout = device.create_pipeline_layout(&info, None).named("vkCreatePipelineLayout", "pattern")?;
            let size = |ty| vk::DescriptorPoolSize {
                ty,
                descriptor_count: KINDS.iter().filter(|&&kind| kind == ty).count() as u32,
            };
            let sizes = [size(vk::DescriptorType::STORAGE_BUFFER), size(vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC)];
            let info = vk::DescriptorPoolCreateInfo::builder().max_sets(1).pool_sizes(&sizes);
            self.pool = device.create_descriptor_pool(&info, None).named("vkCreateDescriptorPool", "pattern")?;
            let info = vk::DescriptorSetAllocateInfo::builder().descriptor_pool(self.pool).set_layouts(&sets);
            self.set = device.allocate_descriptor_sets(&info).named("vkAllocateDescriptorSets", "pattern")?[0];
        }
        Ok(())
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
