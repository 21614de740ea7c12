//! The picture of a surface that is open in the editor: what is drawn, made anew only where something else is asked for.

use super::surface::{Options, Shown, Solid};
use crate::gpu::{Gpu, GpuError, Pixels, PreparedSolid, SolidFrame, SolidNormals, SolidShow, Tessellation};
use crate::mesh;
use crate::patch::solid::{Segments, SolidTable};
use crate::surface::adaptive::Depth;
use crate::surface::drawing;
use crate::surface::level::{Level, Scheme};
use crate::surface::patches::{first_level, patches};
use crate::surface::refine::levels;
use crate::surface::shade::{shade, Settings};
use crate::surface::triangulate::triangulate;
use crate::surface::SurfaceError;
use egui::{ColorImage, TextureHandle, TextureId, TextureOptions};

/// Segments of a patch's side on level 0.
const SEGMENTS: Segments = Segments::Base(32);

/// Most half-edges of a level that follows the hand.
const LIVELY: u64 = 4_000_000;

/// What the last picture was of, and all that made it.
pub(super) struct Drawn {
    revision: u64,
    options: Options,
    table: SolidTable,
    prepared: Option<(SolidFrame, PreparedSolid)>,
    texture: Option<TextureHandle>,
}

impl Solid {
    /// The level that is drawn: the one chosen, or the finest that still follows the hand.
    pub fn level(&self) -> u32 {
        let corners = u64::from(self.mesh.half_edges());
        let fits = |l: &u32| *l == 0 || corners.saturating_mul(4u64.saturating_pow(*l)) <= LIVELY;
        (0..=self.options.level).rev().find(fits).unwrap_or(0)
    }

    fn table(&self) -> Result<SolidTable, SurfaceError> {
        let o = self.options;
        let cut = (o.scheme == Scheme::Loop).then(|| triangulate(&self.scene).0);
        let scene = cut.as_ref().unwrap_or(&self.scene);
        // Triangles of a manifold are one.
        let cut_mesh = cut.as_ref().and_then(|scene| mesh::build(&scene.polygons()).ok());
        let mesh = cut_mesh.as_ref().unwrap_or(&self.mesh);
        if o.patches && o.shown != Shown::Mesh {
            let control = Level::new(scene, mesh, o.scheme)?;
            let last = o.level.max(first_level(&control));
            let (_, made) = patches(&control, &scene.normals, &o.settings, Depth::adaptive(last, &o.settings));
            return Ok(drawing::patches(&made, made.bounds().0));
        }
        let levels = levels(scene, mesh, o.scheme, self.level())?;
        let last = &levels[levels.len() - 1];
        if o.shown == Shown::Mesh {
            return Ok(drawing::mesh(last, &last.position));
        }
        let settings = Settings { everywhere: o.normals == SolidNormals::Subdivided, ..o.settings };
        let shaded = shade(&levels, &scene.normals, &settings);
        let normals = match o.normals {
            SolidNormals::Blended => &shaded.blended,
            SolidNormals::Geometric => &shaded.geometric,
            SolidNormals::Subdivided => &shaded.subdivided,
        };
        Ok(drawing::triangles(last, &shaded, &last.position, normals))
    }

    fn frame(&self, [width, height]: [u32; 2], samples: u32) -> SolidFrame {
        let o = self.options;
        SolidFrame {
            width,
            height,
            camera: self.camera(f64::from(width) / f64::from(height.max(1))),
            show: match o.shown {
                Shown::Surface(show) => show,
                Shown::Mesh => SolidShow::Plain,
            },
            stripes: o.stripes,
            background: Some([0.86, 0.86, 0.88, 1.0]),
            samples,
            tessellation: Tessellation { segments: SEGMENTS, normals: o.normals, power: o.settings.power as f32 },
        }
    }

    /// Draws the surface, unless the last picture is just this one, and returns its texture.
    ///
    /// # Errors
    /// There is no such level, or the device fails: a line.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        ctx: &egui::Context,
        size: [u32; 2],
        samples: u32,
    ) -> Result<Option<TextureId>, String> {
        if size[0] == 0 || size[1] == 0 {
            return Ok(None);
        }
        let frame = self.frame(size, samples);
        let fresh = self.drawn.as_ref().is_some_and(|d| d.revision == self.revision && d.options == self.options);
        if !fresh {
            let texture = self.drawn.take().and_then(|d| d.texture);
            let table = self.table().map_err(|e| e.to_string())?;
            let (revision, options) = (self.revision, self.options);
            self.drawn = Some(Drawn { revision, options, table, prepared: None, texture });
        }
        let Some(drawn) = &mut self.drawn else { return Ok(None) };
        drawn.picture(gpu, ctx, frame).map_err(|e| e.to_string())
    }
}

impl Drawn {
    fn picture(&mut self, gpu: &Gpu, ctx: &egui::Context, frame: SolidFrame) -> Result<Option<TextureId>, GpuError> {
        match &mut self.prepared {
            Some((before, _)) if *before == frame => return Ok(self.texture.as_ref().map(TextureHandle::id)),
            Some((before, prepared)) if SolidFrame { camera: before.camera, ..frame.clone() } == *before => {
                prepared.look(frame.camera, &self.table);
                *before = frame.clone();
            }
            _ => {
                self.prepared = None;
                let prepared = gpu.prepare_solid(&self.table, &frame)?;
                self.prepared = Some((frame.clone(), prepared));
            }
        }
        let Some((_, prepared)) = &self.prepared else { return Ok(None) };
        prepared.run(true)?;
        let Pixels::Rgba8(pixels) = prepared.pixels()? else { return Ok(None) };
        let image = ColorImage::from_rgba_unmultiplied([frame.width as usize, frame.height as usize], &pixels);
        match &mut self.texture {
            Some(texture) => texture.set(image, TextureOptions::NEAREST),
            None => self.texture = Some(ctx.load_texture("surface", image, TextureOptions::NEAREST)),
        }
        Ok(self.texture.as_ref().map(TextureHandle::id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::surface::SurfaceScene;

    const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nt crease 2/1/0 0 1 2\n";

    #[test]
    fn every_way_to_draw_it_makes_a_table() {
        let mut solid = Solid::new(SurfaceScene::parse(CUBE.as_bytes(), "test").unwrap()).unwrap();
        for (scheme, patches, shown) in [
            (Scheme::CatmullClark, false, Shown::Surface(SolidShow::Shaded)),
            (Scheme::CatmullClark, true, Shown::Surface(SolidShow::Weights)),
            (Scheme::CatmullClark, true, Shown::Mesh),
            (Scheme::Loop, true, Shown::Surface(SolidShow::Highlight)),
        ] {
            for level in [0, 4] {
                solid.options = Options { scheme, patches, shown, level, ..Options::default() };
                let table = solid.table().unwrap();
                assert!(table.parts.iter().any(|p| p.count > 0), "{:?}", solid.options);
                let has_patches = table.parts.iter().any(|p| p.primitive.is_patch());
                assert_eq!(has_patches, patches && shown != Shown::Mesh);
            }
        }
        solid.options.level = 30;
        assert_eq!(solid.level(), 8);
    }
}
