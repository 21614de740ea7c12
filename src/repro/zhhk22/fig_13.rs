//! Figs. 13 to 16: models, their meshes, and how far their pictures are from the limit.

use super::show::{self, ERROR_COLUMNS};
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};

const fn figure(id: &'static str, place: &'static str, title: &'static str, make: Make) -> Figure {
    Figure { id, paper: "ZHHK22", place, title, make }
}

type Make = fn(&mut Sheet) -> Result<(), ReproError>;

/// The bowling pin, and a mesh of several polygons of our own.
pub const FIG_13: Figure =
    figure("zhhk22-fig13", "Fig. 13", "The bowling pin: meshes and distance from the limit", |sheet| {
        let pin = sheet.model("bolling/bolling_Subd3.obj");
        let own = sheet.scene("unit/geometry_level_2.json")?;
        let paper = "The paper reports at most 0.31 % for the pin.";
        models(sheet, &[("bowling_pin", pin), ("our_geometry_edit", Some(own))], paper)
    });

/// The beach ball, which is not published: a mesh of our own with polygons of several kinds.
pub const FIG_14: Figure =
    figure("zhhk22-fig14", "Fig. 14", "In place of the beach ball: polygons of several kinds", |sheet| {
        let own = sheet.scene("unit/mixed_polygons.json")?;
        let paper = "The paper reports at most 0.53 % for its beach ball, which is not published.";
        models(sheet, &[("our_polygons", Some(own))], paper)
    });

/// The butterfly, and our cherry.
pub const FIG_15: Figure = figure("zhhk22-fig15", "Fig. 15", "The butterfly: local against global meshes", |sheet| {
    let butterfly = sheet.model("butterfly/butterfly_Subdi4.obj");
    let own = sheet.scene("cherry.json")?;
    let paper = "The published butterfly has edits down to level 4; the paper counts faces of level 5.";
    models(sheet, &[("butterfly", butterfly), ("our_cherry", Some(own))], paper)
});

/// The sunglasses, and a mesh of our own with a hole.
pub const FIG_16: Figure = figure("zhhk22-fig16", "Fig. 16", "The sunglasses: local against global meshes", |sheet| {
    let glasses = sheet.model("glass/1/glass3.obj");
    let own = sheet.scene("unit/hole.json")?;
    models(sheet, &[("sunglasses", glasses), ("our_mesh_with_a_hole", Some(own))], "")
});

fn models(sheet: &mut Sheet, models: &[(&str, Option<String>)], paper: &str) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for (name, scene) in models {
        let Some(scene) = scene else { continue };
        let words = name.replace('_', " ");
        show::base_mesh(sheet, scene, &format!("{name}_base"), &format!("{words}: M^0"))?;
        let caption = format!("{words}: uniform subdivision");
        let whole = show::wire(sheet, scene, &format!("{name}_global"), "--mode global", &caption)?;
        let global = cell(&whole, "/patches");
        show::wire(sheet, scene, &format!("{name}_mesh"), "", &format!("{words}: adaptive refinement"))?;
        show::picture(sheet, scene, name, "", &words)?;
        for (way, flags) in [("authors", "--rules authors"), ("gradtess", "")] {
            let what = format!("{words}, rules {way}");
            let total = cell(&sheet.run(&format!("stats {scene} {flags}"))?, "/total");
            let cells = show::error(sheet, scene, &format!("{name}_error_{way}"), flags, &what)?;
            let first = |tess: &str| [words.clone(), way.to_owned(), tess.to_owned(), total.clone(), global.clone()];
            rows.push(first("--pixels 1").into_iter().chain(cells).collect());
            let cells = show::error_at(sheet, scene, &format!("--tess 16 {flags}"))?;
            rows.push(first("--tess 16").into_iter().chain(cells).collect());
        }
    }
    sheet.caption(format!(
        "M^0, the meshes of uniform and of adaptive refinement, the surface, and its distance from the limit in the unit RGB cube: \
         per cent of sqrt 3, mapped × 200, so that half a per cent is the brightest; pixels of silhouettes and sharp edges are \
         grey and not compared. Pictures have segments of one pixel; the table has 16 segments an edge too. {paper}"
    ));
    let columns = [&["scene", "rules", "tessellation", "patches", "global"][..], &ERROR_COLUMNS].concat();
    sheet.table(
        "errors.csv",
        &columns,
        rows,
        "Distance of the colour from the limit, per cent of sqrt 3; global: faces of uniform subdivision",
    )
}
