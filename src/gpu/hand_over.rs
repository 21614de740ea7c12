//! Commands around the widgets' pass: what an image held before it, and how it gets to the screen and to the host.

use super::context::Context;
use super::memory::{Buffer, COLOUR_RANGE};
use super::surface_format::Way;
use ash::vk;

/// Clears an image whatever it held, and leaves it as a colour attachment.
pub(super) fn clear(context: &Context, commands: vk::CommandBuffer, image: vk::Image) {
    use vk::{AccessFlags as Access, ImageLayout as Layout, PipelineStageFlags as Stage};
    barrier(
        context,
        commands,
        image,
        [Layout::UNDEFINED, Layout::TRANSFER_DST_OPTIMAL],
        // The wait for the image covers these two stages, and an earlier frame of widgets wrote the attachment.
        [Stage::COLOR_ATTACHMENT_OUTPUT | Stage::TRANSFER, Stage::TRANSFER],
        [Access::COLOR_ATTACHMENT_WRITE, Access::TRANSFER_WRITE],
    );
    let black = vk::ClearColorValue { float32: [0.0, 0.0, 0.0, 1.0] };
    // SAFETY: recording, outside a render pass; the image is in this layout.
    unsafe {
        context.device.cmd_clear_color_image(commands, image, Layout::TRANSFER_DST_OPTIMAL, &black, &[COLOUR_RANGE]);
    }
    barrier(
        context,
        commands,
        image,
        [Layout::TRANSFER_DST_OPTIMAL, Layout::COLOR_ATTACHMENT_OPTIMAL],
        [Stage::TRANSFER, Stage::COLOR_ATTACHMENT_OUTPUT],
        [Access::TRANSFER_WRITE, Access::COLOR_ATTACHMENT_READ | Access::COLOR_ATTACHMENT_WRITE],
    );
}

/// Copies a drawn image to the host and makes it ready to present again.
pub(super) fn copy(
    context: &Context,
    commands: vk::CommandBuffer,
    image: vk::Image,
    extent: [u32; 2],
    pixels: &Buffer,
) {
    use vk::{AccessFlags as Access, ImageLayout as Layout, PipelineStageFlags as Stage};
    barrier(
        context,
        commands,
        image,
        [Layout::PRESENT_SRC_KHR, Layout::TRANSFER_SRC_OPTIMAL],
        [Stage::COLOR_ATTACHMENT_OUTPUT, Stage::TRANSFER],
        [Access::COLOR_ATTACHMENT_WRITE, Access::TRANSFER_READ],
    );
    let region = vk::BufferImageCopy::builder()
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        })
        .image_extent(vk::Extent3D { width: extent[0], height: extent[1], depth: 1 });
    let to_host = vk::BufferMemoryBarrier::builder()
        .src_access_mask(Access::TRANSFER_WRITE)
        .dst_access_mask(Access::HOST_READ)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .buffer(pixels.handle)
        .size(vk::WHOLE_SIZE);
    // SAFETY: recording, outside a render pass; the buffer has four bytes for each pixel.
    unsafe {
        let layout = Layout::TRANSFER_SRC_OPTIMAL;
        context.device.cmd_copy_image_to_buffer(commands, image, layout, pixels.handle, &[region.build()]);
        let none = vk::DependencyFlags::empty();
        context.device.cmd_pipeline_barrier(commands, Stage::TRANSFER, Stage::HOST, none, &[], &[to_host.build()], &[]);
    }
    barrier(
        context,
        commands,
        image,
        [Layout::TRANSFER_SRC_OPTIMAL, Layout::PRESENT_SRC_KHR],
        [Stage::TRANSFER, Stage::BOTTOM_OF_PIPE],
        [Access::TRANSFER_READ, Access::empty()],
    );
}

/// Brings a drawn image into the swapchain's, ready to present.
pub(super) fn hand_over(
    context: &Context,
    commands: vk::CommandBuffer,
    [from, to]: [vk::Image; 2],
    [width, height]: [u32; 2],
    way: Way,
) {
    use vk::{AccessFlags as Access, ImageLayout as Layout, PipelineStageFlags as Stage};
    barrier(
        context,
        commands,
        from,
        [Layout::PRESENT_SRC_KHR, Layout::TRANSFER_SRC_OPTIMAL],
        [Stage::COLOR_ATTACHMENT_OUTPUT | Stage::TRANSFER, Stage::TRANSFER],
        [Access::COLOR_ATTACHMENT_WRITE, Access::TRANSFER_READ],
    );
    barrier(
        context,
        commands,
        to,
        [Layout::UNDEFINED, Layout::TRANSFER_DST_OPTIMAL],
        // The wait for the image covers this stage.
        [Stage::TRANSFER, Stage::TRANSFER],
        [Access::empty(), Access::TRANSFER_WRITE],
    );
    let layers = vk::ImageSubresourceLayers {
        aspect_mask: vk::ImageAspectFlags::COLOR,
        mip_level: 0,
        base_array_layer: 0,
        layer_count: 1,
    };
    let (source, target) = (Layout::TRANSFER_SRC_OPTIMAL, Layout::TRANSFER_DST_OPTIMAL);
    // SAFETY: recording, outside a render pass; both images have this extent and these layouts, and their formats are
    // as the way says.
    unsafe {
        match way {
            Way::Blitted(_) => {
                let whole = [vk::Offset3D::default(), vk::Offset3D { x: width as i32, y: height as i32, z: 1 }];
                let region = vk::ImageBlit {
                    src_subresource: layers,
                    src_offsets: whole,
                    dst_subresource: layers,
                    dst_offsets: whole,
                };
                let device = &context.device;
                device.cmd_blit_image(commands, from, source, to, target, &[region], vk::Filter::NEAREST);
            }
            Way::Straight | Way::Copied(_) => {
                let region = vk::ImageCopy {
                    src_subresource: layers,
                    dst_subresource: layers,
                    extent: vk::Extent3D { width, height, depth: 1 },
                    ..vk::ImageCopy::default()
                };
                context.device.cmd_copy_image(commands, from, source, to, target, &[region]);
            }
        }
    }
    barrier(
        context,
        commands,
        to,
        [Layout::TRANSFER_DST_OPTIMAL, Layout::PRESENT_SRC_KHR],
        [Stage::TRANSFER, Stage::BOTTOM_OF_PIPE],
        [Access::TRANSFER_WRITE, Access::empty()],
    );
}

fn barrier(
    context: &Context,
    commands: vk::CommandBuffer,
    image: vk::Image,
    [old, new]: [vk::ImageLayout; 2],
    [before, after]: [vk::PipelineStageFlags; 2],
    [wrote, reads]: [vk::AccessFlags; 2],
) {
    let barrier = vk::ImageMemoryBarrier::builder()
        .src_access_mask(wrote)
        .dst_access_mask(reads)
        .old_layout(old)
        .new_layout(new)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image)
        .subresource_range(COLOUR_RANGE);
    // SAFETY: recording, outside a render pass; the image is in the old layout, or its content does not matter.
    unsafe {
        let none = vk::DependencyFlags::empty();
        context.device.cmd_pipeline_barrier(commands, before, after, none, &[], &[], &[barrier.build()]);
    }
}
