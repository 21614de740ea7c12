//! PDF pages as other programs draw them, and MuPDF's arithmetic.

use gradtess::image::Picture;
use std::path::Path;
use std::process::Command;

/// Whether a program is installed; says so where it is not.
pub fn there(program: &str) -> bool {
    let found = Command::new(program).arg("-v").output().is_ok();
    if !found {
        println!("PDF pages: skipped for {program}, which is not installed");
    }
    found
}

/// A picture by another program: width, height, and red, green, blue from 0 to 255, rows from the top.
pub struct Theirs {
    pub size: [u32; 2],
    pub rgb: Vec<[f64; 3]>,
}

/// A page by a program, 600 pixels on the longer side: `gs` gives 16 bits a channel, `gs8` and `mutool` 8.
pub fn rendered(program: &str, page: &Path, out: &Path) -> Theirs {
    let device = if program == "gs8" { "-sDEVICE=png16m" } else { "-sDEVICE=tiff48nc" };
    let done = match program {
        "mutool" => {
            Command::new("mutool").args(["draw", "-q", "-F", "png", "-r", "72", "-o"]).arg(out).arg(page).output()
        }
        _ => Command::new("gs")
            .args(["-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", device, "-sCompression=none", "-r72"])
            .arg(format!("-sOutputFile={}", out.display()))
            .arg(page)
            .output(),
    };
    let done = done.unwrap();
    assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
    if program == "gs" {
        return tiff(&std::fs::read(out).unwrap());
    }
    let picture = Picture::read_png(out).unwrap();
    let all = (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (x, y)));
    let rgb = all.map(|(x, y)| [0, 1, 2].map(|c| f64::from(picture.pixel(x, y)[c]))).collect();
    Theirs { size: [picture.width, picture.height], rgb }
}

/// An uncompressed TIFF of 16 bits a channel, in strips.
fn tiff(bytes: &[u8]) -> Theirs {
    let little = &bytes[..2] == b"II";
    let number = |at: usize, n: usize| {
        let part = bytes[at..at + n].iter().copied();
        let step = |all: usize, b: u8| all << 8 | usize::from(b);
        if little {
            part.rev().fold(0, step)
        } else {
            part.fold(0, step)
        }
    };
    let directory = number(4, 4);
    // All values of a tag.
    let values = |tag: usize| -> Vec<usize> {
        let entry = (0..number(directory, 2)).map(|i| directory + 2 + 12 * i).find(|&e| number(e, 2) == tag);
        let entry = entry.expect("a tag");
        let (width, count) = (if number(entry + 2, 2) == 3 { 2 } else { 4 }, number(entry + 4, 4));
        let start = if width * count <= 4 { entry + 8 } else { number(entry + 8, 4) };
        (0..count).map(|i| number(start + width * i, width)).collect()
    };
    assert_eq!((values(258), values(259)), (vec![16, 16, 16], vec![1]));
    let strips = values(273).into_iter().zip(values(279)).flat_map(|(start, n)| (start..start + n).step_by(6));
    let channel = |at: usize| number(at, 2) as f64 / 257.0;
    let rgb = strips.map(|at| [channel(at), channel(at + 2), channel(at + 4)]).collect();
    Theirs { size: [values(256)[0] as u32, values(257)[0] as u32], rgb }
}

/// A masked colour over another as MuPDF 1.21 draws it, all of 8 bits: cut off once more, with an alpha of 256 steps of
/// which the middle one is missing.
pub fn over(colour: i32, alpha: i32, below: i32) -> i32 {
    let mask = alpha + (alpha >> 7);
    ((colour - below) * mask + (below << 8)) >> 8
}

/// All that MuPDF can draw of a colour (0 to 1, not raised) of a page over what is between `low` and `high` (0 to 255): its
/// 8-bit numbers are those that the page has, cut off, and their composition is [`over`].
pub fn reach(colour: f64, raise: f64, alpha: f64, [low, high]: [f64; 2]) -> [f64; 2] {
    let raised = ((colour + raise) * 255.0).clamp(0.0, 255.0);
    let cut = |x: f64| (x - 1.0).max(0.0);
    if alpha >= 1.0 {
        return [cut(raised), raised];
    }
    let alpha = alpha * 255.0;
    // Below the missing step the mask is the alpha itself, above it is one more.
    let masks = [if alpha < 129.0 { cut(alpha) } else { alpha }, if alpha >= 127.0 { alpha + 1.0 } else { alpha }];
    let mut reach = [f64::INFINITY, f64::NEG_INFINITY];
    for (colour, mask) in masks.into_iter().flat_map(|mask| [(cut(raised), mask), (raised, mask)]) {
        let at = |below: f64| below + (colour - below) * mask / 256.0;
        reach = [reach[0].min(at(low) - 1.0), reach[1].max(at(high))];
    }
    reach
}
