//! Attributes of coarse triangles on the device, and what one draw says beside them.

use super::{PatternFrame, PatternScene, PatternShow};
use crate::gpu::context::Context;
use crate::gpu::descriptors::Descriptors;
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

/// Where the attributes of a flat triangle stand in it: points, normals and colours of its corners.
pub(super) const FLAT: [u32; 9] = [0, 16, 32, 160, 176, 192, 352, 368, 384];

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
    pub list: u32,
    pub record: u32,
    pub level: u32,
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
            list: 0,
            record: 0,
            level: 0,
        }
    }
}

/// Stages that read push constants and descriptors.
pub(super) const STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::ALL_GRAPHICS;

/// How coefficients are used.
pub(super) const STORAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::STORAGE_BUFFER.as_raw()
        | vk::BufferUsageFlags::UNIFORM_BUFFER.as_raw()
        | vk::BufferUsageFlags::VERTEX_BUFFER.as_raw(),
);

/// The set of all attributes, with what it names.
pub(super) struct Attributes {
    context: Rc<Context>,
    descriptors: Descriptors,
    pub layout: vk::PipelineLayout,
    /// Coefficients.
    pub controls: Buffer,
    // Named by the set.
    _heights: Buffer,
}

impl Attributes {
    /// `controls`: coefficients that the device has made; `records`: what the read-back writes to; `list`: triangles by
    /// their level of detail.
    pub fn new(
        context: &Rc<Context>,
        scene: &PatternScene,
        controls: Option<Buffer>,
        records: Option<&Buffer>,
        list: Option<&Buffer>,
    ) -> Result<Attributes, GpuError> {
        let mut heights: Vec<u8> = Vec::new();
        match scene.displacement {
            Displacement::Height(map) => {
                heights.extend(bytes_of(&[map.size[0], map.size[1], 0, 0]));
                heights.extend(bytes_of(&map.heights));
            }
            _ => heights.resize(32, 0),
        }
        let most = u64::from(context.info.limits.max_storage_buffer);
        let blocks = (size_of::<Block>() * scene.controls.len()) as u64;
        if [blocks, heights.len() as u64, records.map_or(0, |r| r.size)].iter().any(|&n| n > most) {
            return Err(GpuError::Request("the scene is too large for one buffer; ask for less".to_owned()));
        }
        let filled = |name, bytes: &[u8], usage| {
            let mut buffer = Buffer::new(context, name, bytes.len() as u64, usage, MemoryLocation::CpuToGpu)?;
            buffer.write(bytes)?;
            Ok::<Buffer, GpuError>(buffer)
        };
        let heights = filled("heights", &heights, vk::BufferUsageFlags::STORAGE_BUFFER)?;
        let controls = match controls {
            Some(made) => made,
            None => {
                let blocks: Vec<Block> = scene.controls.iter().map(Block::new).collect();
                filled("coarse triangles", bytes_of(&blocks), STORAGE)?
            }
        };
        let storage = vk::DescriptorType::STORAGE_BUFFER;
        // What is not there is not looked at either.
        let bound = [
            (storage, &controls, vk::WHOLE_SIZE),
            (vk::DescriptorType::UNIFORM_BUFFER_DYNAMIC, &controls, size_of::<Block>() as u64),
            (storage, &heights, vk::WHOLE_SIZE),
            (storage, records.unwrap_or(&heights), vk::WHOLE_SIZE),
            (storage, list.unwrap_or(&heights), vk::WHOLE_SIZE),
        ];
        let mut made = Attributes {
            context: Rc::clone(context),
            descriptors: Descriptors::new(context, "pattern attributes", STAGES, &bound)?,
            layout: vk::PipelineLayout::null(),
            controls,
            _heights: heights,
        };
        let layouts = [made.descriptors.layout];
        let ranges = [vk::PushConstantRange { stage_flags: STAGES, offset: 0, size: size_of::<PatternPush>() as u32 }];
        let info = vk::PipelineLayoutCreateInfo::builder().set_layouts(&layouts).push_constant_ranges(&ranges);
        // SAFETY: the info is valid; 128 bytes of push constants are within every device's limit.
        made.layout =
            unsafe { context.device.create_pipeline_layout(&info, None) }.named("vkCreatePipelineLayout", "pattern")?;
        Ok(made)
    }

    /// The set.
    pub fn set(&self) -> vk::DescriptorSet {
        self.descriptors.set
    }
}

impl Drop for Attributes {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe { self.context.device.destroy_pipeline_layout(self.layout, None) };
    }
}
