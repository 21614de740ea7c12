//! Statistics, intervals, verdicts and files of the timing room, on synthetic data whose answers are known.

use gradtess::timing::compare::read_frames;
use gradtess::timing::pair::{ratios, unpaired, Verdict};
use gradtess::timing::protocol::{Protocol, ProtocolError};
use gradtess::timing::random::Random;
use gradtess::timing::record::{header, Fields, FrameRecord, Phase, COLUMNS, SCOPES};
use gradtess::timing::run::{results, values};
use gradtess::timing::statistics::{percentile, sum, summary};
use gradtess::timing::trace::{Span, Trace};

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{a} is not {b}");
}

/// Standard normal numbers (Box, Muller).
fn normal(random: &mut Random) -> f64 {
    (-2.0 * (1.0 - random.unit()).ln()).sqrt() * (std::f64::consts::TAU * random.unit()).cos()
}

#[test]
fn statistics_of_small_sets_are_exact() {
    let ascending: Vec<f64> = (1..=20).map(f64::from).collect();
    let s = summary(&ascending, 1).unwrap();
    assert_eq!((s.n, s.min, s.max), (20, 1.0, 20.0));
    close(s.mean, 10.5);
    // The squares of 1 to 20 add up to 2870, so the variance is (2870 - 20 * 10.5^2) / 19 = 35.
    close(s.sd, 35f64.sqrt());
    // Ranks 10, 18, 19 and 20.
    assert_eq!([s.p50, s.p90, s.p95, s.p99], [10.0, 18.0, 19.0, 20.0]);

    // Far from zero: the variance of 4, 7, 13, 16 is 30, and adding a thousand million changes nothing.
    let far: Vec<f64> = [4.0, 7.0, 13.0, 16.0].iter().map(|x| x + 1e9).collect();
    let s = summary(&far, 1).unwrap();
    close(s.mean - 1e9, 10.0);
    close(s.sd, 30f64.sqrt());

    let one = summary(&[3.5], 1).unwrap();
    assert_eq!((one.mean, one.sd, one.p50, one.p99, one.median_ci95), (3.5, 0.0, 3.5, 3.5, [3.5, 3.5]));
    assert!(summary(&[], 1).is_none());
}

#[test]
fn an_outlier_stays() {
    let mut times = vec![1.0; 99];
    times.push(1000.0);
    let s = summary(&times, 1).unwrap();
    assert_eq!((s.n, s.p99, s.max), (100, 1.0, 1000.0));
    close(s.mean, 10.99);
}

#[test]
fn sums_lose_nothing() {
    // Each in turn swallows the others when added naively.
    assert_eq!(sum(&[1.0, 1e100, 1.0, -1e100]), 2.0);
    let tenths = vec![0.1; 1_000_000];
    close(sum(&tenths), 100_000.0);
}

#[test]
fn percentiles_are_the_nearest_rank() {
    // The textbook example of the method.
    let v = [15.0, 20.0, 35.0, 40.0, 50.0];
    assert_eq!([5.0, 30.0, 40.0, 50.0, 100.0].map(|p| percentile(&v, p)), [15.0, 20.0, 20.0, 35.0, 50.0]);
    let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
    for p in 1..=100 {
        assert_eq!(percentile(&hundred, f64::from(p)), f64::from(p));
    }
}

#[test]
fn the_bootstrap_is_decided_by_its_seed() {
    let mut random = Random::new(3);
    let times: Vec<f64> = (0..101).map(|_| 5.0 + normal(&mut random)).collect();
    let interval = |seed| summary(&times, seed).unwrap().median_ci95;
    assert_eq!(interval(7), interval(7));
    let s = summary(&times, 7).unwrap();
    assert!(s.median_ci95[0] < s.p50 && s.p50 < s.median_ci95[1]);
    // The order of the values is nothing to the interval.
    let mut turned = times.clone();
    turned.reverse();
    assert_eq!(summary(&turned, 7).unwrap().median_ci95, interval(7));
    let pair = ratios(&times, &turned, 7).unwrap();
    assert_eq!(pair, ratios(&times, &turned, 7).unwrap());
    assert_ne!(pair.mean.ci95, ratios(&times, &turned, 8).unwrap().mean.ci95);
}

#[test]
fn intervals_hold_the_true_median_as_often_as_they_say() {
    let mut random = Random::new(11);
    let trials = 200;
    let held = (0..trials)
        .filter(|&trial| {
            let times: Vec<f64> = (0..101).map(|_| 10.0 + normal(&mut random)).collect();
            let [low, high] = summary(&times, trial).unwrap().median_ci95;
            low <= 10.0 && 10.0 <= high
        })
        .count();
    // 95 % give or take three standard deviations, and what the percentile bootstrap is known to lose.
    assert!((178..=199).contains(&held), "{held} of {trials}");
}

