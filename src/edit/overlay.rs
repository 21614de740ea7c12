//! What is seen of the edited level: its handles and its control mesh, within a view (ZHHK22 5.1, Fig. 10).

use super::handle::{least_slot, origin_of, Id, Kind, Origin, Stage};
use super::place::{finest, limit_in};
use super::EditError;
use crate::mesh::HalfEdgeMesh;
use crate::refine::region::{region, Region};
use crate::refine::Refinement;
use crate::scene::Scene;
use crate::subdiv::fan::{position_fan, Fan};
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::Level;
use crate::subdiv::limit::edge_point;
use glam::{DVec2, DVec4};

/// Most faces of the level that are shown at once; more would lie closer than a pointer can tell apart.
pub const MOST_FACES: usize = 6000;

/// Distance of a sector's handle from its vertex, pixels.
pub const SECTOR_OFFSET: f64 = 13.0;

/// A handle in the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handle {
    /// Its name.
    pub id: Id,
    /// Limit point of its vertex, scene units.
    pub at: DVec2,
    /// Where it is drawn and picked: the limit or control point, sectors offset into their face.
    pub shown: DVec2,
    /// Control point of its vertex.
    pub control: DVec2,
    /// Colour of its corner, or of the vertex's first sector.
    pub colour: DVec4,
}

/// An edge of the control mesh as a cubic over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Bezier points; on a straight line where control positions are shown.
    pub curve: [DVec2; 4],
    /// Whether colours do not blend across it.
    pub sharp: bool,
    /// A slot along it, of the level shown.
    pub slot: Slot,
    /// Whether it is part of an edge of the input mesh.
    pub input: bool,
}

/// Handles and control mesh of a stage within a view.
#[derive(Clone, Debug, Default)]
pub struct Overlay {
    /// Handles, vertex by vertex in slot order.
    pub handles: Vec<Handle>,
    /// Edges, each once.
    pub edges: Vec<Edge>,
    /// The level has more faces in the view than are shown; its handles wait until the view is closer.
    pub crowded: bool,
}

/// What to make of the overlay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Which mesh.
    pub stage: Stage,
    /// Model rectangle x0, y0, x1, y1 that is visible.
    pub view: [f64; 4],
    /// Scene units a pixel.
    pub pixel: f64,
    /// Control points (true) or limit points.
    pub control: bool,
}

/// The overlay of a refined scene. Costs the faces of the level in the view, and one ternary step.
///
/// # Errors
/// As [`region`].
pub fn overlay(scene: &Scene, mesh: &HalfEdgeMesh, refinement: &Refinement, look: &Look) -> Result<Overlay, EditError> {
    let level = look.stage.level();
    let [x0, y0, x1, y1] = look.view;
    // A vertex may lie outside the hull of its own face; half a view more catches what is near.
    let margin = 0.25 * (x1 - x0).max(y1 - y0);
    let wide = [x0 - margin, y0 - margin, x1 + margin, y1 + margin];
    let mut budget = MOST_FACES * 2;
    let mut crowded = false;
    let made = region(scene, mesh, level, &[], |l, f| {
        let seen = !crowded && touches(l, f, wide);
        if seen && l.level + 1 == level {
            // Each face has four children.
            match budget.checked_sub(4) {
                Some(left) => budget = left,
                None => crowded = true,
            }
        }
        seen
    })?;
    if crowded {
        return Ok(Overlay { crowded, ..Overlay::default() });
    }
    let mut collect =
        Collect { mesh, map: IndexMap::new(mesh), refinement, made: &made, look, out: Overlay::default() };
    collect.run(scene);
    let mut out = collect.out;
    if out.edges.len() > 2 * MOST_FACES || out.handles.len() > 2 * MOST_FACES {
        out = Overlay { crowded: true, ..Overlay::default() };
    }
    Ok(out)
}

/// Whether the bounding box of a face's control points meets a rectangle.
fn touches(level: &Level, f: u32, [x0, y0, x1, y1]: [f64; 4]) -> bool {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for h in level.of_face(f) {
        let p = level.position(h);
        (low, high) = (low.min(p), high.max(p));
    }
    low.x <= x1 && high.x >= x0 && low.y <= y1 && high.y >= y0
}

/// Name in M^l of a local half-edge.
pub(super) fn slot_of(map: &IndexMap, level: &Level, h: u32) -> Slot {
    let f = level.face_of(h);
    match level.level {
        0 => u64::from(h),
        _ => {
            debug_assert!(map.half_edges(level.level) > 0);
            4 * level.face[f as usize] + u64::from(h & 3)
        }
    }
}

struct Collect<'a> {
    mesh: &'a HalfEdgeMesh,
    map: IndexMap<'a>,
    refinement: &'a Refinement,
    made: &'a Region,
    look: &'a Look,
    out: Overlay,
}

