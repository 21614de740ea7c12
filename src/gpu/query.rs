//! Timestamps and pipeline statistics as plain numbers.

use super::context::Context;
use super::error::{GpuError, Named};
use ash::vk;
use serde::Serialize;
use std::rc::Rc;

/// What a pair of timestamps encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Scope {
    Frame,
    Bicubic,
    BicubicTransition,
    Gregory,
    GregoryTransition,
    Overlay,
}

impl Scope {
    /// Debug label.
    pub fn label(self) -> &'static str {
        match self {
            Scope::Frame => "frame",
            Scope::Bicubic => "bicubic",
            Scope::BicubicTransition => "bicubic transition",
            Scope::Gregory => "gregory",
            Scope::GregoryTransition => "gregory transition",
            Scope::Overlay => "overlay",
        }
    }
}

/// GPU times in ns. `None`: nothing of that sort was drawn, or the device has no timestamps. Draws overlap on hardware,
/// so the parts need not add up to the frame; on
/// lavapipe, which rasterises at the end of the pass, the parts hold the vertex work only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GpuTimes {
    /// From the start of the frame to the end of its render pass; without upload and read-back.
    pub frame_ns: Option<u64>,
    /// The copies that brought the table to the device, taken when it was uploaded.
    pub upload_ns: Option<u64>,
    /// Whole bicubic patches.
    pub bicubic_ns: Option<u64>,
    /// Bicubic parts of transition faces.
    pub bicubic_transition_ns: Option<u64>,
    /// Whole Gregory patches.
    pub gregory_ns: Option<u64>,
    /// Gregory parts of transition faces.
    pub gregory_transition_ns: Option<u64>,
    /// The wireframe over the surface.
    pub overlay_ns: Option<u64>,
}

impl GpuTimes {
    pub(super) fn add(&mut self, scope: Scope, ns: u64) {
        let sum = match scope {
            Scope::Frame => &mut self.frame_ns,
            Scope::Bicubic => &mut self.bicubic_ns,
            Scope::BicubicTransition => &mut self.bicubic_transition_ns,
            Scope::Gregory => &mut self.gregory_ns,
            Scope::GregoryTransition => &mut self.gregory_transition_ns,
            Scope::Overlay => &mut self.overlay_ns,
        };
        *sum = Some(sum.unwrap_or(0) + ns);
    }
}

/// One stretch of a frame on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GpuSpan {
    /// What it encloses: `frame`, or the kind of patch as in captures.
    pub label: &'static str,
    /// First timestamp, in ticks of the device; [`super::Calibration`] turns it into host time.
    pub begin_ticks: u64,
    /// Length, ns.
    pub ns: u64,
}

/// Counts of one frame, from pipeline-statistics queries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Statistics {
    /// Control points fetched.
    pub ia_vertices: u64,
    /// Patches assembled.
    pub ia_primitives: u64,
    /// Vertex shader runs.
    pub vs_invocations: u64,
    /// Primitives that reached clipping.
    pub clip_invocations: u64,
    /// Primitives that left clipping.
    pub clip_primitives: u64,
    /// Fragment shader runs.
    pub fs_invocations: u64,
    /// Patches that went through the control shader.
    pub tcs_patches: u64,
    /// Evaluation shader runs.
    pub tes_invocations: u64,
}

/// Timestamps in pairs.
pub(super) struct Timestamps {
    context: Rc<Context>,
    pool: vk::QueryPool,
    scopes: Vec<Scope>,
    // Pairs the pool has room for.
    room: usize,
}

impl Timestamps {
    /// A pair for each scope; `None` when the device has no timestamps.
    pub fn new(context: &Rc<Context>, scopes: Vec<Scope>) -> Result<Option<Timestamps>, GpuError> {
        if context.info.limits.timestamp_valid_bits == 0 || scopes.is_empty() {
            return Ok(None);
        }
        let info = vk::QueryPoolCreateInfo::builder()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(2 * scopes.len() as u32);
        // SAFETY: the device is alive, the count is not 0.
        let pool = unsafe { context.device.create_query_pool(&info, None) }.named("vkCreateQueryPool", "timestamps")?;
        context.name(pool, "timestamps");
        let room = scopes.len();
        Ok(Some(Timestamps { context: Rc::clone(context), pool, scopes, room }))
    }

    /// The same pool with other pairs, or a new one if it has not room for them.
    pub fn again(mut self, scopes: Vec<Scope>) -> Result<Option<Timestamps>, GpuError> {
        if scopes.is_empty() || scopes.len() > self.room {
            return Timestamps::new(&self.context, scopes);
        }
        self.scopes = scopes;
        Ok(Some(self))
    }

    /// Resets all pairs. Outside a render pass.
    pub fn record_reset(&self, commands: vk::CommandBuffer) {
        let count = 2 * self.scopes.len() as u32;
        // SAFETY: recording; the queries are not in use, submissions are waited for.
        unsafe { self.context.device.cmd_reset_query_pool(commands, self.pool, 0, count) };
    }

    /// Writes the first timestamp of pair `i`.
    pub fn record_begin(&self, commands: vk::CommandBuffer, i: usize) {
        // The end of what came before: at the top of the pipe the work before would be counted in.
        self.write(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, 2 * i as u32);
    }

    /// Writes the second timestamp of pair `i`.
    pub fn record_end(&self, commands: vk::CommandBuffer, i: usize) {
        self.write(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, 2 * i as u32 + 1);
    }

    fn write(&self, commands: vk::CommandBuffer, stage: vk::PipelineStageFlags, query: u32) {
        // SAFETY: recording; the query was reset in this command buffer.
        unsafe { self.context.device.cmd_write_timestamp(commands, stage, self.pool, query) };
    }

