//! Fig. 6: scalar tagged meshes.

use super::{counts, draw};
use crate::repro::sheet::cell;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "bs05-fig6",
    paper: "BS05",
    place: "Fig. 6",
    title: "Scalar tagged triangles: two creases by tags of the vertices",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let scene = sheet.scene("pattern/character.json")?;
    let mut rows = Vec::new();
    let looks = [
        ("coarse", "--evaluator linear --level 1", "The coarse mesh"),
        ("smooth", "--evaluator pn --level 64", "Curved PN triangles: tags do not count"),
        ("creased", "--evaluator st --level 64", "Scalar tagged: two creases"),
        ("normals", "--evaluator st --level 64 --show normals", "Its normals: two along a crease"),
    ];
    for (name, flags, words) in looks {
        let said =
            draw(sheet, &format!("{name}.png"), &scene, &format!("{flags} --orbit 30,10"), |_| words.to_owned())?;
        rows.push([vec![name.to_owned(), cell(&said, "/coarse_triangles")], counts(&said).to_vec()].concat());
    }
    sheet.caption(
        "A figure of about as many triangles as the paper's 162, with two creases. Deviation vectors part the normals, \
         tension and bias bend the curves; tags travel with the coefficients, and the shader is that of Fig. 5.",
    );
    let columns = ["what", "coarse_triangles", "vertices_stored", "triangles_drawn", "device_bytes"];
    sheet.table("counts.csv", &columns, rows, "What each picture stores and draws")
}
