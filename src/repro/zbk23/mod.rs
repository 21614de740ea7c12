//! Figures of ZBK23: control meshes, shading, highlight lines and blend weights side by side.
//!
//! Models that the authors published are taken where they are; elsewhere meshes of the same kind, made here.

mod meshes;

use super::sheet::cell;
use super::{Figure, ReproError, Sheet};
use meshes::{cross, cube, hat, tetrahedron};

const fn figure(id: &'static str, place: &'static str, title: &'static str, make: Make) -> Figure {
    Figure { id, paper: "ZBK23", place, title, make }
}

type Make = fn(&mut Sheet) -> Result<(), ReproError>;

/// All of them.
pub const FIGURES: [Figure; 12] = [
    figure("zbk23-fig1", "Fig. 1", "A tetrahedron with three sharp edges, by sharpness", |sheet| {
        let mut rows = Vec::new();
        for (scheme, words) in SCHEMES {
            for s in [0, 1, 2, 4, 6] {
                let scene = sheet.write(&format!("tetrahedron_{s}.obj"), &tetrahedron(&["0 1 2 0"], s))?;
                let name = format!("{}_{s}", words.replace('-', "_"));
                panel(sheet, &scene, &name, &format!("{scheme} --level 6"), &format!("{words}, s = {s}"))?;
                rows.push(counts(sheet, &scene, &format!("{words}, s = {s}"), &format!("{scheme} --level 6"))?);
            }
        }
        sheet.caption("Three edges of sharpness s after six steps, by Loop and by Catmull-Clark subdivision.");
        table(sheet, rows)
    }),
    figure("zbk23-fig2", "Fig. 2", "Artefacts around extraordinary vertices, and subdivision shading", |sheet| {
        let scene = sheet.write("tetrahedron.obj", &tetrahedron(&[], 0))?;
        for (scheme, words) in SCHEMES {
            let name = words.replace('-', "_");
            let flags = format!("{scheme} --level 3 --show highlight");
            panel(sheet, &scene, &format!("{name}_mesh"), &format!("{scheme} --level 3 --show wire"), words)?;
            panel(sheet, &scene, &format!("{name}_limit"), &format!("{flags} --normals geometric"), "N_L")?;
            panel(sheet, &scene, &format!("{name}_blended"), &flags, "N_B")?;
        }
        for (scheme, words) in SCHEMES {
            let name = words.replace('-', "_");
            let flags = format!("{scheme} --tess 16 --level 3 --show highlight");
            let limit = format!("{flags} --normals geometric");
            panel(sheet, &scene, &format!("{name}_patches_limit"), &limit, &format!("{words} patches, N_L"))?;
            let words = format!("{words} patches, N_B at every tessellated vertex");
            panel(sheet, &scene, &format!("{name}_patches_blended"), &flags, &words)?;
            let checked = sheet.run(&format!("check {scene} {scheme} --tess 8 --level 6 --zooms 2 --size 128x128"))?;
            sheet.note(format!(
                "Patches ({name}) down to level 6 are at most {} of the size off the surface; N_B turns by at most {} degrees across their edges.",
                cell(&checked, "/patches/off_max/1"),
                cell(&checked, "/patches/blended_normal_jump_max")
            ));
        }
        sheet.caption("Highlight lines at level 3 with the limit's normals and with the blended ones.");
        Ok(())
    }),
    figure("zbk23-fig3", "Fig. 3", "Blend weights in variants A and B", |sheet| {
        let tetra = own(sheet, "Tetrahedron4.obj", "tetrahedron", &tetrahedron(&["0 1 2 0"], 4))?;
        let cube = own(sheet, "cube4.obj", "cube", &cube(&["0 1 2 3 0", "0 4", "1 5", "2 6"], 4))?;
        let mut rows = Vec::new();
        for (scene, name, scheme) in [(tetra, "tetrahedron", SCHEMES[0].0), (cube, "cube", SCHEMES[1].0)] {
            control(sheet, &scene, name, scheme)?;
            let flags = format!("{scheme} --level 4 --weights-from 2");
            panel(sheet, &scene, &format!("{name}_surface"), &flags, "level 4")?;
            for variant in ["a", "b"] {
                let flags = format!("{flags} --variant {variant}");
                let words = format!("{name}, variant {}", variant.to_uppercase());
                panel(sheet, &scene, &format!("{name}_{variant}"), &format!("{flags} --show weights"), &words)?;
                rows.push(counts(sheet, &scene, &words, &flags)?);
            }
        }
        sheet.caption(
            "Weights from blue (0) to red (1), first set at level 2. In variant B they are exactly 0 on creases.",
        );
        table(sheet, rows)
    }),
    figure("zbk23-fig4", "Fig. 4", "Weights before and after a semi-sharp crease has decayed", |sheet| {
        let quads = own(sheet, "3d-cross-quad4.obj", "cross", &cross(4))?;
        let mut rows = Vec::new();
        let triangles = "--scheme loop --triangulate";
        for (scheme, words) in [(triangles, "Loop"), (SCHEMES[1].0, "Catmull-Clark")] {
            let name = words.replace('-', "_").to_lowercase();
            control(sheet, &quads, &name, scheme)?;
            for level in [4, 5] {
                let flags = format!("{scheme} --level {level} --weights-from 2");
                let words = format!("{words}, level {level}");
                panel(sheet, &quads, &format!("{name}_{level}"), &flags, &words)?;
                panel(sheet, &quads, &format!("{name}_{level}_weights"), &format!("{flags} --show weights"), &words)?;
                rows.push(counts(sheet, &quads, &words, &flags)?);
            }
        }
        sheet.caption("Four edges of sharpness 4. At level 4 nothing is blended on them, at level 5 their extraordinary vertices count.");
        table(sheet, rows)
    }),
    figure("zbk23-fig5", "Fig. 5", "Weights with darts as smooth and as sharp vertices", |sheet| {
        let tetra = own(sheet, "Tetrahedron4Dart.obj", "tetrahedron", &tetrahedron(&["0 1 2"], 4))?;
        let cube = own(sheet, "cube4Dart.obj", "cube", &cube(&["0 1 2 3"], 4))?;
        darts(sheet, &[(tetra, "tetrahedron", SCHEMES[0].0), (cube, "cube", SCHEMES[1].0)], "weights")?;
        sheet.caption("Weights from blue (0) to red (1), first set at level 2, at level 4.");
        Ok(())
    }),
    figure("zbk23-fig6", "Fig. 6", "Several normals at sharp vertices: regions", |sheet| {
        let scene = sheet.write("cube.obj", &cube(&["0 1 2 3 0", "0 4"], 10))?;
        control(sheet, &scene, "cube", SCHEMES[1].0)?;
        panel(sheet, &scene, "normals", "--level 3 --show normals", "normals: a vertex on a crease has one a region")?;
        let mut rows = Vec::new();
        for level in 1..=4 {
            rows.push(counts(sheet, &scene, &format!("level {level}"), &format!("--level {level}"))?);
        }
        sheet.caption("Normals are those of vertices in regions between sharp edges; all other vertices have one.");
        table(sheet, rows)
    }),
    figure("zbk23-fig8", "Fig. 8", "In place of the robot: a crease of sharpness 2", |sheet| {
        let scene = sheet.write("cross.obj", &cross(2))?;
        with_and_without(sheet, &scene, "cross")?;
        sheet.caption("Highlight lines at level 4 without and with subdivision shading (variant B, weights from level 1). The paper's robot is not published as a manifold mesh.");
        Ok(())
    }),
    figure("zbk23-fig9", "Fig. 9", "Spot with semi-sharp ears", |sheet| {
        match sheet.model("Spot2.obj") {
            Some(spot) => with_and_without(sheet, &spot, "spot")?,
            None => sheet.note("Spot is among the authors' models, which were not given."),
        }
        sheet.caption(
            "Highlight lines at level 4 without and with subdivision shading (variant B, weights from level 1).",
        );
        Ok(())
    }),
    figure("zbk23-fig10", "Fig. 10", "An open mesh by Loop subdivision: variants A and B", |sheet| {
        let scene = sheet.write("hat.obj", &hat(4))?;
        both_variants(sheet, &scene, "hat", SCHEMES[0].0)
    }),
    figure("zbk23-fig11", "Fig. 11", "Letter A by Catmull-Clark subdivision: variants A and B", |sheet| {
        match sheet.model("ItaPaperGeom.obj") {
            Some(letter) => {
                sheet.note("The published letter has no sharp edges, so both variants are the same; where it has some, see Fig. 13.");
                both_variants(sheet, &letter, "letter", SCHEMES[1].0)
            }
            None => {
                let scene = sheet.write("cross.obj", &cross(4))?;
                sheet.note("The letter is among the authors' models, which were not given: a cross with a sharp rim in its place.");
                both_variants(sheet, &scene, "cross", SCHEMES[1].0)
            }
        }
    }),
    figure("zbk23-fig12", "Fig. 12", "Darts of a tetrahedron, smooth and sharp", |sheet| {
        let tetra = own(sheet, "Tetrahedron4Dart.obj", "tetrahedron", &tetrahedron(&["0 1 2"], 4))?;
        darts(sheet, &[(tetra, "tetrahedron", SCHEMES[0].0)], "highlight")?;
        sheet.caption("Highlight lines at level 4.");
        Ok(())
    }),
    figure("zbk23-fig13", "Fig. 13", "Darts of letter A, smooth and sharp", |sheet| {
        let scene = own(sheet, "ItaPaperGeomDart.obj", "letter", &cube(&["0 1 2 3"], 4))?;
        darts(sheet, &[(scene, "letter", SCHEMES[1].0)], "highlight")?;
        sheet.caption("Highlight lines at level 4.");
        Ok(())
    }),
];

