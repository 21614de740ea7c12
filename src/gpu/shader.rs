//! The compiled shaders, embedded. `tools/shaders.rs` makes them from `glsl/`.

use super::context::Context;
use super::error::{GpuError, Named};
use super::pipeline::Shape;
use crate::patch::solid::Primitive;
use crate::patch::Kind;
use ash::vk;
use std::rc::Rc;

/// Name and words of an embedded shader.
pub(super) struct Spv {
    pub name: &'static str,
    bytes: &'static [u8],
}

macro_rules! spv {
    ($name:literal) => {
        Spv { name: $name, bytes: include_bytes!(concat!("../../spv/", $name, ".spv")) }
    };
}

/// Hands control points on.
pub(super) const VERTEX: Spv = spv!("patch.vert");
/// Colours pixels.
pub(super) const FRAGMENT: Spv = spv!("colour.frag");

/// Vertices of surfaces in space.
pub(super) const SOLID_VERTEX: Spv = spv!("solid.vert");
/// Colours pixels of surfaces in space.
pub(super) const SOLID_FRAGMENT: Spv = spv!("solid.frag");

/// Makes control points of patches in space.
pub(super) const STENCIL: Spv = spv!("stencil.comp");

/// A refinement pattern's vertex, by instance.
pub(super) const PATTERN_VERTEX: Spv = spv!("pattern.vert");
/// The same with its triangle's attributes as uniforms.
pub(super) const PATTERN_UNIFORM: Spv = spv!("pattern_uniform.vert");
/// The same of a flat triangle whose attributes change with the instance.
pub(super) const PATTERN_FLAT: Spv = spv!("pattern_flat.vert");
/// The same between levels of detail.
pub(super) const PATTERN_DETAIL: Spv = spv!("pattern_detail.vert");
/// By instance, written to a buffer.
pub(super) const PATTERN_READBACK: Spv = spv!("pattern_readback.vert");
/// Of a flat triangle, written to a buffer.
pub(super) const PATTERN_FLAT_READBACK: Spv = spv!("pattern_flat_readback.vert");
/// Between levels of detail, written to a buffer.
pub(super) const PATTERN_DETAIL_READBACK: Spv = spv!("pattern_detail_readback.vert");
/// Chooses levels of detail.
pub(super) const PATTERN_DETAIL_CHOICE: Spv = spv!("pattern_detail.comp");
/// Makes coefficients of curved triangles.
pub(super) const PATTERN_COEFFICIENTS: Spv = spv!("pattern_control.comp");
/// A vertex of a whole refined mesh.
pub(super) const PATTERN_STATIC: Spv = spv!("pattern_static.vert");
/// A coarse triangle on its way to the tessellator.
pub(super) const PATTERN_PATCH: Spv = spv!("pattern_patch.vert");
/// Its levels.
pub(super) const PATTERN_CONTROL: Spv = spv!("pattern.tesc");
/// Its vertices.
pub(super) const PATTERN_EVALUATION: Spv = spv!("pattern.tese");
/// Pixels of refined meshes.
pub(super) const PATTERN_FRAGMENT: Spv = spv!("pattern.frag");

/// Sets the levels.
pub(super) fn control(kind: Kind, shape: Shape) -> Spv {
    match (kind, shape) {
        (Kind::Bicubic, Shape::Whole) => spv!("bicubic.tesc"),
        (Kind::Bicubic, Shape::Triangle) => spv!("bicubic_triangle.tesc"),
        (Kind::Bicubic, Shape::Quad) => spv!("bicubic_quad.tesc"),
        (Kind::Gregory, Shape::Whole) => spv!("gregory.tesc"),
        (Kind::Gregory, Shape::Triangle) => spv!("gregory_triangle.tesc"),
        (Kind::Gregory, Shape::Quad) => spv!("gregory_quad.tesc"),
        (Kind::Stitched, _) => spv!("stitched.tesc"),
        (Kind::RemappedBicubic, _) => spv!("remap_bicubic.tesc"),
        (Kind::RemappedGregory, _) => spv!("remap_gregory.tesc"),
    }
}

