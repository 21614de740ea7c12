//! Eight-bit RGBA pictures: PNG files, comparison, and sheets of several pictures.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::Path;

/// An RGBA picture, 8 bits a channel, straight alpha.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `4 * width * height` bytes, rows from the top.
    pub rgba: Vec<u8>,
}

/// What went wrong with a picture file.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file could not be opened, written or renamed.
    #[error("{file}: {source}")]
    File {
        /// Path of the file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a PNG, or not one of 8 bits a channel.
    #[error("{file}: {what}; give an RGB or RGBA PNG of 8 bits a channel")]
    Content {
        /// Path of the file.
        file: String,
        /// What is wrong.
        what: String,
    },
}

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: u32, height: u32, colour: [u8; 4]) -> Picture {
        Picture { width, height, rgba: colour.repeat(width as usize * height as usize) }
    }

    /// The pixel in column `x` and row `y` from the top.
    ///
    /// # Panics
    /// When it lies outside.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "pixel {x},{y} of {}x{}", self.width, self.height);
        let at = 4 * (y as usize * self.width as usize + x as usize);
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2], self.rgba[at + 3]]
    }

    /// Writes a PNG: under a temporary name first, which then takes the place of `path`, so that an older file stays
    /// whole when this fails. `text` are (keyword, text) chunks, such as the driver that drew it.
    ///
    /// # Errors
    /// [`ImageError::File`].
    pub fn write_png(&self, path: &Path, text: &[(&str, &str)]) -> Result<(), ImageError> {
        let part = path.with_file_name(format!(
            ".{}.{}.part",
            path.file_name().unwrap_or_default().to_string_lossy(),
            std::process::id()
        ));
        let written = self.encode(&part, text).and_then(|()| std::fs::rename(&part, path));
        written.map_err(|source| {
            // The error that matters is the first; the leftover may not even exist.
            let _ = std::fs::remove_file(&part);
            ImageError::File { file: path.display().to_string(), source }
        })
    }

    /// The picture as the bytes of a PNG.
    ///
    /// # Errors
    /// The encoder refuses the size.
    pub fn png(&self) -> Result<Vec<u8>, ImageError> {
        let mut bytes = Vec::new();
        self.encode_to(&mut bytes, &[]).map_err(|source| ImageError::File { file: "picture".to_owned(), source })?;
        Ok(bytes)
    }

    fn encode(&self, path: &Path, text: &[(&str, &str)]) -> std::io::Result<()> {
        self.encode_to(BufWriter::new(File::create(path)?), text)
    }

    fn encode_to(&self, mut out: impl Write, text: &[(&str, &str)]) -> std::io::Result<()> {
        let mut encoder = png::Encoder::new(&mut out, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        for (keyword, value) in text {
            encoder.add_text_chunk((*keyword).to_owned(), (*value).to_owned())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgba)?;
        writer.finish()?;
        out.flush()
    }

    /// Reads an RGB or RGBA PNG of 8 bits a channel.
    ///
    /// # Errors
    /// [`ImageError`].
    pub fn read_png(path: &Path) -> Result<Picture, ImageError> {
        let file = path.display().to_string();
        let bad = |what: String| ImageError::Content { file: file.clone(), what };
        let opened = File::open(path).map_err(|source| ImageError::File { file: file.clone(), source })?;
        let mut reader = png::Decoder::new(BufReader::new(opened)).read_info().map_err(|e| bad(e.to_string()))?;
        let size = reader.output_buffer_size().ok_or_else(|| bad("the picture is too large".to_owned()))?;
        let mut bytes = vec![0; size];
        let info = reader.next_frame(&mut bytes).map_err(|e| bad(e.to_string()))?;
        bytes.truncate(info.buffer_size());
        let rgba = match (info.bit_depth, info.color_type) {
            (png::BitDepth::Eight, png::ColorType::Rgba) => bytes,
            (png::BitDepth::Eight, png::ColorType::Rgb) => {
                bytes.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]).collect()
            }
            (depth, colour) => return Err(bad(format!("{colour:?}, {} bits a channel", depth as u8))),
        };
        Ok(Picture { width: info.width, height: info.height, rgba })
    }

    /// The rectangle of `width` by `height` pixels whose top left pixel is (x, y), cut where the picture ends.
    pub fn crop(&self, x: u32, y: u32, width: u32, height: u32) -> Picture {
        let (x, y) = (x.min(self.width), y.min(self.height));
        let (width, height) = (width.min(self.width - x), height.min(self.height - y));
        let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
        for row in y..y + height {
            let at = 4 * (row as usize * self.width as usize + x as usize);
            rgba.extend_from_slice(&self.rgba[at..at + 4 * width as usize]);
        }
        Picture { width, height, rgba }
    }

    /// Copies `other` over this picture with its top left pixel at (x, y), cut where this picture ends. No blending.
    pub fn paste(&mut self, other: &Picture, x: u32, y: u32) {
        if x >= self.width || y >= self.height {
            return;
        }
        let columns = 4 * other.width.min(self.width - x) as usize;
        for row in 0..other.height.min(self.height - y) {
            let from = 4 * (row as usize * other.width as usize);
            let to = 4 * ((y + row) as usize * self.width as usize + x as usize);
            self.rgba[to..to + columns].copy_from_slice(&other.rgba[from..from + columns]);
        }
    }

    /// The picture over an opaque colour.
    pub fn over(&self, [r, g, b]: [u8; 3]) -> Picture {
        let blend = |c: u8, under: u8, alpha: u8| {
            ((u32::from(c) * u32::from(alpha) + u32::from(under) * (255 - u32::from(alpha)) + 127) / 255) as u8
        };
        let rgba = self
            .rgba
            .chunks_exact(4)
            .flat_map(|p| [blend(p[0], r, p[3]), blend(p[1], g, p[3]), blend(p[2], b, p[3]), 255])
            .collect();
        Picture { rgba, ..*self }
    }
}

