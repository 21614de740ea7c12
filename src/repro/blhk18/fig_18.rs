//! Fig. 18: the same mesh interpolated in different colour spaces.

use super::{short, variant};
use crate::image::Picture;
use crate::patch::space::{linear_of, SPACES};
use crate::repro::{Figure, ReproError, Sheet};
use serde_json::json;

/// The figure.
pub const FIGURE: Figure = Figure {
    id: "blhk18-fig18",
    paper: "BLHK18",
    place: "Fig. 18 (App. A)",
    title: "A 2 x 3 mesh interpolated in different colour spaces",
    make,
};

/// Luminance of a pixel, 0 to 1.
fn luminance(p: [u8; 4]) -> f64 {
    let [r, g, b] = [0, 1, 2].map(|c| linear_of(f64::from(p[c]) / 255.0));
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Mean and least luminance of a picture's inside.
fn measured(picture: &Picture) -> [f64; 2] {
    let inside = (4..picture.height - 4).flat_map(|y| (4..picture.width - 4).map(move |x| (x, y)));
    let all: Vec<f64> = inside.map(|(x, y)| luminance(picture.pixel(x, y))).collect();
    [all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(f64::INFINITY, f64::min)]
}

fn make(sheet: &mut Sheet) -> Result<(), ReproError> {
    let mut rows = Vec::new();
    for (_, space) in SPACES {
        let file = variant(sheet, "ferguson/colour_spaces.json", &format!("{space}.json"), &[("space", json!(space))])?;
        let picture = format!("{space}.png");
        let out = sheet.file(&picture);
        // Without a margin, so that the middle of a patch is a pixel.
        sheet.run(&format!("render {file} -o {out} --size 480x320 --view 0,0,120,80 --pixels 1"))?;
        sheet.picture(&picture, space);
        let drawn = sheet.read_picture(&picture)?;
        let [mean, least] = measured(&drawn);
        // On the lower side of the first patch, between blue and yellow.
        let [r, g, b, _] = drawn.pixel(80, 319);
        rows.push(vec![space.to_owned(), short(mean), short(least), format!("{r} {g} {b}")]);
    }
    sheet.caption(
        "Linear sRGB is a linear map of CIEXYZ and gives the same picture. The others are darker than CIEXYZ; sRGB is darkest \
         between far hues; CIELAB has purple between blue and yellow, where CIELUV is nearly grey. Oklab is younger than the paper.",
    );
    let columns = ["space", "mean_luminance", "least_luminance", "blue_yellow_middle_rgb"];
    sheet.table(
        "spaces.csv",
        &columns,
        rows,
        "Luminance (Y of white 1) of the pictures, and the colour midway between blue and yellow",
    )
}
