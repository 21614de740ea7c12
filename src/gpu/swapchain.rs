//! A window's surface and the swapchains made of it.

use super::context::Context;
use super::error::{GpuError, Named};
use super::memory::Image;
use super::surface_format::{bytes_order, choose_format, Way};
use ash::extensions::khr;
use ash::vk;
use std::rc::Rc;

/// A window's surface.
pub(super) struct Surface {
    pub(super) context: Rc<Context>,
    pub(super) surfaces: khr::Surface,
    pub(super) swapchains: khr::Swapchain,
    pub(super) handle: vk::SurfaceKHR,
}

/// A swapchain and what belongs to its images.
pub(super) struct Chain {
    pub(super) handle: vk::SwapchainKHR,
    pub(super) images: Vec<vk::Image>,
    // Of each image: signalled when it is drawn.
    pub(super) drawn: Vec<vk::Semaphore>,
    pub(super) extent: [u32; 2],
    // Where the widgets are drawn when the images' own format would convert their colours.
    pub(super) between: Option<Between>,
    // Format and readability of what the widgets are drawn to.
    pub(super) format: vk::Format,
    pub(super) readable: bool,
    // Whether the widgets' renderer knows these images.
    pub(super) announced: bool,
}

/// An image in a format that keeps colours as they are, and how it gets to the swapchain's.
pub(super) struct Between {
    pub(super) image: Image,
    pub(super) way: Way,
}

impl Surface {
    /// A swapchain for a window of `size` pixels in place of the `old` one, which is to be discarded then; the device is
    /// idle. `None`: the window has no pixels. `converting`: see [`choose_format`].
    pub(super) fn chain(
        &self,
        size: [u32; 2],
        converting: bool,
        old: Option<&Chain>,
    ) -> Result<Option<Chain>, GpuError> {
        let (device, physical) = (self.context.device.clone(), self.context.physical);
        // SAFETY: device and surface belong to one instance.
        let (able, formats) = unsafe {
            (
                self.surfaces
                    .get_physical_device_surface_capabilities(physical, self.handle)
                    .named("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", "window")?,
                self.surfaces
                    .get_physical_device_surface_formats(physical, self.handle)
                    .named("vkGetPhysicalDeviceSurfaceFormatsKHR", "window")?,
            )
        };
        let extent = match able.current_extent.width {
            u32::MAX => [
                size[0].clamp(able.min_image_extent.width, able.max_image_extent.width),
                size[1].clamp(able.min_image_extent.height, able.max_image_extent.height),
            ],
            _ => [able.current_extent.width, able.current_extent.height],
        };
        if extent[0] == 0 || extent[1] == 0 || size[0] == 0 || size[1] == 0 {
            return Ok(None);
        }
        let blits = |format| {
            // SAFETY: the device is alive.
            let able = unsafe { self.context.instance.handle.get_physical_device_format_properties(physical, format) };
            able.optimal_tiling_features.contains(vk::FormatFeatureFlags::BLIT_DST)
        };
        let (format, way) = choose_format(&formats, converting, blits)?;
        let mut count = able.min_image_count + 1;
        if able.max_image_count != 0 {
            count = count.min(able.max_image_count);
        }
        let mut usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST;
        let mut readable = able.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_SRC);
        if readable {
            usage |= vk::ImageUsageFlags::TRANSFER_SRC;
        }
        let mut drawn_in = format.format;
        let mut between = None;
        if let Way::Copied(plain) | Way::Blitted(plain) = way {
            (drawn_in, readable) = (plain, true);
            let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
                | vk::ImageUsageFlags::TRANSFER_DST
                | vk::ImageUsageFlags::TRANSFER_SRC;
            let one = vk::SampleCountFlags::TYPE_1;
            let image = Image::new(&self.context, "window before conversion", extent, plain, one, usage)?;
            between = Some(Between { image, way });
        }
        let alpha = [
            vk::CompositeAlphaFlagsKHR::OPAQUE,
            vk::CompositeAlphaFlagsKHR::INHERIT,
            vk::CompositeAlphaFlagsKHR::PRE_MULTIPLIED,
        ];
        let alpha = alpha.into_iter().find(|&a| able.supported_composite_alpha.contains(a));
        let info = vk::SwapchainCreateInfoKHR::builder()
            .surface(self.handle)
            .min_image_count(count)
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(vk::Extent2D { width: extent[0], height: extent[1] })
            .image_array_layers(1)
            .image_usage(usage)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(able.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE))
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old.map_or(vk::SwapchainKHR::null(), |c| c.handle));
        // SAFETY: the old swapchain belongs to this surface; all pointers live until the call returns.
        let handle =
            unsafe { self.swapchains.create_swapchain(&info, None) }.named("vkCreateSwapchainKHR", "window")?;
        let mut chain = Chain {
            handle,
            images: Vec::new(),
            drawn: Vec::new(),
            extent,
            between,
            format: drawn_in,
            readable: readable && bytes_order(drawn_in).is_some(),
            announced: false,
        };
        // SAFETY: as above; after wait-idle nothing uses the old images.
        unsafe {
            chain.images = self.swapchains.get_swapchain_images(handle).named("vkGetSwapchainImagesKHR", "window")?;
            device.device_wait_idle().named("vkDeviceWaitIdle", "window")?;
        }
        for _ in &chain.images {
            chain.drawn.push(semaphore(&self.context, "image drawn")?);
        }
        Ok(Some(chain))
    }

    /// Destroys a swapchain that nothing uses any more.
    pub(super) fn discard(&self, chain: Option<Chain>) {
        let Some(chain) = chain else { return };
        // SAFETY: the device is idle; the images' views in egui-ash are replaced before it draws again.
        unsafe {
            chain.drawn.iter().for_each(|&s| self.context.device.destroy_semaphore(s, None));
            self.swapchains.destroy_swapchain(chain.handle, None);
        }
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: its swapchains are gone.
        unsafe { self.surfaces.destroy_surface(self.handle, None) };
    }
}

/// A semaphore that is not signalled.
pub(super) fn semaphore(context: &Context, name: &str) -> Result<vk::Semaphore, GpuError> {
    // SAFETY: the device is alive.
    let made = unsafe { context.device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
        .named("vkCreateSemaphore", name)?;
    context.name(made, name);
    Ok(made)
}
