//! Two configurations measured in one run, frame by frame in turns: is one slower?
//!
//! Frame i of A and frame i of B are measured next to each other, in random order. Whatever disturbs the machine disturbs
//! both alike, so the ratio of the two is far steadier than either time. Disturbances last longer than a frame: the
//! bootstrap draws blocks of neighbouring pairs (Künsch 1989), not single ones.

use super::random::Random;
use super::statistics::{interval, percentile, sum, RESAMPLES};
use serde::{Deserialize, Serialize};

/// Whether the interval holds 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The interval contains 1: no difference was found.
    Equal,
    /// It does not.
    Different,
}

/// A ratio of times with its bootstrap 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ratio {
    /// Time of B over time of A: 2 means that B takes twice as long.
    pub ratio: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// What the interval says.
    pub verdict: Verdict,
}

impl Ratio {
    /// A ratio and its interval with the verdict that follows.
    pub fn new(ratio: f64, ci95: [f64; 2]) -> Ratio {
        let verdict = if ci95[0] <= 1.0 && 1.0 <= ci95[1] { Verdict::Equal } else { Verdict::Different };
        Ratio { ratio, ci95, verdict }
    }
}

/// What a pair of configurations amounts to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairRatios {
    /// Pairs of frames.
    pub n: usize,
    /// Median of the ratios of single pairs: the verdict of the pair.
    pub median: Ratio,
    /// Ratio of the mean times, which is what the paper's charts show. One disturbed frame in a hundred widens it.
    pub mean: Ratio,
}

/// Ratios of `b[i]` to `a[i]`; `None` unless there are as many of both, at least one, and all are positive.
pub fn ratios(a: &[f64], b: &[f64], seed: u64) -> Option<PairRatios> {
    let n = a.len();
    if n == 0 || n != b.len() || a.iter().chain(b).any(|t| t.is_nan() || *t <= 0.0) {
        return None;
    }
    let single: Vec<f64> = a.iter().zip(b).map(|(a, b)| b / a).collect();
    // The cube root of n: the usual length where correlation dies out quickly.
    let block = (n as f64).cbrt().ceil() as usize;
    let mut random = Random::new(seed);
    let mut index = Vec::with_capacity(n + block);
    let (mut medians, mut means) = (Vec::with_capacity(RESAMPLES), Vec::with_capacity(RESAMPLES));
    for _ in 0..RESAMPLES {
        index.clear();
        while index.len() < n {
            let start = random.below(n);
            index.extend((0..block).map(|k| (start + k) % n));
        }
        index.truncate(n);
        let mut drawn: Vec<f64> = index.iter().map(|&i| single[i]).collect();
        medians.push(middle(&mut drawn));
        let total = |t: &[f64]| index.iter().map(|&i| t[i]).sum::<f64>();
        means.push(total(b) / total(a));
    }
    Some(PairRatios {
        n,
        median: Ratio::new(middle(&mut single.clone()), interval(&mut medians)),
        mean: Ratio::new(sum(b) / sum(a), interval(&mut means)),
    })
}

/// Median; between two values their geometric mean, so that A over B is one over B over A.
fn middle(values: &mut [f64]) -> f64 {
    let n = values.len();
    let (below, &mut upper, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    if n % 2 == 1 {
        return upper;
    }
    let lower = below.iter().copied().max_by(f64::total_cmp).unwrap_or(upper);
    (lower * upper).sqrt()
}

/// Ratio of the medians of `b` to `a`, measured in different runs: each is a list of repeats. Repeats are drawn first and
/// frames within them second, since what differs from repeat to repeat differs between runs too.
pub fn unpaired(a: &[Vec<f64>], b: &[Vec<f64>], seed: u64) -> Option<Ratio> {
    let pooled = |runs: &[Vec<f64>]| runs.iter().flatten().copied().collect::<Vec<f64>>();
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        percentile(&values, 50.0)
    };
    let (all_a, all_b) = (pooled(a), pooled(b));
    if all_a.is_empty() || all_b.is_empty() || all_a.iter().chain(&all_b).any(|t| t.is_nan() || *t <= 0.0) {
        return None;
    }
    let mut random = Random::new(seed);
    let mut resample = |runs: &[Vec<f64>]| {
        let runs: Vec<&Vec<f64>> = runs.iter().filter(|run| !run.is_empty()).collect();
        let mut drawn = Vec::new();
        for _ in 0..runs.len() {
            let run = runs[random.below(runs.len())];
            drawn.extend((0..run.len()).map(|_| run[random.below(run.len())]));
        }
        drawn
    };
    let mut ratios: Vec<f64> = (0..RESAMPLES).map(|_| median(resample(b)) / median(resample(a))).collect();
    Some(Ratio::new(median(all_b) / median(all_a), interval(&mut ratios)))
}
