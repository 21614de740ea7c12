//! Writer of the authors' format. The format holds less than a [`Scene`], so it says what is lost.

use crate::scene::numbering::{ends, nexts, twins};
use crate::scene::{ColourEdit, CornerRule, Frame, Scene};
use glam::DVec4;
use std::collections::{BTreeSet, HashMap};
use std::fmt::Write as _;

/// A model as text and what did not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The whole file.
    pub text: String,
    /// What the format cannot hold, one line for each kind; empty when nothing is lost.
    pub losses: Vec<String>,
}

/// Writes `scene` in the authors' format.
///
/// Initial corner colours become colour edits of level 0, whose sharpness follows from the colours; where that is not
/// what the scene says, it is listed in [`Written::losses`], like everything else that has no words there.
///
/// # Errors
/// (what, fix) when a geometry edit has no vertex number, which the format demands, or a number is beyond single
/// precision.
pub fn write(scene: &Scene) -> Result<Written, (String, String)> {
    let mut out = Output { text: String::new(), losses: Vec::new(), rounded: 0 };
    for p in &scene.mesh.positions {
        let (x, y) = (out.real(p.x)?, out.real(p.y)?);
        out.line(format_args!("v {x} {y}"));
    }
    for face in scene.mesh.face_start.windows(2) {
        let corners = &scene.mesh.corners[face[0] as usize..face[1] as usize];
        let numbers: Vec<String> = corners.iter().map(|&v| (u64::from(v) + 1).to_string()).collect();
        out.line(format_args!("f {}", numbers.join(" ")));
    }
    for (index, edit) in scene.geometry.iter().enumerate() {
        let vertex = edit.vertex.ok_or_else(|| {
            (
                format!(
                    "geometry edit {index} (level {}, half-edge {}) has no vertex number",
                    edit.level, edit.half_edge
                ),
                "give its \"vertex\" in the scene".to_owned(),
            )
        })?;
        let (a, b) = (out.real(edit.a)?, out.real(edit.b)?);
        let boundary = u8::from(edit.frame == Frame::Boundary);
        out.line(format_args!("ve {} {vertex} {} {a} {b} {boundary}", edit.level, edit.half_edge));
    }
    let initial = initial_colours(scene, &mut out.losses);
    for edit in initial.iter().chain(&scene.colours) {
        let [r, g, b] = [out.real(edit.colour.x)?, out.real(edit.colour.y)?, out.real(edit.colour.z)?];
        out.line(format_args!("ce {} {} {r} {g} {b}", edit.level, edit.half_edge));
    }
    out.list_losses(scene);
    Ok(Written { text: out.text, losses: out.losses })
}

struct Output {
    text: String,
    losses: Vec<String>,
    rounded: usize,
}

impl Output {
    fn line(&mut self, line: std::fmt::Arguments) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "{line}");
    }

    /// `value` as the authors' tool will hold it; counts the values that change.
    fn real(&mut self, value: f64) -> Result<f32, (String, String)> {
        let single = value as f32;
        if !single.is_finite() {
            return Err((format!("{value} does not fit single precision"), "scale the scene down".to_owned()));
        }
        self.rounded += usize::from(f64::from(single) != value);
        Ok(single)
    }

    fn list_losses(&mut self, scene: &Scene) {
        let translucent = scene.corner_colours.iter().chain(scene.colours.iter().map(|edit| &edit.colour));
        let counts = [
            (self.rounded, "numbers rounded to single precision"),
            (translucent.filter(|colour| colour.w != 1.0).count(), "colours lose their alpha"),
            (scene.handles.len(), "handles lost; write them as geometry edits of level 0"),
            (scene.face_points.len(), "face points lost; write them as geometry edits of level 0"),
            (
                usize::from(scene.corners == CornerRule::Smooth),
                "corner rule lost: the authors' tool always keeps corners sharp",
            ),
        ];
        for (count, what) in counts {
            if count > 0 {
                self.losses.push(format!("{count} {what}"));
            }
        }
    }
}