/// Control and evaluation of patches in space; none of triangles and lines.
pub(super) fn solid(primitive: Primitive) -> Option<[Spv; 2]> {
    match primitive {
        Primitive::Triangles | Primitive::Lines => None,
        Primitive::Bicubic => Some([spv!("solid_bicubic.tesc"), spv!("solid_bicubic.tese")]),
        Primitive::Gregory => Some([spv!("solid_gregory.tesc"), spv!("solid_gregory.tese")]),
        Primitive::Transition => Some([spv!("solid_transition.tesc"), spv!("solid_transition.tese")]),
        Primitive::Quartic => Some([spv!("solid_quartic.tesc"), spv!("solid_quartic.tese")]),
        Primitive::QuarticGregory => Some([spv!("solid_quartic_gregory.tesc"), spv!("solid_quartic_gregory.tese")]),
        Primitive::QuarticTransition => {
            Some([spv!("solid_quartic_transition.tesc"), spv!("solid_quartic_transition.tese")])
        }
    }
}

/// Evaluates vertices for drawing.
pub(super) fn evaluation(kind: Kind, shape: Shape) -> Spv {
    match (kind, shape) {
        (Kind::Bicubic, Shape::Whole) => spv!("bicubic.tese"),
        (Kind::Bicubic, Shape::Triangle) => spv!("bicubic_triangle.tese"),
        (Kind::Bicubic, Shape::Quad) => spv!("bicubic_quad.tese"),
        (Kind::Gregory, Shape::Whole) => spv!("gregory.tese"),
        (Kind::Gregory, Shape::Triangle) => spv!("gregory_triangle.tese"),
        (Kind::Gregory, Shape::Quad) => spv!("gregory_quad.tese"),
        (Kind::Stitched, _) => spv!("stitched.tese"),
        (Kind::RemappedBicubic, _) => spv!("remap_bicubic.tese"),
        (Kind::RemappedGregory, _) => spv!("remap_gregory.tese"),
    }
}

/// Evaluates vertices and writes them to a buffer.
pub(super) fn readback(kind: Kind, shape: Shape) -> Spv {
    match (kind, shape) {
        (Kind::Bicubic, Shape::Whole) => spv!("bicubic_readback.tese"),
        (Kind::Bicubic, Shape::Triangle) => spv!("bicubic_triangle_readback.tese"),
        (Kind::Bicubic, Shape::Quad) => spv!("bicubic_quad_readback.tese"),
        (Kind::Gregory, Shape::Whole) => spv!("gregory_readback.tese"),
        (Kind::Gregory, Shape::Triangle) => spv!("gregory_triangle_readback.tese"),
        (Kind::Gregory, Shape::Quad) => spv!("gregory_quad_readback.tese"),
        (Kind::Stitched, _) => spv!("stitched_readback.tese"),
        (Kind::RemappedBicubic, _) => spv!("remap_bicubic_readback.tese"),
        (Kind::RemappedGregory, _) => spv!("remap_gregory_readback.tese"),
    }
}

/// A shader module; it is needed only until the pipeline is made.
pub(super) struct Module {
    context: Rc<Context>,
    pub handle: vk::ShaderModule,
}

impl Module {
    pub fn new(context: &Rc<Context>, spv: &Spv) -> Result<Module, GpuError> {
        let words: Vec<u32> = spv.bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let info = vk::ShaderModuleCreateInfo::builder().code(&words);
        // SAFETY: the words are SPIR-V that spirv-val accepted (tests/spirv.rs).
        let handle =
            unsafe { context.device.create_shader_module(&info, None) }.named("vkCreateShaderModule", spv.name)?;
        context.name(handle, spv.name);
        Ok(Module { context: Rc::clone(context), handle })
    }
}

impl Drop for Module {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once made.
        unsafe { self.context.device.destroy_shader_module(self.handle, None) };
    }
}
