//! A patch table on the device.

use super::context::{Commands, Context};
use super::error::GpuError;
use super::memory::{bytes_of, Buffer};
use super::partial::Ring;
use super::query::{Scope, Timestamps};
use crate::patch::pack::pack;
use crate::patch::space::Interpolation;
use crate::patch::transition::PARTS;
use crate::patch::{DrawRange, Kind, PatchTable};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// A patch table on the device: control points, indices and the list of its ranges. It may outlive the `Gpu` that
/// made it, which then lives on in it.
pub struct DeviceTable {
    // Dropped first: it may hold copies into the buffers that are on their way.
    pub(super) ring: Ring,
    /// Bytes of control points and of indices.
    pub(super) lengths: [u64; 2],
    pub(super) ranges: Vec<DrawRange>,
    pub(super) colour: Interpolation,
    // None: the table is empty.
    pub(super) buffers: Option<TableBuffers>,
    pub(super) upload_ns: Option<u64>,
    // What the next update can use again; only of tables that are updated.
    uploader: Option<Uploader>,
}

pub(super) struct TableBuffers {
    pub control: Buffer,
    pub indices: Buffer,
}

impl DeviceTable {
    /// Bytes of control points and indices on the device: 32 a control point, 4 an index.
    pub fn bytes(&self) -> u64 {
        self.lengths[0] + self.lengths[1]
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

/// Part of a table by which buffers are larger, where more may come: an edit that refines a little more finds room.
const SPARE: u64 = 4;

/// Checks the table, casts it to f32 and copies it to the device through staging buffers; `with_room` for more.
pub(super) fn upload(context: &Rc<Context>, table: &PatchTable, with_room: bool) -> Result<DeviceTable, GpuError> {
    let mut made = DeviceTable {
        ranges: Vec::new(),
        colour: table.colour,
        buffers: None,
        upload_ns: None,
        ring: Ring::default(),
        lengths: [0; 2],
        uploader: None,
    };
    fill(context, table, &mut made, if with_room { SPARE } else { 0 })?;
    made.uploader = None;
    Ok(made)
}

/// As [`upload`], into the buffers of an earlier table as far as they are large enough. After a failed copy the table is
/// empty, after any other error it is the earlier one.
pub(super) fn update(context: &Rc<Context>, table: &PatchTable, into: &mut DeviceTable) -> Result<(), GpuError> {
    fill(context, table, into, SPARE)
}

/// Makes room for `lengths` bytes of control points and indices in larger buffers, and copies what is there on the device.
/// After an error the table is what it was.
pub(super) fn grow(context: &Rc<Context>, into: &mut DeviceTable, lengths: [u64; 2]) -> Result<(), GpuError> {
    into.ring.finish()?;
    let Some(old) = &into.buffers else { return Ok(()) };
    let [control, indices] =
        [(&old.control, lengths[0]), (&old.indices, lengths[1])].map(|(old, length)| match length {
            _ if length <= old.size => old.size,
            _ => length + length / SPARE,
        });
    let new = TableBuffers::new(context, control, indices)?;
    Commands::new(context, "larger table")?.run(|commands| {
        for (from, to, size) in
            [(&old.control, &new.control, into.lengths[0]), (&old.indices, &new.indices, into.lengths[1])]
        {
            let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size };
            // SAFETY: recording; both buffers have at least this size, and no submission writes to either.
            unsafe { context.device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]) };
        }
        Ok(())
    })?;
    into.buffers = Some(new);
    Ok(())
}

impl TableBuffers {
    /// Buffers of these sizes, bytes.
    fn new(context: &Rc<Context>, control: u64, indices: u64) -> Result<TableBuffers, GpuError> {
        let on_device = |name: &str, size, usage| {
            let usage = usage | vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::TRANSFER_SRC;
            Buffer::new(context, name, size, usage, MemoryLocation::GpuOnly)
        };
        Ok(TableBuffers {
            control: on_device("control points", control, vk::BufferUsageFlags::VERTEX_BUFFER)?,
            indices: on_device("patch indices", indices, vk::BufferUsageFlags::INDEX_BUFFER)?,
        })
    }
}

