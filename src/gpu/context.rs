//! The logical device with its queue, command pool and allocator: what every object needs to be made and destroyed.

use super::device::{Candidate, DeviceInfo, Optional};
use super::error::{GpuError, Named};
use super::fault::Faults;
use super::instance::{c_name, Instance};
use ash::extensions::ext::CalibratedTimestamps;
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::rc::Rc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// The allocator, until the device goes.
#[derive(Clone, Default)]
pub struct SharedAllocator(pub(super) Arc<Mutex<Option<Allocator>>>);

pub(super) struct Context {
    pub device: ash::Device,
    pub queue: vk::Queue,
    pub optional: Optional,
    pub info: DeviceInfo,
    pub physical: vk::PhysicalDevice,
    /// Present when the device has the extension.
    pub calibrated: Option<CalibratedTimestamps>,
    pub queue_family: u32,
    pub faults: Faults,
    pub(super) pool: vk::CommandPool,
    // Emptied in Drop, before the device goes. Shared with what draws the editor's widgets.
    pub allocator: SharedAllocator,
    // Last: dropped after the body of Drop has destroyed the device.
    pub instance: Instance,
}

/// Host time of one submission, ns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Submission {
    pub record_ns: u64,
    pub submit_ns: u64,
    pub wait_ns: u64,
}

impl Context {
    /// `present`: whether frames go to a window.
    pub fn new(instance: Instance, candidate: Candidate, present: bool) -> Result<Context, GpuError> {
        let Candidate { handle, queue_family, optional, info } = candidate;
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::builder()
            .queue_family_index(queue_family)
            .queue_priorities(&priorities)
            .build()];
        let features = vk::PhysicalDeviceFeatures::builder()
            .tessellation_shader(true)
            .fill_mode_non_solid(optional.wire)
            .pipeline_statistics_query(optional.statistics)
            .vertex_pipeline_stores_and_atomics(optional.readback);
        let mut extensions = Vec::new();
        if optional.calibrated {
            extensions.push(vk::ExtCalibratedTimestampsFn::name().as_ptr());
        }
        if present {
            extensions.push(ash::extensions::khr::Swapchain::name().as_ptr());
        }
        let create = vk::DeviceCreateInfo::builder()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features);
        // SAFETY: the queue family and the features were found on this very device; the pointers live until the call returns.
        let device =
            unsafe { instance.handle.create_device(handle, &create, None) }.named("vkCreateDevice", &info.name)?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.handle.clone(),
            device: device.clone(),
            physical_device: handle,
            debug_settings: gpu_allocator::AllocatorDebugSettings {
                log_leaks_on_shutdown: false,
                ..Default::default()
            },
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        });
        // SAFETY: one queue of this family was asked for; the pool info is valid.
        let (queue, pool) = unsafe {
            let info = vk::CommandPoolCreateInfo::builder()
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
                .queue_family_index(queue_family);
            (device.get_device_queue(queue_family, 0), device.create_command_pool(&info, None))
        };
        let mut context = Context {
            device,
            queue,
            optional,
            info,
            physical: handle,
            calibrated: optional.calibrated.then(|| CalibratedTimestamps::new(&instance.entry, &instance.handle)),
            queue_family,
            faults: Faults::default(),
            pool: vk::CommandPool::null(),
            allocator: SharedAllocator::default(),
            instance,
        };
        context.pool = pool.named("vkCreateCommandPool", "gradtess")?;
        *context.allocator() =
            Some(allocator.map_err(|e| GpuError::Memory { object: "the allocator".to_owned(), what: e.to_string() })?);
        context.name(context.queue, "gradtess queue");
        context.name(context.pool, "gradtess commands");
        Ok(context)
    }

    /// The allocator, for as long as the guard lives.
    pub fn allocator(&self) -> MutexGuard<'_, Option<Allocator>> {
        self.allocator.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives an object its name in validation messages and captures.
    pub fn name<H: vk::Handle>(&self, handle: H, name: &str) {
        let Some(debug) = &self.instance.debug else {
            return;
        };
        let name = c_name(name);
        let info = vk::DebugUtilsObjectNameInfoEXT::builder()
            .object_type(H::TYPE)
            .object_handle(handle.as_raw())
            .object_name(&name);
        // SAFETY: the handle belongs to this device. A name that cannot be set is no loss.
        let _ = unsafe { debug.set_debug_utils_object_name(self.device.handle(), &info) };
    }

    /// Opens a debug label; [`Context::end_label`] closes it.
    pub fn begin_label(&self, commands: vk::CommandBuffer, name: &str) {
        let Some(debug) = &self.instance.debug else {
            return;
        };
        let name = c_name(name);
        let label = vk::DebugUtilsLabelEXT::builder().label_name(&name);
        // SAFETY: the buffer is being recorded.
        unsafe { debug.cmd_begin_debug_utils_label(commands, &label) };
    }

    /// Closes the innermost debug label.
    pub fn end_label(&self, commands: vk::CommandBuffer) {
        if let Some(debug) = &self.instance.debug {
            // SAFETY: the buffer is being recorded and a label is open.
            unsafe { debug.cmd_end_debug_utils_label(commands) };
        }
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: every object holds a reference to this context, so none is left but these; nothing runs after wait-idle.
        unsafe {
            let _ = self.device.device_wait_idle();
            *self.allocator() = None;
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
        }
    }
}

