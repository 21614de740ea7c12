//! `gradtess render` of a gradient mesh: what differs is how patches come about.

use super::open::{rule, target, Ferguson};
use crate::command::Failure;
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use std::time::Instant;

/// Patches for a picture.
pub struct Patches {
    /// The table.
    pub table: PatchTable,
    /// What is seen.
    pub view: [f64; 4],
    /// Time of virtual subdivision, ms.
    pub fit_ms: f64,
    /// Time of the patch table, ms.
    pub table_ms: f64,
}

/// Makes the patches of a picture.
pub fn patches(
    ferguson: &Ferguson,
    tess: TessRule,
    view: Option<[f64; 4]>,
    size: [u32; 2],
) -> Result<Patches, Failure> {
    let rule = rule(tess)?;
    let view = ferguson.view(view, size)?;
    let begun = Instant::now();
    let target = target(rule, view, size);
    let fitted = ferguson.mesh.fit(&target);
    let fitted_at = Instant::now();
    let table = crate::ferguson::table::table(&fitted, &target);
    let ms = |from: Instant, to: Instant| crate::command::open::milliseconds((to - from).as_nanos());
    let made = Instant::now();
    Ok(Patches { table, view, fit_ms: ms(begun, fitted_at), table_ms: ms(fitted_at, made) })
}
