//! Changed control points go to the device, and nothing else.
//!
//! A ring of small staging buffers, each with its command buffer: one is written while the copies out of the others may
//! still run, so an edit waits only for the upload three edits before.

use super::context::{Commands, Context};
use super::error::GpuError;
use super::memory::{bytes_of, Buffer};
use super::table::DeviceTable;
use crate::patch::pack::pack_point;
use crate::patch::PatchTable;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// Uploads that may be on their way.
const RING: usize = 3;
/// Control points between two changed ones that are copied along rather than to begin another region.
const GAP: u32 = 4;
/// Least size of a staging buffer.
const LEAST: u64 = 64 << 10;

const POINT: u64 = size_of::<[f32; 8]>() as u64;

/// What an upload copied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uploaded {
    /// Bytes.
    pub bytes: u64,
    /// Runs of neighbouring control points.
    pub regions: usize,
}

/// The staging buffers of a table.
#[derive(Default)]
pub(super) struct Ring {
    slots: Vec<Slot>,
    next: usize,
}

struct Slot {
    staging: Buffer,
    commands: Commands,
    pending: bool,
}

impl Slot {
    fn new(context: &Rc<Context>, size: u64) -> Result<Slot, GpuError> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        Ok(Slot {
            staging: Buffer::new(context, "changed points staging", size, usage, MemoryLocation::CpuToGpu)?,
            commands: Commands::new(context, "changed points")?,
            pending: false,
        })
    }

    fn finish(&mut self) -> Result<(), GpuError> {
        if std::mem::take(&mut self.pending) {
            self.commands.wait()?;
        }
        Ok(())
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        // Buffers must not go while the GPU reads them. A failed wait leaves the device idle or lost.
        let _ = self.finish();
    }
}

impl Ring {
    /// Waits for everything that is on its way.
    pub fn finish(&mut self) -> Result<(), GpuError> {
        self.slots.iter_mut().try_for_each(Slot::finish)
    }

    fn slot(&mut self, context: &Rc<Context>, size: u64) -> Result<&mut Slot, GpuError> {
        let room = size.max(LEAST).next_power_of_two();
        let i = self.next;
        if i == self.slots.len() {
            self.slots.push(Slot::new(context, room)?);
        }
        self.next = (i + 1) % RING;
        let slot = &mut self.slots[i];
        slot.finish()?;
        if slot.staging.size < size {
            *slot = Slot::new(context, room)?;
        }
        Ok(slot)
    }
}

/// Copies the control points with the numbers `changed` (ascending) of a table that is on the device but for those.
pub(super) fn update_points(
    context: &Rc<Context>,
    table: &PatchTable,
    changed: &[u32],
    into: &mut DeviceTable,
) -> Result<Uploaded, GpuError> {
    let whole = table.control.len() as u64 * POINT + table.indices.len() as u64 * 4;
    if into.bytes() != whole || into.ranges() != table.ranges {
        return Err(GpuError::Request("another table is on the device; upload the whole one".to_owned()));
    }
    let runs = runs(changed);
    let last = runs.last().map_or(0, |r| r.end);
    if last as usize > table.control.len() || changed.windows(2).any(|w| w[0] >= w[1]) {
        return Err(GpuError::Request("changed control points are to be in the table, and ascending".to_owned()));
    }
    let DeviceTable { ring, buffers: Some(buffers), .. } = into else { return Ok(Uploaded::default()) };
    if runs.is_empty() {
        return Ok(Uploaded::default());
    }
    let packed: Vec<[f32; 8]> =
        runs.iter().flat_map(|r| &table.control[r.start as usize..r.end as usize]).map(pack_point).collect();
    let bytes = bytes_of(&packed);
    let slot = ring.slot(context, bytes.len() as u64)?;
    slot.staging.write(bytes)?;
    let mut at = 0;
    let regions: Vec<vk::BufferCopy> = runs
        .iter()
        .map(|r| {
            let size = u64::from(r.end - r.start) * POINT;
            let region = vk::BufferCopy { src_offset: at, dst_offset: u64::from(r.start) * POINT, size };
            at += size;
            region
        })
        .collect();
    slot.commands.submit(None, None, |commands| {
        context.begin_label(commands, "changed points");
        let read = vk::AccessFlags::VERTEX_ATTRIBUTE_READ;
        let (draw, copy) = (vk::PipelineStageFlags::VERTEX_INPUT, vk::PipelineStageFlags::TRANSFER);
        let before = vk::MemoryBarrier::builder()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE);
        let after = vk::MemoryBarrier::builder()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(read | vk::AccessFlags::TRANSFER_READ);
        let none = vk::DependencyFlags::empty();
        // SAFETY: recording, outside a render pass. The regions lie in both buffers: in the staging buffer, which has at
        // least the room of all of them and is written again only after this submission was waited for, and in the
        // table's, whose size was compared. The ring is finished before the table's buffers go.
        unsafe {
            let device = &context.device;
            // Earlier draws have read, and earlier copies have written, before anything is written here.
            device.cmd_pipeline_barrier(commands, draw | copy, copy, none, &[before.build()], &[], &[]);
            device.cmd_copy_buffer(commands, slot.staging.handle, buffers.control.handle, &regions);
            device.cmd_pipeline_barrier(commands, copy, draw | copy, none, &[after.build()], &[], &[]);
        }
        context.end_label(commands);
        Ok(())
    })?;
    slot.pending = true;
    Ok(Uploaded { bytes: bytes.len() as u64, regions: regions.len() })
}

/// Neighbouring numbers together.
fn runs(changed: &[u32]) -> Vec<std::ops::Range<u32>> {
    let mut runs: Vec<std::ops::Range<u32>> = Vec::new();
    for &i in changed {
        match runs.last_mut() {
            Some(run) if i <= run.end.saturating_add(GAP) => run.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}

/// Control points and indices as they are on the device, for tests.
pub(super) fn read_back(context: &Rc<Context>, table: &mut DeviceTable) -> Result<(Vec<u8>, Vec<u8>), GpuError> {
    table.ring.finish()?;
    let Some(buffers) = &table.buffers else { return Ok(Default::default()) };
    let [control, indices] = table.lengths;
    let commands = Commands::new(context, "read back")?;
    let mut copies = Vec::new();
    for (from, size) in [(&buffers.control, control), (&buffers.indices, indices)] {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        copies.push((from, Buffer::new(context, "table read back", size, usage, MemoryLocation::GpuToCpu)?, size));
    }
    commands.run(|commands| {
        let visible = vk::MemoryBarrier::builder()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ);
        let (copy, host) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST);
        for (from, to, size) in &copies {
            let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: *size };
            // SAFETY: recording; both buffers have at least this size, and no submission writes to either.
            unsafe { context.device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]) };
        }
        // SAFETY: recording, outside a render pass.
        unsafe {
            let none = vk::DependencyFlags::empty();
            context.device.cmd_pipeline_barrier(commands, copy, host, none, &[visible.build()], &[], &[]);
        }
        Ok(())
    })?;
    let mut bytes = copies.iter().map(|c| c.1.bytes().map(<[u8]>::to_vec));
    let (control, indices) = (bytes.next().expect("two"), bytes.next().expect("two"));
    Ok((control?, indices?))
}

#[cfg(test)]
mod tests {
    use super::runs;

    #[test]
    fn near_neighbours_go_together() {
        assert_eq!(runs(&[]), []);
        assert_eq!(runs(&[3, 4, 5, 9, 15, 100]), [3..10, 15..16, 100..101]);
    }
}
