//! Deliberate mistakes that the validation layer must report. A layer that is installed and says nothing is worse than
//! none, so tests (and anyone in doubt) let the canaries sing first.

use super::context::{Commands, Context};
use super::error::{GpuError, Named};
use super::instance::Message;
use super::memory::{Buffer, Image, COLOUR_RANGE};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// A deliberate mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Canary {
    /// A buffer of no bytes: the core checks of parameters.
    ZeroSizeBuffer,
    /// A render pass over an image that is in another layout than the pass says: the tracking of state.
    LayoutMismatch,
    /// Two copies into one buffer with no barrier between: synchronisation validation.
    TwoCopies,
}

/// All of them.
pub const CANARIES: [Canary; 3] = [Canary::ZeroSizeBuffer, Canary::LayoutMismatch, Canary::TwoCopies];

/// Makes the mistake and returns what the layer said to it; those messages leave the log.
pub(super) fn sing(context: &Rc<Context>, canary: Canary) -> Result<Vec<Message>, GpuError> {
    let before = context.instance.take_messages();
    let made = match canary {
        Canary::ZeroSizeBuffer => zero_size_buffer(context),
        Canary::LayoutMismatch => layout_mismatch(context),
        Canary::TwoCopies => two_copies(context),
    };
    let said = context.instance.take_messages();
    context.instance.put_back(before);
    made.map(|()| said)
}

fn zero_size_buffer(context: &Context) -> Result<(), GpuError> {
    let info = vk::BufferCreateInfo::builder().usage(vk::BufferUsageFlags::TRANSFER_SRC);
    // SAFETY: invalid on purpose; a driver may refuse or make an empty buffer, which nothing touches.
    unsafe {
        if let Ok(buffer) = context.device.create_buffer(&info, None) {
            context.device.destroy_buffer(buffer, None);
        }
    }
    Ok(())
}

fn layout_mismatch(context: &Rc<Context>) -> Result<(), GpuError> {
    let format = vk::Format::R8G8B8A8_UNORM;
    let image = Image::new(
        context,
        "canary image",
        [4, 4],
        format,
        vk::SampleCountFlags::TYPE_1,
        vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST,
    )?;
    let attachments = [vk::AttachmentDescription::builder()
        .format(format)
        .samples(vk::SampleCountFlags::TYPE_1)
        .load_op(vk::AttachmentLoadOp::LOAD)
        .store_op(vk::AttachmentStoreOp::STORE)
        .initial_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
        .final_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
        .build()];
    let colour = [vk::AttachmentReference { attachment: 0, layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL }];
    let subpasses = [vk::SubpassDescription::builder()
        .pipeline_bind_point(vk::PipelineBindPoint::GRAPHICS)
        .color_attachments(&colour)
        .build()];
    let info = vk::RenderPassCreateInfo::builder().attachments(&attachments).subpasses(&subpasses);
    // SAFETY: the pass and the framebuffer are valid; the image is left in the transfer layout on purpose before the
    // pass that expects it as an attachment. The images are 4x4 and no pixel is looked at.
    unsafe {
        let pass = context.device.create_render_pass(&info, None).named("vkCreateRenderPass", "canary")?;
        let views = [image.view];
        let info =
            vk::FramebufferCreateInfo::builder().render_pass(pass).attachments(&views).width(4).height(4).layers(1);
        let framebuffer = context.device.create_framebuffer(&info, None).named("vkCreateFramebuffer", "canary");
        let ran = framebuffer.and_then(|framebuffer| {
            let ran = Commands::new(context, "canary").and_then(|commands| {
                commands.run(|commands| {
                    let barrier = vk::ImageMemoryBarrier::builder()
                        .dst_access_mask(vk::AccessFlags::COLOR_ATTACHMENT_READ)
                        .new_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
                        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                        .image(image.handle)
                        .subresource_range(COLOUR_RANGE);
                    context.device.cmd_pipeline_barrier(
                        commands,
                        vk::PipelineStageFlags::TOP_OF_PIPE,
                        vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
                        vk::DependencyFlags::empty(),
                        &[],
                        &[],
                        &[barrier.build()],
                    );
                    let begin = vk::RenderPassBeginInfo::builder()
                        .render_pass(pass)
                        .framebuffer(framebuffer)
                        .render_area(vk::Rect2D {
                            offset: vk::Offset2D::default(),
                            extent: vk::Extent2D { width: 4, height: 4 },
                        });
                    context.device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
                    context.device.cmd_end_render_pass(commands);
                    Ok(())
                })
            });
            context.device.destroy_framebuffer(framebuffer, None);
            ran
        });
        context.device.destroy_render_pass(pass, None);
        ran.map(|_| ())
    }
}

fn two_copies(context: &Rc<Context>) -> Result<(), GpuError> {
    let source = Buffer::staging(context, "canary source", &[0u32; 16])?;
    let sink = Buffer::new(context, "canary sink", 64, vk::BufferUsageFlags::TRANSFER_DST, MemoryLocation::GpuOnly)?;
    Commands::new(context, "canary")?.run(|commands| {
        let region = [vk::BufferCopy { src_offset: 0, dst_offset: 0, size: 64 }];
        for _ in 0..2 {
            // SAFETY: in bounds; the hazard is on purpose, and both copies write the same zeros.
            unsafe { context.device.cmd_copy_buffer(commands, source.handle, sink.handle, &region) };
        }
        Ok(())
    })?;
    Ok(())
}