/// Several pictures in rows of `columns`, each in a cell of the largest one's size, `gap` pixels apart.
pub fn contact_sheet(pictures: &[Picture], columns: u32, gap: u32, ground: [u8; 4]) -> Picture {
    let columns = columns.clamp(1, pictures.len().max(1) as u32);
    let rows = (pictures.len() as u32).div_ceil(columns);
    let cell = |side: fn(&Picture) -> u32| pictures.iter().map(side).max().unwrap_or(0) + gap;
    let (across, down) = (cell(|p| p.width), cell(|p| p.height));
    let mut sheet = Picture::filled(columns * across + gap, rows * down + gap, ground);
    for (i, picture) in (0..).zip(pictures) {
        sheet.paste(picture, gap + i % columns * across, gap + i / columns * down);
    }
    sheet
}

/// How two pictures of one size differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Greatest difference of any channel, 0 to 255.
    pub max_channel: u8,
    /// Pixels by their greatest channel difference: `histogram[d]` of them differ by d.
    pub histogram: Vec<u64>,
    /// Pixels that are covered (alpha above 0) in one picture only.
    pub coverage: u64,
}

impl Difference {
    /// Fraction of the pixels whose greatest channel difference is above `n`.
    pub fn fraction_beyond(&self, n: u8) -> f64 {
        let all: u64 = self.histogram.iter().sum();
        let beyond: u64 = self.histogram[n as usize + 1..].iter().sum();
        beyond as f64 / all.max(1) as f64
    }
}

/// Compares two pictures; `None` when their sizes differ.
pub fn compare(a: &Picture, b: &Picture) -> Option<Difference> {
    if (a.width, a.height) != (b.width, b.height) {
        return None;
    }
    let mut difference = Difference { max_channel: 0, histogram: vec![0; 256], coverage: 0 };
    for (p, q) in a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)) {
        let most = (0..4).map(|c| p[c].abs_diff(q[c])).max().unwrap_or(0);
        difference.histogram[most as usize] += 1;
        difference.max_channel = difference.max_channel.max(most);
        difference.coverage += u64::from((p[3] > 0) != (q[3] > 0));
    }
    Some(difference)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkered() -> Picture {
        let mut picture = Picture::filled(3, 2, [10, 20, 30, 255]);
        picture.rgba[4..8].copy_from_slice(&[200, 0, 0, 0]);
        picture
    }

    #[test]
    fn a_png_comes_back_and_nothing_is_left_beside_it() {
        let folder = std::env::temp_dir().join(format!("gradtess-image-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.png");
        checkered().write_png(&path, &[("Software", "gradtess")]).unwrap();
        checkered().write_png(&path, &[]).unwrap();
        assert_eq!(Picture::read_png(&path).unwrap(), checkered());
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
        std::fs::write(&path, b"not a picture").unwrap();
        assert!(matches!(Picture::read_png(&path), Err(ImageError::Content { .. })));
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(matches!(checkered().write_png(&path, &[]), Err(ImageError::File { .. })));
    }

    #[test]
    fn differences_are_counted() {
        let mut other = checkered();
        other.rgba[0] += 3;
        other.rgba[7] = 255;
        let difference = compare(&checkered(), &other).unwrap();
        assert_eq!((difference.max_channel, difference.coverage), (255, 1));
        assert_eq!(difference.fraction_beyond(3), 1.0 / 6.0);
        assert_eq!(difference.fraction_beyond(2), 2.0 / 6.0);
        assert_eq!(compare(&checkered(), &Picture::filled(2, 3, [0; 4])), None);
    }

    #[test]
    fn crops_and_sheets_put_pixels_where_they_belong() {
        let crop = checkered().crop(1, 0, 9, 1);
        assert_eq!((crop.width, crop.height, crop.pixel(0, 0)), (2, 1, [200, 0, 0, 0]));
        let sheet = contact_sheet(&[checkered(), crop, checkered()], 2, 1, [9; 4]);
        assert_eq!((sheet.width, sheet.height), (9, 7));
        assert_eq!(sheet.pixel(2, 1), [200, 0, 0, 0]);
        assert_eq!(sheet.pixel(5, 1), [200, 0, 0, 0]);
        assert_eq!(sheet.pixel(1, 4), [10, 20, 30, 255]);
        assert_eq!(sheet.pixel(0, 0), [9; 4]);
    }

    #[test]
    fn transparent_pixels_show_the_ground() {
        assert_eq!(checkered().over([1, 2, 3]).pixel(1, 0), [1, 2, 3, 255]);
        assert_eq!(checkered().over([1, 2, 3]).pixel(0, 0), [10, 20, 30, 255]);
    }
}
