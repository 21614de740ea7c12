//! Fig. 3: levels of detail, and what the paper leaves to the future: adaptive ones, and geomorphing.

use super::{counts, draw};
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "bs05-fig3",
    paper: "BS05",
    place: "Fig. 3",
    title: "Levels of detail by choosing a pattern; adaptive and geomorphic ones",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let character = sheet.scene("pattern/character.json")?;
    let mut rows = Vec::new();
    for level in [1, 2, 4, 16] {
        let words = |said: &_| format!("Level {level}: {} triangles", cell(said, "/triangles"));
        let name = format!("level_{level}.png");
        let said = draw(sheet, &name, &character, &format!("--level {level} --orbit 30,10"), words)?;
        rows.push([vec![format!("level {level}")], counts(&said).to_vec()].concat());
    }
    // From close by, so that edges differ in length on the picture.
    let ocean = sheet.scene("pattern/ocean.json")?;
    for (scope, words) in [("mesh", "One level for all of the ocean"), ("triangle", "Each edge has its own")] {
        let flags = format!("--lod {scope} --method indirect --segment 10 --show wire --orbit 20,12 --distance 3.2");
        let name = format!("ocean_{scope}.png");
        let said =
            draw(sheet, &name, &ocean, &flags, |said| format!("{words}: {} triangles", cell(said, "/triangles")))?;
        rows.push([vec![format!("ocean, {scope}")], counts(&said).to_vec()].concat());
    }
    let columns = ["what", "vertices_stored", "triangles_drawn", "device_bytes"];
    sheet.table("counts.csv", &columns, rows, "What each picture stores and draws")?;

    let mut rows = Vec::new();
    let frames = if sheet.full() { 300 } else { 60 };
    for name in ["sphere", "character", "ocean"] {
        let scene = sheet.scene(&format!("pattern/{name}.json"))?;
        let said = sheet
            .run(&format!("check {scene} --lod triangle --method indirect --zooms 0 --fly {frames} --size 320x240"))?;
        let cells = ["/flight/frames", "/flight/background_inside", "/edges_shared", "/parted"].map(|p| cell(&said, p));
        rows.push([vec![name.to_owned()], cells.to_vec()].concat());
    }
    let columns = ["scene", "frames", "background_inside", "edges_shared", "vertices_parted"];
    sheet.table(
        "flight.csv",
        &columns,
        rows,
        "A flight around and close by: background pixels within the outline, and seams bit by bit",
    )?;

    let ball = sheet.scene("pattern/ball.json")?;
    let mut rows = Vec::new();
    for (what, flag) in [("geomorphing", ""), ("popping", "--no-morph")] {
        let said = sheet.run(&format!(
            "check {ball} --lod triangle --segment 240 --zooms 0 --slow-zoom 300 --size 320x240 {flag}"
        ))?;
        let cells = ["/zoom/frames", "/zoom/change", "/zoom/change_at_one_level"].map(|p| cell(&said, p));
        rows.push([vec![what.to_owned()], cells.to_vec()].concat());
    }
    let columns = ["levels", "frames", "change_of_255", "change_at_one_level"];
    sheet.table(
        "zoom.csv",
        &columns,
        rows,
        "A slow zoom to half the distance: greatest change of a pixel from frame to frame",
    )?;
    sheet.caption(
        "Patterns of several levels, chosen when drawn; creases stay. The paper chooses one level for a mesh by its distance \
         and says that it pops. Levels of edges, of which both triangles think the same, let triangles differ without \
         cracks, and vertices that slide along the surface let levels change without a jump.",
    );
    Ok(())
}
