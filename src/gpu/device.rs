//! What devices there are, what they lack, and which one to take.

use super::error::{GpuError, Named};
use super::instance::{name_of, Instance};
use ash::vk;
use serde::Serialize;
use std::ffi::CStr;

/// A Vulkan device as `gradtess devices` and `run.json` show it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeviceInfo {
    /// Number to choose it by.
    pub index: usize,
    /// Name, as the driver gives it.
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: &'static str,
    /// Vulkan version, such as `1.3.230`.
    pub api: String,
    /// Name and description of the driver; empty where the device is older than Vulkan 1.2.
    pub driver: String,
    /// Name of the driver alone.
    pub driver_name: String,
    /// Its description alone.
    pub driver_info: String,
    /// The driver's own version number, undecoded.
    pub driver_version: u32,
    /// PCI vendor, or a Khronos id.
    pub vendor_id: u32,
    /// PCI device.
    pub device_id: u32,
    /// Bytes in all device-local heaps.
    pub device_local_bytes: u64,
    /// The limits that matter here.
    pub limits: Limits,
    /// What it lacks and gradtess cannot do without. Empty: the device can be used.
    pub missing: Vec<String>,
    /// What it lacks and gradtess can do without, and what is lost.
    pub without: Vec<String>,
}

/// Limits of a device that gradtess runs into.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Greatest width and height of a picture, pixels.
    pub max_image: [u32; 2],
    /// Greatest tessellation level.
    pub max_tessellation_level: u32,
    /// Most control points in a patch.
    pub max_patch_points: u32,
    /// Bytes of push constants.
    pub max_push_constants: u32,
    /// Greatest index value in an index buffer.
    pub max_index: u32,
    /// Bytes a storage buffer may have.
    pub max_storage_buffer: u32,
    /// Sample counts of a colour target, a bit each.
    pub colour_samples: u32,
    /// Nanoseconds a timestamp tick.
    pub timestamp_period_ns: f32,
    /// Valid bits of a timestamp; 0: no timestamps.
    pub timestamp_valid_bits: u32,
}

/// Features that are used where present.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Optional {
    pub wire: bool,
    pub statistics: bool,
    pub readback: bool,
    pub calibrated: bool,
}

/// A device that can be taken.
pub(super) struct Candidate {
    pub handle: vk::PhysicalDevice,
    pub queue_family: u32,
    pub optional: Optional,
    pub info: DeviceInfo,
}

/// The greatest patch: 20 points of a Gregory face and 8 of a transition part.
const PATCH_POINTS: u32 = 28;

/// All devices in the loader's order.
pub(super) fn list(instance: &Instance) -> Result<Vec<Candidate>, GpuError> {
    // SAFETY: the instance is alive.
    let handles =
        unsafe { instance.handle.enumerate_physical_devices() }.named("vkEnumeratePhysicalDevices", "gradtess")?;
    Ok(handles.into_iter().enumerate().map(|(index, handle)| examine(instance, index, handle)).collect())
}