/// Times of a busy machine: a common disturbance that lasts for some frames, noise of each frame, and now and then a
/// frame that is interrupted.
fn busy(random: &mut Random, n: usize, slower: f64) -> [Vec<f64>; 2] {
    let mut common = 0.0;
    let frame = |random: &mut Random, common: f64| {
        let hit = if random.unit() < 0.02 { 3.0 } else { 1.0 };
        10.0 * hit * (common + 0.1 * normal(random)).exp()
    };
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for _ in 0..n {
        common = 0.9 * common + 0.1 * normal(random);
        a.push(frame(random, common));
        b.push(slower * frame(random, common));
    }
    [a, b]
}

#[test]
fn pairs_find_what_is_there_and_nothing_else() {
    let mut random = Random::new(5);
    let trials = 60;
    let mut count = |slower: f64, verdict: Verdict| {
        (0..trials)
            .filter(|&trial| {
                let [a, b] = busy(&mut random, 300, slower);
                ratios(&a, &b, trial).unwrap().median.verdict == verdict
            })
            .count() as u64
    };
    let (equal, different) = (count(1.0, Verdict::Equal), count(1.05, Verdict::Different));
    assert!(equal * 10 >= trials * 9, "equal {equal} of {trials}");
    assert!(different * 10 >= trials * 9, "different {different} of {trials}");
}

#[test]
fn ratios_of_constant_times_are_exact() {
    let (a, b) = (vec![2.0; 10], vec![3.0; 10]);
    let r = ratios(&a, &b, 1).unwrap();
    close(r.median.ratio, 1.5);
    close(r.mean.ratio, 1.5);
    assert_eq!((r.n, r.median.ci95, r.median.verdict), (10, [1.5, 1.5], Verdict::Different));
    assert_eq!(ratios(&a, &a, 1).unwrap().median.verdict, Verdict::Equal);
    // B over A is one over A over B, for even numbers too.
    let (a, b) = ([1.0, 1.0, 1.0, 1.0], [1.0, 2.0, 3.0, 8.0]);
    close(ratios(&a, &b, 1).unwrap().median.ratio * ratios(&b, &a, 1).unwrap().median.ratio, 1.0);
    for (a, b) in [(&[1.0][..], &[][..]), (&[], &[]), (&[1.0], &[f64::NAN]), (&[0.0], &[1.0])] {
        assert!(ratios(a, b, 1).is_none() && unpaired(&[a.to_vec()], &[b.to_vec()], 1).is_none());
    }
    let r = unpaired(&[vec![2.0; 5], vec![2.0; 5]], &[vec![3.0; 5]], 1).unwrap();
    assert_eq!((r.ratio, r.verdict), (1.5, Verdict::Different));
}

/// The columns as the protocol documents them.
const DOCUMENTED: &str = "schema,run_id,repeat,frame,phase,cpu_start_ns,gpu_start_ns,cpu_frame_ms,cpu_edit_ms,cpu_refine_ms,cpu_patch_ms,\
cpu_upload_ms,cpu_record_ms,cpu_submit_ms,cpu_wait_ms,in_present_ms,between_presents_ms,gpu_latency_ms,gpu_frame_ms,gpu_upload_ms,\
gpu_regular_ms,gpu_transition_ms,gpu_gregory_ms,gpu_pattern_ms,gpu_overlay_ms,edits,edits_in_place,faces_affected,faces_touched,patches_changed,max_level,patches_bicubic,\
patches_transition,patches_gregory,patches_gregory_transition,tess_factor,control_points,upload_bytes,gpu_bytes,ia_primitives,vs_invocations,tcs_patches,\
tes_invocations,clip_invocations,clip_primitives,fs_invocations,gpu_clock_mhz,gpu_temp_c,gpu_power_w";

#[test]
fn the_header_is_the_documented_one() {
    assert_eq!(header(), format!("{DOCUMENTED}\n"));
    for (scope, _) in SCOPES {
        assert!(COLUMNS.contains(&format!("{scope}_ms").as_str()), "{scope}");
    }
}

fn record(repeat: u32, frame: u32, phase: Phase, ms: f64) -> FrameRecord {
    let fields = Fields { cpu_frame_ms: Some(ms), edits: Some(1), ..Fields::default() };
    FrameRecord { repeat, frame, phase, fields }
}

