//! Frames in a window, and what the widgets' renderer (egui-ash) needs to draw them.
//!
//! The scene is drawn off-screen by the same [`Canvas`] as every other picture, and its image is shown by the widgets'
//! pass as a texture: what is seen is what `render` writes, and its times are those of `bench`.

use super::context::{Commands, Context, SharedAllocator};
use super::device;
use super::error::{GpuError, Named};
use super::hand_over::{clear, copy, hand_over};
use super::instance::Instance;
use super::memory::Buffer;
use super::pipeline::Pipelines;
use super::surface_format::picture;
use super::swapchain::{semaphore, Chain, Surface};
use super::{Canvas, Gpu, GpuOptions};
use crate::image::Picture;
use ash::extensions::khr;
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
    surface: Surface,
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
        let surfaces = khr::Surface::new(&instance.entry, &instance.handle);
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
            let all = device::presenting(all, &surfaces, surface, &instance);
            device::choose(all, options.device.as_deref())
        });
        let candidate = match opened {
            Ok(candidate) => candidate,
            Err(e) => {
                // SAFETY: nothing was made of the surface.
                unsafe { surfaces.destroy_surface(surface, None) };
                return Err(e);
            }
        };
        let context = Rc::new(Context::new(instance, candidate, true)?);
        let gpu = Gpu { pipelines: Pipelines::new(&context)?, context };
        let swapchains = khr::Swapchain::new(&gpu.context.instance.handle, &gpu.context.device);
        let surface = Surface { context: Rc::clone(&gpu.context), surfaces, swapchains, handle: surface };
        let screen = Screen::new(&gpu.context, surface, converting)?;
        Ok((gpu, screen))
    }
}

impl Screen {
    fn new(context: &Rc<Context>, surface: Surface, converting: bool) -> Result<Screen, GpuError> {
        let mut screen = Screen {
            commands: Commands::new(context, "window")?,
            context: Rc::clone(context),
            surface,
            chain: None,
            stale: false,
            acquired: vk::Semaphore::null(),
            sampler: vk::Sampler::null(),
            kept: Vec::new(),
            converting,
            suspended: false,
        };
        screen.acquired = semaphore(context, "image acquired")?;
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

    /// What egui-ash needs of the device.
    pub fn render_state(&self) -> AshRenderState<SharedAllocator> {
        let context = &self.context;
        AshRenderState {
            entry: context.instance.entry.clone(),
            instance: context.instance.handle.clone(),
            physical_device: context.physical,
            device: context.device.clone(),
            surface_loader: self.surface.surfaces.clone(),
            swapchain_loader: self.surface.swapchains.clone(),
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
            self.surface.discard(chain);
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
        let acquired = unsafe {
            self.surface.swapchains.acquire_next_image(chain.handle, u64::MAX, self.acquired, vk::Fence::null())
        };
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
        match unsafe { self.surface.swapchains.queue_present(context.queue, &info) } {
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
        let Some(chain) = self.surface.chain(size, self.converting, self.chain.as_ref())? else { return Ok(false) };
        let old = self.chain.replace(chain);
        self.surface.discard(old);
        self.stale = false;
        Ok(true)
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
            self.surface.discard(chain);
            self.context.device.destroy_semaphore(self.acquired, None);
            self.context.device.destroy_sampler(self.sampler, None);
        }
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
