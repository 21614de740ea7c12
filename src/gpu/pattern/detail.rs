//! Draws of triangles by their level of detail: lists made by the host, or by a compute shader for indirect draws.

use super::attributes::PatternPush;
use crate::camera::Camera;
use crate::gpu::compute::Kernel;
use crate::gpu::context::Context;
use crate::gpu::depth_frame::DepthFrame;
use crate::gpu::error::GpuError;
use crate::gpu::memory::{bytes_of, Buffer, Plain};
use crate::gpu::shader;
use crate::pattern::detail::{self, Detail, Levels, Scope, View};
use crate::pattern::{Control, RefinementPattern};
use ash::vk;
use glam::DVec3;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// Twin of `Placed` in `glsl/inc/detail.glsl`.
#[repr(C)]
#[derive(Clone, Copy)]
struct Placed {
    level: [f32; 4],
    which: [u32; 4],
}

const _: () = assert!(size_of::<Placed>() == 32);
// SAFETY: repr(C), 4-byte fields only, without padding.
unsafe impl Plain for Placed {}

/// Twin of `View` in `glsl/pattern_detail.comp`.
#[repr(C)]
#[derive(Clone, Copy, Default)]
struct ViewPush {
    eye: [f32; 4],
    segment: f32,
    most: f32,
    whole: f32,
    flags: u32,
    count: u32,
}

// SAFETY: repr(C), 4-byte fields only, without padding.
unsafe impl Plain for ViewPush {}

/// Words of an indirect indexed draw.
const WORDS: usize = 5;

/// Where a pattern stands among all of them.
#[derive(Clone, Copy)]
struct Part {
    vertices: u32,
    vertex_offset: i32,
    indices: u32,
    first_index: u32,
}

/// The patterns of 1, 2, 4, ... segments one after the other.
pub(super) struct Patterns {
    parts: Vec<Part>,
    /// Their vertices.
    pub weights: Vec<[f32; 3]>,
    /// Their indices, each from its own first vertex.
    pub indices: Vec<u32>,
}

impl Patterns {
    /// Up to level `most`.
    pub fn new(most: u32) -> Result<Patterns, GpuError> {
        let mut made = Patterns { parts: Vec::new(), weights: Vec::new(), indices: Vec::new() };
        for up in 0..=most {
            let pattern = RefinementPattern::triangle(1 << up).map_err(|e| GpuError::Request(e.to_string()))?;
            made.parts.push(Part {
                vertices: pattern.weights.len() as u32,
                vertex_offset: made.weights.len() as i32,
                indices: pattern.indices.len() as u32,
                first_index: made.indices.len() as u32,
            });
            made.weights.extend(pattern.weights);
            made.indices.extend(pattern.indices);
        }
        Ok(made)
    }
}

/// A triangle as the device evaluates it between levels of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluatedTriangle {
    /// Its number.
    pub triangle: u32,
    /// Its levels.
    pub levels: Levels,
    /// Position and normal of every vertex of its pattern, in the pattern's order.
    pub points: Vec<[[f32; 3]; 2]>,
}

/// What chooses levels on the device.
struct Chooser {
    kernel: Kernel,
    commands: Buffer,
    push: ViewPush,
}

/// The lists of triangles that each pattern draws.
pub(super) struct DetailDraws {
    context: Rc<Context>,
    detail: Detail,
    bounds: [DVec3; 2],
    parts: Vec<Part>,
    count: u32,
    /// Of each pattern where its part of the list begins, and how long it is; the lengths are the host's lists'.
    ranges: Vec<[u32; 2]>,
    list: Buffer,
    chooser: Option<Chooser>,
}

/// The buffer of lists: one for all triangles, or, filled by the device, one for each pattern.
pub(super) fn list(
    context: &Rc<Context>,
    count: usize,
    detail: &Detail,
    by_device: bool,
    read: bool,
) -> Result<Buffer, GpuError> {
    let lists = if by_device { detail.most as usize + 1 } else { 1 };
    let location = match (by_device, read) {
        (false, _) => MemoryLocation::CpuToGpu,
        (true, false) => MemoryLocation::GpuOnly,
        (true, true) => MemoryLocation::GpuToCpu,
    };
    let size = (lists * count * size_of::<Placed>()) as u64;
    if size > u64::from(context.info.limits.max_storage_buffer) {
        return Err(GpuError::Request("the scene is too large for one buffer; ask for less".to_owned()));
    }
    Buffer::new(context, "levels of detail", size, vk::BufferUsageFlags::STORAGE_BUFFER, location)
}

