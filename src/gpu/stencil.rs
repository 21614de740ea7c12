//! Control points made on the device from vertices and stencils.

use super::compute::{Kernel, MOST};
use super::context::Context;
use super::depth_frame::DepthFrame;
use super::error::GpuError;
use super::memory::{bytes_of, Buffer};
use super::shader;
use crate::patch::stencil::PackedStencils;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// What is wrong with `stencils` of `sources`: the device follows them blindly.
pub(super) fn fault(stencils: &PackedStencils, sources: &[[f32; 8]]) -> Option<String> {
    // Differences and sums of a few stay finite.
    const LARGE: f32 = 1e36;
    if sources.iter().flatten().any(|x| x.abs() > LARGE) {
        return Some("the scene's coordinates are too large to draw; scale them".to_owned());
    }
    stencils.fault(sources.len()).map(|what| format!("solid table: {what}"))
}

/// Whether a device that binds `most` bytes of storage at once has room for them. Of more, control points are made on the CPU.
pub(super) fn fits(stencils: &PackedStencils, sources: usize, most: u32) -> bool {
    let longest = (size_of::<[f32; 8]>() * stencils.points.len().max(sources)).max(8 * stencils.terms.len());
    longest as u64 <= u64::from(most) && u32::try_from(stencils.terms.len()).is_ok()
}

/// A vertex buffer of the control points. Sources and stencils are not empty, without [`fault`], and [`fits`] holds.
pub(super) fn make(
    context: &Rc<Context>,
    frame: &DepthFrame,
    stencils: &PackedStencils,
    sources: &[[f32; 8]],
) -> Result<Buffer, GpuError> {
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let given = frame.upload(&[
        ("stencil sources", bytes_of(sources), storage),
        ("stencil terms", bytes_of(&stencils.terms), storage),
        ("stencil points", bytes_of(&stencils.points), storage),
    ])?;
    let count = stencils.points.len() as u32;
    let usage = storage | vk::BufferUsageFlags::VERTEX_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
    let bytes = u64::from(count) * size_of::<[f32; 8]>() as u64;
    let made = Buffer::new(context, "control points", bytes, usage, MemoryLocation::GpuOnly)?;
    let buffers = [&given[0], &given[1], &given[2], &made];
    let kernel = Kernel::new(context, "stencils", &shader::STENCIL, &buffers, size_of::<[u32; 2]>())?;
    frame.compute(|commands| {
        for first in (0..count).step_by(MOST as usize) {
            let end = count.min(first.saturating_add(MOST));
            kernel.record(commands, bytes_of(&[first, end]), end - first);
        }
        // The fence that is waited for makes them visible to every later submission, too.
        let from = (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE);
        let to = (
            vk::PipelineStageFlags::VERTEX_INPUT | vk::PipelineStageFlags::TRANSFER,
            vk::AccessFlags::VERTEX_ATTRIBUTE_READ | vk::AccessFlags::TRANSFER_READ,
        );
        kernel.record_barrier(commands, from, to);
    })?;
    Ok(made)
}

/// The control points in `made`, as the device has them.
pub(super) fn read(context: &Rc<Context>, frame: &DepthFrame, made: &Buffer) -> Result<Vec<[f32; 8]>, GpuError> {
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let here = Buffer::new(context, "control points read back", made.size, usage, MemoryLocation::GpuToCpu)?;
    frame.compute(|commands| {
        let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: made.size };
        // SAFETY: recording, outside a render pass; both buffers have this size and outlive the submission, which is waited for.
        unsafe { context.device.cmd_copy_buffer(commands, made.handle, here.handle, &[region]) };
        here.record_to_host(commands, vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
    })?;
    let floats = here.bytes()?.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let floats: Vec<f32> = floats.collect();
    Ok(floats.chunks_exact(8).map(|p| std::array::from_fn(|c| p[c])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_of_the_buffers_has_to_fit() {
        let stencils = PackedStencils { points: vec![[0, 5, 0, 5]; 3], terms: vec![[0, 0]; 5] };
        assert!(fits(&stencils, 2, 96) && !fits(&stencils, 2, 95));
        assert!(fits(&stencils, 4, 128) && !fits(&stencils, 4, 127));
        let stencils = PackedStencils { terms: vec![[0, 0]; 20], ..stencils };
        assert!(fits(&stencils, 4, 160) && !fits(&stencils, 4, 159));
    }
}
