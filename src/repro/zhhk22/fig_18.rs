//! Fig. 18: one polygon each; limit meshes of M^0 and M^1, and the surface.

use crate::repro::sheet::number;
use crate::repro::{Figure, ReproError, Sheet};

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "zhhk22-fig18",
    paper: "ZHHK22",
    place: "Fig. 18",
    title: "Triangle, quad, pentagon and hexagon: limit meshes and colour surfaces",
    make,
};

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for name in ["triangle", "quad", "pentagon", "hexagon"] {
        let scene = sheet.scene(&format!("{name}.json"))?;
        let stats = sheet.run(&format!("stats {scene}"))?;
        let mut faces = Vec::new();
        for level in [0, 1] {
            let mesh = sheet.run(&format!("mesh {scene} --level {level}"))?;
            faces.push(mesh["faces"].as_array().map_or(0, Vec::len).to_string());
        }
        let wire = format!("{name}_mesh.png");
        let out = sheet.file(&wire);
        sheet.run(&format!(
            "render {scene} -o {out} --mode global --level 1 --tess 1 --show wire --size 480x480 --samples 4"
        ))?;
        sheet.picture(&wire, format!("{name}: M^1 on the limit, {} faces", faces[1]));
        let surface = format!("{name}.png");
        let out = sheet.file(&surface);
        sheet.run(&format!("render {scene} -o {out} --tess 32 --size 480x480 --samples 4"))?;
        sheet.picture(&surface, format!("{name}: colour surface"));
        let [bicubic, gregory] = ["/bicubic", "/gregory"].map(|kind| number(&stats, kind).to_string());
        rows.push(vec![name.to_owned(), faces[0].clone(), faces[1].clone(), bicubic, gregory]);
    }
    sheet.caption(
        "One polygon with a distinct colour at each corner. Colours blend smoothly although a non-quad face stands in the \
         middle of M^0; it leaves an extraordinary vertex, around which Gregory patches are drawn.",
    );
    sheet.table("faces.csv", &["mesh", "faces_M0", "faces_M1", "bicubic", "gregory"], rows, "Faces and patches drawn")
}
