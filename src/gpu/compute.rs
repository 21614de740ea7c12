//! Compute shaders over storage buffers.

use super::context::Context;
use super::descriptors::Descriptors;
use super::error::{GpuError, Named};
use super::memory::Buffer;
use super::shader::{Module, Spv};
use ash::vk;
use std::rc::Rc;

/// Invocations of a work group, as every compute shader of the project declares them.
const GROUP: u32 = 64;

/// Most invocations that one dispatch may have on every device.
pub(super) const MOST: u32 = 65_535 * GROUP;

/// A compute pipeline with its one set of storage buffers, which have to outlive its use.
pub(super) struct Kernel {
    context: Rc<Context>,
    descriptors: Descriptors,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
}

impl Kernel {
    /// `push`: bytes of push constants, at most 128.
    pub fn new(
        context: &Rc<Context>,
        name: &str,
        spv: &Spv,
        buffers: &[&Buffer],
        push: usize,
    ) -> Result<Kernel, GpuError> {
        let stages = vk::ShaderStageFlags::COMPUTE;
        let bound: Vec<_> = buffers.iter().map(|&b| (vk::DescriptorType::STORAGE_BUFFER, b, vk::WHOLE_SIZE)).collect();
        let mut made = Kernel {
            context: Rc::clone(context),
            descriptors: Descriptors::new(context, name, stages, &bound)?,
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
        };
        let layouts = [made.descriptors.layout];
        let ranges = [vk::PushConstantRange { stage_flags: stages, offset: 0, size: push as u32 }];
        let info = vk::PipelineLayoutCreateInfo::builder().set_layouts(&layouts).push_constant_ranges(&ranges);
        // SAFETY: the device is alive, the info valid.
        made.layout =
            unsafe { context.device.create_pipeline_layout(&info, None) }.named("vkCreatePipelineLayout", name)?;
        let module = Module::new(context, spv)?;
        let stage = vk::PipelineShaderStageCreateInfo::builder().stage(stages).module(module.handle).name(c"main");
        let info = vk::ComputePipelineCreateInfo::builder().stage(stage.build()).layout(made.layout);
        // SAFETY: every pointer in `info` lives until the call returns.
        let pipelines =
            unsafe { context.device.create_compute_pipelines(vk::PipelineCache::null(), &[info.build()], None) };
        made.pipeline = pipelines.map_err(|(_, result)| result).named("vkCreateComputePipelines", name)?[0];
        context.name(made.pipeline, name);
        Ok(made)
    }

    /// Records one invocation for each of `count` things, at most [`MOST`]. Outside a render pass.
    pub fn record(&self, commands: vk::CommandBuffer, push: &[u8], count: u32) {
        let (device, compute) = (&self.context.device, vk::PipelineBindPoint::COMPUTE);
        // SAFETY: recording, outside a render pass; set, layout and pipeline belong together, and with the buffers they
        // outlive the submission, which is waited for.
        unsafe {
            device.cmd_bind_pipeline(commands, compute, self.pipeline);
            device.cmd_bind_descriptor_sets(commands, compute, self.layout, 0, &[self.descriptors.set], &[]);
            device.cmd_push_constants(commands, self.layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            device.cmd_dispatch(commands, count.div_ceil(GROUP), 1, 1);
        }
    }

    /// Records that what was written before by `from` is there for `to`. Outside a render pass.
    pub fn record_barrier(
        &self,
        commands: vk::CommandBuffer,
        from: (vk::PipelineStageFlags, vk::AccessFlags),
        to: (vk::PipelineStageFlags, vk::AccessFlags),
    ) {
        let barrier = [vk::MemoryBarrier::builder().src_access_mask(from.1).dst_access_mask(to.1).build()];
        let none = vk::DependencyFlags::empty();
        // SAFETY: recording, outside a render pass.
        unsafe { self.context.device.cmd_pipeline_barrier(commands, from.0, to.0, none, &barrier, &[], &[]) };
    }
}

impl Drop for Kernel {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe {
            self.context.device.destroy_pipeline(self.pipeline, None);
            self.context.device.destroy_pipeline_layout(self.layout, None);
        }
    }
}