impl DetailDraws {
    /// `controls`: their coefficients on the device, for levels that the device chooses; `read`: whether the host wants to
    /// know them.
    pub fn new(
        context: &Rc<Context>,
        detail: &Detail,
        bounds: [DVec3; 2],
        patterns: &Patterns,
        list: Buffer,
        controls: Option<&Buffer>,
        read: bool,
    ) -> Result<DetailDraws, GpuError> {
        let chooser = match controls {
            None => None,
            Some(controls) => {
                let size = (4 * WORDS * patterns.parts.len()) as u64;
                let usage = vk::BufferUsageFlags::STORAGE_BUFFER
                    | vk::BufferUsageFlags::INDIRECT_BUFFER
                    | vk::BufferUsageFlags::TRANSFER_DST;
                let location = if read { MemoryLocation::GpuToCpu } else { MemoryLocation::GpuOnly };
                let commands = Buffer::new(context, "indirect draws", size, usage, location)?;
                let buffers = [controls, &list, &commands];
                let push = size_of::<ViewPush>();
                let kernel = Kernel::new(context, "pattern levels", &shader::PATTERN_DETAIL_CHOICE, &buffers, push)?;
                Some(Chooser { kernel, commands, push: ViewPush::default() })
            }
        };
        Ok(DetailDraws {
            context: Rc::clone(context),
            detail: *detail,
            bounds,
            parts: patterns.parts.clone(),
            count: 0,
            ranges: Vec::new(),
            list,
            chooser,
        })
    }

    /// Levels for a view. `controls`: those of the scene.
    pub fn look(&mut self, camera: &Camera, height: u32, controls: &[Control]) -> Result<(), GpuError> {
        let view = View::new(camera, height);
        self.count = controls.len() as u32;
        let Some(chooser) = &mut self.chooser else {
            let levels = detail::all(controls, self.bounds, &self.detail, &view);
            return self.group(&levels);
        };
        let whole = match self.detail.scope {
            Scope::Mesh => detail::mesh_level(controls, self.bounds, &self.detail, &view),
            Scope::Triangle => -1.0,
        };
        chooser.push = ViewPush {
            eye: view.eye.extend(view.scale).to_array(),
            segment: self.detail.segment as f32,
            most: self.detail.most as f32,
            whole,
            flags: u32::from(view.orthographic) | u32::from(!self.detail.morph) << 1,
            count: self.count,
        };
        let count = self.count;
        self.ranges = (0..self.parts.len() as u32).map(|group| [group * count, 0]).collect();
        Ok(())
    }

    fn group(&mut self, levels: &[Levels]) -> Result<(), GpuError> {
        let mut placed: Vec<(u32, Placed)> = (0..)
            .zip(levels)
            .map(|(t, l)| {
                let [a, b, c] = l.edges;
                (l.pattern(), Placed { level: [a, b, c, l.inner], which: [t, l.turned, 0, 0] })
            })
            .collect();
        placed.sort_by_key(|(group, _)| *group);
        self.ranges = vec![[0, 0]; self.parts.len()];
        for (i, (group, _)) in (0..).zip(&placed) {
            let range = &mut self.ranges[*group as usize];
            if range[1] == 0 {
                range[0] = i;
            }
            range[1] += 1;
        }
        let list: Vec<Placed> = placed.into_iter().map(|(_, placed)| placed).collect();
        // Nothing runs that reads the list: every submission is waited for.
        self.list.write(bytes_of(&list))
    }

    /// Bytes of lists and indirect draws.
    pub fn bytes(&self) -> u64 {
        self.list.size + self.chooser.as_ref().map_or(0, |c| c.commands.size)
    }

