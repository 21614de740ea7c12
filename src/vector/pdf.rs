//! PDF: one page with tensor-product shadings of type 7 (ISO 32000-1, 8.7.4.5.8).
//!
//! Every cell is written with flag 0 and 16 points of 32 bits, 16 bits a colour component: whole bytes, because readers
//! disagree on padding. There is no /Function: viewers evaluate it in different ways. Alpha becomes a soft mask, a second
//! shading of the same patches in grey. Streams are packed.
//!
//! Some readers cut 8-bit values off (MuPDF, and Ghostscript with 8 bits where colours change), some round, and some have
//! bits to spare (Ghostscript with 16). Colours are raised by [`RAISE`], so that one page serves all of them: what is cut off is within 0.53/255 of
//! the scene's colour, what has bits to spare within 0.47/255, and a colour of 8 bits is drawn as itself by each. The /Decode
//! range ends where raised white is: 255.47/255, which readers hold at 255 or cut off to it. Alphas are
//! not raised: no colour between raised ones is raised by more, whatever the alpha. How readers compose layers is their own;
//! MuPDF keeps 8 bits (see `tests/pdf_pages.rs`).

use super::cells::Cell;
use super::VectorError;
use flate2::{read::ZlibEncoder, Compression};
use glam::DVec2;
use pdf_writer::types::MaskType;
use pdf_writer::writers::StreamShadingType;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref};
use std::io::Read;

/// Length of the page's longer side, points.
pub const LONG_SIDE: f64 = 600.0;

/// What colours are raised by: nearly half an 8-bit step.
pub const RAISE: f64 = 0.47 / 255.0;

/// Order of a record's points in the net: first index along u, second along v.
const ORDER: [usize; 16] = [0, 4, 8, 12, 13, 14, 15, 11, 7, 3, 2, 1, 5, 9, 10, 6];
/// Order of its colours among the corners A, B, C, D.
const COLOURS: [usize; 4] = [0, 3, 2, 1];

/// Ranges of the coordinates of a stream: x low and high, y low and high. Single precision, as the file states them.
type Decode = [f32; 4];

fn decode_of(cells: &[Cell], place: impl Fn(DVec2) -> DVec2) -> Decode {
    let mut d = [f32::INFINITY, f32::NEG_INFINITY, f32::INFINITY, f32::NEG_INFINITY];
    for p in cells.iter().flat_map(|c| c.geometry).map(place) {
        for (axis, x) in [p.x, p.y].into_iter().enumerate() {
            // Beyond what the cast may have cut off.
            let slack = x.abs() * f64::from(f32::EPSILON) + f64::from(f32::MIN_POSITIVE);
            d[2 * axis] = d[2 * axis].min((x - slack) as f32);
            d[2 * axis + 1] = d[2 * axis + 1].max((x + slack) as f32);
        }
    }
    d
}

/// Nearest of the 2^32 steps of a range.
fn coordinate(x: f64, low: f32, high: f32) -> u32 {
    let (low, high) = (f64::from(low), f64::from(high));
    ((x - low) / (high - low) * f64::from(u32::MAX)).round().clamp(0.0, f64::from(u32::MAX)) as u32
}

/// A colour channel in 16 bits, 0 to 1 and what it is raised by. The range is that of raised colours: cut off at 1, a cell
/// that reaches white would be raised less and less towards it, and readers that cut off would draw 254.9 as 254.
fn component(x: f64, raise: f64) -> u16 {
    ((x.clamp(0.0, 1.0) + raise) / (1.0 + raise) * 65535.0).round() as u16
}

