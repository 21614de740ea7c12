//! Statistics of a set of times. No value is ever removed.

use super::random::Random;
use serde::{Deserialize, Serialize};

/// Resamples of a bootstrap interval. The ends of a 95 % interval then lie on the 25th value from either side.
pub const RESAMPLES: usize = 1000;

/// What `run.json` says of one scope. Units are those of the values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Values.
    pub n: usize,
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation of a sample (divisor n - 1); 0 for one value.
    pub sd: f64,
    /// Least value.
    pub min: f64,
    /// Percentiles by nearest rank: the least value that at least so many per cent of all do not exceed.
    pub p50: f64,
    /// 90 %.
    pub p90: f64,
    /// 95 %.
    pub p95: f64,
    /// 99 %.
    pub p99: f64,
    /// Greatest value.
    pub max: f64,
    /// Percentile bootstrap 95 % interval of `p50`.
    pub median_ci95: [f64; 2],
}

/// Summary of `values`, `None` without any. `seed` is that of the bootstrap.
pub fn summary(values: &[f64], seed: u64) -> Option<Summary> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (&min, &max) = (sorted.first()?, sorted.last()?);
    let mean = mean(values);
    let squares: Vec<f64> = values.iter().map(|x| (x - mean) * (x - mean)).collect();
    Some(Summary {
        n: values.len(),
        mean,
        sd: if values.len() > 1 { (sum(&squares) / (values.len() - 1) as f64).sqrt() } else { 0.0 },
        min,
        p50: percentile(&sorted, 50.0),
        p90: percentile(&sorted, 90.0),
        p95: percentile(&sorted, 95.0),
        p99: percentile(&sorted, 99.0),
        max,
        median_ci95: median_interval(&sorted, seed),
    })
}

/// Sum with compensation (Neumaier 1974): exact to about one rounding, whatever the order.
pub fn sum(values: &[f64]) -> f64 {
    let (mut sum, mut lost) = (0.0f64, 0.0);
    for &x in values {
        let t = sum + x;
        lost += if sum.abs() >= x.abs() { (sum - t) + x } else { (x - t) + sum };
        sum = t;
    }
    sum + lost
}

/// Arithmetic mean; NaN without values.
pub fn mean(values: &[f64]) -> f64 {
    sum(values) / values.len() as f64
}

/// Rank (from 1) of a percentile among `n` values, by nearest rank: ceil(p n / 100), at least 1.
fn rank(n: usize, p: f64) -> usize {
    // Whole per cents, so that 95 % of 20 values is rank 19 and not, by rounding, 20.
    ((p * n as f64 / 100.0 - 1e-9).ceil() as usize).clamp(1, n)
}

/// Percentile by nearest rank of values in ascending order, at least one.
pub fn percentile(sorted: &[f64], p: f64) -> f64 {
    sorted[rank(sorted.len(), p) - 1]
}

/// Percentile bootstrap 95 % interval of the median of values in ascending order.
fn median_interval(sorted: &[f64], seed: u64) -> [f64; 2] {
    let n = sorted.len();
    let mut random = Random::new(seed);
    let mut drawn = vec![0u32; n];
    let mut medians: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            drawn.fill_with(|| random.below(n) as u32);
            // Order statistics of values are values of order statistics.
            sorted[*drawn.select_nth_unstable(rank(n, 50.0) - 1).1 as usize]
        })
        .collect();
    interval(&mut medians)
}

/// The middle 95 % of bootstrap values, which are put in order.
pub fn interval(values: &mut [f64]) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [percentile(values, 2.5), percentile(values, 97.5)]
}
