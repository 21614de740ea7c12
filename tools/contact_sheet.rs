//! `contact-sheet OUT.png IN.png...` puts many pictures on one sheet, each with its name, so that a person sees them all
//! at a glance.

use gradtess::image::{contact_sheet, ImageError, Picture};
use std::path::Path;
use std::process::ExitCode;

/// Longest side of a picture on the sheet, in pixels.
const CELL: u32 = 240;
const COLUMNS: u32 = 6;
const GAP: u32 = 12;
/// Height of the name under a picture: 7 rows of dots and 4 free ones.
const CAPTION: u32 = 11;
const PAPER: [u8; 4] = [255; 4];
/// Behind the pictures: grey, so that white and transparent surfaces show.
const GROUND: [u8; 3] = [226; 3];
const INK: [u8; 4] = [60, 60, 60, 255];

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
    let cell = |path: &String| {
        let name = Path::new(path).file_stem().unwrap_or_default().to_string_lossy().replace("__", "/");
        Picture::read_png(Path::new(path)).map(|picture| in_cell(&picture, &name))
    };
    let cells: Vec<Picture> = inputs.iter().map(cell).collect::<Result<_, _>>()?;
    Ok(contact_sheet(&cells, COLUMNS, GAP, PAPER))
}

/// The picture in the middle of a grey square, and its name below.
fn in_cell(picture: &Picture, name: &str) -> Picture {
    let [r, g, b] = GROUND;
    let mut cell = Picture::filled(CELL, CELL + CAPTION, PAPER);
    cell.paste(&Picture::filled(CELL, CELL, [r, g, b, 255]), 0, 0);
    let small = shrunk(picture);
    cell.paste(&small, (CELL - small.width) / 2, (CELL - small.height) / 2);
    // The end of a name tells more than its beginning.
    let fits = (CELL / 6) as usize;
    let skip = name.chars().count().saturating_sub(fits);
    for (i, letter) in name.chars().skip(skip).enumerate() {
        for (x, column) in (6 * i as u32..).zip(glyph(letter)) {
            for y in (0..7).filter(|y| column >> y & 1 == 1) {
                cell.paste(&Picture::filled(1, 1, INK), x, CELL + CAPTION - 7 + y);
            }
        }
    }
    cell
}

/// The picture over the ground, shrunk by a whole number so that every pixel counts the same.
fn shrunk(picture: &Picture) -> Picture {
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

/// Five columns of seven dots, the lowest bit on top. Names need no more than these; capitals look like small letters.
fn glyph(letter: char) -> [u8; 5] {
    match letter.to_ascii_lowercase() {
        '0' => [0x3e, 0x51, 0x49, 0x45, 0x3e],
        '1' => [0x00, 0x42, 0x7f, 0x40, 0x00],
        '2' => [0x42, 0x61, 0x51, 0x49, 0x46],
        '3' => [0x21, 0x41, 0x45, 0x4b, 0x31],
        '4' => [0x18, 0x14, 0x12, 0x7f, 0x10],
        '5' => [0x27, 0x45, 0x45, 0x45, 0x39],
        '6' => [0x3c, 0x4a, 0x49, 0x49, 0x30],
        '7' => [0x01, 0x71, 0x09, 0x05, 0x03],
        '8' => [0x36, 0x49, 0x49, 0x49, 0x36],
        '9' => [0x06, 0x49, 0x49, 0x29, 0x1e],
        'a' => [0x20, 0x54, 0x54, 0x54, 0x78],
        'b' => [0x7f, 0x48, 0x44, 0x44, 0x38],
        'c' => [0x38, 0x44, 0x44, 0x44, 0x28],
        'd' => [0x38, 0x44, 0x44, 0x48, 0x7f],
        'e' => [0x38, 0x54, 0x54, 0x54, 0x18],
        'f' => [0x08, 0x7e, 0x09, 0x01, 0x02],
        'g' => [0x0c, 0x52, 0x52, 0x52, 0x3e],
        'h' => [0x7f, 0x08, 0x04, 0x04, 0x78],
        'i' => [0x00, 0x44, 0x7d, 0x40, 0x00],
        'j' => [0x20, 0x40, 0x44, 0x3d, 0x00],
        'k' => [0x7f, 0x10, 0x28, 0x44, 0x00],
        'l' => [0x00, 0x41, 0x7f, 0x40, 0x00],
        'm' => [0x7c, 0x04, 0x78, 0x04, 0x78],
        'n' => [0x7c, 0x08, 0x04, 0x04, 0x78],
        'o' => [0x38, 0x44, 0x44, 0x44, 0x38],
        'p' => [0x7c, 0x14, 0x14, 0x14, 0x08],
        'q' => [0x08, 0x14, 0x14, 0x18, 0x7c],
        'r' => [0x7c, 0x08, 0x04, 0x04, 0x08],
        's' => [0x48, 0x54, 0x54, 0x54, 0x20],
        't' => [0x04, 0x3f, 0x44, 0x40, 0x20],
        'u' => [0x3c, 0x40, 0x40, 0x20, 0x7c],
        'v' => [0x1c, 0x20, 0x40, 0x20, 0x1c],
        'w' => [0x3c, 0x40, 0x30, 0x40, 0x3c],
        'x' => [0x44, 0x28, 0x10, 0x28, 0x44],
        'y' => [0x0c, 0x50, 0x50, 0x50, 0x3c],
        'z' => [0x44, 0x64, 0x54, 0x4c, 0x44],
        '_' => [0x40; 5],
        '/' => [0x20, 0x10, 0x08, 0x04, 0x02],
        '.' => [0x00, 0x60, 0x60, 0x00, 0x00],
        _ => [0x08; 5],
    }
}