/// A command buffer with its fence. Recording, submitting and waiting are one call, so it never runs while it is dropped.
pub(super) struct Commands {
    context: Rc<Context>,
    buffer: vk::CommandBuffer,
    fence: vk::Fence,
    name: String,
}

impl Commands {
    /// A primary command buffer and its fence.
    pub fn new(context: &Rc<Context>, name: &str) -> Result<Commands, GpuError> {
        let info = vk::CommandBufferAllocateInfo::builder()
            .command_pool(context.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is alive.
        let buffer =
            unsafe { context.device.allocate_command_buffers(&info) }.named("vkAllocateCommandBuffers", name)?[0];
        let mut commands =
            Commands { context: Rc::clone(context), buffer, fence: vk::Fence::null(), name: name.to_owned() };
        // SAFETY: the device is alive.
        commands.fence = unsafe { context.device.create_fence(&vk::FenceCreateInfo::default(), None) }
            .named("vkCreateFence", name)?;
        context.name(commands.buffer, name);
        context.name(commands.fence, name);
        Ok(commands)
    }

    /// Records with `record`, submits and waits until the GPU is done.
    ///
    /// # Errors
    /// What `record` or a call returned. After a failed wait the device is idle or lost.
    pub fn run(&self, record: impl FnOnce(vk::CommandBuffer) -> Result<(), GpuError>) -> Result<Submission, GpuError> {
        self.run_between(None, None, record)
    }

    /// As [`Commands::run`], after `wait` (before anything is written to a colour attachment or copied) and with a signal
    /// to `then`.
    pub fn run_between(
        &self,
        wait: Option<vk::Semaphore>,
        then: Option<vk::Semaphore>,
        record: impl FnOnce(vk::CommandBuffer) -> Result<(), GpuError>,
    ) -> Result<Submission, GpuError> {
        let [record_ns, submit_ns] = self.submit(wait, then, record)?;
        Ok(Submission { record_ns, submit_ns, wait_ns: self.wait()? })
    }

    /// Records and submits; the times of both. [`Commands::wait`] has to follow before this is run again or dropped.
    ///
    /// # Errors
    /// As [`Commands::run`].
    pub fn submit(
        &self,
        wait: Option<vk::Semaphore>,
        then: Option<vk::Semaphore>,
        record: impl FnOnce(vk::CommandBuffer) -> Result<(), GpuError>,
    ) -> Result<[u64; 2], GpuError> {
        let device = &self.context.device;
        let start = Instant::now();
        let begin = vk::CommandBufferBeginInfo::builder().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: an earlier run of this buffer has finished; the pool allows its reset.
        unsafe { device.begin_command_buffer(self.buffer, &begin) }.named("vkBeginCommandBuffer", &self.name)?;
        let recorded = record(self.buffer);
        // SAFETY: recording was begun.
        unsafe { device.end_command_buffer(self.buffer) }.named("vkEndCommandBuffer", &self.name)?;
        recorded?;
        let record_ns = elapsed(start);
        self.context.faults.may_submit().named("vkQueueSubmit", &self.name)?;

        let start = Instant::now();
        let buffers = [self.buffer];
        let (waits, signals) = (wait.as_slice(), then.as_slice());
        let stages = [vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT | vk::PipelineStageFlags::TRANSFER];
        let submits = [vk::SubmitInfo::builder()
            .wait_semaphores(waits)
            .wait_dst_stage_mask(&stages[..waits.len()])
            .command_buffers(&buffers)
            .signal_semaphores(signals)
            .build()];
        // SAFETY: the fence is unsignalled, the buffer recorded; the arrays live until the call returns.
        unsafe {
            device.reset_fences(&[self.fence]).named("vkResetFences", &self.name)?;
            device.queue_submit(self.context.queue, &submits, self.fence).named("vkQueueSubmit", &self.name)?;
        }
        Ok([record_ns, elapsed(start)])
    }

    /// Waits until the GPU is done with what was submitted last; the time that took. After an error the device is idle or
    /// lost.
    ///
    /// # Errors
    /// The device is lost.
    pub fn wait(&self) -> Result<u64, GpuError> {
        let device = &self.context.device;
        let start = Instant::now();
        // SAFETY: the fence was submitted.
        let waited = unsafe { device.wait_for_fences(&[self.fence], true, u64::MAX) };
        if waited.is_err() {
            // SAFETY: nothing else uses the queue; after this the buffer may be freed.
            let _ = unsafe { device.device_wait_idle() };
        }
        waited.named("vkWaitForFences", &self.name)?;
        Ok(elapsed(start))
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // SAFETY: `run` waits, so the GPU has finished with both.
        unsafe {
            self.context.device.destroy_fence(self.fence, None);
            self.context.device.free_command_buffers(self.context.pool, &[self.buffer]);
        }
    }
}

fn elapsed(start: Instant) -> u64 {
    u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX)
}
