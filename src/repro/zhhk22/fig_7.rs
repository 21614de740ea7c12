//! Fig. 7: an irregular face and its ring are refined.

use super::show::{self, corners};
use crate::repro::plot::Mesh;
use crate::repro::sheet::number;
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::{json, Value};

/// The figure.
pub const FIGURE: Figure =
    Figure { id: "zhhk22-fig7", paper: "ZHHK22", place: "Fig. 7", title: "Refinement around an irregular face", make };

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let scene = json!({
        "gradtess": 1, "name": "a quad and a triangle",
        "vertices": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.87, 0.5]],
        "faces": [[0, 1, 2, 3], [1, 4, 2]],
    });
    let file = sheet.write("quad_and_triangle.json", &format!("{scene}\n"))?;
    let [faces, polygons] = show::base_mesh(sheet, &file, "M0", "M^0 after the ternary step")?;
    let stats = sheet.run(&format!("stats {file}"))?;
    let patches = sheet.run(&format!("patches {file}"))?;
    let drawn = |p: &Value| {
        let fill = match (p["level"].as_u64(), p["kind"].as_str()) {
            (_, Some("gregory")) => 1,
            (Some(0), _) if p["constellation"].as_u64() != Some(0) => 2,
            (Some(0), _) => 0,
            _ => 3,
        };
        (corners(p), fill)
    };
    let mesh = Mesh {
        fills: ["level 0", "level 1, Gregory", "level 0, transition", "level 1"].map(str::to_owned).to_vec(),
        faces: patches["patches"].as_array().into_iter().flatten().map(drawn).collect(),
    };
    sheet.plot("M1.svg", &mesh.svg(), "What is drawn, on the limit: the triangle and its ring stand on level 1")?;
    sheet.caption(
        "The ternary step leaves a smaller triangle in the triangle. It and the faces at its corners are refined once, after which \
         all faces are quads; the rest stays on level 0.",
    );
    let affected = number(&stats, "/levels/0/affected");
    let row =
        [faces as f64, polygons as f64, affected, number(&stats, "/levels/0/drawn"), number(&stats, "/levels/1/drawn")];
    let columns = ["faces_M0", "non_quads", "refined", "drawn_at_level_0", "drawn_at_level_1"];
    sheet.table(
        "faces.csv",
        &columns,
        vec![row.map(|n| n.to_string()).to_vec()],
        "Faces of M^0 and what becomes of them",
    )
}
