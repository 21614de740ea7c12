//! What a run ran on and when, as far as it can be found out without asking anyone. `None` is unknown.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::read_to_string;
use std::time::{Duration, SystemTime};

/// The machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Host {
    /// Name and version of the system.
    pub os: Option<String>,
    /// Kernel version.
    pub kernel: Option<String>,
    /// Model of the processor.
    pub cpu: Option<String>,
    /// Processors that this program may use.
    pub cores: Option<usize>,
    /// Main memory, bytes.
    pub memory: Option<u64>,
    /// Frequency governor of the first processor.
    pub governor: Option<String>,
    /// Whether this is a virtual machine.
    pub virtual_machine: Option<bool>,
    /// Processes that wanted a processor in the minute before the run.
    pub load: Option<f64>,
}

impl Host {
    /// Looks around. Complete on Linux, nearly empty elsewhere.
    pub fn here() -> Host {
        let cpuinfo = read_to_string("/proc/cpuinfo").unwrap_or_default();
        let system = read_to_string("/etc/os-release").ok();
        let field = |key: &str| {
            let line = cpuinfo.lines().find(|line| line.split(':').next().is_some_and(|k| k.trim() == key))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let memory = read_to_string("/proc/meminfo").ok().and_then(|text| {
            let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
            line.trim().trim_end_matches("kB").trim().parse::<u64>().ok().map(|kib| kib << 10)
        });
        Host {
            os: system
                .and_then(|text| {
                    let name = text.lines().find_map(|line| line.strip_prefix("PRETTY_NAME="))?;
                    Some(name.trim_matches('"').to_owned())
                })
                .or_else(|| Some(std::env::consts::OS.to_owned())),
            kernel: trimmed("/proc/sys/kernel/osrelease"),
            cpu: field("model name"),
            cores: std::thread::available_parallelism().ok().map(Into::into),
            memory,
            governor: trimmed("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
            virtual_machine: field("flags").map(|flags| flags.split(' ').any(|flag| flag == "hypervisor")),
            load: read_to_string("/proc/loadavg").ok().and_then(|text| text.split(' ').next()?.parse().ok()),
        }
    }
}

fn trimmed(path: &str) -> Option<String> {
    read_to_string(path).ok().map(|text| text.trim().to_owned()).filter(|text| !text.is_empty())
}

/// Clocks of the device. They are never set by this program.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clocks {
    /// Whether they were locked, as far as is known: a fixed governor of a software rasteriser's processor.
    pub locked: bool,
    /// How that was found out.
    pub method: String,
    /// What was asked for, MHz.
    pub requested_mhz: Option<f64>,
    /// Least clock seen of any processor, between repeats, MHz.
    pub observed_min_mhz: Option<f64>,
    /// Greatest.
    pub observed_max_mhz: Option<f64>,
}

impl Clocks {
    /// Clocks of a software rasteriser (`software`) are those of the processor; others are unknown.
    pub fn new(software: bool, host: &Host) -> Clocks {
        let locked = software && host.governor.as_deref() == Some("performance");
        let method = match (software, &host.governor) {
            (true, Some(governor)) => format!("governor {governor}"),
            (true, None) => "the governor is unknown".to_owned(),
            (false, _) => "not looked at; lock the clocks with the vendor's tool before a run".to_owned(),
        };
        Clocks { locked, method, ..Clocks::default() }
    }

    /// Looks at the processor's clocks now.
    pub fn observe(&mut self) {
        let text = read_to_string("/proc/cpuinfo").unwrap_or_default();
        for mhz in text.lines().filter(|line| line.starts_with("cpu MHz")).filter_map(|line| line.split_once(':')) {
            let Ok(mhz) = mhz.1.trim().parse::<f64>() else {
                continue;
            };
            self.observed_min_mhz = Some(self.observed_min_mhz.map_or(mhz, |m| m.min(mhz)));
            self.observed_max_mhz = Some(self.observed_max_mhz.map_or(mhz, |m| m.max(mhz)));
        }
    }
}

/// A moment as ISO 8601 in UTC, to the second.
pub fn iso8601(time: SystemTime) -> String {
    let seconds = time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or(Duration::ZERO).as_secs();
    let (days, rest) = ((seconds / 86_400) as i64, seconds % 86_400);
    // Civil date of a day number (Hinnant, "chrono-compatible low-level date algorithms"); March begins the year.
    let z = days + 719_468;
    let (era, day_of_era) = (z.div_euclid(146_097), z.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let (month, carry) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let year = year_of_era + era * 400 + carry;
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", rest / 3600, rest / 60 % 60, rest % 60)
}

/// A UUID (version 4 in form) that no other run has: from the time, the process and `salt`.
pub fn run_id(salt: u64) -> String {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or(Duration::ZERO).as_nanos();
    let mut hash = Sha256::new();
    for part in [now, u128::from(std::process::id()), u128::from(salt)] {
        hash.update(part.to_le_bytes());
    }
    // The kernel's own randomness, where it has any to give.
    hash.update(read_to_string("/proc/sys/kernel/random/uuid").unwrap_or_default());
    let mut b: [u8; 16] = std::array::from_fn(|_| 0);
    b.copy_from_slice(&hash.finalize()[..16]);
    b[6] = b[6] & 0x0f | 0x40;
    b[8] = b[8] & 0x3f | 0x80;
    let hex: String = b.iter().map(|b| format!("{b:02x}")).collect();
    format!("{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

/// SHA-256 of bytes in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_right_around_leap_days() {
        let at = |s| iso8601(SystemTime::UNIX_EPOCH + Duration::from_secs(s));
        assert_eq!(at(0), "1970-01-01T00:00:00Z");
        assert_eq!(at(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(at(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(at(1_709_251_199), "2024-02-29T23:59:59Z");
        assert_eq!(at(1_704_067_200), "2024-01-01T00:00:00Z");
    }

    #[test]
    fn run_ids_are_uuids_and_differ() {
        let (a, b) = (run_id(1), run_id(1));
        assert_ne!(a, b);
        assert_eq!(a.len(), 36);
        assert_eq!(a.as_bytes()[14], b'4');
    }
}
