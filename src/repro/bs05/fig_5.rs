//! Fig. 5: curved PN triangles.

use super::{counts, draw};
use crate::repro::sheet::{cell, number};
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure =
    Figure { id: "bs05-fig5", paper: "BS05", place: "Fig. 5", title: "Curved PN triangles in the vertex shader", make };

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let scene = sheet.scene("pattern/character.json")?;
    let mut rows = Vec::new();
    let looks = [
        ("coarse", "--evaluator linear --level 1", "The coarse mesh"),
        ("wire", "--evaluator pn --level 8 --show wire", "The pattern of level 8 on each triangle"),
        ("pn", "--evaluator pn --level 32", "Curved PN triangles with quadratic normals"),
        ("linear_normals", "--evaluator pn --level 32 --normal-field linear", "The same with linear normals"),
        ("factor_4", "--evaluator pn --level 32 --normal-field boubekeur", "With the factor 4 of App. A as printed"),
    ];
    for (name, flags, words) in looks {
        let said =
            draw(sheet, &format!("{name}.png"), &scene, &format!("{flags} --orbit 30,10"), |_| words.to_owned())?;
        rows.push([vec![name.to_owned()], counts(&said).to_vec()].concat());
    }
    let columns = ["what", "vertices_stored", "triangles_drawn", "device_bytes"];
    sheet.table("counts.csv", &columns, rows, "What each picture stores and draws")?;
    let mut rows = Vec::new();
    for coefficients in ["cpu", "gpu"] {
        for evaluator in ["linear", "pn", "st"] {
            let said = sheet.run(&format!(
                "check {scene} --evaluator {evaluator} --coefficients {coefficients} --zooms 20 --size 320x240"
            ))?;
            rows.push(vec![
                evaluator.to_owned(),
                coefficients.to_owned(),
                format!("{:.1e}", number(&said, "/max_error")),
                cell(&said, "/edges_shared"),
                cell(&said, "/parted"),
                cell(&said, "/crack_pixels"),
            ]);
        }
    }
    sheet.caption(
        "Ten coefficients a triangle, made on the CPU as in the paper or by a compute shader, and evaluated where the \
         pattern's vertices are. Neighbours share their edge curves bit for bit.",
    );
    let columns = ["evaluator", "coefficients", "error_of_diagonal", "edges_shared", "vertices_parted", "crack_pixels"];
    sheet.table("check.csv", &columns, rows, "Positions of the device against the CPU, seams, and cracks in 20 views")
}
