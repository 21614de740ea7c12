//! Faults on demand: memory that runs out and a device that is lost, for tests of what follows and for machines whose
//! memory is shared.

use super::error::GpuError;
use ash::vk;
use std::cell::Cell;

/// What goes wrong, and what counts towards it.
#[derive(Default)]
pub(super) struct Faults {
    /// Most bytes that may be allocated at a time.
    limit: Cell<Option<u64>>,
    allocated: Cell<u64>,
    lost: Cell<bool>,
}

impl Faults {
    /// Bytes allocated now.
    pub fn allocated(&self) -> u64 {
        self.allocated.get()
    }

    pub fn limit_memory(&self, bytes: Option<u64>) {
        self.limit.set(bytes);
    }

    pub fn lose(&self, lost: bool) {
        self.lost.set(lost);
    }

    /// Before `bytes` more are allocated for `object`.
    pub fn may_allocate(&self, object: &str, bytes: u64) -> Result<(), GpuError> {
        match self.limit.get() {
            Some(limit) if self.allocated.get().saturating_add(bytes) > limit => Err(GpuError::Memory {
                object: object.to_owned(),
                what: format!("{bytes} bytes more than the {} in use pass the limit of {limit}", self.allocated.get()),
            }),
            _ => Ok(()),
        }
    }

    pub fn count(&self, allocated: u64, freed: u64) {
        self.allocated.set(self.allocated.get().saturating_add(allocated).saturating_sub(freed));
    }

    /// Before anything is submitted.
    pub fn may_submit(&self) -> Result<(), vk::Result> {
        match self.lost.get() {
            true => Err(vk::Result::ERROR_DEVICE_LOST),
            false => Ok(()),
        }
    }
}
