//! The reference picture under the mesh.

use crate::scene::{Reference, Scene};
use egui::{ColorImage, TextureHandle, TextureOptions};
use glam::{DVec2, DVec4};
use std::path::{Path, PathBuf};

/// The picture that the scene names, as far as it could be read.
#[derive(Default)]
pub struct Picture {
    /// What was read, or could not be.
    file: Option<PathBuf>,
    /// Its pixels.
    pub pixels: Option<crate::image::Picture>,
    texture: Option<TextureHandle>,
}

impl Picture {
    /// Reads what the scene names, unless that is at hand; what is wrong with it.
    pub fn follow(&mut self, scene: &Scene, folder: &Path) -> Option<String> {
        let file = scene.reference.as_ref().map(|r| folder.join(&r.file));
        if file == self.file {
            return None;
        }
        (self.pixels, self.texture) = (None, None);
        self.file.clone_from(&file);
        let file = file?;
        match crate::image::Picture::read_png(&file) {
            Ok(picture) => {
                self.pixels = Some(picture);
                None
            }
            Err(e) => Some(format!("the reference picture is missing: {e}")),
        }
    }

    /// The texture, made when first asked for.
    pub fn texture(&mut self, ctx: &egui::Context) -> Option<egui::TextureId> {
        let pixels = self.pixels.as_ref()?;
        let texture = self.texture.get_or_insert_with(|| {
            let size = [pixels.width as usize, pixels.height as usize];
            let image = ColorImage::from_rgba_unmultiplied(size, &pixels.rgba);
            ctx.load_texture("reference picture", image, TextureOptions::LINEAR)
        });
        Some(texture.id())
    }
}

/// The place of a new picture: as high as the model, centred on it.
pub fn placed(file: String, picture: &crate::image::Picture, [x0, y0, x1, y1]: [f64; 4]) -> Reference {
    let (w, h) = (f64::from(picture.width.max(1)), f64::from(picture.height.max(1)));
    let scale = ((x1 - x0) / w).max((y1 - y0) / h);
    let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
    let (cx, cy) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let (dx, dy) = (0.5 * w * scale, 0.5 * h * scale);
    Reference { file, rect: [cx - dx, cy - dy, cx + dx, cy + dy], opacity: 1.0, locked: true }
}

/// Colour of the reference picture at a model point; `None` outside, or where it is clear.
pub fn sample(scene: &Scene, picture: &Picture, at: DVec2) -> Option<DVec4> {
    let (reference, pixels) = (scene.reference.as_ref()?, picture.pixels.as_ref()?);
    let [x0, y0, x1, y1] = reference.rect;
    let (u, v) = ((at.x - x0) / (x1 - x0), (y1 - at.y) / (y1 - y0));
    if !((0.0..1.0).contains(&u) && (0.0..1.0).contains(&v)) {
        return None;
    }
    let (i, j) = ((u * f64::from(pixels.width)) as usize, (v * f64::from(pixels.height)) as usize);
    let first = 4 * (j * pixels.width as usize + i);
    let p = pixels.rgba.get(first..first + 4)?;
    (p[3] > 0).then(|| DVec4::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]), f64::from(p[3])) / 255.0)
}
