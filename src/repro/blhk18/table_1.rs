//! Table 1: patches of locally refined meshes beside those of traditional ones.

use crate::repro::plot::{Bar, Bars};
use crate::repro::sheet::{cell, number};
use crate::repro::{Figure, ReproError, Sheet};

/// The table.
pub const FIGURE: Figure = Figure {
    id: "blhk18-table1",
    paper: "BLHK18",
    place: "Table 1",
    title: "Patches with local refinement and branching, against traditional gradient meshes",
    make,
};

/// The paper's rows: model, ours, traditional.
const PAPER: [(&str, u64, u64); 4] = [("leek", 59, 93), ("plum", 154, 274), ("cheese", 69, 126), ("lanterns", 76, 145)];

/// Scenes of the project.
const OURS: [&str; 6] = ["local_refinement", "sections", "radial", "branching", "sharp_colours", "still_life"];

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    let mut groups = Vec::new();
    let bar = |value: f64| Some(Bar { value, interval: None });
    for (model, local, traditional) in PAPER {
        let ratio = format!("{:.2}", traditional as f64 / local as f64);
        rows.push(vec![
            model.to_owned(),
            "paper".to_owned(),
            local.to_string(),
            traditional.to_string(),
            ratio,
            "NA".into(),
        ]);
        groups.push((format!("{model}\n(paper)"), vec![bar(local as f64), bar(traditional as f64)]));
    }
    for name in OURS {
        let scene = sheet.scene(&format!("ferguson/{name}.json"))?;
        let stats = sheet.run(&format!("stats {scene}"))?;
        let [local, traditional] = ["/patches", "/traditional"].map(|k| number(&stats, k));
        let row = ["/patches", "/traditional"].map(|k| cell(&stats, k));
        let ratio = format!("{:.2}", traditional / local);
        rows.push(vec![
            name.replace('_', " "),
            "gradtess".to_owned(),
            row[0].clone(),
            row[1].clone(),
            ratio,
            cell(&stats, "/sections"),
        ]);
        groups.push((name.replace('_', "\n"), vec![bar(local), bar(traditional)]));
    }
    sheet.caption(
        "The paper's models are not published; its rows stand as printed. The scenes below them are this project's own. A \
         traditional gradient mesh draws the same with every split continued through its row or column; where the paper \
         also used several meshes for an object, the count here keeps one.",
    );
    let columns = ["model", "made_by", "patches", "traditional", "ratio", "t_sections"];
    sheet.table("table1.csv", &columns, rows, "Patches that draw the same picture")?;
    let bars = Bars {
        axis: "patches".to_owned(),
        series: vec!["local refinement".to_owned(), "traditional".to_owned()],
        groups,
        logarithmic: false,
    };
    sheet.plot("table1.svg", &bars.svg(), "Patches with local refinement and without")
}
