//! Fig. 11: self-intersection prevention.

use super::show;
use crate::edit::drag::Drag;
use crate::edit::folds::{drag_within, Cost, Watch};
use crate::edit::handle::{least_slot, Id, Kind};
use crate::edit::model::{Drawing, Model};
use crate::edit::EditError;
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};
use crate::scene::{native, Scene};
use crate::subdiv::index_map::IndexMap;
use crate::subdiv::level::vertex_bits::BOUNDARY;
use glam::DVec2;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig11",
    paper: "ZHHK22",
    place: "Fig. 11",
    title: "A handle dragged as far as nothing folds",
    make,
};

fn failed(e: EditError) -> ReproError {
    ReproError::Figure(e.to_string())
}

/// Where a drag of the first inner vertex of M^0 ended; the scene at its end, and one dragged a little farther.
struct Dragged {
    start: DVec2,
    end: DVec2,
    tries: u32,
    scenes: [Scene; 2],
}

/// Share of the scene's size by which the drag goes on past its end.
const PAST: f64 = 0.02;

fn drag(scene: Scene) -> Result<Dragged, EditError> {
    let model = Model::new(scene.clone(), Drawing::default())?;
    let zero = &model.refinement.levels[0];
    let inner = (0..zero.origin.len()).find(|&h| zero.bits[zero.origin[h] as usize] & BOUNDARY == 0);
    let slot = least_slot(&IndexMap::new(&model.mesh), 0, inner.unwrap_or(0) as u64);
    let drag = Drag::begin(&scene, &model.mesh, Id { kind: Kind::Vertex, level: 0, slot })?;
    let size = crate::edit::drag::size_of(&scene);
    let (start, aim) = (drag.start(), DVec2::new(1.0, 0.2).normalize());
    let (mut last, mut cost) = (scene.clone(), Cost::default());
    let end = drag_within(
        &mut Watch::new(&model),
        &drag,
        &model,
        &mut last,
        [start, start + 2.0 * size * aim],
        1e-4 * size,
        &mut cost,
    )?;
    let mut past = scene;
    drag.to(&mut past, &model.mesh, end + PAST * size * aim)?;
    Ok(Dragged { start, end, tries: cost.tries, scenes: [last, past] })
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for name in ["quad", "triangle"] {
        let file = format!("{name}.json");
        sheet.scene(&file)?;
        let bytes = crate::repro::scenes::content(&file).unwrap_or_default();
        let done = drag(Scene::parse(bytes, &file)?).map_err(failed)?;
        for (scene, what) in done.scenes.iter().zip(["stopped", "dragged_on"]) {
            let file = sheet.write(&format!("{name}_{what}.json"), &native::write(scene))?;
            let words = format!("{name}, {}", what.replace('_', " "));
            show::picture(sheet, &file, &format!("{name}_{what}"), "--tess 10 --show wire", &words)?;
            let found = sheet.run(&format!("check {file} --zooms 0 --size 64x64 --max-cracks 100000"))?;
            let mut row = vec![name.to_owned(), what.replace('_', " ")];
            row.push(done.start.distance(done.end).to_string());
            row.push(done.tries.to_string());
            row.extend(
                ["folded", "undecided", "gd01", "positive", "least_sine"].map(|k| cell(&found, &format!("/folds/{k}"))),
            );
            rows.push(row);
        }
    }
    sheet.caption(
        "An inner vertex of M^0 is dragged to the right, as the editor does it with fold-over prevention: the drag stops where the \
         next position would turn a patch over. Beside it the same drag two per cent of the scene farther. The paper tests bicubics \
         in place of Gregory patches and lets those overlap slightly; here each patch is tested as what it is drawn as.",
    );
    let columns = [
        "scene",
        "drag",
        "distance",
        "positions_tried",
        "folded",
        "undecided",
        "injective_by_gd01",
        "positive_jacobian",
        "least_sine",
    ];
    sheet.table(
        "folds.csv",
        &columns,
        rows,
        "Faces that are turned over where the drag has stopped, and a little farther",
    )
}