fn examine(instance: &Instance, index: usize, handle: vk::PhysicalDevice) -> Candidate {
    // SAFETY: the handle comes from this instance.
    let (properties, features, memory, families) = unsafe {
        (
            instance.handle.get_physical_device_properties(handle),
            instance.handle.get_physical_device_features(handle),
            instance.handle.get_physical_device_memory_properties(handle),
            instance.handle.get_physical_device_queue_family_properties(handle),
        )
    };
    let limits = &properties.limits;
    let queue_family =
        families.iter().position(|f| f.queue_flags.contains(vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE));
    let colour = |format| {
        // SAFETY: as above.
        let found = unsafe { instance.handle.get_physical_device_format_properties(handle, format) };
        found
            .optimal_tiling_features
            .contains(vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND | vk::FormatFeatureFlags::TRANSFER_SRC)
    };

    let mut missing = Vec::new();
    let mut need = |present: bool, what: &str| {
        if !present {
            missing.push(what.to_owned());
        }
    };
    need(properties.api_version >= vk::API_VERSION_1_1, "Vulkan 1.1");
    need(queue_family.is_some(), "a queue for graphics and compute");
    need(features.tessellation_shader == vk::TRUE, "tessellationShader");
    need(limits.max_tessellation_generation_level >= 64, "tessellation level 64");
    need(limits.max_tessellation_patch_size >= PATCH_POINTS, "patches of 28 points");
    need(colour(vk::Format::R8G8B8A8_UNORM), "blending into R8G8B8A8_UNORM");
    need(colour(vk::Format::R32G32B32A32_SFLOAT), "blending into R32G32B32A32_SFLOAT");
    let optional = Optional {
        wire: features.fill_mode_non_solid == vk::TRUE,
        statistics: features.pipeline_statistics_query == vk::TRUE,
        readback: features.vertex_pipeline_stores_and_atomics == vk::TRUE,
        calibrated: has_extension(instance, handle, vk::ExtCalibratedTimestampsFn::name()),
    };
    let valid_bits = queue_family.map_or(0, |q| families[q].timestamp_valid_bits);
    let mut without = Vec::new();
    let mut lose = |present: bool, what: &str| {
        if !present {
            without.push(what.to_owned());
        }
    };
    lose(optional.wire, "fillModeNonSolid: no wireframe");
    lose(optional.statistics, "pipelineStatisticsQuery: no invocation counts");
    lose(optional.readback, "vertexPipelineStoresAndAtomics: no read-back of evaluated points");
    lose(valid_bits > 0, "timestamps: no GPU times");
    lose(optional.calibrated, "VK_EXT_calibrated_timestamps: GPU times are not on the host's clock");

    let (driver_name, driver_info) = driver(instance, handle, properties.api_version);
    let info = DeviceInfo {
        index,
        name: name_of(&properties.device_name).to_string_lossy().into_owned(),
        kind: match properties.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
            vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
            vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
            vk::PhysicalDeviceType::CPU => "cpu",
            _ => "other",
        },
        api: version(properties.api_version),
        driver: format!("{driver_name} {driver_info}").trim().to_owned(),
        driver_name,
        driver_info,
        driver_version: properties.driver_version,
        vendor_id: properties.vendor_id,
        device_id: properties.device_id,
        device_local_bytes: memory.memory_heaps[..memory.memory_heap_count as usize]
            .iter()
            .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
            .map(|heap| heap.size)
            .sum(),
        limits: Limits {
            max_image: [
                limits.max_image_dimension2_d.min(limits.max_framebuffer_width).min(limits.max_viewport_dimensions[0]),
                limits.max_image_dimension2_d.min(limits.max_framebuffer_height).min(limits.max_viewport_dimensions[1]),
            ],
            max_tessellation_level: limits.max_tessellation_generation_level,
            max_patch_points: limits.max_tessellation_patch_size,
            max_push_constants: limits.max_push_constants_size,
            max_index: limits.max_draw_indexed_index_value,
            max_storage_buffer: limits.max_storage_buffer_range,
            colour_samples: limits.framebuffer_color_sample_counts.as_raw(),
            timestamp_period_ns: limits.timestamp_period,
            timestamp_valid_bits: valid_bits,
        },
        missing,
        without,
    };
    Candidate { handle, queue_family: queue_family.unwrap_or(0) as u32, optional, info }
}

fn has_extension(instance: &Instance, handle: vk::PhysicalDevice, name: &CStr) -> bool {
    // SAFETY: the handle comes from this instance.
    let all = unsafe { instance.handle.enumerate_device_extension_properties(handle) };
    all.is_ok_and(|all| all.iter().any(|e| name_of(&e.extension_name) == name))
}

fn version(v: u32) -> String {
    format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v))
}

fn driver(instance: &Instance, handle: vk::PhysicalDevice, device_api: u32) -> (String, String) {
    if instance.api < vk::API_VERSION_1_2 || device_api < vk::API_VERSION_1_2 {
        return (String::new(), String::new());
    }
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::builder().push_next(&mut driver);
    // SAFETY: the chained structure belongs to Vulkan 1.2, which both sides have.
    unsafe { instance.handle.get_physical_device_properties2(handle, &mut properties) };
    let text = |name| name_of(name).to_string_lossy().into_owned();
    (text(&driver.driver_name), text(&driver.driver_info))
}