const SCHEMES: [(&str, &str); 2] = [("--scheme loop", "loop"), ("", "catmull-clark")];

/// The authors' model `model`, or a mesh of our own.
fn own(sheet: &Sheet, model: &str, name: &str, text: &str) -> Result<String, ReproError> {
    match sheet.model(model) {
        Some(scene) => Ok(scene),
        None => sheet.write(&format!("{name}.obj"), text),
    }
}

fn panel(sheet: &mut Sheet, scene: &str, name: &str, flags: &str, caption: &str) -> Result<(), ReproError> {
    let file = format!("{name}.png");
    let out = sheet.file(&file);
    sheet.run(&format!("render {scene} -o {out} --size 400x400 --samples 4 --background #ffffff {flags}"))?;
    sheet.picture(&file, caption);
    Ok(())
}

fn control(sheet: &mut Sheet, scene: &str, name: &str, scheme: &str) -> Result<(), ReproError> {
    panel(
        sheet,
        scene,
        &format!("{name}_control"),
        &format!("{scheme} --show control"),
        "control mesh, sharp edges in red",
    )
}

/// Numbers of a level.
fn counts(sheet: &mut Sheet, scene: &str, words: &str, flags: &str) -> Result<Vec<String>, ReproError> {
    let stats = sheet.run(&format!("stats {scene} {flags}"))?;
    let last = stats["levels"].as_array().map_or(0, |levels| levels.len().saturating_sub(1));
    let of_level = ["vertices", "faces", "sharp_edges"].map(|key| cell(&stats, &format!("/levels/{last}/{key}")));
    let whole = ["wedges", "blended", "normals_computed"].map(|key| cell(&stats, &format!("/{key}")));
    Ok([words.to_owned()].into_iter().chain(of_level).chain(whole).collect())
}

