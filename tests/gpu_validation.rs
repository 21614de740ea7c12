//! The validation layer listens, and devices are chosen or refused.

mod gpu_support;

use gpu_support::*;
use gradtess::gpu::{devices, Gpu, GpuError, GpuOptions, CANARIES};

#[test]
fn every_canary_is_reported() {
    with_gpu(|gpu| {
        for canary in CANARIES {
            let heard = gpu.canary(canary).unwrap();
            println!("{canary:?}: {:?}", heard.iter().map(|m| &m.id).collect::<Vec<_>>());
            assert!(heard.iter().any(|message| message.error), "{canary:?} went unheard: {heard:?}");
        }
        assert!(gpu.canary(CANARIES[2]).unwrap()[0].id.starts_with("SYNC-HAZARD"));
    });
}

#[test]
fn devices_are_listed_and_chosen() {
    let all = devices().unwrap();
    let usable = all.iter().find(|device| device.missing.is_empty()).expect("a usable device");
    println!("{}", serde_json::to_string_pretty(&all).unwrap());
    for name in [usable.name.clone(), usable.name.to_uppercase(), usable.index.to_string()] {
        let gpu = Gpu::new(&GpuOptions { device: Some(name), validate: false }).unwrap();
        assert_eq!(gpu.device(), usable);
        assert!(gpu.messages().is_empty());
    }
}

#[test]
fn unknown_devices_are_refused_with_a_list() {
    for asked in ["no such device", "99", ""] {
        let options = GpuOptions { device: Some(asked.to_owned()), validate: false };
        let Err(error) = Gpu::new(&options) else { panic!("{asked:?} was found") };
        assert!(matches!(error, GpuError::UnknownDevice { .. }) && error.is_request());
        assert!(error.to_string().contains(&devices().unwrap()[0].name), "{error}");
    }
}

/// Runs in a process of its own, started by the test below; without its variable it has nothing to look at.
#[test]
fn child_without_a_driver() {
    if std::env::var_os("GRADTESS_TEST_CHILD").is_none() {
        return;
    }
    assert!(devices().is_ok_and(|all| all.is_empty()) || matches!(devices(), Err(GpuError::NoDevice)));
    let Err(error) = Gpu::new(&GpuOptions::default()) else { panic!("there is a device") };
    assert!(matches!(error, GpuError::NoDevice) && !error.is_request());
    println!("refused: {error}");
}

#[test]
fn a_machine_without_a_driver_is_told_so() {
    let run = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "child_without_a_driver", "--nocapture"])
        .env("GRADTESS_TEST_CHILD", "1")
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .env("VK_ICD_FILENAMES", "/nonexistent.json")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && said.contains("refused: no Vulkan device"), "{said}");
}
