//! Device timestamps on the host's clock (VK_EXT_calibrated_timestamps).
//!
//! The device's clock is read between two readings of the host's. Half the time between them is how far off the
//! calibration may be; no host clock domain of the driver's is needed.

use super::context::Context;
use super::error::{GpuError, Named};
use super::query::ticks_between;
use ash::vk;
use std::time::{Duration, Instant};

/// The narrowest of this many readings is taken.
const READINGS: usize = 8;

/// One moment on both clocks.
#[derive(Clone, Copy, Debug)]
pub struct Calibration {
    /// On the host.
    pub host: Instant,
    /// On the device, ticks.
    pub ticks: u64,
    /// How far apart the two may be, ns.
    pub deviation_ns: u64,
    period_ns: f64,
    bits: u32,
}

impl Calibration {
    /// Host time of a device timestamp that is at most half the counter's range away.
    pub fn host_time(&self, ticks: u64) -> Instant {
        let ahead = ticks_between(self.ticks, ticks, self.bits);
        let behind = ticks_between(ticks, self.ticks, self.bits);
        let duration = |n: u64| Duration::from_nanos((n as f64 * self.period_ns) as u64);
        if ahead <= behind {
            self.host + duration(ahead)
        } else {
            self.host.checked_sub(duration(behind)).unwrap_or(self.host)
        }
    }
}

impl Context {
    pub fn calibrate(&self) -> Result<Option<Calibration>, GpuError> {
        let limits = &self.info.limits;
        let Some(calibrated) = self.calibrated.as_ref().filter(|_| limits.timestamp_valid_bits > 0) else {
            return Ok(None);
        };
        let info = [vk::CalibratedTimestampInfoEXT::builder().time_domain(vk::TimeDomainEXT::DEVICE).build()];
        let mut best: Option<Calibration> = None;
        for _ in 0..READINGS {
            let before = Instant::now();
            // SAFETY: the extension is enabled, and a driver that has it has the device's own domain.
            let (ticks, _) = unsafe { calibrated.get_calibrated_timestamps(self.device.handle(), &info) }
                .named("vkGetCalibratedTimestampsEXT", "device")?;
            let half = before.elapsed() / 2;
            let deviation_ns = half.as_nanos() as u64;
            if best.is_none_or(|b| deviation_ns < b.deviation_ns) {
                best = Some(Calibration {
                    host: before + half,
                    ticks: ticks_between(0, ticks[0], limits.timestamp_valid_bits),
                    deviation_ns,
                    period_ns: f64::from(limits.timestamp_period_ns),
                    bits: limits.timestamp_valid_bits,
                });
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_before_and_after_and_across_the_wrap() {
        let host = Instant::now();
        let c = Calibration { host, ticks: 0xFFFF_FFF0, deviation_ns: 0, period_ns: 10.0, bits: 32 };
        assert_eq!(c.host_time(0x10) - host, Duration::from_nanos(320));
        assert_eq!(host - c.host_time(0xFFFF_FFE0), Duration::from_nanos(160));
    }
}
