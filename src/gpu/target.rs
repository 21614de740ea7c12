//! Render passes and the off-screen colour target. A classic `VkRenderPass`: the validation layer of 1.3.239 checks
//! little under dynamic rendering.

use super::context::Context;
use super::error::{GpuError, Named};
use super::memory::{Buffer, Image, COLOUR_RANGE};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

/// Format of depth buffers: one of the two of which every Vulkan device has to have one, with 1 and with 4 samples.
fn depth_format(context: &Context) -> vk::Format {
    // SAFETY: the physical device belongs to the instance.
    let found = unsafe {
        context.instance.handle.get_physical_device_format_properties(context.physical, vk::Format::D32_SFLOAT)
    };
    if found.optimal_tiling_features.contains(vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT) {
        vk::Format::D32_SFLOAT
    } else {
        vk::Format::X8_D24_UNORM_PACK32
    }
}

/// What a pass renders into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PassKey {
    /// No attachment: the read-back.
    Empty,
    /// A colour target of this format; with more than one sample it is resolved at the end.
    Colour { format: vk::Format, samples: u32 },
    /// As [`PassKey::Colour`], with a depth buffer that starts at 1 and is thrown away at the end.
    Depth { format: vk::Format, samples: u32 },
    /// Draws over what a pass of this format and one sample has left; compatible with that.
    Over { format: vk::Format },
}

impl PassKey {
    pub fn samples(self) -> vk::SampleCountFlags {
        match self {
            PassKey::Colour { samples: 4, .. } | PassKey::Depth { samples: 4, .. } => vk::SampleCountFlags::TYPE_4,
            _ => vk::SampleCountFlags::TYPE_1,
        }
    }

    /// Whether there is a depth buffer.
    pub fn has_depth(self) -> bool {
        matches!(self, PassKey::Depth { .. })
    }
}

/// The render passes made so far.
pub(super) struct Passes {
    context: Rc<Context>,
    made: RefCell<HashMap<PassKey, vk::RenderPass>>,
}

impl Passes {
    pub fn new(context: &Rc<Context>) -> Passes {
        Passes { context: Rc::clone(context), made: RefCell::default() }
    }

    /// The render pass of a key, made now if it is the first time.
    pub fn get(&self, key: PassKey) -> Result<vk::RenderPass, GpuError> {
        if let Some(&made) = self.made.borrow().get(&key) {
            return Ok(made);
        }
        let pass = self.make(key)?;
        self.made.borrow_mut().insert(key, pass);
        Ok(pass)
    }