#[test]
fn rows_have_six_digits_and_na() {
    let mut line = String::new();
    record(2, 3, Phase::Measure, 1.0 / 3.0).write("id", &mut line);
    let cells: Vec<&str> = line.trim_end().split(',').collect();
    assert_eq!(cells.len(), COLUMNS.len());
    assert_eq!(&cells[..5], ["gradtess.frames/1", "id", "2", "3", "measure"]);
    let at = |name: &str| cells[COLUMNS.iter().position(|c| *c == name).unwrap()];
    assert_eq!((at("cpu_frame_ms"), at("edits"), at("gpu_frame_ms"), at("gpu_power_w")), ("0.333333", "1", "NA", "NA"));
}

#[test]
fn only_timed_frames_count() {
    let mut records = vec![record(0, 0, Phase::Warmup, 100.0), record(0, 0, Phase::Stats, 100.0)];
    for repeat in 0..2 {
        records.extend((0..3).map(|i| record(repeat, i, Phase::Measure, f64::from(1 + i + 10 * repeat))));
    }
    let found = results(&records, 1);
    assert_eq!(found.keys().collect::<Vec<_>>(), ["cpu_frame"]);
    let frame = &found["cpu_frame"];
    assert_eq!((frame.pooled.n, frame.pooled.mean, frame.repeats.len()), (6, 7.0, 2));
    assert_eq!((frame.repeats[0].p50, frame.repeats[1].p50), (2.0, 12.0));
    assert_eq!(values(&records, |f| f.cpu_frame_ms), [vec![1.0, 2.0, 3.0], vec![11.0, 12.0, 13.0]]);

    // The file says the same.
    let mut csv = header();
    for record in &records {
        record.write("id", &mut csv);
    }
    let read = read_frames(&csv).unwrap();
    assert_eq!(read["id"]["cpu_frame_ms"], [vec![1.0, 2.0, 3.0], vec![11.0, 12.0, 13.0]]);
    assert!(!read["id"].contains_key("gpu_frame_ms"));
    assert!(read_frames("a,b\n").unwrap_err().contains("line 1"));
    assert!(read_frames(&(header() + "1,2\n")).unwrap_err().contains("line 2"));
}

#[test]
fn schedules_are_shuffled_whole_and_repeatable() {
    let protocol = Protocol { repeats: 4, ..Protocol::default() };
    let schedule = |seed| protocol.schedule(3, &mut Random::new(seed));
    assert_eq!(schedule(9), schedule(9));
    assert_ne!(schedule(9), schedule(10));
    for scene in 0..3 {
        let repeats: Vec<u32> = schedule(9).iter().filter(|turn| turn.0 == scene).map(|turn| turn.1).collect();
        assert_eq!(repeats, [0, 1, 2, 3]);
    }
    assert_eq!(
        (protocol.warmup_frames, protocol.warmup_s, protocol.measure_frames, protocol.stats_frames),
        (64, 1.0, 512, 8)
    );
    assert_eq!(Protocol { measure_frames: 0, ..Protocol::default() }.check(), Err(ProtocolError::Nothing));
    assert_eq!(Protocol { warmup_s: f64::NAN, ..Protocol::default() }.check(), Err(ProtocolError::Warmup));
}

#[test]
fn traces_nest_stages_in_frames() {
    let mut trace = Trace::default();
    let fields = Fields {
        cpu_start_ns: Some(1_000_000),
        cpu_frame_ms: Some(5.0),
        cpu_refine_ms: Some(1.0),
        cpu_wait_ms: Some(3.5),
        ..Fields::default()
    };
    let record = FrameRecord { repeat: 0, frame: 7, phase: Phase::Measure, fields };
    trace.add("scene", &record, &[Span { label: "frame", start_ns: 2_000_000, ns: 3_000_000 }]);
    let document = trace.document("id", "device");
    assert_eq!(document["metadata"]["run_id"], "id");
    let events = document["traceEvents"].as_array().unwrap();
    let spans: Vec<(&str, f64, f64)> = events
        .iter()
        .filter(|e| e["ph"] == "X")
        .map(|e| (e["name"].as_str().unwrap(), e["ts"].as_f64().unwrap(), e["dur"].as_f64().unwrap()))
        .collect();
    let expected =
        [("frame", 1000.0, 5000.0), ("refine", 1000.0, 1000.0), ("wait", 2000.0, 3500.0), ("frame", 2000.0, 3000.0)];
    assert_eq!(spans, expected);
    assert!(events.iter().any(|e| e["ph"] == "C"));
}
