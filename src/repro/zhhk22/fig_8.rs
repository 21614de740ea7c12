//! Fig. 8: cascading around an extraordinary vertex.

use super::show::{self, ERROR_COLUMNS};
use crate::mesh;
use crate::refine::{refine, Mode, Options};
use crate::repro::sheet::number;
use crate::repro::{Figure, ReproError, Sheet};
use crate::scene::Scene;
use crate::subdiv::index_map::IndexMap;
use crate::subdiv::level::vertex_bits::EXTRAORDINARY;
use glam::DVec2;
use serde_json::{json, Value};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig8",
    paper: "ZHHK22",
    place: "Fig. 8",
    title: "Refinement around an extraordinary vertex without and with cascading",
    make,
};

/// The half-edge of M^2 that leaves the middle of a face of M^0 with an extraordinary corner: its two-ring is that face.
fn middle_of_sector(scene: &Scene) -> Option<u64> {
    let mesh = mesh::build(&scene.mesh).ok()?;
    let refined = refine(scene, &mesh, Options { mode: Mode::Global(2), ..Options::default() }).ok()?;
    let (zero, two) = (&refined.levels[0], &refined.levels[2]);
    let at = |h: u32| zero.value[zero.origin[h as usize] as usize].p;
    let extraordinary = |h: u32| zero.bits[zero.origin[h as usize] as usize] & EXTRAORDINARY != 0;
    let face = (0..zero.faces() as u32).find(|&f| zero.of_face(f).any(extraordinary))?;
    let middle = zero.of_face(face).map(at).sum::<DVec2>() / 4.0;
    let distance = |h: &usize| two.value[two.origin[*h] as usize].p.distance(middle);
    let nearest = (0..two.origin.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    Some(IndexMap::new(&mesh).to_app_a(2, nearest as u64))
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    sheet.scene("unit/valence_5.json")?;
    let bytes = crate::repro::scenes::content("unit/valence_5.json").unwrap_or_default();
    let half_edge = middle_of_sector(&Scene::parse(bytes, "valence_5.json")?)
        .ok_or_else(|| ReproError::Figure("the fan has no extraordinary vertex".to_owned()))?;
    let mut scene: Value = serde_json::from_slice(bytes).map_err(|e| ReproError::Figure(e.to_string()))?;
    scene["geometry"] = json!([{"level": 2, "half_edge": half_edge, "a": 0.3, "b": 0.3}]);
    if let Some(keys) = scene.as_object_mut() {
        keys.remove("$schema");
    }
    let file = sheet.write("edited_fan.json", &format!("{scene}\n"))?;
    let ways = [
        ("off", "without cascading", "--rules authors --no-cascade"),
        ("authors", "with cascading, rules authors", "--rules authors"),
        ("gradtess", "with cascading, rules gradtess", ""),
    ];
    let mut rows = Vec::new();
    for (name, words, flags) in ways {
        let stats = sheet.run(&format!("stats {file} {flags}"))?;
        show::wire(sheet, &file, &format!("{name}_mesh"), flags, words)?;
        let cells = show::error(sheet, &file, &format!("{name}_error"), flags, words)?;
        let counts = ["/levels/0/affected", "/total"].map(|key| number(&stats, key).to_string());
        rows.push([words.to_owned()].into_iter().chain(counts).chain(cells).collect());
    }
    sheet.caption(
        "A vertex of M^2 in one sector of a vertex of valence 5 is moved. Without cascading that sector alone is refined, and its \
         Gregory patches meet coarser ones of the neighbours; with it all sectors are refined to the same level.",
    );
    let columns = [&["refinement", "faces_of_M0_refined", "patches"][..], &ERROR_COLUMNS].concat();
    sheet.table(
        "cascade.csv",
        &columns,
        rows,
        "Faces refined, and the distance of the colour from the limit in per cent of sqrt 3",
    )
}
