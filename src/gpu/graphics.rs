//! Graphics pipelines from the few things in which they differ.

use super::context::Context;
use super::error::{GpuError, Named};
use super::memory::bytes_of;
use super::shader::{Module, Spv};
use super::target::{PassKey, Passes};
use ash::vk;
use std::rc::Rc;

/// What a pipeline is made of. The vertex buffer is binding 0.
pub(super) struct Recipe<'a> {
    pub name: &'a str,
    pub stages: Vec<(vk::ShaderStageFlags, Spv)>,
    /// Specialisation constants 0, 1, ... of every stage.
    pub constants: &'a [u32],
    /// Bytes of a vertex.
    pub stride: u32,
    /// Attributes at locations 0, 1, ..., 16 bytes from one to the next.
    pub formats: &'a [vk::Format],
    /// Binding 1, where there is one: bytes from instance to instance, and where in them vectors of four floats stand, at
    /// the locations that follow.
    pub instances: Option<(u32, &'a [u32])>,
    pub topology: vk::PrimitiveTopology,
    /// Control points of a patch; 0 without tessellation.
    pub patch_points: u32,
    /// Edges instead of faces.
    pub wire: bool,
    /// Steps back a little, so that lines in the same place are seen.
    pub behind: bool,
    /// Premultiplied colours, later over earlier; else later instead of earlier.
    pub blended: bool,
    /// Nothing is rasterised: the read-back.
    pub discard: bool,
    pub layout: vk::PipelineLayout,
    pub pass: PassKey,
}

impl Recipe<'_> {
    /// Makes the pipeline. Viewport and scissor are dynamic.
    pub fn make(&self, context: &Rc<Context>, passes: &Passes) -> Result<vk::Pipeline, GpuError> {
        let mut modules = Vec::with_capacity(self.stages.len());
        for (stage, spv) in &self.stages {
            modules.push((*stage, Module::new(context, spv)?));
        }
        let entries: Vec<vk::SpecializationMapEntry> = (0..self.constants.len() as u32)
            .map(|i| vk::SpecializationMapEntry { constant_id: i, offset: 4 * i, size: 4 })
            .collect();
        let special = vk::SpecializationInfo::builder().map_entries(&entries).data(bytes_of(self.constants));
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
        let mut bindings = vec![vk::VertexInputBindingDescription {
            binding: 0,
            stride: self.stride,
            input_rate: vk::VertexInputRate::VERTEX,
        }];
        let mut attributes: Vec<vk::VertexInputAttributeDescription> = (0..)
            .zip(self.formats)
            .map(|(i, &format)| vk::VertexInputAttributeDescription { location: i, binding: 0, format, offset: 16 * i })
            .collect();
        if let Some((stride, offsets)) = self.instances {
            bindings.push(vk::VertexInputBindingDescription {
                binding: 1,
                stride,
                input_rate: vk::VertexInputRate::INSTANCE,
            });
            let format = vk::Format::R32G32B32A32_SFLOAT;
            attributes.extend((self.formats.len() as u32..).zip(offsets).map(|(location, &offset)| {
                vk::VertexInputAttributeDescription { location, binding: 1, format, offset }
            }));
        }
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::builder()
            .vertex_binding_descriptions(&bindings)
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::builder().topology(self.topology);
        let tessellation = vk::PipelineTessellationStateCreateInfo::builder().patch_control_points(self.patch_points);
        let viewport = vk::PipelineViewportStateCreateInfo::builder().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::builder()
            .rasterizer_discard_enable(self.discard)
            .polygon_mode(if self.wire { vk::PolygonMode::LINE } else { vk::PolygonMode::FILL })
            .cull_mode(vk::CullModeFlags::NONE)
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .depth_bias_enable(self.behind)
            .depth_bias_constant_factor(1.0)
            .depth_bias_slope_factor(1.0)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::builder().rasterization_samples(self.pass.samples());
        let attachments = [vk::PipelineColorBlendAttachmentState::builder()
            .blend_enable(self.blended)
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
            .depth_test_enable(self.pass.has_depth())
            .depth_write_enable(self.pass.has_depth())
            .depth_compare_op(vk::CompareOp::LESS_OR_EQUAL);
        let states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::builder().dynamic_states(&states);

        let mut info = vk::GraphicsPipelineCreateInfo::builder()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .rasterization_state(&raster)
            .layout(self.layout)
            .render_pass(passes.get(self.pass)?);
        if self.patch_points > 0 {
            info = info.tessellation_state(&tessellation);
        }
        if !self.discard {
            info = info
                .viewport_state(&viewport)
                .multisample_state(&multisample)
                .color_blend_state(&blend)
                .depth_stencil_state(&depth)
                .dynamic_state(&dynamic);
        }
        // SAFETY: every pointer in `info` lives until the call returns; the features used were found on the device.
        let made =
            unsafe { context.device.create_graphics_pipelines(vk::PipelineCache::null(), &[info.build()], None) };
        let pipeline = made.map_err(|(_, result)| result).named("vkCreateGraphicsPipelines", self.name)?[0];
        context.name(pipeline, self.name);
        Ok(pipeline)
    }
}
