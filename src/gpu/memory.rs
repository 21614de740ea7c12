//! Buffers and images that own their memory and carry a name.

use super::context::Context;
use super::error::{GpuError, Named};
use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// A plain struct that may be sent to the GPU byte by byte.
///
/// # Safety
/// The type is `repr(C)` or primitive, has no padding, and every bit pattern is a value.
pub(super) unsafe trait Plain: Copy {}
// SAFETY: primitives and arrays of them have no padding, and every bit pattern is a value.
unsafe impl Plain for u8 {}
// SAFETY: as above.
unsafe impl Plain for u32 {}
// SAFETY: as above.
unsafe impl Plain for f32 {}
// SAFETY: as above.
unsafe impl<const N: usize> Plain for [f32; N] {}
// SAFETY: as above.
unsafe impl<const N: usize> Plain for [u32; N] {}

/// The bytes of a slice.
pub(super) fn bytes_of<T: Plain>(slice: &[T]) -> &[u8] {
    // SAFETY: `Plain` types have no padding, so every byte is initialised.
    unsafe { std::slice::from_raw_parts(slice.as_ptr().cast(), size_of_val(slice)) }
}

pub(super) struct Buffer {
    context: Rc<Context>,
    pub handle: vk::Buffer,
    /// Bytes asked for.
    pub size: u64,
    allocation: Option<Allocation>,
    name: String,
}

impl Buffer {
    /// A buffer of `size` bytes, more than 0.
    pub fn new(
        context: &Rc<Context>,
        name: &str,
        size: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Buffer, GpuError> {
        let info = vk::BufferCreateInfo::builder().size(size).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the device is alive.
        let handle = unsafe { context.device.create_buffer(&info, None) }.named("vkCreateBuffer", name)?;
        let mut buffer = Buffer { context: Rc::clone(context), handle, size, allocation: None, name: name.to_owned() };
        // SAFETY: the handle was just made.
        let requirements = unsafe { context.device.get_buffer_memory_requirements(handle) };
        let allocation = allocate(context, name, requirements, location, true)?;
        // SAFETY: the memory is fresh, of the right type and size, and stays until the buffer is destroyed.
        let bound = unsafe { context.device.bind_buffer_memory(handle, allocation.memory(), allocation.offset()) };
        buffer.allocation = Some(allocation);
        bound.named("vkBindBufferMemory", name)?;
        context.name(handle, name);
        Ok(buffer)
    }

    /// A host-visible buffer that holds `data`.
    pub fn staging<T: Plain>(context: &Rc<Context>, name: &str, data: &[T]) -> Result<Buffer, GpuError> {
        let bytes = bytes_of(data);
        let mut buffer = Buffer::new(
            context,
            name,
            bytes.len() as u64,
            vk::BufferUsageFlags::TRANSFER_SRC,
            MemoryLocation::CpuToGpu,
        )?;
        buffer.write(bytes)?;
        Ok(buffer)
    }

    /// Overwrites the start of a host-visible buffer.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), GpuError> {
        let mapped = self.allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        match mapped.and_then(|slice| slice.get_mut(..bytes.len())) {
            Some(slice) => {
                slice.copy_from_slice(bytes);
                Ok(())
            }
            None => Err(self.not_mapped()),
        }
    }

    /// The bytes of a host-visible buffer. The GPU must be done with it, and a barrier to the host recorded.
    pub fn bytes(&self) -> Result<&[u8], GpuError> {
        let mapped = self.allocation.as_ref().and_then(Allocation::mapped_slice);
        mapped.and_then(|slice| slice.get(..self.size as usize)).ok_or_else(|| self.not_mapped())
    }

