//! `contact-sheet OUT.png IN.png...` puts many pictures on one sheet, so that a person sees them all at a glance.

use gradtess::image::{contact_sheet, ImageError, Picture};
use std::path::Path;
use std::process::ExitCode;

/// Longest side of a picture on the sheet, in pixels.
const CELL: u32 = 240;
const COLUMNS: u32 = 6;
const GAP: u32 = 12;
const GROUND: [u8; 3] = [255; 3];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some((out, inputs)) = arguments.split_first().filter(|(_, inputs)| !inputs.is_empty()) else {
        eprintln!("error: usage: contact-sheet OUT.png IN.png...");
        return ExitCode::from(2);
    };
    match sheet(inputs).and_then(|sheet| sheet.write_png(Path::new(out), &[])) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(1)
        }
    }
}

fn sheet(inputs: &[String]) -> Result<Picture, ImageError> {
    let pictures: Vec<Picture> = inputs
        .iter()
        .map(|path| Picture::read_png(Path::new(path)).map(|picture| in_cell(&picture)))
        .collect::<Result<_, _>>()?;
    let [r, g, b] = GROUND;
    Ok(contact_sheet(&pictures, COLUMNS, GAP, [r, g, b, 255]))
}

/// The picture over the ground, shrunk by whole numbers of pixels so that every pixel counts the same.
fn in_cell(picture: &Picture) -> Picture {
    let picture = picture.over(GROUND);
    let step = picture.width.max(picture.height).div_ceil(CELL).max(1);
    let mut small = Picture::filled(picture.width / step, picture.height / step, [255; 4]);
    for y in 0..small.height {
        for x in 0..small.width {
            let block = picture.crop(x * step, y * step, step, step);
            let at = 4 * (y as usize * small.width as usize + x as usize);
            for channel in 0..3 {
                let sum: u32 = block.rgba.iter().skip(channel).step_by(4).map(|&c| u32::from(c)).sum();
                small.rgba[at + channel] = (sum / (step * step)) as u8;
            }
        }
    }
    small
}
