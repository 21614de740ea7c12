//! A window's swapchain, and what the widgets' renderer (egui-ash) needs to draw into it.
//!
//! The scene is drawn off-screen by the same [`Canvas`] as every other picture, and its image is shown by the widgets'
//! pass as a texture: what is seen is what `render` writes, and its times are those of `bench`.

use super::context::{Commands, Context, SharedAllocator};
use super::device;
use super::error::{GpuError, Named};
use super::instance::Instance;
use super::memory::{Buffer, Image, COLOUR_RANGE};
use super::pipeline::Pipelines;
use super::{Canvas, Gpu, GpuOptions};
use crate::image::Picture;
use ash::extensions::khr::{Surface, Swapchain};
use ash::vk;
use egui_ash::raw_window_handle::{HasRawDisplayHandle, HasRawWindowHandle};
use egui_ash::{winit, AshRenderState, EguiCommand, SwapchainUpdateInfo};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc};
use gpu_allocator::MemoryLocation;
use std::ffi::CString;
use std::rc::Rc;

/// A window's surface with its swapchain.
pub struct Screen {
    context: Rc<Context>,
    surface_loader: Surface,
    loader: Swapchain,
    surface: vk::SurfaceKHR,
    chain: Option<Chain>,
    stale: bool,
    commands: Commands,
    acquired: vk::Semaphore,
    sampler: vk::Sampler,
    // Widgets that could not be shown yet: they bring textures with them, so none may be left out.
    kept: Vec<EguiCommand>,
    converting: bool,
    suspended: bool,
}

/// A swapchain and what belongs to its images.
struct Chain {
    handle: vk::SwapchainKHR,
    images: Vec<vk::Image>,
    // Of each image: signalled when it is drawn.
    drawn: Vec<vk::Semaphore>,
    extent: [u32; 2],
    // Where the widgets are drawn when the images' own format would convert their colours.
    between: Option<Between>,
    // Format and readability of what the widgets are drawn to.
    format: vk::Format,
    readable: bool,
    // Whether the widgets' renderer knows these images.
    announced: bool,
}

/// An image in a format that keeps colours as they are, and how it gets to the swapchain's.
struct Between {
    image: Image,
    way: Way,
}

/// How widgets get into the swapchain's images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// They are drawn there.
    Straight,
    /// Byte for byte out of an image of this format, which differs from theirs in how bytes are read only.
    Copied(vk::Format),
    /// Out of an image of this format, value for value.
    Blitted(vk::Format),
}

/// What became of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It is on the screen; with the picture, when one was asked for.
    Shown(Option<Picture>),
    /// There was nothing to show it on just now: minimised, or resized a moment ago.
    Later,
}

impl Gpu {
    /// Opens a device that can show frames in `window`; `extensions` are the instance extensions for that. With
    /// `converting` only surface formats that convert to sRGB are taken, as on devices that offer no others.
    ///
    /// # Errors
    /// As [`Gpu::new`]; or the device cannot present.
    pub fn for_window(
        options: &GpuOptions,
        extensions: &[CString],
        window: &winit::window::Window,
        converting: bool,
    ) -> Result<(Gpu, Screen), GpuError> {
        let instance = Instance::new(options.validate, extensions)?;
        let surface_loader = Surface::new(&instance.entry, &instance.handle);
        // SAFETY: the extensions for this display are enabled; the window outlives the surface (egui-ash drops the
        // window after its exit event, upon which the screen is dropped).
        let surface = unsafe {
            ash_window::create_surface(
                &instance.entry,
                &instance.handle,
                window.raw_display_handle(),
                window.raw_window_handle(),
                None,
            )
        }
        .named("vkCreateSurfaceKHR", "window")?;
        let opened = device::list(&instance).and_then(|all| {
            let all = device::presenting(all, &surface_loader, surface, &instance);
            device::choose(all, options.device.as_deref())
        });
        let candidate = match opened {
            Ok(candidate) => candidate,
            Err(e) => {
                // SAFETY: nothing was made of the surface.
                unsafe { surface_loader.destroy_surface(surface, None) };
                return Err(e);
            }
        };
        let context = Rc::new(Context::new(instance, candidate, true)?);
        let gpu = Gpu { pipelines: Pipelines::new(&context)?, context };
        let mut screen = Screen::new(&gpu.context, surface_loader, surface)?;
        screen.converting = converting;
        Ok((gpu, screen))
    }
}

