//! What part of the model the canvas shows, and where things are in it.

use egui::{Pos2, Rect};
use glam::DVec2;

/// The part of the model in the canvas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Model point in the middle.
    pub centre: DVec2,
    /// Scene units a pixel.
    pub unit: f64,
    /// The canvas in the window, points; whole pixels.
    pub rect: Rect,
    /// Pixels a point.
    pub scale: f32,
}

impl Default for View {
    fn default() -> Self {
        let rect = Rect::from_min_size(Pos2::ZERO, egui::Vec2::splat(100.0));
        View { centre: DVec2::ZERO, unit: 0.01, rect, scale: 1.0 }
    }
}

impl View {
    /// Pixels of the canvas.
    pub fn size(&self) -> [u32; 2] {
        [(self.rect.width() * self.scale).round() as u32, (self.rect.height() * self.scale).round() as u32]
    }

    /// Scene units a point.
    pub fn per_point(&self) -> f64 {
        self.unit * f64::from(self.scale)
    }

    /// Window point of a model point.
    pub fn to_window(self, p: DVec2) -> Pos2 {
        let d = (p - self.centre) / self.per_point();
        let c = self.rect.center();
        Pos2::new(c.x + d.x as f32, c.y - d.y as f32)
    }

    /// Model point under a window point.
    pub fn to_model(self, p: Pos2) -> DVec2 {
        let d = p - self.rect.center();
        self.centre + DVec2::new(f64::from(d.x), -f64::from(d.y)) * self.per_point()
    }

    /// Model rectangle x0, y0, x1, y1 that is seen.
    pub fn seen(&self) -> [f64; 4] {
        let [w, h] = self.size();
        let half = DVec2::new(f64::from(w), f64::from(h)) * 0.5 * self.unit;
        let (low, high) = (self.centre - half, self.centre + half);
        [low.x, low.y, high.x, high.y]
    }

    /// Shows a model rectangle whole, with some air around it.
    pub fn fit(&mut self, [x0, y0, x1, y1]: [f64; 4]) {
        let [w, h] = self.size();
        let room = |pixels: u32| (f64::from(pixels) - 48.0).max(1.0);
        let unit = ((x1 - x0) / room(w)).max((y1 - y0) / room(h));
        if unit.is_finite() && unit > 0.0 {
            self.unit = unit;
        }
        self.centre = DVec2::new(0.5 * (x0 + x1), 0.5 * (y0 + y1));
    }

    /// Zooms by `factor` (above 1: closer) about a window point, which stays where it is. `size` is the model's, so
    /// that numbers stay within reason.
    pub fn zoom(&mut self, factor: f64, about: Pos2, size: f64) {
        let fixed = self.to_model(about);
        self.unit = (self.unit / factor).clamp(1e-9 * size, 10.0 * size);
        self.centre += fixed - self.to_model(about);
    }

    /// Moves the model by points of the window.
    pub fn pan(&mut self, by: egui::Vec2) {
        self.centre -= DVec2::new(f64::from(by.x), -f64::from(by.y)) * self.per_point();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zooming_keeps_the_point_under_the_pointer() {
        let rect = Rect::from_min_max(Pos2::new(0.0, 30.0), Pos2::new(800.0, 630.0));
        let mut view = View { rect, scale: 2.0, ..View::default() };
        view.fit([-1.0, -1.0, 3.0, 1.0]);
        assert_eq!(view.size(), [1600, 1200]);
        let at = Pos2::new(123.0, 456.0);
        let under = view.to_model(at);
        view.zoom(1.7, at, 4.0);
        assert!((view.to_model(at) - under).length() < 1e-9);
        assert!((view.to_window(under) - at).length() < 1e-3);
        let [x0, y0, x1, y1] = view.seen();
        assert!(((x1 - x0) / (y1 - y0) - 4.0 / 3.0).abs() < 1e-12);
        view.pan(egui::vec2(10.0, -5.0));
        assert!((view.to_model(at + egui::vec2(10.0, -5.0)) - under).length() < 1e-9);
    }
}
