//! `gradtess convert` to the formats that hold patches: SVG and PDF of any scene, and JSON of gradient meshes.

use super::open::{target, Ferguson};
use crate::command::picture::{bounds, fit};
use crate::command::{silent, Failure, Global};
use crate::ferguson::Mesh;
use crate::gpu::{Format, Frame, Gpu, Show};
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use crate::scene::{svg, write_atomically};
use crate::vector::{bicubics, cells, flatten, folded, layers, pdf, Conversion, VectorError};
use std::path::Path;

/// Error of bilinear colours that exports stay within: with [`pdf::RAISE`] on top of it, colours are within 0.62/255.
const TOLERANCE: f64 = 0.15 / 255.0;
/// Pixels of the longer side of the picture in a drawing.
const PICTURE: u32 = 1024;

impl From<VectorError> for Failure {
    fn from(e: VectorError) -> Self {
        Failure::input(e)
    }
}

/// Writes a gradient mesh by the extension of `output`; what is lost, one sentence each.
pub fn run(ferguson: &Ferguson, output: &Path, flat: bool, global: &Global) -> Result<Vec<String>, Failure> {
    let mesh = &ferguson.mesh;
    match output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("json") => {
            write_atomically(output, crate::scene::ferguson::write(mesh).as_bytes())?;
            Ok(Vec::new())
        }
        Some("svg") => drawing(&crate::ferguson::table::table(mesh, &Default::default()), Some(mesh), output, global),
        Some("pdf") => {
            let table = crate::ferguson::table::table(mesh, &Default::default());
            let of = mesh.component();
            let component: Vec<u32> = table.faces.iter().map(|face| of[face.name as usize]).collect();
            page(&table, &component, &mesh.name, output, flat, global)
        }
        _ => Err(Failure::input(format_args!(
            "{}: unknown format; name the file *.json, *.svg or *.pdf",
            output.display()
        ))),
    }
}

fn converted(conversion: Conversion) -> Option<String> {
    (conversion.gregory > 0).then(|| {
        format!(
            "{} Gregory patches are written as bicubics, at most {:.2e} off in position and {:.2e} in colour",
            conversion.gregory, conversion.position, conversion.colour
        )
    })
}

/// A PDF page of any table, whose patches belong to these components; `flat` ones have no transparency.
pub fn page(
    table: &PatchTable,
    component: &[u32],
    title: &str,
    output: &Path,
    flat: bool,
    global: &Global,
) -> Result<Vec<String>, Failure> {
    let (patches, conversion) = bicubics(table);
    if let Some(fold) = folded(&patches) {
        return Err(fold.into());
    }
    let cells = match flat {
        true => flatten::cells(&patches, component, table.colour, TOLERANCE)?,
        false => cells::cells(&patches, table.colour, TOLERANCE),
    };
    let view = bounds(table).ok_or(VectorError::Empty)?;
    write_atomically(output, &pdf::page(&layers::layers(&cells, component), view, title)?)?;
    if !global.quiet && !global.json {
        crate::command::print(&format!(
            "{}: {} patches in {} cells, colours {} {:.3}/255 of the scene's (then raised by {:.2}/255 for readers that cut off)\n",
            output.display(),
            patches.len(),
            cells.all.len(),
            if cells.proved { "within" } else { "(sampled) within" },
            cells.error * 255.0,
            pdf::RAISE * 255.0
        ));
    }
    let mut losses: Vec<String> = converted(conversion).into_iter().collect();
    if cells.error > TOLERANCE {
        losses.push(format!("colours are up to {:.3}/255 off: a patch was cut as far as it goes", cells.error * 255.0));
    }
    Ok(losses)
}

/// An SVG drawing of any table: a picture, and over it the gradients of a mesh that has the form of grids.
pub fn drawing(
    table: &PatchTable,
    mesh: Option<&Mesh>,
    output: &Path,
    global: &Global,
) -> Result<Vec<String>, Failure> {
    let whole = bounds(table).ok_or(VectorError::Empty)?;
    let (w, h) = (whole[2] - whole[0], whole[3] - whole[1]);
    let side = |a: f64, b: f64| ((f64::from(PICTURE) * (a / b).min(1.0)).ceil() as u32).clamp(1, PICTURE);
    let size = [side(w, h), side(h, w)];
    let view = fit(whole, size)?;
    let gpu = Gpu::new(&global.gpu())?;
    let rule = TessRule::Pixels(2.0);
    let fitted = mesh.map(|mesh| {
        let target = target(rule, view, size);
        crate::ferguson::table::table(&mesh.fit(&target), &target)
    });
    let uploaded = gpu.upload(fitted.as_ref().unwrap_or(table))?;
    let frame = Frame {
        width: size[0],
        height: size[1],
        view,
        tess: rule,
        show: Show::Surface,
        background: None,
        samples: 4,
        format: Format::Rgba8,
        statistics: false,
    };
    let picture = gpu.render(&uploaded, &frame)?.pixels.into_picture(size[0], size[1]);
    silent(&gpu)?;
    let grids = mesh.and_then(svg::grids);
    let none = Mesh::default();
    let text = svg::write(mesh.unwrap_or(&none), grids.as_deref(), &picture.png()?, view);
    write_atomically(output, text.as_bytes())?;
    Ok(match grids {
        Some(_) => Vec::new(),
        None => {
            vec!["the scene is no rectangular gradient mesh, which is all that SVG has: only its picture is written"
                .to_owned()]
        }
    })
}
