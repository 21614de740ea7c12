//! `gradtess check --fly N` and `--slow-zoom N`: background within the outline, and jumps, along scripted camera paths.

use super::render::pattern;
use crate::check::flight::{background_inside, flight, greatest_change, slow_zoom};
use crate::command::Failure;
use crate::gpu::{Gpu, PatternFrame, PatternMethod, PatternScene as Drawn};
use serde::Serialize;

/// Greatest change of a channel between frames of a slow zoom that is let pass, unless the zoom itself changes more.
pub const CHANGE: u8 = 8;

/// Level of the pattern that the outline is taken from.
const OUTLINE: u32 = 32;

/// A flight.
#[derive(Serialize)]
pub struct Flight {
    frames: u32,
    /// Pixels in which the background was seen within the outline of the same view at one level.
    pub background_inside: usize,
    /// Pixels that were covered.
    covered: usize,
}

/// A slow zoom.
#[derive(Serialize)]
pub struct Zoom {
    frames: u32,
    /// Greatest change of a channel of a pixel from one frame to the next, of 255.
    pub change: u8,
    /// The same drawn at one level: what the zoom itself changes, where colours or creases are sharp.
    pub change_at_one_level: u8,
    /// Least part of a picture that was compared.
    compared: f64,
}

impl Flight {
    /// In words.
    pub fn text(&self) -> String {
        format!("{} frames, {} background pixels inside", self.frames, self.background_inside)
    }
}

impl Zoom {
    /// In words.
    pub fn text(&self) -> String {
        let [n, change, one] = [self.frames, self.change.into(), self.change_at_one_level.into()];
        format!("{n} frames, no pixel changes by more than {change} of 255 (at one level {one})")
    }
}

/// Flies as `frame` draws.
pub fn fly(gpu: &Gpu, drawn: &Drawn, frame: &PatternFrame, frames: u32) -> Result<Flight, Failure> {
    let aspect = f64::from(frame.width) / f64::from(frame.height);
    let outline = pattern(OUTLINE, false)?;
    let whole = Drawn { pattern: &outline, coarse: None, ..*drawn };
    let at_one_level = PatternFrame { method: PatternMethod::Instanced, detail: None, ..frame.clone() };
    let mut reference = gpu.prepare_pattern(&whole, &at_one_level)?;
    let mut prepared = gpu.prepare_pattern(drawn, frame)?;
    // Outlines of curves by segments differ by less than half of one.
    let reach = frame.detail.map_or(3, |detail| (detail.segment / 2.0).ceil().clamp(3.0, 64.0) as usize);
    let mut flown = Flight { frames, background_inside: 0, covered: 0 };
    for camera in flight(frame.bounds, frames, aspect) {
        let mut pictures = Vec::with_capacity(2);
        for (prepared, scene) in [(&mut prepared, drawn), (&mut reference, &whole)] {
            prepared.look(camera, scene)?;
            prepared.run(true)?;
            pictures.push(prepared.pixels()?.into_picture(frame.width, frame.height));
        }
        flown.background_inside += background_inside(&pictures[0], Some(&pictures[1]), reach);
        flown.covered += pictures[0].rgba.chunks_exact(4).filter(|p| p[3] > 0).count();
    }
    Ok(flown)
}

/// Zooms as `frame` draws.
pub fn zoom(gpu: &Gpu, drawn: &Drawn, frame: &PatternFrame, frames: u32) -> Result<Zoom, Failure> {
    let aspect = f64::from(frame.width) / f64::from(frame.height);
    let all = (f64::from(frame.width) * f64::from(frame.height)).max(1.0);
    let fine = pattern(OUTLINE, false)?;
    let whole = Drawn { pattern: &fine, coarse: None, ..*drawn };
    let at_one_level = PatternFrame { method: PatternMethod::Instanced, detail: None, ..frame.clone() };
    let mut compared: f64 = 1.0;
    let mut changes = [0; 2];
    for (k, (frame, scene)) in [(frame, drawn), (&at_one_level, &whole)].into_iter().enumerate() {
        let mut prepared = gpu.prepare_pattern(scene, frame)?;
        let mut last = None;
        for camera in slow_zoom(frame.bounds, frames, aspect) {
            prepared.look(camera, scene)?;
            prepared.run(true)?;
            let picture = prepared.pixels()?.into_picture(frame.width, frame.height);
            if let Some(last) = &last {
                let (change, both) = greatest_change(last, &picture);
                changes[k] = changes[k].max(change);
                compared = compared.min(both as f64 / all);
            }
            last = Some(picture);
        }
    }
    Ok(Zoom { frames, change: changes[0], change_at_one_level: changes[1], compared })
}