    /// Records the choice of levels by the device. Outside a render pass.
    pub fn record_choice(&self, commands: vk::CommandBuffer) {
        use vk::{AccessFlags as Access, PipelineStageFlags as Stage};
        let Some(chooser) = &self.chooser else { return };
        let words: Vec<u32> =
            self.parts.iter().flat_map(|p| [p.indices, 0, p.first_index, p.vertex_offset as u32, 0]).collect();
        // SAFETY: recording, outside a render pass; the buffer has just this size, at most 160 bytes.
        unsafe { self.context.device.cmd_update_buffer(commands, chooser.commands.handle, 0, bytes_of(&words)) };
        let written = (Stage::TRANSFER, Access::TRANSFER_WRITE);
        let both = Access::SHADER_READ | Access::SHADER_WRITE;
        chooser.kernel.record_barrier(commands, written, (Stage::COMPUTE_SHADER, both));
        chooser.kernel.record(commands, bytes_of(std::slice::from_ref(&chooser.push)), self.count);
        let readers = Stage::DRAW_INDIRECT | Stage::VERTEX_SHADER | Stage::HOST;
        let reads = Access::INDIRECT_COMMAND_READ | Access::SHADER_READ | Access::HOST_READ;
        chooser.kernel.record_barrier(commands, (Stage::COMPUTE_SHADER, Access::SHADER_WRITE), (readers, reads));
    }

    /// Records one instanced draw for each pattern. In a render pass, buffers and pipeline bound; `send` sends the push
    /// constants.
    pub fn record(&self, commands: vk::CommandBuffer, push: &PatternPush, mut send: impl FnMut(&PatternPush)) {
        let device = &self.context.device;
        let mut record = 0;
        for (up, (part, [first, length])) in self.parts.iter().zip(self.ranges.iter().copied()).enumerate() {
            let direct = self.chooser.is_none() || length > 0;
            if direct && length == 0 {
                continue;
            }
            let mut push = *push;
            push.vertices = part.vertices;
            push.list = first;
            // The vertex number of the shader counts from the first of all patterns.
            push.record = u32::wrapping_sub(record, part.vertex_offset as u32);
            push.level = 1 << up;
            send(&push);
            record += length * part.vertices;
            // SAFETY: recording, in a render pass; the parts lie within the buffers, and the indirect draws are such.
            unsafe {
                match &self.chooser {
                    Some(chooser) if !direct => device.cmd_draw_indexed_indirect(
                        commands,
                        chooser.commands.handle,
                        (4 * WORDS * up) as u64,
                        1,
                        4 * WORDS as u32,
                    ),
                    _ => {
                        device.cmd_draw_indexed(commands, part.indices, length, part.first_index, part.vertex_offset, 0)
                    }
                }
            }
        }
    }

    /// Lets the device choose, and takes the lengths of its lists over: draws are direct from then on. For the read-back.
    pub fn take_choice(&mut self, frame: &DepthFrame) -> Result<(), GpuError> {
        let Some(chooser) = &self.chooser else { return Ok(()) };
        frame.compute(|commands| self.record_choice(commands))?;
        let bytes = chooser.commands.bytes()?;
        for (range, draw) in self.ranges.iter_mut().zip(bytes.chunks_exact(4 * WORDS)) {
            range[1] = u32::from_le_bytes([draw[4], draw[5], draw[6], draw[7]]).min(self.count);
        }
        Ok(())
    }

    /// Triangles in the order of their records, each with its levels and how many records it has.
    pub fn triangles(&self) -> Result<Vec<(u32, Levels, usize)>, GpuError> {
        let bytes = self.list.bytes()?;
        let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
        let mut all = Vec::new();
        for (part, [first, length]) in self.parts.iter().zip(&self.ranges) {
            for i in *first..first + length {
                let at = size_of::<Placed>() * i as usize;
                let level = [0, 1, 2, 3].map(|k| f32::from_le_bytes(word(at + 4 * k)));
                let which = [4, 5].map(|k| u32::from_le_bytes(word(at + 4 * k)));
                let levels = Levels { edges: [level[0], level[1], level[2]], inner: level[3], turned: which[1] };
                all.push((which[0], levels, part.vertices as usize));
            }
        }
        Ok(all)
    }
}
