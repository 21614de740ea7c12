//! The scene in the window: drawn by the same pipelines as every picture, and shown as a texture.

use super::view::View;
use crate::gpu::{Canvas, DeviceTable, Format, Frame, FrameTimes, Gpu, GpuError, Pixels, Screen, Show};
use crate::incremental::Changed;
use crate::patch::tess::TessRule;
use crate::patch::PatchTable;
use egui::TextureId;
use egui_ash::ImageRegistry;
use std::time::{Duration, Instant};

/// What is shown of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Surface, wire, kinds or levels.
    pub show: Show,
    /// Tessellation.
    pub tess: TessRule,
    /// Colour under it; `None`: clear, for a picture below.
    pub background: Option<[f32; 4]>,
    /// 1 or 4.
    pub samples: u32,
}

/// Times of the last frame of the scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drawn {
    /// Writing the table to the device, host time; `None` when it was there already.
    pub upload: Option<Duration>,
    /// The rest of the frame.
    pub frame: FrameTimes,
    /// Making ready: pipelines and push constants.
    pub prepare: Duration,
}

/// The device, the window's surface, and the scene on the device.
pub struct Renderer {
    // In this order they are dropped: what needs the device first.
    canvas: Option<Canvas>,
    table: Option<DeviceTable>,
    /// The window's swapchain.
    pub screen: Screen,
    /// The device.
    pub gpu: Gpu,
    registry: ImageRegistry,
    texture: Option<TextureId>,
    drawn: Option<(u64, Frame)>,
    /// Times of the last frame.
    pub last: Drawn,
}

impl Renderer {
    /// Nothing drawn yet.
    pub fn new(gpu: Gpu, screen: Screen, registry: ImageRegistry) -> Renderer {
        Renderer {
            canvas: None,
            table: None,
            screen,
            gpu,
            registry,
            texture: None,
            drawn: None,
            last: Drawn::default(),
        }
    }

    /// Draws anew whatever comes next: another scene, whose revisions count for themselves.
    pub fn forget(&mut self) {
        self.drawn = None;
    }

    /// Draws a table as the view shows it, unless the last picture is of that very revision, and returns its texture.
    /// `changed_since`: what a revision has not; `None`: the whole table is another.
    ///
    /// # Errors
    /// As [`Gpu::update`] and [`Gpu::prepare`].
    pub fn draw(
        &mut self,
        of: &PatchTable,
        now: u64,
        changed_since: impl Fn(u64) -> Option<Changed>,
        view: &View,
        look: &Look,
    ) -> Result<Option<TextureId>, GpuError> {
        let frame = frame_of(view, look);
        if frame.width == 0 || frame.height == 0 {
            return Ok(None);
        }
        if self.drawn.as_ref().is_some_and(|(revision, f)| *revision == now && *f == frame) {
            return Ok(self.texture);
        }
        let mut upload = None;
        if self.table.is_none() || self.drawn.as_ref().is_none_or(|(revision, _)| *revision != now) {
            let start = Instant::now();
            let changed = self.drawn.as_ref().and_then(|(revision, _)| changed_since(*revision));
            // Until it is drawn, nobody knows what is on the device.
            self.drawn = None;
            match &mut self.table {
                Some(table) => match changed {
                    Some(changed) if changed.indices.is_empty() && table.ranges() == of.ranges => {
                        self.gpu.update_points(table, of, &changed.control)?;
                    }
                    Some(changed) => {
                        self.gpu.update_parts(table, of, &changed.control, &changed.indices)?;
                    }
                    None => self.gpu.update(table, of)?,
                },
                None => self.table = Some(self.gpu.upload_with_room(of)?),
            }
            upload = Some(start.elapsed());
        }
        let Some(table) = &self.table else { return Ok(None) };
        let start = Instant::now();
        let old = self.canvas.take();
        let prepared = match old {
            Some(mut canvas) if canvas.fits(&frame) => {
                canvas.reframe(&frame)?;
                self.gpu.prepare_again(canvas, table)?
            }
            _ => {
                if let Some(texture) = self.texture.take() {
                    self.registry.unregister_user_texture(texture);
                }
                drop(old);
                self.gpu.prepare(table, &frame)?
            }
        };
        let prepare = start.elapsed();
        let times = prepared.run_to_show()?;
        let canvas = prepared.into_canvas();
        if self.texture.is_none() {
            let (image, sampler) = self.screen.texture(&canvas);
            self.texture = Some(self.registry.register_user_texture(image, sampler));
        }
        self.canvas = Some(canvas);
        self.last = Drawn { upload, frame: times, prepare };
        self.drawn = Some((now, frame));
        Ok(self.texture)
    }

    /// Colour of the surface at one window point, straight alpha; drawn anew, one pixel large. `None`: no surface there.
    ///
    /// # Errors
    /// As [`Renderer::draw`].
    pub fn colour_at(&mut self, view: &View, look: &Look, at: glam::DVec2) -> Result<Option<[f32; 4]>, GpuError> {
        let Some(table) = &self.table else { return Ok(None) };
        let half = 0.5 * view.unit;
        let frame = Frame {
            width: 1,
            height: 1,
            view: [at.x - half, at.y - half, at.x + half, at.y + half],
            show: Show::Surface,
            background: None,
            samples: 1,
            format: Format::Rgba32f,
            ..frame_of(view, look)
        };
        let drawn = self.gpu.render(table, &frame)?;
        Ok(match drawn.pixels {
            Pixels::Rgba32f(p) if p[3] > 0.0 => Some([p[0], p[1], p[2], p[3]]),
            _ => None,
        })
    }
}

/// The frame that a view is.
pub fn frame_of(view: &View, look: &Look) -> Frame {
    let [width, height] = view.size();
    Frame {
        width,
        height,
        view: view.seen(),
        tess: look.tess,
        show: look.show,
        background: look.background,
        samples: look.samples,
        format: Format::Rgba8,
        statistics: false,
    }
}
