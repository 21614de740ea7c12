//! One descriptor set of whole buffers, with its layout and its pool.

use super::context::Context;
use super::error::{GpuError, Named};
use super::memory::Buffer;
use ash::vk;
use std::rc::Rc;

/// A set whose binding i is the i-th buffer. The buffers have to outlive its use.
pub(super) struct Descriptors {
    context: Rc<Context>,
    pub layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    pub set: vk::DescriptorSet,
}

impl Descriptors {
    /// `bound`: what each buffer is read as, and how many bytes of it ([`vk::WHOLE_SIZE`] for all).
    pub fn new(
        context: &Rc<Context>,
        name: &str,
        stages: vk::ShaderStageFlags,
        bound: &[(vk::DescriptorType, &Buffer, u64)],
    ) -> Result<Descriptors, GpuError> {
        let mut made = Descriptors {
            context: Rc::clone(context),
            layout: vk::DescriptorSetLayout::null(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
        };
        let bindings: Vec<vk::DescriptorSetLayoutBinding> = (0..)
            .zip(bound)
            .map(|(i, (kind, ..))| {
                vk::DescriptorSetLayoutBinding::builder()
                    .binding(i)
                    .descriptor_type(*kind)
                    .descriptor_count(1)
                    .stage_flags(stages)
                    .build()
            })
            .collect();
        let sizes: Vec<vk::DescriptorPoolSize> =
            bound.iter().map(|(ty, ..)| vk::DescriptorPoolSize { ty: *ty, descriptor_count: 1 }).collect();
        let device = &context.device;
        // SAFETY: the device is alive, the infos valid; the pool has room for this one set.
        unsafe {
            let info = vk::DescriptorSetLayoutCreateInfo::builder().bindings(&bindings);
            made.layout =
                device.create_descriptor_set_layout(&info, None).named("vkCreateDescriptorSetLayout", name)?;
            let info = vk::DescriptorPoolCreateInfo::builder().max_sets(1).pool_sizes(&sizes);
            made.pool = device.create_descriptor_pool(&info, None).named("vkCreateDescriptorPool", name)?;
            let layouts = [made.layout];
            let info = vk::DescriptorSetAllocateInfo::builder().descriptor_pool(made.pool).set_layouts(&layouts);
            made.set = device.allocate_descriptor_sets(&info).named("vkAllocateDescriptorSets", name)?[0];
        }
        context.name(made.layout, name);
        context.name(made.set, name);
        let infos: Vec<[vk::DescriptorBufferInfo; 1]> = bound
            .iter()
            .map(|(_, buffer, range)| [vk::DescriptorBufferInfo { buffer: buffer.handle, offset: 0, range: *range }])
            .collect();
        let writes: Vec<vk::WriteDescriptorSet> = (0..)
            .zip(bound)
            .zip(&infos)
            .map(|((i, (kind, ..)), info)| {
                vk::WriteDescriptorSet::builder()
                    .dst_set(made.set)
                    .dst_binding(i)
                    .descriptor_type(*kind)
                    .buffer_info(info)
                    .build()
            })
            .collect();
        // SAFETY: the set is not in use; the infos live until the call returns.
        unsafe { device.update_descriptor_sets(&writes, &[]) };
        Ok(made)
    }
}

impl Drop for Descriptors {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns. The set goes with its pool.
        unsafe {
            self.context.device.destroy_descriptor_pool(self.pool, None);
            self.context.device.destroy_descriptor_set_layout(self.layout, None);
        }
    }
}
