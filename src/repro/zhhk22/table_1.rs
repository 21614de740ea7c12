//! Table 1: patch counts of all models, ours beside the paper's.

use crate::repro::plot::{Bar, Bars};
use crate::repro::sheet::{cell, number};
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::Value;

/// The table.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-table1",
    paper: "ZHHK22",
    place: "Table 1",
    title: "Patch counts by kind, against global subdivision",
    make,
};

/// Columns of counts.
const COUNTS: [&str; 6] = ["bicubic", "bicubic_transition", "gregory", "gregory_transition", "total", "global"];

/// The paper's rows, and words in the names of the authors' files of that model.
const PAPER: [(&str, &[&str], [u64; 6]); 8] = [
    ("cherry", &["cherry"], [1322, 248, 49, 4, 1371, 78336]),
    ("tulip", &["tulip"], [642, 79, 57, 4, 699, 5472]),
    ("leek", &["leek"], [930, 74, 21, 4, 951, 2160]),
    ("beach ball", &["beach", "ball"], [312, 40, 24, 0, 336, 6048]),
    ("bowling pin", &["bolling", "bowling", "pin"], [2085, 242, 0, 0, 2085, 4032]),
    ("butterfly", &["butterfly"], [3708, 458, 33, 0, 3741, 94464]),
    ("sunglasses", &["glass"], [1539, 199, 69, 6, 1608, 11088]),
    ("pear", &["pear"], [3467, 827, 43, 1, 3510, 313_344]),
];

const OURS: [&str; 5] = ["cherry.json", "triangle.json", "quad.json", "pentagon.json", "hexagon.json"];

fn row(model: &str, made_by: &str, source: &str, level: &str, counts: &[String]) -> Vec<String> {
    [model, made_by, source, level].into_iter().map(str::to_owned).chain(counts.iter().cloned()).collect()
}

fn counts(stats: &Value) -> Vec<String> {
    COUNTS.iter().map(|name| cell(stats, &format!("/{name}"))).collect()
}

/// The authors' file of a model: the one that has the deepest edits, and of those the one with the most patches.
fn published(sheet: &mut Sheet, words: &[&str]) -> Result<Option<(String, Value)>, ReproError> {
    let named = |file: &String| {
        let name = file.rsplit('/').next().unwrap_or_default().to_lowercase();
        name.ends_with(".obj") && words.iter().any(|word| name.starts_with(word))
    };
    let mut best: Option<(String, Value)> = None;
    for file in sheet.models().into_iter().filter(named) {
        let stats = sheet.run(&format!("stats {file} --rules authors"))?;
        let rank = |stats: &Value| (number(stats, "/global_level"), number(stats, "/total"));
        if best.as_ref().is_none_or(|(_, other)| rank(&stats) > rank(other)) {
            best = Some((file, stats));
        }
    }
    Ok(best)
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    let mut groups = Vec::new();
    let mut compared = Vec::new();
    for (model, words, paper) in PAPER {
        rows.push(row(model, "paper", "Table 1", "NA", &paper.map(|n| n.to_string())));
        let Some((file, authors)) = published(sheet, words)? else { continue };
        let source = file.rsplit('/').next().unwrap_or_default().to_owned();
        let ours = sheet.run(&format!("stats {file}"))?;
        let level = cell(&authors, "/global_level");
        rows.push(row(model, "rules authors", &source, &level, &counts(&authors)));
        rows.push(row(model, "rules gradtess", &source, &level, &counts(&ours)));
        let equal = COUNTS.iter().zip(paper).all(|(name, n)| number(&authors, &format!("/{name}")) == n as f64);
        compared.push(format!("{model} {}", if equal { "equals the paper's row" } else { "differs" }));
        groups.push(group(model, &ours));
    }
    for name in OURS {
        let file = sheet.scene(name)?;
        let authors = sheet.run(&format!("stats {file} --rules authors"))?;
        let ours = sheet.run(&format!("stats {file}"))?;
        let (model, level) = (format!("{} (ours)", cell(&ours, "/scene")), cell(&ours, "/global_level"));
        rows.push(row(&model, "rules authors", name, &level, &counts(&authors)));
        rows.push(row(&model, "rules gradtess", name, &level, &counts(&ours)));
        groups.push(group(&model, &ours));
    }
    sheet.caption(
        "Patches that are drawn, transition patches among them, and the faces that uniform subdivision to the level of \
         the finest edit has. Rules authors follow the authors' tool to the letter; rules gradtess grade levels and confine \
         colour edits to the sectors that they can change. Scenes marked as ours are no models of the paper and have no row in it.",
    );
    if !compared.is_empty() {
        sheet.note(format!(
            "By rules authors, {}. Where they differ, the published file is another save of the model than the table's.",
            compared.join(", ")
        ));
    }
    let columns = [&["model", "made_by", "source", "level"][..], &COUNTS].concat();
    sheet.table("table1.csv", &columns, rows, "Counts of patches; global: faces of uniform subdivision")?;
    let bars = Bars {
        axis: "patches".to_owned(),
        series: vec!["rules gradtess".to_owned(), "global".to_owned()],
        groups,
        logarithmic: true,
    };
    sheet.plot("table1.svg", &bars.svg(), "Patches drawn against faces of uniform subdivision, logarithmic")
}

fn group(model: &str, stats: &Value) -> (String, Vec<Option<Bar>>) {
    let bar = |pointer| Some(Bar { value: number(stats, pointer), interval: None });
    (model.replace(" (ours)", "\n(ours)"), vec![bar("/total"), bar("/global")])
}
