//! Height maps: PNG of 8 or 16 bits, of which the first channel counts.

use std::io::Cursor;

/// Most texels.
const MOST: u64 = 1 << 26;

/// Columns, rows, and heights from 0 to 1, rows from the top.
pub(super) fn read(bytes: &[u8]) -> Result<([u32; 2], Vec<f32>), String> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let (width, height) = (reader.info().width, reader.info().height);
    if u64::from(width) * u64::from(height) > MOST {
        return Err(format!("{width}x{height} texels are too many"));
    }
    let size = reader.output_buffer_size().ok_or("the picture is too large")?;
    let mut raw = vec![0; size];
    let info = reader.next_frame(&mut raw).map_err(|e| e.to_string())?;
    let channels = info.color_type.samples();
    let heights = match info.bit_depth {
        png::BitDepth::Sixteen => raw[..info.buffer_size()]
            .chunks_exact(2 * channels)
            .map(|p| f32::from(u16::from_be_bytes([p[0], p[1]])) / 65535.0)
            .collect(),
        _ => raw[..info.buffer_size()].chunks_exact(channels).map(|p| f32::from(p[0]) / 255.0).collect(),
    };
    Ok(([info.width, info.height], heights))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(depth: png::BitDepth, colour: png::ColorType, data: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, 2, 1);
        encoder.set_depth(depth);
        encoder.set_color(colour);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        out
    }

    #[test]
    fn both_depths_keep_their_precision() {
        let deep = png(png::BitDepth::Sixteen, png::ColorType::Grayscale, &[0x12, 0x34, 0xFF, 0xFF]);
        assert_eq!(read(&deep).unwrap(), ([2, 1], vec![f32::from(0x1234u16) / 65535.0, 1.0]));
        let flat = png(png::BitDepth::Eight, png::ColorType::Rgb, &[51, 0, 0, 255, 9, 9]);
        assert_eq!(read(&flat).unwrap().1, [0.2, 1.0]);
        assert!(read(b"no picture").is_err());
    }
}
