//! `gradtess devices`: what there is and what it lacks.

use super::{print, print_json, Failure, Global};
use crate::gpu::{self, DeviceInfo};
use serde::Serialize;

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    devices: Vec<DeviceInfo>,
}

/// Lists the devices.
pub fn run(global: &Global) -> Result<(), Failure> {
    let devices = gpu::devices()?;
    if global.json {
        return print_json(&Report { schema: "gradtess.devices/1", devices });
    }
    for d in &devices {
        let verdict = match (d.missing.is_empty(), d.without.is_empty()) {
            (true, true) => "usable".to_string(),
            (true, false) => format!("usable, without {}", d.without.join(", ")),
            (false, _) => format!("not usable, lacks {}", d.missing.join(", ")),
        };
        print(&format!("{}: {} ({}, Vulkan {}, {}): {verdict}\n", d.index, d.name, d.kind, d.api, d.driver));
    }
    if devices.is_empty() {
        return Err(gpu::GpuError::NoDevice.into());
    }
    Ok(())
}