/// The colour edits of level 0 that stand for the initial corner colours; appends what they change.
fn initial_colours(scene: &Scene, losses: &mut Vec<String>) -> Vec<ColourEdit> {
    let edited: HashMap<u64, DVec4> =
        scene.colours.iter().filter(|edit| edit.level == 0).map(|edit| (edit.half_edge, edit.colour)).collect();
    let of_corner = |h: usize| 9 * h as u64;
    let colour = |h: usize| {
        let initial = scene.corner_colours.get(h).copied().unwrap_or(DVec4::ONE);
        edited.get(&of_corner(h)).copied().unwrap_or(initial).truncate()
    };
    let made: Vec<ColourEdit> = (0..scene.corner_colours.len())
        .filter(|&h| !edited.contains_key(&of_corner(h)))
        .map(|h| ColourEdit { level: 0, half_edge: of_corner(h), colour: colour(h).extend(1.0) })
        .collect();

    // In the authors' format an input edge is sharp exactly when the sectors on its two sides differ at one of its
    // ends and one of them is edited.
    let (twins, nexts) = (twins(&scene.mesh), nexts(&scene.mesh));
    let tagged: BTreeSet<u32> = scene.sharp.iter().copied().collect();
    let is_edited = |h: usize| edited.contains_key(&of_corner(h));
    let (mut lost, mut gained) = (0, 0);
    for h in 0..ends(&scene.mesh).len() {
        let Some(t) = twins[h].map(|t| t as usize).filter(|&t| h < t) else {
            continue;
        };
        let sides = [(h, nexts[t] as usize), (t, nexts[h] as usize)];
        let differs = sides.iter().any(|&(a, b)| colour(a) != colour(b));
        let by_edit = sides.iter().any(|&(a, b)| colour(a) != colour(b) && (is_edited(a) || is_edited(b)));
        let is_tagged = tagged.contains(&(h as u32)) || tagged.contains(&(t as u32));
        lost += usize::from(is_tagged && !differs);
        gained += usize::from(!is_tagged && differs && !by_edit);
    }
    if lost > 0 {
        losses.push(format!("{lost} sharp edges lost: the colours on their two sides are equal"));
    }
    if gained > 0 {
        losses.push(format!("{gained} edges become sharp: the corner colours on their two sides differ"));
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{shapes, GeometryEdit, Handle};
    use glam::DVec2;

    fn scene(mesh: &str) -> Scene {
        Scene { mesh: shapes::builtin(mesh).unwrap(), ..Scene::default() }
    }

    #[test]
    fn corner_colours_become_edits_unless_edited() {
        let mut scene = scene("grid:2x2");
        scene.mesh.positions.iter_mut().for_each(|p| *p *= 0.5);
        scene.corner_colours = vec![DVec4::new(0.5, 0.25, 0.0, 1.0); 16];
        scene.colours =
            (0..4).map(|h| ColourEdit { level: 0, half_edge: 9 * h, colour: scene.corner_colours[0] }).collect();
        let written = write(&scene).unwrap();
        assert_eq!(written.losses, Vec::<String>::new());
        assert_eq!(written.text.lines().filter(|line| line.starts_with("ce 0 ")).count(), 16);
    }

    #[test]
    fn every_loss_is_named() {
        let mut scene = scene("strip:2");
        scene.corners = CornerRule::Smooth;
        scene.mesh.positions[0].x = 0.1;
        scene.handles = vec![Handle { half_edge: 0, at: DVec2::ONE }];
        scene.face_points = scene.handles.clone();
        scene.corner_colours = vec![DVec4::new(1.0, 1.0, 1.0, 0.5); 8];
        // Half-edge 2 of face 0 and half-edge 0 of face 1 (number 4) run along the shared edge of a strip.
        let shared = twins(&scene.mesh).iter().position(Option::is_some).unwrap() as u32;
        scene.sharp = vec![shared];
        let text = write(&scene).unwrap().losses.join("\n");
        for word in ["single", "alpha", "handles", "face points", "corner rule", "sharp edges lost"] {
            assert!(text.contains(word), "{word} in {text}");
        }
        scene.sharp.clear();
        scene.corner_colours[4..].fill(DVec4::ZERO);
        assert!(write(&scene).unwrap().losses.join("\n").contains("become sharp"));
    }

    #[test]
    fn a_geometry_edit_needs_its_vertex() {
        let mut scene = scene("quad");
        scene.geometry =
            vec![GeometryEdit { level: 0, half_edge: 3, vertex: None, a: 0.5, b: 0.0, frame: Frame::Sector }];
        assert!(write(&scene).unwrap_err().0.contains("no vertex number"));
        scene.geometry[0].vertex = Some(4);
        assert!(write(&scene).unwrap().text.ends_with("ve 0 4 3 0.5 0 0\n"));
    }
}
