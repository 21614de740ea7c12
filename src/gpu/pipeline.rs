//! Pipelines: one for each (kind, whole face or triangle part or quad part, fill, target), made when first needed.
//! Which part of which constellation is drawn comes by push constants, so a cold start compiles few.

use super::context::Context;
use super::error::{GpuError, Named};
use super::graphics::Recipe;
use super::layout::Push;
use super::shader;
use super::target::{PassKey, Passes};
use crate::patch::transition::{EXTRA_POINTS, PARTS};
use crate::patch::{DrawRange, Kind};
use ash::vk;
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

/// The domain that is tessellated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Shape {
    /// A whole face.
    Whole,
    /// A triangle part of a transition face.
    Triangle,
    /// A quad part.
    Quad,
}

impl Shape {
    pub fn of(part: Option<u8>) -> Shape {
        match part {
            None => Shape::Whole,
            Some(number) if PARTS[number as usize].triangle => Shape::Triangle,
            Some(_) => Shape::Quad,
        }
    }
}

/// What becomes of the vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Fill {
    Surface,
    Wire,
    Readback,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct PipelineKey {
    pub kind: Kind,
    pub shape: Shape,
    pub fill: Fill,
    pub pass: PassKey,
}

impl PipelineKey {
    pub fn of(range: &DrawRange, fill: Fill, pass: PassKey) -> PipelineKey {
        PipelineKey { kind: range.kind, shape: Shape::of(range.part), fill, pass }
    }

    fn name(&self) -> String {
        format!("{:?} {:?} {:?} pipeline", self.kind, self.shape, self.fill)
    }
}

/// Stages that read the push constants.
pub(super) const PUSH_STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::TESSELLATION_CONTROL.as_raw()
        | vk::ShaderStageFlags::TESSELLATION_EVALUATION.as_raw()
        | vk::ShaderStageFlags::FRAGMENT.as_raw(),
);

/// Layouts, and the pipelines made so far.
pub(super) struct Pipelines {
    context: Rc<Context>,
    pub passes: Passes,
    /// Push constants; set 0 with one storage buffer, bound for [`Fill::Readback`] only.
    pub layout: vk::PipelineLayout,
    pub records: vk::DescriptorSetLayout,
    made: RefCell<HashMap<PipelineKey, vk::Pipeline>>,
}

impl Pipelines {
    pub fn new(context: &Rc<Context>) -> Result<Pipelines, GpuError> {
        let mut pipelines = Pipelines {
            context: Rc::clone(context),
            passes: Passes::new(context),
            layout: vk::PipelineLayout::null(),
            records: vk::DescriptorSetLayout::null(),
            made: RefCell::default(),
        };
        let bindings = [vk::DescriptorSetLayoutBinding::builder()
            .binding(0)
            .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::TESSELLATION_EVALUATION)
            .build()];
        let info = vk::DescriptorSetLayoutCreateInfo::builder().bindings(&bindings);
        // SAFETY: the device is alive, the info valid.
        pipelines.records = unsafe { context.device.create_descriptor_set_layout(&info, None) }
            .named("vkCreateDescriptorSetLayout", "records")?;
        let sets = [pipelines.records];
        let ranges = [vk::PushConstantRange { stage_flags: PUSH_STAGES, offset: 0, size: size_of::<Push>() as u32 }];
        let info = vk::PipelineLayoutCreateInfo::builder().set_layouts(&sets).push_constant_ranges(&ranges);
        // SAFETY: as above; 80 bytes of push constants are within every device's limit.
        pipelines.layout =
            unsafe { context.device.create_pipeline_layout(&info, None) }.named("vkCreatePipelineLayout", "patches")?;
        context.name(pipelines.records, "records");
        context.name(pipelines.layout, "patches");
        Ok(pipelines)
    }

    /// The pipeline of a key, made now if it is the first time.
    pub fn get(&self, key: PipelineKey) -> Result<vk::Pipeline, GpuError> {
        if let Some(&made) = self.made.borrow().get(&key) {
            return Ok(made);
        }
        let pipeline = self.make(key)?;
        self.made.borrow_mut().insert(key, pipeline);
        Ok(pipeline)
    }

    fn make(&self, key: PipelineKey) -> Result<vk::Pipeline, GpuError> {
        let PipelineKey { kind, shape, fill, pass } = key;
        if fill == Fill::Wire && !self.context.optional.wire {
            return Err(self.lacks("fillModeNonSolid (wireframe)"));
        }
        if fill == Fill::Readback && !self.context.optional.readback {
            return Err(self.lacks("vertexPipelineStoresAndAtomics (read-back)"));
        }
        let name = key.name();
        let evaluation =
            if fill == Fill::Readback { shader::readback(kind, shape) } else { shader::evaluation(kind, shape) };
        let mut stages = vec![
            (vk::ShaderStageFlags::VERTEX, shader::VERTEX),
            (vk::ShaderStageFlags::TESSELLATION_CONTROL, shader::control(kind, shape)),
            (vk::ShaderStageFlags::TESSELLATION_EVALUATION, evaluation),
        ];
        if fill != Fill::Readback {
            stages.push((vk::ShaderStageFlags::FRAGMENT, shader::FRAGMENT));
        }
        let extra = if shape == Shape::Whole { 0 } else { EXTRA_POINTS };
        let recipe = Recipe {
            name: &name,
            stages,
            constants: &[],
            stride: size_of::<[f32; 8]>() as u32,
            formats: &[vk::Format::R32G32B32A32_SFLOAT; 2],
            instances: None,
            topology: vk::PrimitiveTopology::PATCH_LIST,
            patch_points: (kind.points() + extra) as u32,
            wire: fill == Fill::Wire,
            behind: false,
            blended: true,
            discard: fill == Fill::Readback,
            layout: self.layout,
            pass,
        };
        recipe.make(&self.context, &self.passes)
    }

    fn lacks(&self, missing: &str) -> GpuError {
        GpuError::Lacks { device: self.context.info.name.clone(), missing: missing.to_owned() }
    }
}

impl Drop for Pipelines {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe {
            for (_, pipeline) in self.made.get_mut().drain() {
                self.context.device.destroy_pipeline(pipeline, None);
            }
            self.context.device.destroy_pipeline_layout(self.layout, None);
            self.context.device.destroy_descriptor_set_layout(self.records, None);
        }
    }
}
