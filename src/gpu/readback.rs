//! Evaluated points read back from the device, for tests and for proving that edges are watertight.
//!
//! A variant of the evaluation shader appends every vertex to a storage buffer. Shaders cannot be told which patch they
//! are at by `gl_PrimitiveID` (it is wrong on lavapipe), so every patch is a draw of its own with its number pushed.

use super::context::{Commands, Context};
use super::draw::tess_push;
use super::error::{GpuError, Named};
use super::layout::{Record, RECORDS_AT};
use super::memory::{bytes_of, Buffer};
use super::pipeline::{Fill, PipelineKey, Pipelines, PUSH_STAGES};
use super::table::{DeviceTable, TableBuffers};
use super::target::{PassKey, Target};
use crate::patch::tess::{greatest, TessRule, MAX_LEVEL};
use ash::vk;
use gpu_allocator::MemoryLocation;
use std::rc::Rc;

/// A vertex as the tessellator made it and the shader evaluated it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvaluatedPoint {
    /// Number of the draw range in the table.
    pub range: u32,
    /// Number of the patch in the range.
    pub patch: u32,
    /// Part of a transition face, as in the range.
    pub part: Option<u8>,
    /// `gl_TessCoord`: u, v, 0 for quads, barycentric for triangles.
    pub coord: [f32; 3],
    /// Tessellation level of sides 0 to 3 (a triangle's fourth is 1).
    pub outer: [f32; 4],
    /// The eight channels, bit for bit.
    pub value: [f32; 8],
}

/// Records in one batch, 84 MB.
const BATCH: u64 = 1 << 20;

/// A run of patches of one range.
struct Run {
    range: usize,
    first: u32,
    count: u32,
}

/// Every vertex of every patch, sorted by range, patch and coordinate; a vertex that the device evaluated more than once
/// appears once for each value it got.
pub(super) fn evaluate(
    context: &Rc<Context>,
    pipelines: &Pipelines,
    table: &DeviceTable,
    tess: TessRule,
    scale: [f64; 2],
) -> Result<Vec<EvaluatedPoint>, GpuError> {
    tess.check_to(greatest(&table.ranges)).map_err(GpuError::Request)?;
    let Some(buffers) = &table.buffers else {
        return Ok(Vec::new());
    };
    let mut points = Vec::new();
    let mut batch = Vec::new();
    let mut expected = 0;
    for (number, range) in table.ranges.iter().enumerate() {
        let levels = tess.levels(range.level);
        let stitched = if range.kind.points() == 32 { MAX_LEVEL } else { 1.0 };
        let most = levels.full.max(levels.half).max(levels.inner).max(stitched) as u64 + 1;
        let vertices = most * most;
        let mut first = 0;
        while first < range.count {
            let room = ((BATCH - expected) / vertices).min(u64::from(range.count - first)) as u32;
            if room == 0 {
                run_batch(context, pipelines, table, buffers, tess, scale, &batch, expected, &mut points)?;
                batch.clear();
                expected = 0;
                continue;
            }
            batch.push(Run { range: number, first, count: room });
            expected += u64::from(room) * vertices;
            first += room;
        }
    }
    if !batch.is_empty() {
        run_batch(context, pipelines, table, buffers, tess, scale, &batch, expected, &mut points)?;
    }
    let key = |p: &EvaluatedPoint| (p.range, p.patch, p.coord.map(f32::to_bits), p.value.map(f32::to_bits));
    points.sort_by_key(key);
    points.dedup_by_key(|p| key(p));
    Ok(points)
}

#[allow(clippy::too_many_arguments)]
fn run_batch(
    context: &Rc<Context>,
    pipelines: &Pipelines,
    table: &DeviceTable,
    buffers: &TableBuffers,
    tess: TessRule,
    scale: [f64; 2],
    batch: &[Run],
    expected: u64,
    points: &mut Vec<EvaluatedPoint>,
) -> Result<(), GpuError> {
    // A device may evaluate a vertex more than once; then the buffer is too small, and the counter says what is needed.
    let mut capacity = expected;
    loop {
        let bytes = RECORDS_AT as u64 + capacity * size_of::<Record>() as u64;
        if bytes > u64::from(context.info.limits.max_storage_buffer) || u32::try_from(capacity).is_err() {
            return Err(GpuError::Request(format!(
                "{capacity} evaluated points are too many for one buffer of '{}'",
                context.info.name
            )));
        }
        let mut records =
            Buffer::new(context, "records", bytes, vk::BufferUsageFlags::STORAGE_BUFFER, MemoryLocation::GpuToCpu)?;
        records.write(bytes_of(&[0, capacity as u32, 0, 0]))?;
        let set = RecordSet::new(context, pipelines, &records)?;
        let target = Target::new(context, &pipelines.passes, PassKey::Empty, [1, 1])?;
        let draws: Vec<(vk::Pipeline, &Run)> = batch
            .iter()
            .map(|run| {
                let key = PipelineKey::of(&table.ranges[run.range], Fill::Readback, PassKey::Empty);
                Ok((pipelines.get(key)?, run))
            })
            .collect::<Result<_, GpuError>>()?;
        Commands::new(context, "read-back")?.run(|commands| {
            record(context, pipelines, table, buffers, &target, &set, &draws, tess, scale, &records, commands);
            Ok(())
        })?;
        let bytes = records.bytes()?;
        let count = u64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        if count > capacity {
            capacity = count;
            continue;
        }
        let used = &bytes[RECORDS_AT..][..count as usize * size_of::<Record>()];
        points.extend(used.chunks_exact(size_of::<Record>()).map(|chunk| {
            let record = Record::read(chunk);
            let [range, patch, ..] = record.place;
            EvaluatedPoint {
                range,
                patch,
                part: table.ranges[range as usize].part,
                coord: [record.coord[0], record.coord[1], record.coord[2]],
                outer: record.outer,
                value: record.value,
            }
        }));
        return Ok(());
    }
}