impl Collect<'_> {
    fn run(&mut self, scene: &Scene) {
        let level = self.made.last();
        let corners = scene.corners;
        let mut limits = vec![DVec2::NAN; level.vertices()];
        // One half-edge of each vertex that has a face of its own here, not only padding.
        let mut spoke = vec![u32::MAX; level.vertices()];
        for f in (0..level.faces() as u32).filter(|&f| level.inside[f as usize]) {
            for h in level.of_face(f) {
                let v = level.origin[h as usize] as usize;
                if spoke[v] == u32::MAX {
                    spoke[v] = h;
                    limits[v] = match finest(self.refinement, level.level, slot_of(&self.map, level, h)) {
                        Some((l, g)) => limit_in(&self.refinement.levels[l], g, corners),
                        None => limit_in(level, h, corners),
                    };
                }
            }
        }
        let [x0, y0, x1, y1] = self.look.view;
        let shown = |v: usize| if self.look.control { level.value[v].p } else { limits[v] };
        let visible = |p: DVec2| p.x >= x0 && p.x <= x1 && p.y >= y0 && p.y <= y1;
        for v in 0..level.vertices() {
            if spoke[v] != u32::MAX && visible(shown(v)) {
                self.vertex(spoke[v], shown(v), limits[v]);
            }
        }
        let mut fans = (Fan::default(), Fan::default());
        for f in (0..level.faces() as u32).filter(|&f| level.inside[f as usize]) {
            for h in level.of_face(f) {
                let twin = level.across(h);
                if twin.is_some_and(|t| t < h && level.inside[level.face_of(t) as usize]) {
                    continue;
                }
                let (a, b) = (level.origin[h as usize] as usize, level.target(h) as usize);
                if !visible(shown(a)) && !visible(shown(b)) {
                    continue;
                }
                let slot = slot_of(&self.map, level, h);
                let input = level.level == 0 && along_input(self.mesh, slot);
                if self.look.stage == Stage::Input && !input {
                    continue;
                }
                let (pa, pb) = (shown(a), shown(b));
                let curve = if self.look.control {
                    [pa, pa.lerp(pb, 1.0 / 3.0), pa.lerp(pb, 2.0 / 3.0), pb]
                } else {
                    self.curve(level, h, corners, &mut fans, [pa, pb])
                };
                let sharp = twin.is_some() && level.colour_border(h);
                self.out.edges.push(Edge { curve, sharp, slot, input });
            }
        }
    }

    /// The limit of an edge. Finer edits bend it further; then the chord has to do.
    fn curve(
        &self,
        level: &Level,
        h: u32,
        corners: crate::scene::CornerRule,
        fans: &mut (Fan<DVec2>, Fan<DVec2>),
        [pa, pb]: [DVec2; 2],
    ) -> [DVec2; 4] {
        let chord = [pa, pa.lerp(pb, 1.0 / 3.0), pa.lerp(pb, 2.0 / 3.0), pb];
        if finest(self.refinement, level.level, slot_of(&self.map, level, h)).is_some() {
            return chord;
        }
        position_fan(level, h, &mut fans.0);
        let near = fans.0.spoke_of(h);
        let far = match level.across(h) {
            Some(t) => {
                position_fan(level, t, &mut fans.1);
                fans.1.spoke_of(t)
            }
            // Along the boundary the way back is the last spoke of the fan at the other end.
            None => {
                position_fan(level, level.next(h), &mut fans.1);
                fans.1.spoke.len() - 1
            }
        };
        [pa, edge_point(&fans.0, near, corners), edge_point(&fans.1, far, corners), pb]
    }

    /// The handles of one vertex.
    fn vertex(&mut self, h: u32, shown: DVec2, at: DVec2) {
        let level = self.made.last();
        let slot = least_slot(&self.map, level.level, slot_of(&self.map, level, h));
        let control = level.position(h);
        let mut push = |kind, slot, shown, colour| {
            let id = Id { kind, level: level.level, slot };
            self.out.handles.push(Handle { id, at, shown, control, colour });
        };
        let colour = level.corner_colour(h);
        let kind = match self.look.stage {
            Stage::Level(_) => Kind::Vertex,
            Stage::Input => match origin_of(self.mesh, slot) {
                Origin::Vertex(_) => Kind::Input,
                Origin::EdgePoint(_) => Kind::Gradient,
                Origin::FacePoint(_) => Kind::FacePoint,
            },
        };
        push(kind, slot, shown, colour);
        if !self.map.is_colour_vertex(level.level, slot) {
            return;
        }
        push(Kind::Colour, slot, shown, colour);
        // Where vertices lie close their sectors would cover each other; those that differ are shown all the same.
        let (mut nearest, mut differ) = (f64::INFINITY, false);
        level.around(h, |s| {
            nearest = nearest.min(level.position(level.next(s)).distance(control));
            differ |= level.corner_colour(s) != colour;
        });
        if nearest < 1.6 * SECTOR_OFFSET * self.look.pixel && !differ {
            return;
        }
        level.around(h, |s| {
            let (a, b) = (level.position(level.next(s)), level.position(level.prev(s)));
            let into = (a - control).normalize_or_zero() + (b - control).normalize_or_zero();
            let mut into = into.normalize_or_zero();
            // A reflex corner's bisector points out of it; a straight one has none.
            let mean = level.of_face(level.face_of(s)).map(|g| level.position(g)).sum::<DVec2>();
            let centre = mean / f64::from(level.valence(level.face_of(s))) - control;
            if into == DVec2::ZERO || into.dot(centre) < 0.0 {
                into = centre.normalize_or_zero();
            }
            let offset = into * SECTOR_OFFSET * self.look.pixel;
            push(Kind::Sector, slot_of(&self.map, level, s), shown + offset, level.corner_colour(s));
        });
    }
}

/// Whether an edge of M^0 is a third of an edge of the input mesh.
fn along_input(mesh: &HalfEdgeMesh, slot: Slot) -> bool {
    // Slots 0 and 3 of a corner quad and slot 0 of a middle quad.
    slot < 8 * u64::from(mesh.half_edges()) && matches!(slot & 7, 0 | 3 | 4)
}

/// The input half-edge that a slot of M^0 runs along, in either direction, if any.
pub fn input_edge(mesh: &HalfEdgeMesh, slot: Slot) -> Option<u32> {
    if !along_input(mesh, slot) {
        return None;
    }
    let h = (slot >> 3) as u32;
    Some(if slot & 7 == 3 { mesh.prev(h) } else { h })
}