/// The devices that can show frames on a surface; the others lack that.
pub(super) fn presenting(
    mut all: Vec<Candidate>,
    loader: &ash::extensions::khr::Surface,
    surface: vk::SurfaceKHR,
    instance: &Instance,
) -> Vec<Candidate> {
    for candidate in &mut all {
        // SAFETY: device, family and surface belong to one instance.
        let shows =
            unsafe { loader.get_physical_device_surface_support(candidate.handle, candidate.queue_family, surface) };
        let swapchain = has_extension(instance, candidate.handle, ash::extensions::khr::Swapchain::name());
        if !(swapchain && shows.unwrap_or(false)) {
            candidate.info.missing.push("presenting to this window".to_owned());
        }
    }
    all
}

/// Takes the device asked for (its index, or a part of its name in any case), or else the usable one that is
/// probably fastest: discrete, integrated, virtual, then software.
pub(super) fn choose(mut all: Vec<Candidate>, asked: Option<&str>) -> Result<Candidate, GpuError> {
    if all.is_empty() {
        return Err(GpuError::NoDevice);
    }
    let infos: Vec<&DeviceInfo> = all.iter().map(|c| &c.info).collect();
    let index = pick(&infos, asked)?;
    let found = all.swap_remove(index);
    if !found.info.missing.is_empty() {
        return Err(GpuError::Lacks { device: found.info.name, missing: found.info.missing.join(", ") });
    }
    Ok(found)
}

fn pick(all: &[&DeviceInfo], asked: Option<&str>) -> Result<usize, GpuError> {
    let Some(asked) = asked else {
        let rank = |info: &DeviceInfo| {
            let speed = match info.kind {
                "discrete" => 0,
                "integrated" => 1,
                "virtual" => 2,
                "cpu" => 3,
                _ => 4,
            };
            (!info.missing.is_empty(), speed)
        };
        return Ok((0..all.len()).min_by_key(|&i| rank(all[i])).unwrap_or(0));
    };
    let found = match asked.parse::<usize>() {
        Ok(index) => (index < all.len()).then_some(index),
        Err(_) => {
            let name = asked.to_lowercase();
            all.iter().position(|info| !name.is_empty() && info.name.to_lowercase().contains(&name))
        }
    };
    found.ok_or_else(|| GpuError::UnknownDevice {
        asked: asked.to_owned(),
        have: all.iter().map(|info| format!("{} {}", info.index, info.name)).collect::<Vec<_>>().join("; "),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(index: usize, name: &str, kind: &'static str, missing: &[&str]) -> DeviceInfo {
        DeviceInfo {
            index,
            name: name.to_owned(),
            kind,
            api: String::new(),
            driver: String::new(),
            driver_name: String::new(),
            driver_info: String::new(),
            driver_version: 0,
            vendor_id: 0,
            device_id: 0,
            device_local_bytes: 0,
            limits: Limits {
                max_image: [0; 2],
                max_tessellation_level: 64,
                max_patch_points: 32,
                max_push_constants: 128,
                max_index: 0,
                max_storage_buffer: 0,
                colour_samples: 1,
                timestamp_period_ns: 1.0,
                timestamp_valid_bits: 64,
            },
            missing: missing.iter().map(|s| (*s).to_owned()).collect(),
            without: Vec::new(),
        }
    }

    #[test]
    fn picks_by_index_by_name_and_by_speed() {
        let a = device(0, "Soft", "cpu", &[]);
        let b = device(1, "Fast One", "discrete", &["tessellationShader"]);
        let c = device(2, "Fair One", "integrated", &[]);
        let all = [&a, &b, &c];
        assert_eq!(pick(&all, None).unwrap(), 2);
        assert_eq!(pick(&all, Some("1")).unwrap(), 1);
        assert_eq!(pick(&all, Some("one")).unwrap(), 1);
        assert_eq!(pick(&all, Some("SOFT")).unwrap(), 0);
        for unknown in ["3", "quick", ""] {
            let error = pick(&all, Some(unknown)).unwrap_err();
            assert!(error.is_request() && error.to_string().contains("2 Fair One"));
        }
    }
}