    fn make(&self, key: PassKey) -> Result<vk::RenderPass, GpuError> {
        let mut attachments = Vec::new();
        let (colour, first, before) = match key {
            PassKey::Empty => (None, vk::AttachmentLoadOp::CLEAR, vk::ImageLayout::UNDEFINED),
            PassKey::Colour { format, samples } | PassKey::Depth { format, samples } => {
                (Some((format, samples)), vk::AttachmentLoadOp::CLEAR, vk::ImageLayout::UNDEFINED)
            }
            PassKey::Over { format } => {
                (Some((format, 1)), vk::AttachmentLoadOp::LOAD, vk::ImageLayout::TRANSFER_SRC_OPTIMAL)
            }
        };
        if key.has_depth() {
            // Before the colours, so that the picture that is read stays the last.
            attachments.push(
                vk::AttachmentDescription::builder()
                    .format(depth_format(&self.context))
                    .samples(key.samples())
                    .load_op(vk::AttachmentLoadOp::CLEAR)
                    .store_op(vk::AttachmentStoreOp::DONT_CARE)
                    .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
                    .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
                    .initial_layout(vk::ImageLayout::UNDEFINED)
                    .final_layout(vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL)
                    .build(),
            );
        }
        if let Some((format, samples)) = colour {
            let single = samples == 1;
            let attachment = |samples, load_op, store_op, final_layout| {
                vk::AttachmentDescription::builder()
                    .format(format)
                    .samples(samples)
                    .load_op(load_op)
                    .store_op(store_op)
                    .stencil_load_op(vk::AttachmentLoadOp::DONT_CARE)
                    .stencil_store_op(vk::AttachmentStoreOp::DONT_CARE)
                    .initial_layout(before)
                    .final_layout(final_layout)
                    .build()
            };
            let (store, layout) = if single {
                (vk::AttachmentStoreOp::STORE, vk::ImageLayout::TRANSFER_SRC_OPTIMAL)
            } else {
                (vk::AttachmentStoreOp::DONT_CARE, vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            };
            attachments.push(attachment(key.samples(), first, store, layout));
            if !single {
                attachments.push(attachment(
                    vk::SampleCountFlags::TYPE_1,
                    vk::AttachmentLoadOp::DONT_CARE,
                    vk::AttachmentStoreOp::STORE,
                    vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                ));
            }
        }
        let reference =
            |attachment| [vk::AttachmentReference { attachment, layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL }];
        let first = u32::from(key.has_depth());
        let (colour, resolve) = (reference(first), reference(first + 1));
        let depth =
            vk::AttachmentReference { attachment: 0, layout: vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL };
        let mut subpass = vk::SubpassDescription::builder().pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS);
        if !attachments.is_empty() {
            subpass = subpass.color_attachments(&colour);
        }
        if attachments.len() as u32 == first + 2 {
            subpass = subpass.resolve_attachments(&resolve);
        }
        if key.has_depth() {
            subpass = subpass.depth_stencil_attachment(&depth);
        }
        let subpasses = [subpass.build()];
        // Before: the copy of an earlier frame. After: the copy of this one.
        let mut dependencies = [
            vk::SubpassDependency {
                src_subpass: vk::SUBPASS_EXTERNAL,
                dst_subpass: 0,
                src_stage_mask: vk::PipelineStageFlags::TRANSFER | vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
                dst_stage_mask: vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
                src_access_mask: vk::AccessFlags::TRANSFER_READ | vk::AccessFlags::COLOR_ATTACHMENT_WRITE,
                dst_access_mask: vk::AccessFlags::COLOR_ATTACHMENT_READ | vk::AccessFlags::COLOR_ATTACHMENT_WRITE,
                dependency_flags: vk::DependencyFlags::empty(),
            },
            vk::SubpassDependency {
                src_subpass: 0,
                dst_subpass: vk::SUBPASS_EXTERNAL,
                src_stage_mask: vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
                dst_stage_mask: vk::PipelineStageFlags::TRANSFER,
                src_access_mask: vk::AccessFlags::COLOR_ATTACHMENT_WRITE,
                dst_access_mask: vk::AccessFlags::TRANSFER_READ,
                dependency_flags: vk::DependencyFlags::empty(),
            },
        ];
        if key.has_depth() {
            // The depth buffer of an earlier frame is done with.
            let tests = vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS;
            let write = vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
            dependencies[0].src_stage_mask |= tests;
            dependencies[0].dst_stage_mask |= tests;
            dependencies[0].src_access_mask |= write;
            dependencies[0].dst_access_mask |= write | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ;
        }
        let mut info = vk::RenderPassCreateInfo::builder().attachments(&attachments).subpasses(&subpasses);
        if !attachments.is_empty() {
            info = info.dependencies(&dependencies);
        }
        let name = format!("{key:?} pass");
        // SAFETY: every pointer in `info` lives until the call returns.
        let pass = unsafe { self.context.device.create_render_pass(&info, None) }.named("vkCreateRenderPass", &name)?;
        self.context.name(pass, &name);
        Ok(pass)
    }
}

impl Drop for Passes {
    fn drop(&mut self) {
        for (_, pass) in self.made.get_mut().drain() {
            // SAFETY: every submission is waited for before its call returns.
            unsafe { self.context.device.destroy_render_pass(pass, None) };
        }
    }
}

/// A framebuffer with its images, and a host buffer that takes the picture.
pub(super) struct Target {
    context: Rc<Context>,
    pub extent: [u32; 2],
    pub pass: vk::RenderPass,
    pub framebuffer: vk::Framebuffer,
    // The depth buffer, the multisampled image, then the one that is read: as the pass has them.
    images: Vec<Image>,
    pixels: Option<Buffer>,
}

impl Target {
    /// A target for `key`. For [`PassKey::Empty`] there is nothing to read.
    pub fn new(context: &Rc<Context>, passes: &Passes, key: PassKey, extent: [u32; 2]) -> Result<Target, GpuError> {
        let mut images = Vec::new();
        let mut pixels = None;
        if let PassKey::Colour { format, samples } | PassKey::Depth { format, samples } = key {
            check(context, format, key.samples(), samples, extent)?;
            if key.has_depth() {
                let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSIENT_ATTACHMENT;
                images.push(Image::new(context, "depth", extent, depth_format(context), key.samples(), usage)?);
            }
            if samples > 1 {
                let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSIENT_ATTACHMENT;
                images.push(Image::new(context, "multisampled colour", extent, format, key.samples(), usage)?);
            }
            let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
                | vk::ImageUsageFlags::TRANSFER_SRC
                | vk::ImageUsageFlags::SAMPLED;
            images.push(Image::new(context, "colour", extent, format, vk::SampleCountFlags::TYPE_1, usage)?);
            let bytes = if format == vk::Format::R8G8B8A8_UNORM { 4 } else { 16 };
            pixels = Some(Buffer::new(
                context,
                "pixels",
                bytes * u64::from(extent[0]) * u64::from(extent[1]),
                vk::BufferUsageFlags::TRANSFER_DST,
                MemoryLocation::GpuToCpu,
            )?);
        }
        let pass = passes.get(key)?;
        let views: Vec<vk::ImageView> = images.iter().map(|image| image.view).collect();
        let info = vk::FramebufferCreateInfo::builder()
            .render_pass(pass)
            .attachments(&views)
            .width(extent[0])
            .height(extent[1])
            .layers(1);
        // SAFETY: the views match the pass's attachments and live as long as the framebuffer.
        let framebuffer =
            unsafe { context.device.create_framebuffer(&info, None) }.named("vkCreateFramebuffer", "target")?;
        context.name(framebuffer, "target");
        Ok(Target { context: Rc::clone(context), extent, pass, framebuffer, images, pixels })
    }

