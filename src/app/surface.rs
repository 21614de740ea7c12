//! A surface in space (ZBK23) that is open in the editor: its sharp edges and their steps, and from where it is seen.

use super::surface_journal::{line_of, line_of_move, Keeper, Line};
use super::surface_picture::Drawn;
use crate::camera::{bounds, Camera, Projection};
use crate::gpu::{SolidNormals, SolidShow};
use crate::mesh::{self, HalfEdgeMesh, NONE};
use crate::scene::surface::{SurfaceScene, INFINITE};
use crate::surface::level::{Level, Scheme};
use crate::surface::shade::Settings;
use egui::{Pos2, Rect};
use glam::{DMat4, DVec3};
use std::collections::BTreeSet;

/// What is shown of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// The surface, coloured so.
    Surface(SolidShow),
    /// The mesh of the level.
    Mesh,
}

/// How the surface is made and drawn; all of it is of the view and none of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Subdivision scheme; Loop cuts polygons into triangles.
    pub scheme: Scheme,
    /// Patches of the limit in place of a level's triangles.
    pub patches: bool,
    /// Level of triangles, or last one of patches.
    pub level: u32,
    /// Normals, weights, p.
    pub settings: Settings,
    /// Which normals colour it.
    pub normals: SolidNormals,
    /// What is shown.
    pub shown: Shown,
    /// Stripes of highlight and reflection lines.
    pub stripes: f32,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            scheme: Scheme::CatmullClark,
            patches: false,
            level: 3,
            settings: Settings::default(),
            normals: SolidNormals::Blended,
            shown: Shown::Surface(SolidShow::Shaded),
            stripes: 30.0,
        }
    }
}

/// Where the eye is around the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Degrees to the right.
    pub yaw: f64,
    /// Degrees above.
    pub pitch: f64,
    /// Distance over that at which everything fits.
    pub distance: f64,
    /// Model units to the right and up.
    pub shift: [f64; 2],
}

impl Default for Orbit {
    fn default() -> Self {
        Orbit { yaw: 30.0, pitch: 20.0, distance: 1.0, shift: [0.0; 2] }
    }
}

/// Vertical angle of view, degrees.
pub(super) const FOV: f64 = 30.0;

/// From space to the window.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    matrix: DMat4,
    rect: Rect,
}

impl Eye {
    /// Place in the window and distance from the eye; `None` behind it.
    pub fn place(&self, p: DVec3) -> Option<(Pos2, f64)> {
        let q = self.matrix * p.extend(1.0);
        if q.w <= 0.0 {
            return None;
        }
        let (c, half) = (self.rect.center(), self.rect.size() * 0.5);
        let at = Pos2::new(c.x + (q.x / q.w) as f32 * half.x, c.y + (q.y / q.w) as f32 * half.y);
        Some((at, q.w))
    }
}

/// Edges and the sharpness that they had and got.
pub(super) struct Step {
    pub(super) edges: Vec<u32>,
    before: Vec<f64>,
    pub(super) after: f64,
}

/// The surface and what follows from it. An edge goes by its lower half-edge.
pub struct Solid {
    /// The surface; creases given by their ends have become sharpness of half-edges.
    pub scene: SurfaceScene,
    pub(super) mesh: HalfEdgeMesh,
    /// How it is drawn.
    pub options: Options,
    /// From where.
    pub orbit: Orbit,
    /// Edges that are selected.
    pub selected: BTreeSet<u32>,
    /// Where the pointer went down, until it has moved: then it turns the surface.
    pub pressed: Option<Pos2>,
    pub(super) bounds: [DVec3; 2],
    pub(super) done: Vec<Step>,
    pub(super) undone: Vec<Step>,
    pub(super) gesture: Option<Step>,
    pub(super) saved_at: Option<usize>,
    pub(super) keeper: Keeper,
    pub(super) revision: u64,
    pub(super) drawn: Option<Drawn>,
}

impl Solid {
    /// A surface without steps.
    ///
    /// # Errors
    /// Its polygons are no manifold, or a tag names no edge: a line without the file's name.
    pub fn new(mut scene: SurfaceScene) -> Result<Solid, String> {
        let mesh = mesh::build(&scene.polygons()).map_err(|e| e.to_string())?;
        let control = Level::new(&scene, &mesh, Scheme::CatmullClark).map_err(|e| e.to_string())?;
        scene.edge_sharpness = (0..control.half_edges())
            .map(|h| if control.twin[h] == NONE { 0.0 } else { control.sharpness[control.edge[h] as usize] })
            .collect();
        scene.creases.clear();
        Ok(Solid {
            bounds: bounds(scene.positions.iter().copied()).unwrap_or_default(),
            scene,
            mesh,
            options: Options::default(),
            orbit: Orbit::default(),
            selected: BTreeSet::new(),
            pressed: None,
            done: Vec::new(),
            undone: Vec::new(),
            gesture: None,
            saved_at: Some(0),
            keeper: Keeper::default(),
            revision: 1,
            drawn: None,
        })
    }