/// `spare`: new buffers are larger by one part in this many; 0: not larger.
fn fill(context: &Rc<Context>, table: &PatchTable, into: &mut DeviceTable, spare: u64) -> Result<(), GpuError> {
    // The buffers may be on their way out.
    into.ring.finish()?;
    check(table, context.info.limits.max_index)?;
    let packed = pack(table);
    let (control, indices) = (bytes_of(&packed.control), bytes_of(&packed.indices));
    // Whatever is new is made before anything of the old table goes, so that memory which runs out leaves that drawable.
    let mut made = None;
    if !control.is_empty() && !indices.is_empty() {
        let room = |bytes: &[u8]| {
            let size = bytes.len() as u64;
            size + size.checked_div(spare).unwrap_or(0)
        };
        let fits = |buffer: &Buffer, bytes: &[u8]| buffer.size >= bytes.len() as u64;
        let uploader = match &into.uploader {
            Some(u) if fits(&u.control, control) && fits(&u.indices, indices) => None,
            _ => Some(Uploader::new(context, room(control), room(indices))?),
        };
        let buffers = match &into.buffers {
            Some(b) if fits(&b.control, control) && fits(&b.indices, indices) => None,
            _ => Some(TableBuffers::new(context, room(control), room(indices))?),
        };
        made = Some((uploader, buffers));
    }
    // Until the copy is done the table is empty.
    let (uploader, buffers) = (into.uploader.take(), into.buffers.take());
    into.ranges.clear();
    (into.upload_ns, into.lengths) = (None, [0; 2]);
    if let Some((new_uploader, new_buffers)) = made {
        let kept = (new_uploader.or(uploader), new_buffers.or(buffers));
        let (Some(mut uploader), Some(buffers)) = kept else { unreachable!("what fits is there") };
        into.upload_ns = uploader.copy(context, &buffers, control, indices)?;
        (into.buffers, into.uploader) = (Some(buffers), Some(uploader));
    }
    into.lengths = [control.len() as u64, indices.len() as u64];
    into.ranges.extend_from_slice(&table.ranges);
    into.colour = table.colour;
    Ok(())
}

/// Staging buffers and what records the copies out of them.
struct Uploader {
    control: Buffer,
    indices: Buffer,
    commands: Commands,
    timestamps: Option<Timestamps>,
}

impl Uploader {
    fn new(context: &Rc<Context>, control: u64, indices: u64) -> Result<Uploader, GpuError> {
        let staging = |name: &str, size: u64| {
            Buffer::new(context, name, size, vk::BufferUsageFlags::TRANSFER_SRC, MemoryLocation::CpuToGpu)
        };
        Ok(Uploader {
            control: staging("control points staging", control)?,
            indices: staging("patch indices staging", indices)?,
            commands: Commands::new(context, "upload")?,
            timestamps: Timestamps::new(context, vec![Scope::Frame])?,
        })
    }

    /// Copies both and waits; GPU time in ns.
    fn copy(
        &mut self,
        context: &Context,
        to: &TableBuffers,
        control: &[u8],
        indices: &[u8],
    ) -> Result<Option<u64>, GpuError> {
        self.control.write(control)?;
        self.indices.write(indices)?;
        self.commands.run(|commands| {
            context.begin_label(commands, "upload");
            if let Some(timestamps) = &self.timestamps {
                timestamps.record_reset(commands);
                timestamps.record_begin(commands, 0);
            }
            for (from, to, size) in
                [(&self.control, &to.control, control.len()), (&self.indices, &to.indices, indices.len())]
            {
                let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: size as u64 };
                // SAFETY: recording; both buffers have at least this size, and no submission uses either.
                unsafe { context.device.cmd_copy_buffer(commands, from.handle, to.handle, &[region]) };
            }
            if let Some(timestamps) = &self.timestamps {
                timestamps.record_end(commands, 0);
            }
            // The fence that is waited for makes the copies visible to every later submission.
            context.end_label(commands);
            Ok(())
        })?;
        match &self.timestamps {
            Some(timestamps) => Ok(timestamps.read()?.frame_ns),
            None => Ok(None),
        }
    }
}

/// The GPU follows indices blindly, so nothing that points outside gets there.
fn check(table: &PatchTable, max_index: u32) -> Result<(), GpuError> {
    let fault = |what: String| Err(GpuError::Request(format!("patch table: {what}")));
    check_length(table, max_index)?;
    if u32::try_from(table.indices.len()).is_err() {
        return fault(format!("{} indices; a table holds at most {}", table.indices.len(), u32::MAX));
    }
    if let Some(index) = table.indices.iter().find(|&&i| i as usize >= table.control.len()) {
        return fault(format!("index {index} of {} control points", table.control.len()));
    }
    check_ranges(table)
}

/// Whether the device counts that far.
pub(super) fn check_length(table: &PatchTable, max_index: u32) -> Result<(), GpuError> {
    if table.control.len() as u64 > u64::from(max_index) {
        let text = format!("patch table: {} control points; the device counts to {max_index}", table.control.len());
        return Err(GpuError::Request(text));
    }
    Ok(())
}

/// As [`check`], without the indices.
pub(super) fn check_ranges(table: &PatchTable) -> Result<(), GpuError> {
    let fault = |what: String| Err(GpuError::Request(format!("patch table: {what}")));
    for range in &table.ranges {
        if range.part.is_some_and(|part| part as usize >= PARTS.len()) {
            return fault(format!("{range:?} names no part"));
        }
        if !matches!(range.kind, Kind::Bicubic | Kind::Gregory) && range.part.is_some() {
            return fault(format!("{range:?} has parts, and its kind has none"));
        }
        let end = u64::from(range.first) + u64::from(range.count) * range.stride() as u64;
        if end > table.indices.len() as u64 {
            return fault(format!("{range:?} runs past the {} indices", table.indices.len()));
        }
    }
    Ok(())
}
