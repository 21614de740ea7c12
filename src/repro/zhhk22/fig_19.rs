//! Fig. 19: several sharp edges meet.

use super::fig_9::{columns, compare};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure =
    Figure { id: "zhhk22-fig19", paper: "ZHHK22", place: "Fig. 19", title: "Sharp colour transitions that meet", make };

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for name in ["sharp_two_meet", "sharp_three_meet"] {
        let scene = sheet.scene(&format!("unit/{name}.json"))?;
        rows.extend(compare(sheet, name, &scene)?);
    }
    sheet.caption(
        "Sharp edges that meet part the colours around a vertex into sectors, which need not be regular. The paper reports at most \
         1.50 % of sqrt 3 for its example. Rows that repeat say that isolation finds no irregular vertex.",
    );
    sheet.table("errors.csv", &columns(), rows, "Distance of the colour from the limit, per cent of sqrt 3")
}