    // Edges.

    /// Edges of the control mesh.
    pub fn edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.mesh.half_edges()).filter(|&h| self.is_edge(h))
    }

    /// Whether an edge goes by this half-edge.
    pub fn is_edge(&self, h: u32) -> bool {
        self.mesh.twin.get(h as usize).is_some_and(|&twin| twin == NONE || h < twin)
    }

    /// Its ends.
    pub fn ends(&self, h: u32) -> [DVec3; 2] {
        [self.mesh.origin[h as usize], self.mesh.origin[self.mesh.next(h) as usize]]
            .map(|v| self.scene.positions[v as usize])
    }

    /// Its sharpness.
    pub fn sharpness(&self, h: u32) -> f64 {
        self.scene.edge_sharpness[h as usize]
    }

    /// Whether it has a face on one side only, where it is sharp for ever whatever its number says.
    pub fn on_boundary(&self, h: u32) -> bool {
        self.mesh.twin[h as usize] == NONE
    }

    /// The edge within `reach` of a place of the window; of several the one in front.
    pub fn edge_at(&self, eye: &Eye, at: Pos2, reach: f32) -> Option<u32> {
        let size = (self.bounds[1] - self.bounds[0]).length().max(f64::MIN_POSITIVE);
        let mut best: Option<(f64, u32)> = None;
        for h in self.edges() {
            let [Some((a, near)), Some((b, far))] = self.ends(h).map(|p| eye.place(p)) else { continue };
            let along = b - a;
            let t = ((at - a).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
            let away = (a + along * t).distance(at);
            if away > reach {
                continue;
            }
            let score = f64::from(away) + 60.0 * (near + (far - near) * f64::from(t)) / size;
            if best.is_none_or(|(s, _)| score < s) {
                best = Some((score, h));
            }
        }
        best.map(|(_, h)| h)
    }

    /// Selects an edge alone, or adds or removes it; no edge and not `add`: nothing is selected.
    pub fn pick(&mut self, edge: Option<u32>, add: bool) {
        if !add {
            self.selected.clear();
        }
        if let Some(h) = edge {
            if !self.selected.remove(&h) {
                self.selected.insert(h);
            }
        }
    }

    // Steps.

    fn put(&mut self, edges: &[u32], sharpness: impl Fn(usize) -> f64) {
        for (k, &h) in edges.iter().enumerate() {
            let s = sharpness(k);
            self.scene.edge_sharpness[h as usize] = s;
            let t = self.mesh.twin[h as usize];
            if t != NONE {
                self.scene.edge_sharpness[t as usize] = s;
            }
        }
        self.revision += 1;
    }

    /// Gives the selected edges a sharpness, as part of a gesture; [`INFINITE`] and more: for ever. Boundary edges keep what
    /// they are.
    pub fn sharpen(&mut self, sharpness: f64) {
        let after = if sharpness >= INFINITE { f64::INFINITY } else { sharpness.max(0.0) };
        let step = self.gesture.take().unwrap_or_else(|| {
            let edges: Vec<u32> = self.selected.iter().copied().filter(|&h| !self.on_boundary(h)).collect();
            let before = edges.iter().map(|&h| self.sharpness(h)).collect();
            Step { edges, before, after }
        });
        let step = Step { after, ..step };
        self.put(&step.edges, |_| after);
        self.gesture = Some(step);
    }

    /// Ends the gesture, which is one step.
    pub fn commit(&mut self) {
        let Some(step) = self.gesture.take() else { return };
        if step.before.iter().all(|&s| s == step.after) {
            return self.keeper.gave_up(Line::GivenUp);
        }
        self.keeper.step(line_of(&step));
        if self.saved_at.is_some_and(|at| at > self.done.len()) {
            self.saved_at = None;
        }
        self.undone.clear();
        self.done.push(step);
    }

    /// Takes a step back, or does it again; whether there was one.
    pub fn step(&mut self, forward: bool) -> bool {
        self.commit();
        let step = if forward { self.undone.pop() } else { self.done.pop() };
        let Some(step) = step else { return false };
        self.keeper.moved(line_of_move(forward));
        self.put(&step.edges, |k| if forward { step.after } else { step.before[k] });
        self.selected = step.edges.iter().copied().collect();
        if forward {
            self.done.push(step);
        } else {
            self.undone.push(step);
        }
        true
    }

    /// Whether the surface differs from its file.
    pub fn unsaved(&self) -> bool {
        self.gesture.is_some() || self.saved_at != Some(self.done.len())
    }

    /// It is on the disk as it is.
    pub fn saved(&mut self) {
        self.saved_at = Some(self.done.len());
        self.keeper.end();
    }

    /// The surface before its first step.
    pub fn as_opened(&self) -> SurfaceScene {
        let mut scene = self.scene.clone();
        for step in self.done.iter().chain(&self.gesture).rev() {
            for (&h, &s) in step.edges.iter().zip(&step.before) {
                scene.edge_sharpness[h as usize] = s;
                let t = self.mesh.twin[h as usize];
                if t != NONE {
                    scene.edge_sharpness[t as usize] = s;
                }
            }
        }
        scene
    }

    /// Steps that can be undone.
    pub fn steps(&self) -> usize {
        self.done.len()
    }

    // Pictures.

    /// The camera for a canvas of that width over height.
    pub fn camera(&self, aspect: f64) -> Camera {
        let o = self.orbit;
        let whole = Camera::orbit(self.bounds, o.yaw, o.pitch, Projection::Perspective { fov: FOV }, aspect);
        let camera = whole.at_distance((whole.eye - whole.target).length() * o.distance);
        let [right, up, _] = camera.axes();
        let shift = right * o.shift[0] + up * o.shift[1];
        Camera { eye: camera.eye + shift, target: camera.target + shift, ..camera }
    }

    /// From space to a canvas.
    pub fn eye(&self, rect: Rect) -> Eye {
        let aspect = f64::from(rect.width() / rect.height().max(1.0));
        Eye { matrix: self.camera(aspect).matrix(aspect, self.bounds), rect }
    }

    /// Model units a point of the window, in the middle of the surface.
    pub fn per_point(&self, rect: Rect) -> f64 {
        let camera = self.camera(f64::from(rect.width() / rect.height().max(1.0)));
        let height = 2.0 * (0.5 * FOV.to_radians()).tan() * (camera.eye - camera.target).length();
        height / f64::from(rect.height().max(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nt crease 2/1/0 0 1 2\n";

    fn solid(text: &str) -> Solid {
        Solid::new(SurfaceScene::parse(text.as_bytes(), "test").unwrap()).unwrap()
    }

    #[test]
    fn a_click_takes_the_edge_in_front_and_a_gesture_is_one_step() {
        let mut solid = solid(CUBE);
        assert_eq!(solid.edges().count(), 12);
        solid.orbit = Orbit { yaw: 0.0, pitch: 0.0, ..Orbit::default() };
        let rect = Rect::from_min_max(Pos2::new(100.0, 20.0), Pos2::new(500.0, 420.0));
        let eye = solid.eye(rect);
        // The front is z = 1; the edge at y = 1 behind it is a little lower in the picture.
        let (front, _) = eye.place(DVec3::new(0.5, 1.0, 1.0)).unwrap();
        let (back, _) = eye.place(DVec3::new(0.5, 1.0, 0.0)).unwrap();
        assert!(front.y < back.y && (front.x - 300.0).abs() < 1e-3);
        let edge = solid.edge_at(&eye, front, 9.0).unwrap();
        assert!(solid.ends(edge).iter().all(|p| p.y == 1.0 && p.z == 1.0));
        assert_eq!(solid.edge_at(&eye, Pos2::new(300.0, 220.0), 9.0), None);
        solid.pick(Some(edge), false);
        for s in [0.5, 3.0, 1.5] {
            solid.sharpen(s);
        }
        solid.commit();
        let creased = solid.edges().find(|&h| solid.sharpness(h) == 2.0).unwrap();
        solid.pick(Some(creased), true);
        solid.sharpen(10.0);
        solid.commit();
        assert_eq!((solid.steps(), solid.sharpness(edge)), (2, f64::INFINITY));
        assert!(solid.step(false));
        assert_eq!([edge, creased].map(|h| solid.sharpness(h)), [1.5, 2.0]);
        assert!(solid.step(false) && !solid.step(false) && !solid.unsaved());
        assert!(solid.step(true) && solid.unsaved());
        // Both halves say the same, and the file has them.
        let written = SurfaceScene::parse(crate::scene::surface::write(&solid.scene).as_bytes(), "test").unwrap();
        assert_eq!(written.edge_sharpness, solid.scene.edge_sharpness);
        assert_eq!(written.edge_sharpness.iter().filter(|&&s| s == 1.5).count(), 2);
    }
}
