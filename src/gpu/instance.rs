//! The Vulkan instance, and the messenger that collects what the validation layer says.
//!
//! The layer prints nothing without a messenger (seen with layer 1.3.239), so asking for validation always installs one.

use super::error::{GpuError, Named};
use ash::extensions::ext::DebugUtils;
use ash::vk;
use std::ffi::{c_void, CStr, CString};
use std::sync::{Mutex, PoisonError};

/// Something that the validation layer reported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// True: an error. False: a warning.
    pub error: bool,
    /// Message id, such as `VUID-VkBufferCreateInfo-size-00912`.
    pub id: String,
    /// The whole text.
    pub text: String,
}

impl std::fmt::Display for Message {
    /// The text in one line; it names the id.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let line = self.text.split_whitespace().collect::<Vec<_>>().join(" ");
        f.write_str(&line)
    }
}

type Log = Mutex<Vec<Message>>;

pub(super) struct Instance {
    // Holds the loader's library open.
    pub entry: ash::Entry,
    pub handle: ash::Instance,
    /// Present when the loader has the extension: names, labels, and with validation the messenger.
    pub debug: Option<DebugUtils>,
    /// Version asked for: 1.1, or 1.2 where the loader has it.
    pub api: u32,
    messenger: vk::DebugUtilsMessengerEXT,
    // Boxed: the messenger holds its address.
    log: Box<Log>,
}

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

impl Instance {
    /// `surface`: the instance extensions that a window system needs.
    pub fn new(validate: bool, surface: &[CString]) -> Result<Instance, GpuError> {
        // SAFETY: loading a library runs its initialisers; the system's Vulkan loader is trusted.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| GpuError::Loader(e.to_string()))?;
        let version = entry
            .try_enumerate_instance_version()
            .named("vkEnumerateInstanceVersion", "loader")?
            .unwrap_or(vk::API_VERSION_1_0);
        if version < vk::API_VERSION_1_1 {
            return Err(GpuError::Loader("it knows Vulkan 1.0 only, 1.1 is needed".to_owned()));
        }
        let api = version.min(vk::API_VERSION_1_2);

        let mut layers = Vec::new();
        if validate {
            let known =
                entry.enumerate_instance_layer_properties().named("vkEnumerateInstanceLayerProperties", "loader")?;
            if !known.iter().any(|layer| name_of(&layer.layer_name) == VALIDATION) {
                return Err(GpuError::NoValidation);
            }
            layers.push(VALIDATION.as_ptr());
        }
        let mut extensions = entry
            .enumerate_instance_extension_properties(None)
            .named("vkEnumerateInstanceExtensionProperties", "loader")?;
        if validate {
            extensions.extend(
                entry
                    .enumerate_instance_extension_properties(Some(VALIDATION))
                    .named("vkEnumerateInstanceExtensionProperties", "validation layer")?,
            );
        }
        let has = |name: &CStr| extensions.iter().any(|e| name_of(&e.extension_name) == name);
        let debug_utils = has(DebugUtils::name());
        let mut names = Vec::new();
        if debug_utils {
            names.push(DebugUtils::name().as_ptr());
        }
        if validate && has(vk::ExtValidationFeaturesFn::name()) {
            names.push(vk::ExtValidationFeaturesFn::name().as_ptr());
        }
        for name in surface {
            if !has(name) {
                return Err(GpuError::Loader(format!("it cannot show windows: {} is missing", name.to_string_lossy())));
            }
            names.push(name.as_ptr());
        }

        let application =
            vk::ApplicationInfo::builder().application_name(c"gradtess").application_version(1).api_version(api);
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::builder().enabled_validation_features(&enabled);
        let mut info = vk::InstanceCreateInfo::builder()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&names);
        if validate {
            info = info.push_next(&mut features);
        }
        // SAFETY: every pointer in `info` lives until the call returns; layers and extensions were found to exist.
        let handle = match unsafe { entry.create_instance(&info, None) } {
            // What the loader says when it finds no driver at all.
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => return Err(GpuError::NoDevice),
            made => made.named("vkCreateInstance", "gradtess")?,
        };

        let mut instance = Instance {
            debug: debug_utils.then(|| DebugUtils::new(&entry, &handle)),
            entry,
            handle,
            api,
            messenger: vk::DebugUtilsMessengerEXT::null(),
            log: Box::default(),
        };
        if let (true, Some(debug)) = (validate, &instance.debug) {
            let log: *const Log = &*instance.log;
            let info = vk::DebugUtilsMessengerCreateInfoEXT::builder()
                .message_severity(
                    vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
                )
                // Not GENERAL: that is the loader talking about drivers it skips.
                .message_type(
                    vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
                )
                .pfn_user_callback(Some(collect))
                .user_data(log.cast_mut().cast::<c_void>());
            // SAFETY: the log is boxed and outlives the messenger (see Drop); the callback matches its type.
            instance.messenger = unsafe { debug.create_debug_utils_messenger(&info, None) }
                .named("vkCreateDebugUtilsMessengerEXT", "messenger")?;
        }
        Ok(instance)
    }

    /// Everything reported so far, oldest first.
    pub fn messages(&self) -> Vec<Message> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Empties the log and returns what was in it.
    pub fn take_messages(&self) -> Vec<Message> {
        std::mem::take(&mut *self.log.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Puts messages that were taken before everything in the log.
    pub fn put_back(&self, messages: Vec<Message>) {
        self.log.lock().unwrap_or_else(PoisonError::into_inner).splice(0..0, messages);
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: everything made from the instance is gone (the device is destroyed before, see `Context`); the log
        // field lives until after this body.
        unsafe {
            if let (Some(debug), true) = (&self.debug, self.messenger != vk::DebugUtilsMessengerEXT::null()) {
                debug.destroy_debug_utils_messenger(self.messenger, None);
            }
            self.handle.destroy_instance(None);
        }
    }
}

/// The text of a fixed-size name that the driver filled in.
pub(super) fn name_of(chars: &[std::ffi::c_char]) -> &CStr {
    // SAFETY: Vulkan ends these arrays with a zero.
    unsafe { CStr::from_ptr(chars.as_ptr()) }
}

/// A name for Vulkan; a zero byte inside ends it.
pub(super) fn c_name(name: &str) -> CString {
    let end = name.find('\0').unwrap_or(name.len());
    CString::new(&name[..end]).unwrap_or_default()
}

unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `data` is valid during the callback; `log` is the boxed log of the instance, which outlives the messenger.
    let (data, log) = unsafe { (&*data, &*log.cast::<Log>()) };
    let text = |p: *const std::ffi::c_char| {
        if p.is_null() {
            String::new()
        } else {
            // SAFETY: Vulkan strings end with a zero.
            unsafe { CStr::from_ptr(p) }.to_string_lossy().into_owned()
        }
    };
    log.lock().unwrap_or_else(PoisonError::into_inner).push(Message {
        error: severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR),
        id: text(data.p_message_id_name),
        text: text(data.p_message),
    });
    vk::FALSE
}