    /// Makes what `stage` wrote by `access` visible to the host. Outside a render pass.
    pub fn record_to_host(&self, commands: vk::CommandBuffer, stage: vk::PipelineStageFlags, access: vk::AccessFlags) {
        let barrier = vk::BufferMemoryBarrier::builder()
            .src_access_mask(access)
            .dst_access_mask(vk::AccessFlags::HOST_READ)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .buffer(self.handle)
            .size(vk::WHOLE_SIZE);
        // SAFETY: recording, outside a render pass; the buffer outlives the submission.
        unsafe {
            self.context.device.cmd_pipeline_barrier(
                commands,
                stage,
                vk::PipelineStageFlags::HOST,
                vk::DependencyFlags::empty(),
                &[],
                &[barrier.build()],
                &[],
            );
        }
    }

    fn not_mapped(&self) -> GpuError {
        GpuError::Memory { object: self.name.clone(), what: "not visible to the host, or too small".to_owned() }
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns, so the GPU is done with the buffer.
        unsafe { self.context.device.destroy_buffer(self.handle, None) };
        free(&self.context, self.allocation.take());
    }
}

pub(super) struct Image {
    context: Rc<Context>,
    pub handle: vk::Image,
    pub view: vk::ImageView,
    allocation: Option<Allocation>,
}

impl Image {
    /// A 2D colour image with one level, in the undefined layout, and its view.
    pub fn new(
        context: &Rc<Context>,
        name: &str,
        extent: [u32; 2],
        format: vk::Format,
        samples: vk::SampleCountFlags,
        usage: vk::ImageUsageFlags,
    ) -> Result<Image, GpuError> {
        let info = vk::ImageCreateInfo::builder()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: extent[0], height: extent[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(samples)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage)
            .sharing_mode(vk::SharingMode::EXCLUSIVE)
            .initial_layout(vk::ImageLayout::UNDEFINED);
        // SAFETY: the caller has checked extent, format and samples against the device.
        let handle = unsafe { context.device.create_image(&info, None) }.named("vkCreateImage", name)?;
        let mut image = Image { context: Rc::clone(context), handle, view: vk::ImageView::null(), allocation: None };
        // SAFETY: the handle was just made.
        let requirements = unsafe { context.device.get_image_memory_requirements(handle) };
        let allocation = allocate(context, name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the memory is fresh, of the right type and size, and stays until the image is destroyed.
        let bound = unsafe { context.device.bind_image_memory(handle, allocation.memory(), allocation.offset()) };
        image.allocation = Some(allocation);
        bound.named("vkBindImageMemory", name)?;
        let info = vk::ImageViewCreateInfo::builder()
            .image(handle)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(vk::ImageSubresourceRange {
                aspect_mask: if usage.contains(vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT) {
                    vk::ImageAspectFlags::DEPTH
                } else {
                    vk::ImageAspectFlags::COLOR
                },
                ..COLOUR_RANGE
            });
        // SAFETY: the image is bound and has this format.
        image.view = unsafe { context.device.create_image_view(&info, None) }.named("vkCreateImageView", name)?;
        context.name(handle, name);
        context.name(image.view, name);
        Ok(image)
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns, so the GPU is done with the image.
        unsafe {
            self.context.device.destroy_image_view(self.view, None);
            self.context.device.destroy_image(self.handle, None);
        }
        free(&self.context, self.allocation.take());
    }
}

/// The one level and layer of a colour image.
pub(super) const COLOUR_RANGE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

fn allocate(
    context: &Context,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation, GpuError> {
    let failed = |what: String| GpuError::Memory { object: name.to_owned(), what };
    context.faults.may_allocate(name, requirements.size)?;
    let allocation = context
        .allocator()
        .as_mut()
        .ok_or_else(|| failed("the device is gone".to_owned()))?
        .allocate(&AllocationCreateDesc {
            name,
            requirements,
            location,
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })
        .map_err(|e| failed(format!("{} bytes: {e}", requirements.size)))?;
    context.faults.count(allocation.size(), 0);
    Ok(allocation)
}

fn free(context: &Context, allocation: Option<Allocation>) {
    if let (Some(allocator), Some(allocation)) = (context.allocator().as_mut(), allocation) {
        context.faults.count(0, allocation.size());
        // Freeing fails only for an allocation of another allocator.
        let _ = allocator.free(allocation);
    }
}