impl Screen {
    fn new(context: &Rc<Context>, surface_loader: Surface, surface: vk::SurfaceKHR) -> Result<Screen, GpuError> {
        let mut screen = Screen {
            loader: Swapchain::new(&context.instance.handle, &context.device),
            commands: Commands::new(context, "window")?,
            context: Rc::clone(context),
            surface_loader,
            surface,
            chain: None,
            stale: false,
            acquired: vk::Semaphore::null(),
            sampler: vk::Sampler::null(),
            kept: Vec::new(),
            converting: false,
            suspended: false,
        };
        screen.acquired = screen.semaphore("image acquired")?;
        // The image has the pixels of its place in the window one by one.
        let info = vk::SamplerCreateInfo::builder()
            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE);
        // SAFETY: the device is alive.
        screen.sampler =
            unsafe { context.device.create_sampler(&info, None) }.named("vkCreateSampler", "scene in window")?;
        context.name(screen.sampler, "scene in window");
        Ok(screen)
    }

    fn semaphore(&self, name: &str) -> Result<vk::Semaphore, GpuError> {
        // SAFETY: the device is alive.
        let made = unsafe { self.context.device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
            .named("vkCreateSemaphore", name)?;
        self.context.name(made, name);
        Ok(made)
    }

    /// What egui-ash needs of the device.
    pub fn render_state(&self) -> AshRenderState<SharedAllocator> {
        let context = &self.context;
        AshRenderState {
            entry: context.instance.entry.clone(),
            instance: context.instance.handle.clone(),
            physical_device: context.physical,
            device: context.device.clone(),
            surface_loader: self.surface_loader.clone(),
            swapchain_loader: self.loader.clone(),
            queue: context.queue,
            queue_family_index: context.queue_family,
            command_pool: context.pool,
            allocator: context.allocator.clone(),
        }
    }

    /// The picture of a canvas as a texture for the widgets' renderer, good after [`super::PreparedFrame::run_to_show`]
    /// and as long as the canvas lives.
    pub fn texture(&self, canvas: &Canvas) -> (vk::ImageView, vk::Sampler) {
        (canvas.view(), self.sampler)
    }

    /// The window has another size.
    pub fn resized(&mut self) {
        self.stale = true;
    }

    /// The system takes the window's pixels away (`true`), or gives them back. The swapchain goes with them.
    pub fn suspend(&mut self, on: bool) {
        self.suspended = on;
        self.stale = true;
        if on {
            let chain = self.chain.take();
            // SAFETY: the device is alive.
            let _ = unsafe { self.context.device.device_wait_idle() };
            self.discard(chain);
        }
    }

    /// Shows a frame of widgets in a window of `size` pixels and waits until it is drawn; `read` asks for its pixels.
    ///
    /// # Errors
    /// A call failed; the surface or the device is lost.
    pub fn show(&mut self, size: [u32; 2], widgets: EguiCommand, read: bool) -> Result<Outcome, GpuError> {
        self.kept.push(widgets);
        if self.suspended {
            return Ok(Outcome::Later);
        }
        let stale = self.stale || self.chain.as_ref().is_none_or(|c| c.extent != size);
        if stale && !self.remake(size)? {
            return Ok(Outcome::Later);
        }
        let Some(chain) = &mut self.chain else { return Ok(Outcome::Later) };
        // SAFETY: the semaphore is unsignalled: every frame that waited for it was waited for.
        let acquired =
            unsafe { self.loader.acquire_next_image(chain.handle, u64::MAX, self.acquired, vk::Fence::null()) };
        let index = match acquired {
            Ok((index, suboptimal)) => {
                self.stale |= suboptimal;
                index
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.stale = true;
                return Ok(Outcome::Later);
            }
            Err(e) => return Err(e).named("vkAcquireNextImageKHR", "window"),
        };
        let mut widgets = std::mem::take(&mut self.kept);
        if let (false, Some(last)) = (chain.announced, widgets.last_mut()) {
            last.update_swapchain(SwapchainUpdateInfo {
                width: chain.extent[0],
                height: chain.extent[1],
                swapchain_images: match &chain.between {
                    Some(between) => vec![between.image.handle; chain.images.len()],
                    None => chain.images.clone(),
                },
                surface_format: chain.format,
            });
            chain.announced = true;
        }
        let pixels = match read && chain.readable {
            true => Some(Buffer::new(
                &self.context,
                "window pixels",
                4 * u64::from(chain.extent[0]) * u64::from(chain.extent[1]),
                vk::BufferUsageFlags::TRANSFER_DST,
                MemoryLocation::GpuToCpu,
            )?),
            false => None,
        };
        let (shown, drawn) = (chain.images[index as usize], chain.drawn[index as usize]);
        let image = chain.between.as_ref().map_or(shown, |b| b.image.handle);
        let context = &self.context;
        self.commands.run_between(Some(self.acquired), Some(drawn), |commands| {
            let count = widgets.len();
            for (i, frame) in widgets.into_iter().enumerate() {
                // Each frame of widgets loads what is there and leaves it ready to present.
                clear(context, commands, image);
                frame.record(commands, index as usize);
                debug_assert!(i < count);
            }
            if let Some(pixels) = &pixels {
                copy(context, commands, image, chain.extent, pixels);
            }
            if let Some(between) = &chain.between {
                hand_over(context, commands, [image, shown], chain.extent, between.way);
            }
            Ok(())
        })?;
        let (waits, chains, indices) = ([drawn], [chain.handle], [index]);
        let info = vk::PresentInfoKHR::builder().wait_semaphores(&waits).swapchains(&chains).image_indices(&indices);
        // SAFETY: the image was acquired, is in the layout for presenting, and the semaphore is signalled by its drawing.
        match unsafe { self.loader.queue_present(context.queue, &info) } {
            Ok(suboptimal) => self.stale |= suboptimal,
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.stale = true,
            Err(e) => return Err(e).named("vkQueuePresentKHR", "window"),
        }
        let picture = match &pixels {
            Some(pixels) => Some(picture(pixels.bytes()?, chain.extent, chain.format)),
            None => None,
        };
        Ok(Outcome::Shown(picture))
    }

    /// Makes the swapchain anew. `false`: the window has no pixels.
    fn remake(&mut self, size: [u32; 2]) -> Result<bool, GpuError> {
        let (device, physical) = (self.context.device.clone(), self.context.physical);
        // SAFETY: device and surface belong to one instance.
        let (able, formats) = unsafe {
            (
                self.surface_loader
                    .get_physical_device_surface_capabilities(physical, self.surface)
                    .named("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", "window")?,
                self.surface_loader
                    .get_physical_device_surface_formats(physical, self.surface)
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
            return Ok(false);
        }
        let blits = |format| {
            // SAFETY: the device is alive.
            let able = unsafe { self.context.instance.handle.get_physical_device_format_properties(physical, format) };
            able.optimal_tiling_features.contains(vk::FormatFeatureFlags::BLIT_DST)
        };
        let (format, way) = choose_format(&formats, self.converting, blits)?;
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
            .surface(self.surface)
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
            .old_swapchain(self.chain.as_ref().map_or(vk::SwapchainKHR::null(), |c| c.handle));
        // SAFETY: the old swapchain belongs to this surface; all pointers live until the call returns.
        let handle = unsafe { self.loader.create_swapchain(&info, None) }.named("vkCreateSwapchainKHR", "window")?;
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
            chain.images = self.loader.get_swapchain_images(handle).named("vkGetSwapchainImagesKHR", "window")?;
            device.device_wait_idle().named("vkDeviceWaitIdle", "window")?;
        }
        for _ in &chain.images {
            chain.drawn.push(self.semaphore("image drawn")?);
        }
        let old = self.chain.replace(chain);
        self.discard(old);
        self.stale = false;
        Ok(true)
    }

    fn discard(&self, chain: Option<Chain>) {
        let Some(chain) = chain else { return };
        // SAFETY: the device is idle; the images' views in egui-ash are replaced before it draws again.
        unsafe {
            chain.drawn.iter().for_each(|&s| self.context.device.destroy_semaphore(s, None));
            self.loader.destroy_swapchain(chain.handle, None);
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // Closures of egui-ash must not outlive it.
        self.kept.clear();
        let chain = self.chain.take();
        // SAFETY: nothing runs after wait-idle.
        unsafe {
            let _ = self.context.device.device_wait_idle();
            self.discard(chain);
            self.context.device.destroy_semaphore(self.acquired, None);
            self.context.device.destroy_sampler(self.sampler, None);
            self.surface_loader.destroy_surface(self.surface, None);
        }
    }
}

/// A surface format, and how colours get there as they are, for they are sRGB already: drawn at best; else drawn in a
/// format without conversion and copied, or blitted where the device `blits` to the format.
fn choose_format(
    formats: &[vk::SurfaceFormatKHR],
    converting: bool,
    blits: impl Fn(vk::Format) -> bool,
) -> Result<(vk::SurfaceFormatKHR, Way), GpuError> {
    use vk::Format as F;
    let straight = [
        F::B8G8R8A8_UNORM,
        F::R8G8B8A8_UNORM,
        F::A8B8G8R8_UNORM_PACK32,
        F::A2B10G10R10_UNORM_PACK32,
        F::A2R10G10B10_UNORM_PACK32,
        F::R5G6B5_UNORM_PACK16,
    ];
    let twins = [
        (F::B8G8R8A8_SRGB, F::B8G8R8A8_UNORM),
        (F::R8G8B8A8_SRGB, F::R8G8B8A8_UNORM),
        (F::A8B8G8R8_SRGB_PACK32, F::A8B8G8R8_UNORM_PACK32),
    ];
    if let Some(any) = formats.iter().find(|f| f.format == F::UNDEFINED) {
        let format = if converting { twins[0].0 } else { straight[0] };
        let way = if converting { Way::Copied(twins[0].1) } else { Way::Straight };
        return Ok((vk::SurfaceFormatKHR { format, color_space: any.color_space }, way));
    }
    let plain = || formats.iter().filter(|f| f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR);
    let find = |wanted: F| plain().find(|f| f.format == wanted).copied();
    if !converting {
        if let Some(found) = straight.into_iter().find_map(find) {
            return Ok((found, Way::Straight));
        }
    }
    if let Some((found, unorm)) = twins.into_iter().find_map(|(srgb, unorm)| Some((find(srgb)?, unorm))) {
        return Ok((found, Way::Copied(unorm)));
    }
    // Values are converted between number types, not between colour spaces.
    let rest = plain().find(|f| !straight.contains(&f.format) && blits(f.format));
    rest.map(|&found| (found, Way::Blitted(F::R8G8B8A8_UNORM))).ok_or_else(|| {
        GpuError::Request("the window takes no surface format of sRGB colours; choose another device".to_owned())
    })
}

/// Whether a format's bytes are blue, green, red, alpha (true) or red, green, blue, alpha; `None` for others.
fn bytes_order(format: vk::Format) -> Option<bool> {
    match format {
        vk::Format::B8G8R8A8_UNORM => Some(true),
        vk::Format::R8G8B8A8_UNORM | vk::Format::A8B8G8R8_UNORM_PACK32 => Some(false),
        _ => None,
    }
}

fn picture(bytes: &[u8], [width, height]: [u32; 2], format: vk::Format) -> Picture {
    let mut rgba = bytes.to_vec();
    for pixel in rgba.chunks_exact_mut(4) {
        if bytes_order(format) == Some(true) {
            pixel.swap(0, 2);
        }
        // Windows are opaque.
        pixel[3] = 255;
    }
    Picture { width, height, rgba }
}

/// Clears an image whatever it held, and leaves it as a colour attachment.
fn clear(context: &Context, commands: vk::CommandBuffer, image: vk::Image) {
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
fn copy(context: &Context, commands: vk::CommandBuffer, image: vk::Image, extent: [u32; 2], pixels: &Buffer) {
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
fn hand_over(
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

impl egui_ash::Allocator for SharedAllocator {
    type Allocation = Allocation;
    type AllocationCreateInfo = AllocationCreateDesc<'static>;

    fn allocate(&self, desc: AllocationCreateDesc<'static>) -> anyhow::Result<Allocation> {
        let mut guard = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        Ok(guard.as_mut().ok_or_else(|| anyhow::anyhow!("the device is gone"))?.allocate(&desc)?)
    }

    fn free(&self, allocation: Allocation) -> anyhow::Result<()> {
        let mut guard = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(allocator) = guard.as_mut() {
            allocator.free(allocation)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(format: vk::Format) -> vk::SurfaceFormatKHR {
        vk::SurfaceFormatKHR { format, color_space: vk::ColorSpaceKHR::SRGB_NONLINEAR }
    }

    #[test]
    fn colours_are_never_converted() {
        let choose = |formats: &[vk::Format], converting| {
            let formats: Vec<_> = formats.iter().map(|&f| surface(f)).collect();
            let found = choose_format(&formats, converting, |f| f == vk::Format::R16G16B16A16_SFLOAT);
            found.map(|(f, way)| (f.format, way))
        };
        use vk::Format as F;
        let both = [F::B8G8R8A8_SRGB, F::R8G8B8A8_UNORM];
        assert_eq!(choose(&both, false).unwrap(), (F::R8G8B8A8_UNORM, Way::Straight));
        assert_eq!(choose(&both, true).unwrap(), (F::B8G8R8A8_SRGB, Way::Copied(F::B8G8R8A8_UNORM)));
        let two = [F::R8G8B8A8_UNORM, F::B8G8R8A8_UNORM];
        assert_eq!(choose(&two, false).unwrap(), (F::B8G8R8A8_UNORM, Way::Straight));
        assert!(choose(&two, true).unwrap_err().is_request());
        assert_eq!(choose(&[F::UNDEFINED], false).unwrap(), (F::B8G8R8A8_UNORM, Way::Straight));
        assert_eq!(choose(&[F::R8G8B8A8_SRGB], false).unwrap().1, Way::Copied(F::R8G8B8A8_UNORM));
        let float = choose(&[F::R16G16B16A16_SFLOAT], false).unwrap();
        assert_eq!(float, (F::R16G16B16A16_SFLOAT, Way::Blitted(F::R8G8B8A8_UNORM)));
        assert!(choose(&[F::R8G8_UNORM], false).unwrap_err().is_request());
        assert_eq!(picture(&[1, 2, 3, 4], [1, 1], F::B8G8R8A8_UNORM).rgba, [3, 2, 1, 255]);
        assert_eq!(picture(&[1, 2, 3, 4], [1, 1], F::R8G8B8A8_UNORM).rgba, [1, 2, 3, 255]);
    }
}