fn table(sheet: &mut Sheet, rows: Vec<Vec<String>>) -> Result<(), ReproError> {
    let columns =
        ["what", "vertices", "faces", "sharp_edges", "normals", "blended_vertices", "subdivided_normals_computed"];
    sheet.table("counts.csv", &columns, rows, "The level drawn; normals: pairs of vertex and region")
}

/// How far two pictures of the sheet are apart: greatest difference of a channel, and pixels that differ.
fn apart(sheet: &Sheet, a: &str, b: &str) -> Result<(u8, usize), ReproError> {
    let [a, b] = [sheet.read_picture(&format!("{a}.png"))?, sheet.read_picture(&format!("{b}.png"))?];
    Ok(super::blhk18::difference(&a, &b))
}

fn note_apart(sheet: &mut Sheet, a: &str, b: &str) -> Result<(), ReproError> {
    let (most, pixels) = apart(sheet, a, b)?;
    sheet.note(format!("{a} and {b} differ in {pixels} pixels, by at most {most} of 255."));
    Ok(())
}

fn with_and_without(sheet: &mut Sheet, scene: &str, name: &str) -> Result<(), ReproError> {
    control(sheet, scene, name, "")?;
    let flags = "--level 4 --show highlight";
    panel(sheet, scene, &format!("{name}_without"), &format!("{flags} --normals geometric"), "without: N_L")?;
    panel(sheet, scene, &format!("{name}_with"), flags, "with: N_B")?;
    panel(
        sheet,
        scene,
        &format!("{name}_patches"),
        "--tess-base 32 --show highlight",
        "patches, N_B at every tessellated vertex",
    )?;
    note_apart(sheet, &format!("{name}_without"), &format!("{name}_with"))?;
    let row = counts(sheet, scene, name, "--level 4")?;
    table(sheet, vec![row])
}

