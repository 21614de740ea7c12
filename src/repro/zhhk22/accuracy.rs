//! Beside Sec. 6: the greatest error of every scene and model, and what causes those above the bounds.

use crate::repro::sheet::{cell, number};
use crate::repro::{scenes, Figure, ReproError, Sheet};
use serde_json::Value;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-accuracy",
    paper: "ZHHK22",
    place: "beside Sec. 6",
    title: "The greatest error of every scene and model",
    make,
};

/// Bound with `--isolate 3`, per cent of sqrt 3.
const ISOLATED: f64 = 0.02;

/// Bound of rules gradtess at darts and where sharp edges meet.
const SHARP: f64 = 0.05;

/// What the paper reports of kinds of features, and files that have them.
const PAPER: [(&str, f64, &[&str]); 4] = [
    ("bowling pin", 0.31, &["bolling_Subd3.obj"]),
    ("polygons, as the beach ball", 0.53, &["mixed_polygons.json"]),
    ("dart", 0.067, &["sharp_dart.json"]),
    ("several sharp edges", 1.5, &["sharp_two_meet.json", "sharp_three_meet.json"]),
];

/// In names of the authors' files that hold an earlier state of a model.
const EARLIER: [&str; 13] = [
    "Subd0",
    "Subd1",
    "bolling_Subd2",
    "editAtSubd2",
    "editAtSubd3",
    "editAtSubd4",
    "Subdi2",
    "Subdi3",
    "glass0",
    "glass1",
    "glass2",
    "House",
    "Quad.obj",
];

/// What is compared with a bound.
struct Bounded {
    case: String,
    bound: f64,
    scene: String,
    flags: &'static str,
    found: Value,
}

fn check(sheet: &mut Sheet, scene: &str, flags: &str) -> Result<Value, ReproError> {
    sheet.run(&format!("check {scene} --zooms 0 --size 480x480 {flags}"))
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut files: Vec<String> = Vec::new();
    for name in scenes::subdivision() {
        files.push(sheet.scene(name)?);
    }
    // Earlier saves of a model have nothing that its last one has not.
    let full = sheet.full();
    let wanted = |file: &String| file.ends_with(".obj") && (full || !EARLIER.iter().any(|name| file.contains(name)));
    for file in sheet.models().into_iter().filter(wanted) {
        // Surfaces in space are OBJ files too.
        if sheet.run(&format!("stats {file}"))?["technique"].is_null() {
            files.push(file);
        }
    }
    let (mut rows, mut bounded) = (Vec::new(), Vec::new());
    for scene in files {
        let name = scene.trim_start_matches("$MODELS/").to_owned();
        let own = check(sheet, &scene, "--tess 64")?;
        let isolated = check(sheet, &scene, "--tess 64 --isolate 3")?;
        let authors = check(sheet, &scene, "--tess 64 --rules authors")?;
        let max = |found: &Value| cell(found, "/error/max_percent");
        let folds = |what: &str| cell(&isolated, &format!("/error/folds/{what}"));
        rows.push(vec![name.clone(), max(&authors), max(&own), max(&isolated), folds("pixels"), folds("max_percent")]);
        let file = name.rsplit('/').next().unwrap_or(&name);
        let mut bound = |case: &str, bound, flags, found: &Value| {
            let case = format!("{name}: {case}");
            bounded.push(Bounded { case, bound, scene: scene.clone(), flags, found: found.clone() });
        };
        if let Some((kind, most, _)) = PAPER.iter().find(|(_, _, files)| files.contains(&file)) {
            bound(&format!("{kind}, rules authors"), *most, "--rules authors", &authors);
        }
        if file.starts_with("sharp_") {
            bound("sharp edges, rules gradtess", SHARP, "", &own);
        }
        bound("--isolate 3", ISOLATED, "--isolate 3", &isolated);
    }
    let mut verdicts = Vec::new();
    let mut met = [0; 2];
    for case in &bounded {
        let max = number(&case.found, "/error/max_percent");
        let good = max <= case.bound;
        met[usize::from(good)] += 1;
        if good && case.bound == ISOLATED {
            // All of them are in the other table.
            continue;
        }
        let why = if good { String::new() } else { why(sheet, case)? };
        let verdict = if good { "met" } else { "not met" };
        verdicts.push(vec![case.case.clone(), case.bound.to_string(), max.to_string(), verdict.to_owned(), why]);
    }
    sheet.caption(format!(
        "Greatest distance of the colour from the limit, per cent of sqrt 3, at 480 x 480 pixels and 64 segments an edge: segments of one \
         pixel are chords too long for colours in patches of few pixels. Pixels of silhouettes and sharp edges are left out; those \
         where the surface folds over stand in columns of their own, as the order of drawing decides which layer they show. Bounds: what the paper reports by rules authors; {SHARP} % at darts \
         and meeting sharp edges by rules gradtess; {ISOLATED} % with --isolate 3 anywhere. {} of {} bounds are met.",
        met[1],
        met[0] + met[1]
    ));
    let columns = ["case", "bound_percent", "max_percent", "verdict", "beyond_because"];
    sheet.table(
        "bounds.csv",
        &columns,
        verdicts,
        format!("Bounds and what exceeds them. Of --isolate 3, only what exceeds {ISOLATED} %"),
    )?;
    let columns = [
        "scene",
        "authors_percent",
        "gradtess_percent",
        "isolated_percent",
        "fold_pixels",
        "isolated_in_folds_percent",
    ];
    sheet.table("errors.csv", &columns, rows, "Maxima by rules authors, by rules gradtess, and with --isolate 3")
}

/// Where a bound is exceeded, and by what: chords grow a quarter as large when segments are halved, patches stay as they are.
fn why(sheet: &mut Sheet, case: &Bounded) -> Result<String, ReproError> {
    let [coarse, fine] = [32, 64].map(|tess| format!("--tess {tess} {}", case.flags));
    let coarse = number(&check(sheet, &case.scene, &coarse)?, "/error/max_percent");
    let fine = number(&check(sheet, &case.scene, &fine)?, "/error/max_percent");
    let worst = |what: &str| cell(&case.found, &format!("/error/worst/{what}"));
    let round = |what: &str| number(&case.found, &format!("/error/worst/{what}"));
    let place = format!(
        "pixel {},{} in {} patch {} of level {} at u {:.3}, v {:.3}",
        worst("pixel/0"),
        worst("pixel/1"),
        worst("kind"),
        worst("patch"),
        worst("level"),
        round("u"),
        round("v")
    );
    let cause = if coarse > 2.5 * fine {
        // Of second order: what is left for ever finer segments.
        let left = ((4.0 * fine - coarse) / 3.0).max(0.0);
        format!("chords: 64 segments an edge, the most of every device, are too few here; endlessly many would leave {left:.4} %")
    } else if worst("kind") == "gregory" {
        "the patch itself: a Gregory patch approximates the limit at an irregular face".to_owned()
    } else {
        "the patch itself: a bicubic where the limit is none by these rules".to_owned()
    };
    Ok(format!("{place}; {coarse:.4} % with 32 segments an edge, {fine:.4} % with 64: {cause}"))
}
