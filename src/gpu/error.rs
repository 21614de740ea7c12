//! What can go wrong, naming the call and the object.

use ash::vk;

/// An error of the GPU room. [`GpuError::is_request`] tells a wrong request (exit status 2) from a machine that failed
/// (exit status 1).
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// The Vulkan loader library could not be opened or is too old.
    #[error("no Vulkan loader: {0}; install one (Debian: libvulkan1)")]
    Loader(String),
    /// Validation was asked for and the layer is not installed.
    #[error("VK_LAYER_KHRONOS_validation is not installed; install it (Debian: vulkan-validationlayers) or leave validation off")]
    NoValidation,
    /// There is no Vulkan device at all.
    #[error("no Vulkan device; install a driver (Debian: mesa-vulkan-drivers has a software one)")]
    NoDevice,
    /// No device has the name or index asked for.
    #[error("no device '{asked}'; there are: {have}")]
    UnknownDevice {
        /// What was asked for.
        asked: String,
        /// Indices and names of the devices there are.
        have: String,
    },
    /// The device lacks something that is needed.
    #[error("device '{device}' lacks {missing}; choose another (`gradtess devices` lists them)")]
    Lacks {
        /// Name of the device.
        device: String,
        /// Features and limits, separated by commas.
        missing: String,
    },
    /// A Vulkan call failed.
    #[error("{call} of {object}: {result}")]
    Call {
        /// Name of the Vulkan call.
        call: &'static str,
        /// Name of the object.
        object: String,
        /// What it returned.
        result: vk::Result,
    },
    /// Memory could not be allocated or mapped.
    #[error("memory for {object}: {what}")]
    Memory {
        /// Name of the object.
        object: String,
        /// What the allocator said.
        what: String,
    },
    /// The request cannot be met by this device, or makes no sense.
    #[error("{0}")]
    Request(String),
}

impl GpuError {
    /// True when the request was wrong (exit status 2), false when the machine failed (exit status 1).
    pub fn is_request(&self) -> bool {
        matches!(self, GpuError::Request(_) | GpuError::UnknownDevice { .. })
    }
}

/// Gives a Vulkan result its call and object.
pub(super) trait Named<T> {
    fn named(self, call: &'static str, object: &str) -> Result<T, GpuError>;
}

impl<T> Named<T> for Result<T, vk::Result> {
    fn named(self, call: &'static str, object: &str) -> Result<T, GpuError> {
        self.map_err(|result| GpuError::Call { call, object: object.to_owned(), result })
    }
}
