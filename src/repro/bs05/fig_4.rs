//! Fig. 4: procedural displacement of high frequency.

use super::{counts, draw};
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "bs05-fig4",
    paper: "BS05",
    place: "Fig. 4",
    title: "Procedural displacement: smooth at a high level of the pattern only",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let sphere = sheet.scene("pattern/sphere.json")?;
    let mut rows = Vec::new();
    for level in [8, 32, 128] {
        let words = |said: &_| format!("Level {level}: {} triangles", cell(said, "/triangles"));
        let said = draw(sheet, &format!("sphere_{level}.png"), &sphere, &format!("--level {level}"), words)?;
        rows.push([vec![format!("sphere {level}")], counts(&said).to_vec()].concat());
    }
    let said =
        draw(sheet, "static.png", &sphere, "--level 128 --method static", |_| "The same as a static mesh".to_owned())?;
    rows.push([vec!["sphere 128, static mesh".to_owned()], counts(&said).to_vec()].concat());
    let ocean = sheet.scene("pattern/ocean.json")?;
    for time in [0, 1] {
        let name = format!("ocean_{time}.png");
        let flags = format!("--time {time} --orbit 20,25");
        draw(sheet, &name, &ocean, &flags, |_| format!("Gradient noise at time {time}"))?;
    }
    sheet.caption(
        "a sin(f |P|) along the normals of a sphere of 80 curved triangles, and octaves of gradient noise, which the paper \
         names as the next step. Every frame may have another time: nothing is uploaded. The pattern is all that is stored.",
    );
    let columns = ["what", "vertices_stored", "triangles_drawn", "device_bytes"];
    sheet.table("counts.csv", &columns, rows, "What each picture stores and draws")
}