    /// What the pass's attachments are cleared to: `colour` is premultiplied.
    pub fn clear_values(key: PassKey, colour: [f32; 4]) -> Vec<vk::ClearValue> {
        let colour = vk::ClearValue { color: vk::ClearColorValue { float32: colour } };
        let depth = vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 1.0, stencil: 0 } };
        let mut values = vec![colour; 2];
        if key.has_depth() {
            values.insert(0, depth);
        }
        values
    }

    /// Records the copy of the picture to the host. The pass has left the image in the layout for it.
    pub fn record_copy(&self, commands: vk::CommandBuffer) {
        let (Some(image), Some(pixels)) = (self.images.last(), &self.pixels) else {
            return;
        };
        let region = vk::BufferImageCopy::builder()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: vk::ImageAspectFlags::COLOR,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: 1,
            })
            .image_extent(vk::Extent3D { width: self.extent[0], height: self.extent[1], depth: 1 });
        // SAFETY: recording, outside a render pass; buffer and image have the same number of tightly packed pixels.
        unsafe {
            self.context.device.cmd_copy_image_to_buffer(
                commands,
                image.handle,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                pixels.handle,
                &[region.build()],
            );
        }
        pixels.record_to_host(commands, vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
    }

    /// The image that the pass leaves, for shaders to read after [`Target::record_for_sampling`].
    pub fn view(&self) -> vk::ImageView {
        self.images.last().map_or(vk::ImageView::null(), |image| image.view)
    }

    /// Lets fragment shaders read the picture. The pass has left the image in the layout for a copy.
    pub fn record_for_sampling(&self, commands: vk::CommandBuffer) {
        let Some(image) = self.images.last() else {
            return;
        };
        let barrier = vk::ImageMemoryBarrier::builder()
            .src_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_WRITE)
            .dst_access_mask(vk::AccessFlags::SHADER_READ)
            .old_layout(vk::ImageLayout::TRANSFER_SRC_OPTIMAL)
            .new_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.handle)
            .subresource_range(COLOUR_RANGE);
        // SAFETY: recording, outside a render pass; the layouts are those before and after.
        unsafe {
            self.context.device.cmd_pipeline_barrier(
                commands,
                vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT | vk::PipelineStageFlags::TRANSFER,
                vk::PipelineStageFlags::FRAGMENT_SHADER,
                vk::DependencyFlags::empty(),
                &[],
                &[],
                &[barrier.build()],
            );
        }
    }

    /// The picture that was copied last, rows from the top, tightly packed. Empty for [`PassKey::Empty`].
    pub fn pixels(&self) -> Result<&[u8], GpuError> {
        self.pixels.as_ref().map_or(Ok(&[]), Buffer::bytes)
    }
}

impl Drop for Target {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe { self.context.device.destroy_framebuffer(self.framebuffer, None) };
    }
}

fn check(
    context: &Context,
    format: vk::Format,
    flags: vk::SampleCountFlags,
    samples: u32,
    [width, height]: [u32; 2],
) -> Result<(), GpuError> {
    let info = &context.info;
    let [max_width, max_height] = info.limits.max_image;
    if width == 0 || height == 0 {
        return Err(GpuError::Request(format!("a picture of {width}x{height} pixels has nothing in it")));
    }
    if width > max_width || height > max_height {
        return Err(GpuError::Request(format!(
            "a picture of {width}x{height} pixels is too large for '{}'; it can do {max_width}x{max_height}",
            info.name
        )));
    }
    // SAFETY: the physical device belongs to the instance.
    let found = unsafe {
        context.instance.handle.get_physical_device_image_format_properties(
            context.physical,
            format,
            vk::ImageType::TYPE_2D,
            vk::ImageTiling::OPTIMAL,
            vk::ImageUsageFlags::COLOR_ATTACHMENT,
            vk::ImageCreateFlags::empty(),
        )
    }
    .named("vkGetPhysicalDeviceImageFormatProperties", &info.name)?;
    if !matches!(samples, 1 | 4) || !found.sample_counts.contains(flags) {
        return Err(GpuError::Request(format!("{samples} samples a pixel; 1 and 4 are possible")));
    }
    Ok(())
}
