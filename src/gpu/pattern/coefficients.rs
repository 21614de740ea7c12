//! Coefficients of curved triangles made on the device from the coarse mesh.

use super::attributes::{Block, STORAGE};
use crate::gpu::compute::Kernel;
use crate::gpu::context::Context;
use crate::gpu::depth_frame::DepthFrame;
use crate::gpu::error::GpuError;
use crate::gpu::memory::{bytes_of, Buffer};
use crate::gpu::shader;
use crate::pattern::{CoarseMesh, Evaluator, NormalField};
use ash::vk;
use glam::{DVec3, DVec4};
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// Vertices as `Vertex` in `glsl/pattern_control.comp` has them.
fn vertices(mesh: &CoarseMesh) -> Vec<[f32; 20]> {
    (0..mesh.positions.len())
        .map(|v| {
            let tag = mesh.tag(v as u32);
            let with = |vector: DVec3, w: f64| vector.extend(w).as_vec4().to_array();
            let uv = mesh.uv.get(v).copied().unwrap_or_default();
            let parts = [
                with(mesh.positions[v], tag.tension),
                with(mesh.normals[v], tag.sharpness),
                with(tag.deviation, tag.bias),
                mesh.colours.get(v).copied().unwrap_or(DVec4::ONE).as_vec4().to_array(),
                [uv.x as f32, uv.y as f32, 0.0, 0.0],
            ];
            std::array::from_fn(|i| parts[i / 4][i % 4])
        })
        .collect()
}

/// A buffer of one block for each triangle of `mesh`.
pub(super) fn make(
    context: &Rc<Context>,
    frame: &DepthFrame,
    mesh: &CoarseMesh,
    evaluator: Evaluator,
    field: NormalField,
) -> Result<Buffer, GpuError> {
    let count = mesh.triangles.len();
    let vertices = vertices(mesh);
    if vertices.iter().flatten().any(|x| !x.is_finite()) {
        return Err(GpuError::Request("the scene's coordinates are too large to draw; scale them".to_owned()));
    }
    let corners: Vec<u32> = mesh.triangles.iter().flat_map(|t| [t[0], t[1], t[2], 0]).collect();
    if corners.iter().any(|&v| v as usize >= vertices.len()) {
        return Err(GpuError::Request("a triangle of the coarse mesh names no vertex".to_owned()));
    }
    let storage = vk::BufferUsageFlags::STORAGE_BUFFER;
    let given = frame.upload(&[
        ("coarse vertices", bytes_of(&vertices), storage),
        ("coarse corners", bytes_of(&corners), storage),
    ])?;
    let made = Buffer::new(
        context,
        "coarse triangles",
        (count * size_of::<Block>()) as u64,
        STORAGE,
        MemoryLocation::GpuOnly,
    )?;
    let settings = [
        count as u32,
        match evaluator {
            Evaluator::Linear => 0,
            Evaluator::Pn => 1,
            Evaluator::St => 2,
        },
        match field {
            NormalField::Vlachos => 0,
            NormalField::Boubekeur => 1,
            NormalField::Linear => 2,
        },
    ];
    let push = bytes_of(&settings);
    let buffers = [&given[0], &given[1], &made];
    let kernel = Kernel::new(context, "pattern coefficients", &shader::PATTERN_COEFFICIENTS, &buffers, push.len())?;
    // The fence that is waited for makes them visible to every later submission.
    frame.compute(|commands| kernel.record(commands, push, count as u32))?;
    Ok(made)
}
