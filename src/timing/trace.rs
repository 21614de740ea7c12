//! `trace.json`: timed frames as Chrome trace events, which Perfetto (ui.perfetto.dev) and chrome://tracing open.

use super::record::FrameRecord;
use serde_json::{json, Value};

/// Process of the host's stages.
const CPU: u32 = 1;
/// Process of the device's queue.
const GPU: u32 = 2;

/// A stretch of GPU work on the host's clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// What it encloses.
    pub label: &'static str,
    /// Start, ns since the run began.
    pub start_ns: u64,
    /// Length, ns.
    pub ns: u64,
}

/// Stages in the order in which they follow each other in a frame; the thread id is the place in this list.
const STAGES: [&str; 8] = ["frame", "edit", "refine", "patch", "upload", "record", "submit", "wait"];

/// Events of a run, collected frame by frame.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    events: Vec<Value>,
}

impl Trace {
    /// Adds a frame of the configuration `label`. Stages are put one after another from the frame's start.
    pub fn add(&mut self, label: &str, record: &FrameRecord, spans: &[Span]) {
        let f = &record.fields;
        let Some(start) = f.cpu_start_ns.map(|ns| ns as f64 * 1e-3) else {
            return;
        };
        let args = json!({"run": label, "repeat": record.repeat, "frame": record.frame});
        let mut at = start;
        let stages = [
            f.cpu_frame_ms,
            f.cpu_edit_ms,
            f.cpu_refine_ms,
            f.cpu_patch_ms,
            f.cpu_upload_ms,
            f.cpu_record_ms,
            f.cpu_submit_ms,
            f.cpu_wait_ms,
        ];
        for (tid, (name, ms)) in STAGES.iter().zip(stages).enumerate() {
            let Some(us) = ms.map(|ms| ms * 1e3) else {
                continue;
            };
            let ts = if tid == 0 { start } else { at };
            self.events
                .push(json!({"ph": "X", "pid": CPU, "tid": tid, "name": name, "ts": ts, "dur": us, "args": args}));
            if tid > 0 {
                at += us;
            }
        }
        for span in spans {
            let (ts, us) = (span.start_ns as f64 * 1e-3, span.ns as f64 * 1e-3);
            // The frame encloses the kinds: one track, nested.
            self.events
                .push(json!({"ph": "X", "pid": GPU, "tid": 0, "name": span.label, "ts": ts, "dur": us, "args": args}));
        }
        let count = |n: Option<u64>| n.unwrap_or(0);
        self.events.push(json!({
            "ph": "C", "pid": CPU, "name": format!("patches {label}"), "ts": start,
            "args": {"bicubic": count(f.patches_bicubic), "gregory": count(f.patches_gregory)},
        }));
    }

    /// The document.
    pub fn document(&self, run_id: &str, device: &str) -> Value {
        let name = |pid: u32, tid: usize, what: &str, name: &str| json!({"ph": "M", "pid": pid, "tid": tid, "name": what, "args": {"name": name}});
        let mut events = vec![name(CPU, 0, "process_name", "CPU"), name(GPU, 0, "process_name", "GPU")];
        events.extend(STAGES.iter().enumerate().map(|(tid, stage)| name(CPU, tid, "thread_name", stage)));
        events.push(name(GPU, 0, "thread_name", "queue"));
        events.extend(self.events.iter().cloned());
        json!({
            "displayTimeUnit": "ms",
            "metadata": {"schema": "gradtess.trace/1", "run_id": run_id, "device": device},
            "traceEvents": events,
        })
    }
}
