//! Draws a picture and the limit's beside it, and reports how far they are apart.

use super::open::{Loaded, Patched};
use super::Failure;
use crate::check::limit_picture::{opaque, LimitPicture};
use crate::check::picture_error::{Compared, Distances, PictureError, Place};
use crate::gpu::{Format, Frame, Gpu, Pixels, Show};
use crate::patch::tess::TessRule;
use crate::patch::{Kind, PatchTable};
use crate::refine::Options;
use serde::Serialize;

/// The error of the picture that `frame` makes of `patched`. Format, background and samples of the frame do not matter:
/// both pictures are drawn in floats, one sample a pixel, all alphas 1.
pub fn measure(gpu: &Gpu, loaded: &Loaded, patched: &Patched, frame: &Frame) -> Result<PictureError, Failure> {
    let limit = loaded.refine(Options::default())?;
    let mut picture = LimitPicture::new(&limit, frame.view, frame.scale());
    let drawn = floats(gpu, &patched.transitions.of(opaque(&patched.table)), frame, frame.tess)?;
    let channels = floats(gpu, &picture.table, frame, TessRule::Fixed(1.0))?;
    picture.table = PatchTable::default();
    let compared = Compared {
        drawn: &patched.refinement,
        table: &patched.table,
        limit: &limit,
        view: frame.view,
        size: [frame.width, frame.height],
        tess: frame.tess,
    };
    Ok(compared.pictures(&mut picture, &drawn, &channels))
}

fn floats(gpu: &Gpu, table: &PatchTable, frame: &Frame, tess: TessRule) -> Result<Vec<f32>, Failure> {
    let frame = Frame {
        tess,
        show: Show::Surface,
        background: None,
        samples: 1,
        format: Format::Rgba32f,
        statistics: false,
        ..frame.clone()
    };
    match gpu.render(&gpu.upload(table)?, &frame)?.pixels {
        Pixels::Rgba32f(pixels) => Ok(pixels),
        Pixels::Rgba8(_) => Err(Failure::machine("the device drew bytes where floats were asked for")),
    }
}

/// A [`PictureError`] as it is printed.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorReport {
    /// Per cent of sqrt 3, over all pixels compared; null of none.
    pub max_percent: Option<f64>,
    pub mean_percent: Option<f64>,
    pub pixels: usize,
    /// The same over pixels in bicubic and in Gregory faces: pixels, max, mean.
    pub bicubic: KindReport,
    pub gregory: KindReport,
    /// The same where the limit folds over, which is not among the others: which layer a pixel shows is a matter of order.
    pub folds: KindReport,
    /// Where the greatest colour distance is.
    pub worst: Option<PlaceReport>,
    /// Pixels of silhouettes and sharp edges, not compared.
    pub edge_pixels: usize,
    /// Other pixels that only one of the two pictures covers.
    pub coverage_pixels: usize,
    /// Greatest distance of patch and limit point, pixels of this picture.
    pub shift_pixels: f64,
    pub shift_at: Option<PlaceReport>,
}

#[derive(Clone, Debug, Serialize)]
pub struct KindReport {
    pub pixels: usize,
    pub max_percent: f64,
    pub mean_percent: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct PlaceReport {
    /// Column and row, from the top left.
    pub pixel: Option<[u32; 2]>,
    pub position: [f64; 2],
    /// Number of the face in the order of `gradtess patches`.
    pub patch: Option<usize>,
    pub kind: Option<&'static str>,
    pub level: Option<u32>,
    pub transition: Option<bool>,
    pub u: f64,
    pub v: f64,
}

impl PlaceReport {
    fn new(place: &Place, pixel: Option<[u32; 2]>, table: &PatchTable) -> PlaceReport {
        let face = place.face.map(|f| &table.faces[f]);
        PlaceReport {
            pixel,
            position: place.position,
            patch: place.face,
            kind: face.map(|f| kind_name(f.kind)),
            level: face.map(|f| f.level),
            transition: face.map(|f| f.transition != 0),
            u: place.uv[0],
            v: place.uv[1],
        }
    }

    /// In words.
    pub fn text(&self) -> String {
        let [x, y] = self.position;
        let at = match self.pixel {
            Some([column, row]) => format!("pixel {column},{row} ({x:.6},{y:.6})"),
            None => format!("{x:.6},{y:.6}"),
        };
        match (self.patch, self.kind, self.level) {
            (Some(patch), Some(kind), Some(level)) => {
                let transition = if self.transition == Some(true) { "transition " } else { "" };
                format!("{at}, {transition}{kind} patch {patch} of level {level} at u {:.4}, v {:.4}", self.u, self.v)
            }
            _ => at,
        }
    }
}

/// Name of a kind in reports.
pub fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Bicubic => "bicubic",
        Kind::Gregory => "gregory",
        Kind::Stitched => "stitched",
        Kind::RemappedBicubic => "bicubic",
        Kind::RemappedGregory => "gregory",
    }
}

impl ErrorReport {
    /// Of an error of the picture of `table`.
    pub fn new(error: &PictureError, table: &PatchTable) -> ErrorReport {
        let kind = |d: Distances| KindReport { pixels: d.pixels, max_percent: d.max, mean_percent: d.mean };
        let some = error.all.pixels > 0;
        ErrorReport {
            max_percent: some.then_some(error.all.max),
            mean_percent: some.then_some(error.all.mean),
            pixels: error.all.pixels,
            bicubic: kind(error.by_kind[0]),
            gregory: kind(error.by_kind[1]),
            folds: kind(error.folds),
            worst: error.worst.as_ref().map(|(pixel, place)| PlaceReport::new(place, Some(*pixel), table)),
            edge_pixels: error.edges,
            coverage_pixels: error.coverage,
            shift_pixels: error.shift,
            shift_at: error.shift_at.as_ref().map(|place| PlaceReport::new(place, None, table)),
        }
    }

    /// In a few lines.
    pub fn text(&self) -> String {
        let (Some(max), Some(mean)) = (self.max_percent, self.mean_percent) else {
            return "  colour: no pixel to compare with the limit\n".to_owned();
        };
        let worst = self.worst.as_ref().map_or(String::new(), PlaceReport::text);
        let mut text = format!(
            "  colour: max {max:.4} %, mean {mean:.6} % of sqrt 3 over {} pixels ({} of edges left out, {} covered by one picture only)\n    \
             greatest at {worst}\n    bicubic: max {:.4} %, {} pixels; Gregory: max {:.4} %, {} pixels\n  \
             position: at most {:.4} pixels from the limit\n",
            self.pixels,
            self.edge_pixels,
            self.coverage_pixels,
            self.bicubic.max_percent,
            self.bicubic.pixels,
            self.gregory.max_percent,
            self.gregory.pixels,
            self.shift_pixels
        );
        if self.folds.pixels > 0 {
            text += &format!(
                "  where the surface folds over, counted apart: max {:.4} %, {} pixels\n",
                self.folds.max_percent, self.folds.pixels
            );
        }
        if let Some(place) = &self.shift_at {
            text += &format!("    greatest at {}\n", place.text());
        }
        text
    }
}
