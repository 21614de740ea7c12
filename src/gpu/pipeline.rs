//! Pipelines: one for each (kind, whole face or triangle part or quad part, fill, target), made when first needed.
//! Which part of which constellation is drawn comes by push constants, so a cold start compiles few.

use super::context::Context;
use super::error::{GpuError, Named};
use super::layout::Push;
use super::shader::{self, Module};
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
        let mut modules = vec![
            (vk::ShaderStageFlags::VERTEX, Module::new(&self.context, &shader::VERTEX)?),
            (vk::ShaderStageFlags::TESSELLATION_CONTROL, Module::new(&self.context, &shader::control(kind, shape))?),
            (vk::ShaderStageFlags::TESSELLATION_EVALUATION, Module::new(&self.context, &evaluation)?),
        ];
        if fill != Fill::Readback {
            modules.push((vk::ShaderStageFlags::FRAGMENT, Module::new(&self.context, &shader::FRAGMENT)?));
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
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::builder().topology(vk::PrimitiveTopology::PATCH_LIST);
        let extra = if shape == Shape::Whole { 0 } else { EXTRA_POINTS };
        let tessellation =
            vk::PipelineTessellationStateCreateInfo::builder().patch_control_points((kind.points() + extra) as u32);
        let viewport = vk::PipelineViewportStateCreateInfo::builder().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::builder()
            .rasterizer_discard_enable(fill == Fill::Readback)
            .polygon_mode(if fill == Fill::Wire { vk::PolygonMode::LINE } else { vk::PolygonMode::FILL })
            .cull_mode(vk::CullModeFlags::NONE)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::builder().rasterization_samples(pass.samples());
        // Premultiplied colours, later over earlier.
        let attachments = [vk::PipelineColorBlendAttachmentState::builder()
            .blend_enable(true)
            .src_color_blend_factor(vk::BlendFactor::ONE)
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .color_blend_op(vk::BlendOp::ADD)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .alpha_blend_op(vk::BlendOp::ADD)
            .color_write_mask(vk::ColorComponentFlags::RGBA)
            .build()];
        let blend = vk::PipelineColorBlendStateCreateInfo::builder().attachments(&attachments);
        let depth = vk::PipelineDepthStencilStateCreateInfo::builder()
            .depth_test_enable(pass.has_depth())
            .depth_write_enable(pass.has_depth())
            .depth_compare_op(vk::CompareOp::LESS_OR_EQUAL);
        let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::builder().dynamic_states(&states);

        let mut info = vk::GraphicsPipelineCreateInfo::builder()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .tessellation_state(&tessellation)
            .rasterization_state(&raster)
            .layout(self.layout)
            .render_pass(self.passes.get(pass)?);
        if fill != Fill::Readback {
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
