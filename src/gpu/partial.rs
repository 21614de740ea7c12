//! Changed control points and indices go to the device, and nothing else.
//!
//! A ring of small staging buffers, each with its command buffer: one is written while the copies out of the others may
//! still run, so an edit waits only for the upload three edits before.

use super::context::{Commands, Context};
use super::error::GpuError;
use super::memory::{bytes_of, Buffer};
use super::table::{check_length, check_ranges, grow, DeviceTable};
use crate::patch::pack::pack_point;
use crate::patch::PatchTable;
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::ops::Range;
use std::rc::Rc;

/// Uploads that may be on their way.
const RING: usize = 3;
/// Control points between two changed ones that are copied along rather than to begin another region.
const GAP: u32 = 4;
/// Least size of a staging buffer.
const LEAST: u64 = 64 << 10;

const POINT: u64 = size_of::<[f32; 8]>() as u64;
const INDEX: u64 = size_of::<u32>() as u64;

/// What an upload copied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uploaded {
    /// Bytes.
    pub bytes: u64,
    /// Runs of neighbouring control points, and of indices.
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
    let whole = table.control.len() as u64 * POINT + table.indices.len() as u64 * INDEX;
    if into.bytes() != whole || into.ranges() != table.ranges {
        return Err(GpuError::Request("another table is on the device; upload the whole one".to_owned()));
    }
    copy(context, table, changed, &[], into)
}

/// Copies control points (numbers, ascending) and stretches of indices (ascending) of a table that is on the device but for
/// those, and takes over its ranges. Where a table has outgrown its buffers, larger ones take what is there first.
pub(super) fn update_parts(
    context: &Rc<Context>,
    table: &PatchTable,
    control: &[u32],
    indices: &[Range<u32>],
    into: &mut DeviceTable,
) -> Result<Uploaded, GpuError> {
    let lengths = [table.control.len() as u64 * POINT, table.indices.len() as u64 * INDEX];
    if into.buffers.is_none() {
        super::table::update(context, table, into)?;
        return Ok(Uploaded { bytes: into.bytes(), regions: 2 });
    }
    let of_another = || GpuError::Request("another table is on the device; upload the whole one".to_owned());
    if into.colour != table.colour || table.indices.is_empty() {
        return Err(of_another());
    }
    // What is beyond the end of the device's table is new.
    let old = (into.lengths[0] / POINT) as u32;
    let new = control.len() - control.partition_point(|&i| i < old);
    if new < table.control.len().saturating_sub(old as usize) {
        return Err(of_another());
    }
    let mut end = 0;
    for run in indices {
        if run.start < end || run.end < run.start || run.end as usize > table.indices.len() {
            return Err(GpuError::Request("changed indices are to be in the table, and ascending".to_owned()));
        }
        end = run.end;
        let points = &table.indices[run.start as usize..run.end as usize];
        if let Some(i) = points.iter().find(|&&i| i as usize >= table.control.len()) {
            return Err(GpuError::Request(format!("patch table: index {i} of {} control points", table.control.len())));
        }
    }
    check_ranges(table)?;
    let fits = into.buffers.as_ref().is_some_and(|b| b.control.size >= lengths[0] && b.indices.size >= lengths[1]);
    if !fits {
        check_length(table, context.info.limits.max_index)?;
        grow(context, into, lengths)?;
    }
    let done = copy(context, table, control, indices, into)?;
    into.lengths = lengths;
    into.ranges.clone_from(&table.ranges);
    Ok(done)
}

fn copy(
    context: &Rc<Context>,
    table: &PatchTable,
    changed: &[u32],
    indices: &[Range<u32>],
    into: &mut DeviceTable,
) -> Result<Uploaded, GpuError> {
    let runs = runs(changed);
    let last = runs.last().map_or(0, |r| r.end);
    if last as usize > table.control.len() || changed.windows(2).any(|w| w[0] >= w[1]) {
        return Err(GpuError::Request("changed control points are to be in the table, and ascending".to_owned()));
    }
    let DeviceTable { ring, buffers: Some(buffers), .. } = into else { return Ok(Uploaded::default()) };
    if runs.is_empty() && indices.is_empty() {
        return Ok(Uploaded::default());
    }
    let packed: Vec<[f32; 8]> =
        runs.iter().flat_map(|r| &table.control[r.start as usize..r.end as usize]).map(pack_point).collect();
    let mut bytes = bytes_of(&packed).to_vec();
    for run in indices {
        bytes.extend_from_slice(bytes_of(&table.indices[run.start as usize..run.end as usize]));
    }
    let slot = ring.slot(context, bytes.len() as u64)?;
    slot.staging.write(&bytes)?;
    let mut at = 0;
    let mut region = |run: &Range<u32>, each: u64| {
        let size = u64::from(run.end - run.start) * each;
        let region = vk::BufferCopy { src_offset: at, dst_offset: u64::from(run.start) * each, size };
        at += size;
        region
    };
    let to_control: Vec<vk::BufferCopy> = runs.iter().map(|run| region(run, POINT)).collect();
    let indices = indices.iter().filter(|run| !run.is_empty());
    let to_indices: Vec<vk::BufferCopy> = indices.map(|run| region(run, INDEX)).collect();
    slot.commands.submit(None, None, |commands| {
        context.begin_label(commands, "changed points");
        let read = vk::AccessFlags::VERTEX_ATTRIBUTE_READ | vk::AccessFlags::INDEX_READ;
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
        // table's, whose sizes were compared. The ring is finished before the table's buffers go.
        unsafe {
            let device = &context.device;
            // Earlier draws have read, and earlier copies have written, before anything is written here.
            device.cmd_pipeline_barrier(commands, draw | copy, copy, none, &[before.build()], &[], &[]);
            for (to, regions) in [(&buffers.control, &to_control), (&buffers.indices, &to_indices)] {
                if !regions.is_empty() {
                    device.cmd_copy_buffer(commands, slot.staging.handle, to.handle, regions);
                }
            }
            device.cmd_pipeline_barrier(commands, copy, draw | copy, none, &[after.build()], &[], &[]);
        }
        context.end_label(commands);
        Ok(())
    })?;
    slot.pending = true;
    Ok(Uploaded { bytes: bytes.len() as u64, regions: to_control.len() + to_indices.len() })
}

/// Neighbouring numbers together.
fn runs(changed: &[u32]) -> Vec<Range<u32>> {
    let mut runs: Vec<Range<u32>> = Vec::new();
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