#[allow(clippy::too_many_arguments)]
fn record(
    context: &Context,
    pipelines: &Pipelines,
    table: &DeviceTable,
    buffers: &TableBuffers,
    target: &Target,
    set: &RecordSet,
    draws: &[(vk::Pipeline, &Run)],
    tess: TessRule,
    scale: [f64; 2],
    records: &Buffer,
    commands: vk::CommandBuffer,
) {
    let device = &context.device;
    let one = vk::Extent2D { width: 1, height: 1 };
    let begin = vk::RenderPassBeginInfo::builder()
        .render_pass(target.pass)
        .framebuffer(target.framebuffer)
        .render_area(vk::Rect2D { offset: vk::Offset2D::default(), extent: one });
    context.begin_label(commands, "read-back");
    // SAFETY: recording; pass, framebuffer, set, pipelines and layout belong together, the index ranges were checked when
    // the table was uploaded, and all of them outlive the submission, which is waited for.
    unsafe {
        device.cmd_begin_render_pass(commands, &begin, vk::SubpassContents::INLINE);
        device.cmd_bind_vertex_buffers(commands, 0, &[buffers.control.handle], &[0]);
        device.cmd_bind_index_buffer(commands, buffers.indices.handle, 0, vk::IndexType::UINT32);
        device.cmd_bind_descriptor_sets(
            commands,
            vk::PipelineBindPoint::GRAPHICS,
            pipelines.layout,
            0,
            &[set.set],
            &[],
        );
        for (pipeline, run) in draws {
            let range = &table.ranges[run.range];
            let stride = range.stride() as u32;
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, *pipeline);
            let mut push = tess_push(tess, scale, range, greatest(&table.ranges));
            push.range = run.range as u32;
            for patch in run.first..run.first + run.count {
                push.patch = patch;
                let bytes = bytes_of(std::slice::from_ref(&push));
                device.cmd_push_constants(commands, pipelines.layout, PUSH_STAGES, 0, bytes);
                device.cmd_draw_indexed(commands, stride, 1, range.first + patch * stride, 0, 0);
            }
        }
        device.cmd_end_render_pass(commands);
    }
    let stage = vk::PipelineStageFlags::TESSELLATION_EVALUATION_SHADER;
    records.record_to_host(commands, stage, vk::AccessFlags::SHADER_WRITE);
    context.end_label(commands);
}

/// A descriptor set that holds the records buffer, with its pool.
struct RecordSet {
    context: Rc<Context>,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
}

impl RecordSet {
    fn new(context: &Rc<Context>, pipelines: &Pipelines, records: &Buffer) -> Result<RecordSet, GpuError> {
        let sizes = [vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: 1 }];
        let info = vk::DescriptorPoolCreateInfo::builder().max_sets(1).pool_sizes(&sizes);
        // SAFETY: the device is alive.
        let pool =
            unsafe { context.device.create_descriptor_pool(&info, None) }.named("vkCreateDescriptorPool", "records")?;
        let mut set = RecordSet { context: Rc::clone(context), pool, set: vk::DescriptorSet::null() };
        let layouts = [pipelines.records];
        let info = vk::DescriptorSetAllocateInfo::builder().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: the pool has room for one set with one storage buffer.
        set.set =
            unsafe { context.device.allocate_descriptor_sets(&info) }.named("vkAllocateDescriptorSets", "records")?[0];
        context.name(set.pool, "records");
        context.name(set.set, "records");
        let buffers = [vk::DescriptorBufferInfo { buffer: records.handle, offset: 0, range: vk::WHOLE_SIZE }];
        let write = vk::WriteDescriptorSet::builder()
            .dst_set(set.set)
            .dst_binding(0)
            .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
            .buffer_info(&buffers);
        // SAFETY: the set is not in use; the buffer outlives the submission.
        unsafe { context.device.update_descriptor_sets(&[write.build()], &[]) };
        Ok(set)
    }
}

impl Drop for RecordSet {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns. The set goes with its pool.
        unsafe { self.context.device.destroy_descriptor_pool(self.pool, None) };
    }
}