/// The stream of records; `components` are the colour channels that are written, each raised.
fn stream(
    cells: &[Cell],
    place: impl Fn(DVec2) -> DVec2,
    d: Decode,
    components: std::ops::Range<usize>,
    raise: f64,
) -> Vec<u8> {
    let mut out = Vec::with_capacity(cells.len() * (1 + 128 + 8 * components.len()));
    for cell in cells {
        out.push(0);
        for i in ORDER {
            let p = place(cell.geometry[i]);
            out.extend(coordinate(p.x, d[0], d[1]).to_be_bytes());
            out.extend(coordinate(p.y, d[2], d[3]).to_be_bytes());
        }
        for i in COLOURS {
            for c in components.clone() {
                out.extend(component(cell.colours[i][c], raise).to_be_bytes());
            }
        }
    }
    out
}

/// A page that shows the model rectangle `view` (x0, y0, x1, y1), its longer side [`LONG_SIDE`] points long. Layers are
/// painted one over another ([`super::layers`]); one that is translucent somewhere has a mask. `title` is what the page is
/// called.
///
/// # Errors
/// [`VectorError::Empty`].
pub fn page(layers: &[Vec<Cell>], [x0, y0, x1, y1]: [f64; 4], title: &str) -> Result<Vec<u8>, VectorError> {
    let (width, height) = (x1 - x0, y1 - y0);
    let scale = LONG_SIDE / width.max(height);
    if layers.iter().all(Vec::is_empty) || !scale.is_finite() || width <= 0.0 || height <= 0.0 {
        return Err(VectorError::Empty);
    }
    let place = |p: DVec2| (p - DVec2::new(x0, y0)) * scale;
    let mut next = 0;
    let mut reference = || {
        next += 1;
        Ref::new(next)
    };
    let [catalog, pages, page, content, info] = std::array::from_fn(|_| reference());
    let media = Rect::new(0.0, 0.0, (width * scale) as f32, (height * scale) as f32);
    let sheets: Vec<Sheet> = layers
        .iter()
        .filter(|cells| !cells.is_empty())
        .map(|cells| Sheet {
            cells,
            shading: reference(),
            mask: cells.iter().flat_map(|c| c.colours).any(|c| c.w < 1.0).then(|| std::array::from_fn(|_| reference())),
        })
        .collect();

    let mut pdf = Pdf::new();
    pdf.document_info(info)
        .title(pdf_writer::TextStr(title))
        .producer(pdf_writer::TextStr(concat!("gradtess ", env!("CARGO_PKG_VERSION"))));
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let named = |letter: char, i: usize| format!("{letter}{i}").into_bytes();
    let mut leaf = pdf.page(page);
    leaf.media_box(media).parent(pages).contents(content);
    let mut resources = leaf.resources();
    let mut shadings = resources.shadings();
    for (i, sheet) in sheets.iter().enumerate() {
        shadings.pair(Name(&named('S', i)), sheet.shading);
    }
    shadings.finish();
    if sheets.iter().any(|sheet| sheet.mask.is_some()) {
        let mut states = resources.ext_g_states();
        for (i, sheet) in sheets.iter().enumerate() {
            if let Some([_, _, state]) = sheet.mask {
                states.pair(Name(&named('M', i)), state);
            }
        }
        states.finish();
    }
    resources.finish();
    leaf.finish();

    let mut drawing = Content::new();
    for (i, sheet) in sheets.iter().enumerate() {
        drawing.save_state();
        if sheet.mask.is_some() {
            drawing.set_parameters(Name(&named('M', i)));
        }
        drawing.shading(Name(&named('S', i)));
        drawing.restore_state();
    }
    pdf.stream(content, &drawing.finish());
    for sheet in &sheets {
        sheet.write(&mut pdf, place, media);
    }
    Ok(pdf.finish())
}

/// A stream for the filter `FlateDecode`.
fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    // Nothing that reads memory fails.
    let _ = ZlibEncoder::new(bytes, Compression::default()).read_to_end(&mut out);
    out
}

/// A layer and the objects that it becomes.
struct Sheet<'a> {
    cells: &'a [Cell],
    shading: Ref,
    /// Shading of the alphas, the form that draws it, and the graphics state that it masks.
    mask: Option<[Ref; 3]>,
}

