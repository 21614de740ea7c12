//! A patch table on the device.

use super::context::{Commands, Context};
use super::error::GpuError;
use super::memory::{bytes_of, Buffer, Plain};
use super::query::{Scope, Timestamps};
use crate::patch::pack::pack;
use crate::patch::transition::PARTS;
use crate::patch::{DrawRange, PatchTable};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// A patch table on the device: control points, indices and the list of its ranges. It may outlive the `Gpu` that
/// made it, which then lives on in it.
pub struct DeviceTable {
    pub(super) ranges: Vec<DrawRange>,
    // None: the table is empty.
    pub(super) buffers: Option<TableBuffers>,
    pub(super) upload_ns: Option<u64>,
    bytes: u64,
}

pub(super) struct TableBuffers {
    pub control: Buffer,
    pub indices: Buffer,
}

impl DeviceTable {
    /// Bytes of control points and indices on the device: 32 a control point, 4 an index.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The draw ranges, as in the table that was uploaded.
    pub fn ranges(&self) -> &[DrawRange] {
        &self.ranges
    }

    /// GPU time of the upload, ns; `None` for an empty table or a device without timestamps.
    pub fn upload_ns(&self) -> Option<u64> {
        self.upload_ns
    }
}

/// Checks the table, casts it to f32 and copies it to the device through staging buffers.
pub(super) fn upload(context: &Rc<Context>, table: &PatchTable) -> Result<DeviceTable, GpuError> {
    check(table, context.info.limits.max_index)?;
    let packed = pack(table);
    let bytes = (size_of_val(&packed.control[..]) + size_of_val(&packed.indices[..])) as u64;
    let mut device_table = DeviceTable { ranges: table.ranges.clone(), buffers: None, upload_ns: None, bytes };
    if packed.control.is_empty() || packed.indices.is_empty() {
        return Ok(device_table);
    }
    let control = Upload::new(context, "control points", &packed.control, vk::BufferUsageFlags::VERTEX_BUFFER)?;
    let indices = Upload::new(context, "patch indices", &packed.indices, vk::BufferUsageFlags::INDEX_BUFFER)?;
    let timestamps = Timestamps::new(context, vec![Scope::Frame])?;
    Commands::new(context, "upload")?.run(|commands| {
        context.begin_label(commands, "upload");
        if let Some(timestamps) = &timestamps {
            timestamps.record_reset(commands);
            timestamps.record_begin(commands, 0);
        }
        control.record(context, commands);
        indices.record(context, commands);
        if let Some(timestamps) = &timestamps {
            timestamps.record_end(commands, 0);
        }
        // The fence that is waited for makes the copies visible to every later submission.
        context.end_label(commands);
        Ok(())
    })?;
    device_table.upload_ns = match timestamps {
        Some(timestamps) => timestamps.read()?.frame_ns,
        None => None,
    };
    device_table.buffers = Some(TableBuffers { control: control.buffer, indices: indices.buffer });
    Ok(device_table)
}

struct Upload {
    staging: Buffer,
    buffer: Buffer,
}

impl Upload {
    fn new<T: Plain>(
        context: &Rc<Context>,
        name: &str,
        data: &[T],
        usage: vk::BufferUsageFlags,
    ) -> Result<Upload, GpuError> {
        let size = bytes_of(data).len() as u64;
        let usage = usage | vk::BufferUsageFlags::TRANSFER_DST;
        Ok(Upload {
            staging: Buffer::staging(context, &format!("{name} staging"), data)?,
            buffer: Buffer::new(context, name, size, usage, MemoryLocation::GpuOnly)?,
        })
    }

    fn record(&self, context: &Context, commands: vk::CommandBuffer) {
        let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: self.buffer.size };
        // SAFETY: recording; both buffers have this size.
        unsafe { context.device.cmd_copy_buffer(commands, self.staging.handle, self.buffer.handle, &[region]) };
    }
}

/// The GPU follows indices blindly, so nothing that points outside gets there.
fn check(table: &PatchTable, max_index: u32) -> Result<(), GpuError> {
    let fault = |what: String| Err(GpuError::Request(format!("patch table: {what}")));
    if table.control.len() as u64 > u64::from(max_index) {
        return fault(format!("{} control points; the device counts to {max_index}", table.control.len()));
    }
    if u32::try_from(table.indices.len()).is_err() {
        return fault(format!("{} indices; a table holds at most {}", table.indices.len(), u32::MAX));
    }
    if let Some(index) = table.indices.iter().find(|&&i| i as usize >= table.control.len()) {
        return fault(format!("index {index} of {} control points", table.control.len()));
    }
    for range in &table.ranges {
        if range.part.is_some_and(|part| part as usize >= PARTS.len()) {
            return fault(format!("{range:?} names no part"));
        }
        let end = u64::from(range.first) + u64::from(range.count) * range.stride() as u64;
        if end > table.indices.len() as u64 {
            return fault(format!("{range:?} runs past the {} indices", table.indices.len()));
        }
    }
    Ok(())
}