fn both_variants(sheet: &mut Sheet, scene: &str, name: &str, scheme: &str) -> Result<(), ReproError> {
    control(sheet, scene, name, scheme)?;
    let mut rows = Vec::new();
    for variant in ["a", "b"] {
        let flags = format!("{scheme} --level 4 --variant {variant}");
        let upper = variant.to_uppercase();
        for (show, words) in [("surface", "shading"), ("highlight", "highlight lines"), ("weights", "weights")] {
            panel(
                sheet,
                scene,
                &format!("{name}_{variant}_{show}"),
                &format!("{flags} --show {show}"),
                &format!("variant {upper}: {words}"),
            )?;
        }
        let patches = format!("{scheme} --tess 8 --variant {variant} --show highlight");
        let words = format!("variant {upper}: highlight lines on patches");
        panel(sheet, scene, &format!("{name}_{variant}_patches"), &patches, &words)?;
        rows.push(counts(sheet, scene, &format!("variant {upper}"), &flags)?);
    }
    for show in ["surface", "highlight", "weights"] {
        note_apart(sheet, &format!("{name}_a_{show}"), &format!("{name}_b_{show}"))?;
    }
    sheet.caption("Level 4, weights from level 1: variant A above, variant B below; weights from blue (0) to red (1).");
    table(sheet, rows)
}

fn darts(sheet: &mut Sheet, scenes: &[(String, &str, &str)], show: &str) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for (scene, name, scheme) in scenes {
        control(sheet, scene, name, scheme)?;
        for darts in ["smooth", "sharp"] {
            let flags = format!("{scheme} --level 4 --weights-from 2 --darts {darts}");
            let words = format!("{name}, darts {darts}");
            panel(sheet, scene, &format!("{name}_{darts}"), &format!("{flags} --show {show}"), &words)?;
            rows.push(counts(sheet, scene, &words, &flags)?);
        }
        note_apart(sheet, &format!("{name}_smooth"), &format!("{name}_sharp"))?;
    }
    table(sheet, rows)
}