impl Sheet<'_> {
    fn write(&self, pdf: &mut Pdf, place: impl Fn(DVec2) -> DVec2 + Copy, media: Rect) {
        let d = decode_of(self.cells, place);
        let range =
            |n: usize, raise: f64| d.into_iter().chain([0.0, (1.0 + raise) as f32].into_iter().cycle().take(2 * n));
        let colours = packed(&stream(self.cells, place, d, 0..3, RAISE));
        let mut colour = pdf.stream_shading(self.shading, &colours);
        colour.filter(Filter::FlateDecode);
        colour.shading_type(StreamShadingType::TensorProductPatch);
        colour.color_space().device_rgb();
        colour.bits_per_coordinate(32).bits_per_component(16).bits_per_flag(8).decode(range(3, RAISE));
        colour.finish();
        let Some([grey, form, state]) = self.mask else { return };
        let alphas = packed(&stream(self.cells, place, d, 3..4, 0.0));
        let mut alpha = pdf.stream_shading(grey, &alphas);
        alpha.filter(Filter::FlateDecode);
        alpha.shading_type(StreamShadingType::TensorProductPatch);
        alpha.color_space().device_gray();
        alpha.bits_per_coordinate(32).bits_per_component(16).bits_per_flag(8).decode(range(1, 0.0));
        alpha.finish();
        let mut drawing = Content::new();
        drawing.shading(Name(b"G"));
        let drawn = drawing.finish();
        let mut group = pdf.form_xobject(form, &drawn);
        group.bbox(media);
        group.resources().shadings().pair(Name(b"G"), grey);
        group.group().transparency().color_space().device_gray();
        group.finish();
        let mut graphics = pdf.ext_graphics(state);
        graphics.soft_mask().subtype(MaskType::Luminosity).group(form);
        graphics.finish();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec4;

    #[test]
    fn a_record_is_what_the_standard_says() {
        let geometry = std::array::from_fn(|i| DVec2::new((i % 4) as f64, (i / 4) as f64));
        let colours = [0.0, 0.25, 0.5, 1.0].map(|x| DVec4::new(x, 0.0, 1.0, 0.5));
        let bytes = stream(&[Cell { geometry, colours }], |p| p, [0.0, 3.0, 0.0, 3.0], 0..3, 0.0);
        assert_eq!(bytes.len(), 1 + 16 * 8 + 4 * 3 * 2);
        let word = |i: usize| u32::from_be_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
        // p00, then p01: one step along v.
        assert_eq!((bytes[0], word(1), word(5)), (0, 0, 0));
        assert_eq!((word(9), word(13)), (0, u32::MAX / 3));
        // The fourth is p03, the corner D; the seventh p33, the corner C.
        assert_eq!((word(1 + 3 * 8), word(5 + 3 * 8)), (0, u32::MAX));
        assert_eq!((word(1 + 6 * 8), word(5 + 6 * 8)), (u32::MAX, u32::MAX));
        // Inner points last: p11, p12, p22, p21.
        assert_eq!((word(1 + 13 * 8), word(5 + 13 * 8)), (u32::MAX / 3, 2 * (u32::MAX / 3)));
        // Colours of A, D, C, B.
        let half = |k: usize| u16::from_be_bytes([bytes[129 + 6 * k], bytes[130 + 6 * k]]);
        assert_eq!([half(0), half(1), half(2), half(3)], [0, 65535, 32768, 16384]);
    }
    #[test]
    fn colours_of_8_bits_survive_readers_that_cut_off_and_those_that_round() {
        for step in 0..=255 {
            let read = f64::from(component(f64::from(step) / 255.0, RAISE)) / 65535.0 * 255.47;
            assert_eq!([read.floor(), read.round()], [f64::from(step); 2]);
        }
        for k in 0..=10_000 {
            let colour = f64::from(k) / 10_000.0;
            let read = f64::from(component(colour, RAISE)) / 65535.0 * 255.47;
            assert!((read - colour * 255.0).abs() < 0.475 && (read.floor() - colour * 255.0).abs() < 0.535);
        }
    }
}