    /// Sums the pairs by scope. The submission has been waited for.
    pub fn read(&self) -> Result<GpuTimes, GpuError> {
        let mut times = GpuTimes::default();
        for (scope, _, ns) in self.pairs()? {
            times.add(scope, ns);
        }
        Ok(times)
    }

    /// Every pair that was written, in order. The submission has been waited for.
    pub fn spans(&self) -> Result<Vec<GpuSpan>, GpuError> {
        let pairs = self.pairs()?;
        Ok(pairs
            .into_iter()
            .map(|(scope, begin_ticks, ns)| GpuSpan { label: scope.label(), begin_ticks, ns })
            .collect())
    }

    /// Scope, first timestamp and length in ns.
    fn pairs(&self) -> Result<Vec<(Scope, u64, u64)>, GpuError> {
        // Value and availability of each.
        let mut words = vec![[0u64; 2]; 2 * self.scopes.len()];
        let count = words.len() as u32;
        // SAFETY: `words` has room for a value and an availability word for each query.
        unsafe {
            self.context.device.get_query_pool_results(
                self.pool,
                0,
                count,
                &mut words,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY,
            )
        }
        .named("vkGetQueryPoolResults", "timestamps")?;
        let limits = &self.context.info.limits;
        let mut pairs = Vec::with_capacity(self.scopes.len());
        for (i, &scope) in self.scopes.iter().enumerate() {
            let [[begin, begun], [end, ended]] = [words[2 * i], words[2 * i + 1]];
            if begun != 0 && ended != 0 {
                let ticks = ticks_between(begin, end, limits.timestamp_valid_bits);
                let ns = (ticks as f64 * f64::from(limits.timestamp_period_ns)).round() as u64;
                pairs.push((scope, ticks_between(0, begin, limits.timestamp_valid_bits), ns));
            }
        }
        Ok(pairs)
    }
}

impl Drop for Timestamps {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe { self.context.device.destroy_query_pool(self.pool, None) };
    }
}

/// Ticks from one timestamp to a later one, of which only the low `bits` count; they may have wrapped once.
pub(super) fn ticks_between(begin: u64, end: u64, bits: u32) -> u64 {
    let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
    end.wrapping_sub(begin) & mask
}

/// One pipeline-statistics query.
pub(super) struct StatisticsQuery {
    context: Rc<Context>,
    pool: vk::QueryPool,
}

impl StatisticsQuery {
    pub fn new(context: &Rc<Context>) -> Result<StatisticsQuery, GpuError> {
        if !context.optional.statistics {
            return Err(GpuError::Lacks {
                device: context.info.name.clone(),
                missing: "pipelineStatisticsQuery (invocation counts)".to_owned(),
            });
        }
        use vk::QueryPipelineStatisticFlags as Flags;
        let info = vk::QueryPoolCreateInfo::builder()
            .query_type(vk::QueryType::PIPELINE_STATISTICS)
            .query_count(1)
            .pipeline_statistics(
                Flags::INPUT_ASSEMBLY_VERTICES
                    | Flags::INPUT_ASSEMBLY_PRIMITIVES
                    | Flags::VERTEX_SHADER_INVOCATIONS
                    | Flags::CLIPPING_INVOCATIONS
                    | Flags::CLIPPING_PRIMITIVES
                    | Flags::FRAGMENT_SHADER_INVOCATIONS
                    | Flags::TESSELLATION_CONTROL_SHADER_PATCHES
                    | Flags::TESSELLATION_EVALUATION_SHADER_INVOCATIONS,
            );
        // SAFETY: the feature is enabled.
        let pool = unsafe { context.device.create_query_pool(&info, None) }.named("vkCreateQueryPool", "statistics")?;
        context.name(pool, "statistics");
        Ok(StatisticsQuery { context: Rc::clone(context), pool })
    }

    /// Resets and begins the query. Outside a render pass.
    pub fn record_begin(&self, commands: vk::CommandBuffer) {
        // SAFETY: recording; the query is not in use.
        unsafe {
            self.context.device.cmd_reset_query_pool(commands, self.pool, 0, 1);
            self.context.device.cmd_begin_query(commands, self.pool, 0, vk::QueryControlFlags::empty());
        }
    }

    /// Ends the query. Outside a render pass.
    pub fn record_end(&self, commands: vk::CommandBuffer) {
        // SAFETY: recording; the query was begun.
        unsafe { self.context.device.cmd_end_query(commands, self.pool, 0) };
    }

    /// The counts. The submission has been waited for.
    pub fn read(&self) -> Result<Statistics, GpuError> {
        let mut words = [[0u64; 8]; 1];
        // SAFETY: one query of eight counters, in the order of their bits.
        unsafe {
            self.context.device.get_query_pool_results(
                self.pool,
                0,
                1,
                &mut words,
                vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
            )
        }
        .named("vkGetQueryPoolResults", "statistics")?;
        let [[ia_vertices, ia_primitives, vs_invocations, clip_invocations, clip_primitives, fs_invocations, tcs_patches, tes_invocations]] =
            words;
        Ok(Statistics {
            ia_vertices,
            ia_primitives,
            vs_invocations,
            clip_invocations,
            clip_primitives,
            fs_invocations,
            tcs_patches,
            tes_invocations,
        })
    }
}

impl Drop for StatisticsQuery {
    fn drop(&mut self) {
        // SAFETY: every submission is waited for before its call returns.
        unsafe { self.context.device.destroy_query_pool(self.pool, None) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timestamps_wrap_at_their_valid_bits() {
        assert_eq!(ticks_between(0xFFFF_FFF0, 0x10, 32), 0x20);
        assert_eq!(ticks_between(0xAB_FFFF_FFF0, 0xCD_0000_0010, 32), 0x20);
        assert_eq!(ticks_between(5, 9, 64), 4);
    }
}
