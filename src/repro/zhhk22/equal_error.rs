//! Tessellation factors by the error that they leave.

use super::timing::size;
use crate::repro::sheet::number;
use crate::repro::{ReproError, Sheet};
use std::collections::BTreeMap;

/// Errors that are greater by this factor still count as equal.
pub const TOLERANCE: f64 = 1.01;

/// Greatest and mean error, per cent.
pub type Error = [f64; 2];

/// The error of the picture of a scene with further flags of `check`.
pub fn error(sheet: &mut Sheet, scene: &str, flags: &str) -> Result<Error, ReproError> {
    let found = sheet.run(&format!("check {scene} --zooms 0 --size {} {flags}", size(sheet)))?;
    Ok(["/error/max_percent", "/error/mean_percent"].map(|key| number(&found, key)))
}

/// Errors of factors that are known by now.
pub type Known = BTreeMap<u32, Error>;

/// The least of the ascending `factors` of `flag` that errs as little as `goal` in both numbers, by bisection, and its error.
pub fn least(
    sheet: &mut Sheet,
    scene: &str,
    flag: &str,
    factors: &[u32],
    goal: Error,
    known: &mut Known,
) -> Result<Option<(u32, Error)>, ReproError> {
    let (mut low, mut high) = (0, factors.len());
    let mut best = None;
    while low < high {
        let middle = (low + high) / 2;
        let factor = factors[middle];
        let found = match known.get(&factor) {
            Some(&found) => found,
            None => error(sheet, scene, &format!("{flag} {factor}"))?,
        };
        known.insert(factor, found);
        if found.iter().zip(goal).all(|(e, g)| *e <= g * TOLERANCE) {
            best = Some((factor, found));
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    Ok(best)
}
