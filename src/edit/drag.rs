//! Limit editing (ZHHK22 5.2, App. B): what is dragged is a point of the surface, and the control point that puts it
//! there is solved for.
//!
//! (B.2) gives it at once where no finer edit moves the same point. Otherwise, and for the points of the input mesh,
//! which the ternary step spreads over several control points, the limit is still an affine function of the control
//! point unless an edit beyond the boundary (eq. 2) depends on it; Newton's method with measured derivatives then ends
//! after one step, and after a few in the one curved case.

use super::handle::{edge_points_of, input_spokes, least_slot, origin_of, Id, Kind, Origin};
use super::place::exact_limit;
use super::EditError;
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::refine::region::region;
use crate::scene::{Frame, GeometryEdit, Handle, Scene};
use crate::subdiv::edit::sector_coordinates;
use crate::subdiv::fan::{position_fan, Fan};
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::Level;
use crate::subdiv::limit::control_for_limit;
use glam::{DMat2, DVec2};

/// Most Newton steps; the curved case takes three or four.
const STEPS: usize = 16;

/// A handle held by the pointer.
pub struct Drag {
    id: Id,
    /// Size of the input mesh: what tolerances are relative to.
    size: f64,
    frame: Option<VertexFrame>,
    start: DVec2,
    /// Where the control point was when the handle was taken.
    control: DVec2,
}

/// The neighbourhood of a control vertex of M^l.
struct VertexFrame {
    /// The level before its own edits, which is what their local frames are made of.
    plain: Level,
    half_edge: u32,
    /// The neighbours after those edits.
    fan: Fan<DVec2>,
    valence: Vec<u32>,
}

impl Drag {
    /// Takes hold of a handle.
    ///
    /// # Errors
    /// The scene cannot be refined, or the handle is none that moves.
    pub fn begin(scene: &Scene, mesh: &HalfEdgeMesh, id: Id) -> Result<Drag, EditError> {
        if !id.kind.is_geometry() {
            return Err(EditError::refused("a colour handle is painted, not moved"));
        }
        let start = exact_limit(scene, mesh, id.level, id.slot)?;
        let mut drag = Drag { id, size: size_of(scene), frame: None, start, control: DVec2::ZERO };
        if id.kind == Kind::Vertex {
            let map = IndexMap::new(mesh);
            let faces = faces_above(&map, id.level, id.slot);
            let made = region(scene, mesh, id.level, &[id.slot], |l, f| {
                faces[l.level as usize].contains(&l.face[f as usize])
            })?;
            let half_edge = made.followed[0].expect("the faces around the vertex are refined");
            let mut fan = Fan::default();
            position_fan(made.last(), half_edge, &mut fan);
            let valence = fan.half_edge.iter().map(|&g| made.last().valence(made.last().face_of(g))).collect();
            drag.control = fan.centre;
            drag.frame = Some(VertexFrame { plain: made.plain, half_edge, fan, valence });
        } else {
            drag.control = input_point(scene, mesh, id)?;
        }
        Ok(drag)
    }

    /// The handle.
    pub fn id(&self) -> Id {
        self.id
    }

    /// Where the limit point was when the handle was taken.
    pub fn start(&self) -> DVec2 {
        self.start
    }

    /// Makes `scene` the one in which the limit point is `target`, and returns the distance that is left, which only
    /// rounding makes.
    ///
    /// # Errors
    /// The point cannot be brought there, or the scene cannot be refined; the scene is then as it was.
    pub fn to(&self, scene: &mut Scene, mesh: &HalfEdgeMesh, target: DVec2) -> Result<f64, EditError> {
        let mut moved = mesh.clone();
        self.to_by(scene, mesh, target, |scene| {
            if self.id.kind == Kind::Input {
                moved.positions.clone_from(&scene.mesh.positions);
            }
            Ok(exact_limit(scene, &moved, self.id.level, self.id.slot)?)
        })
    }

    /// As [`Drag::to`], where the limit point of a scene is measured in another way.
    ///
    /// # Errors
    /// As [`Drag::to`], and those of `limit`.
    pub fn to_by(
        &self,
        scene: &mut Scene,
        mesh: &HalfEdgeMesh,
        target: DVec2,
        limit: impl FnMut(&Scene) -> Result<DVec2, EditError>,
    ) -> Result<f64, EditError> {
        let mut next = scene.clone();
        let left = self.solve(&mut next, mesh, target, limit)?;
        *scene = next;
        Ok(left)
    }

    fn solve(
        &self,
        scene: &mut Scene,
        mesh: &HalfEdgeMesh,
        target: DVec2,
        mut limit: impl FnMut(&Scene) -> Result<DVec2, EditError>,
    ) -> Result<f64, EditError> {
        let most = 1e6 * self.size;
        if !(target - self.start).is_finite() || (target - self.start).length() > most {
            return Err(EditError::refused("that is too far away"));
        }
        let enough = 1e-14 * self.size.max(target.length());
        // (B.2): the neighbours stay.
        let mut x = match &self.frame {
            Some(f) => control_for_limit(&f.fan, &f.valence, target, scene.corners),
            None => self.control + (target - self.start),
        };
        let map = IndexMap::new(mesh);
        let mut measure = |x: DVec2| -> Result<DVec2, EditError> {
            self.put(scene, mesh, &map, x);
            limit(scene)
        };
        let mut best = (f64::INFINITY, x);
        for step in 0..STEPS {
            let here = measure(x)?;
            let off = target - here;
            let better = off.length() < best.0;
            if better {
                best = (off.length(), x);
            }
            // Where only rounding is left, another step may not help.
            if off.length() <= enough || (step > 1 && !better && best.0 < 1e-11 * self.size) {
                break;
            }
            let probe = (0.01 * self.size).max(1e-3 * off.length());
            let du = (measure(x + DVec2::X * probe)? - here) / probe;
            let dv = (measure(x + DVec2::Y * probe)? - here) / probe;
            let slope = DMat2::from_cols(du, dv);
            let area = slope.determinant().abs();
            if area.is_nan() || area <= 1e-12 {
                return Err(EditError::refused("this point does not follow its control point"));
            }
            x += slope.inverse() * off;
        }
        let (left, x) = best;
        self.put(scene, mesh, &map, x);
        if left > 1e-6 * self.size {
            return Err(EditError::refused("the point cannot be brought there"));
        }
        Ok(left)
    }

    /// Moves the control point by `step` from where it was at the beginning: how several handles move together.
    pub fn shift(&self, scene: &mut Scene, mesh: &HalfEdgeMesh, step: DVec2) {
        self.put(scene, mesh, &IndexMap::new(mesh), self.control + step);
    }

    fn put(&self, scene: &mut Scene, mesh: &HalfEdgeMesh, map: &IndexMap, x: DVec2) {
        match &self.frame {
            Some(f) => {
                let step = x - f.plain.position(f.half_edge);
                set_edit(scene, map, self.id, encode(&f.plain, f.half_edge, self.id, map, step));
            }
            None => put_input(scene, mesh, self.id, x),
        }
    }
}

/// Longer side of the input mesh's bounding box.
pub fn size_of(scene: &Scene) -> f64 {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for &p in &scene.mesh.positions {
        (low, high) = (low.min(p), high.max(p));
    }
    let size = (high - low).max_element();
    if size > 0.0 && size.is_finite() {
        size
    } else {
        1.0
    }
}

/// For each level below `level`: names of the faces above those around the vertex of `slot`.
pub(super) fn faces_above(map: &IndexMap, level: u32, slot: Slot) -> Vec<Vec<u64>> {
    let mut names = vec![Vec::new(); level as usize];
    map.around(level, slot, |d| {
        for l in 0..level {
            names[l as usize].push(map.face(l, d >> (2 * (level - l))));
        }
    });
    names
}

/// Writes a step of the origin of `half_edge` as an edit, in the sector that it points into (ZHHK22 3.3), and beyond
/// the boundary by angle and length; `None` for no step. In a flat neighbourhood the widest frame has to do.
fn encode(plain: &Level, half_edge: u32, id: Id, map: &IndexMap, step: DVec2) -> Option<GeometryEdit> {
    if step == DVec2::ZERO {
        return None;
    }
    let vertex = Some(map.vertex(id.level, id.slot));
    // Slots and local half-edges around the vertex, side by side.
    let mut slots = Vec::new();
    map.around(id.level, id.slot, |s| slots.push(s));
    let mut local = Vec::new();
    plain.around(half_edge, |h| local.push(h));
    let mut best: Option<(f64, GeometryEdit)> = None;
    let mut outside = true;
    for (&slot, &h) in slots.iter().zip(&local) {
        let Some((a, b)) = sector_coordinates(plain, h, step) else { continue };
        if !(a.is_finite() && b.is_finite()) {
            continue;
        }
        outside &= a < 0.0 || b < 0.0;
        let at = |g: u32| plain.position(g);
        let e1 = (at(plain.next(h)) - at(h)).length();
        let e2 = (at(plain.prev(h)) - at(h)).length();
        // The way along the two edges: shortest in the sector that the step points into, and along a straight line
        // of edges as short in the one beside it.
        let beside = if a < 0.0 || b < 0.0 { 1.01 } else { 1.0 };
        let way = (a.abs() * e1 + b.abs() * e2) * beside;
        if best.is_none_or(|(least, _)| way < least) {
            let half_edge = map.to_app_a(id.level, slot);
            best = Some((way, GeometryEdit { level: id.level, half_edge, vertex, a, b, frame: Frame::Sector }));
        }
    }
    let beyond = if outside || best.is_none() { encode_beyond(plain, half_edge, id, map, step) } else { None };
    beyond.or(best.map(|(_, edit)| edit))
}

/// Angle and length (eq. 2), when the vertex is on the boundary and the step lies within the outer angle.
fn encode_beyond(plain: &Level, half_edge: u32, id: Id, map: &IndexMap, step: DVec2) -> Option<GeometryEdit> {
    // The interior half-edge that ends in the vertex and has no twin: before the first spoke, walking forward.
    let mut last = (half_edge, id.slot);
    let mut turns = 0;
    while let Some(h) = plain.spoke_after(last.0) {
        last = (h, map.spoke_after(id.level, last.1)?);
        turns += 1;
        if h == half_edge || turns > 4096 {
            return None;
        }
    }
    if plain.twin[plain.prev(last.0) as usize] != NONE {
        return None;
    }
    let (incoming, slot) = (plain.prev(last.0), map.prev(id.level, last.1));
    let first = plain.fan_start(half_edge, |_| false);
    let v = plain.position(half_edge);
    let (e1, e2) = (plain.position(incoming) - v, plain.position(plain.next(first)) - v);
    let full = |x: f64| if x < 0.0 { x + std::f64::consts::TAU } else { x };
    let angle = full(e2.to_angle() - e1.to_angle());
    let turn = full(step.to_angle() - e1.to_angle());
    let (a, b) = (turn / angle, step.length_squared() / (e1.length() * e2.length()));
    ((0.0..=1.0).contains(&a) && b.is_finite()).then(|| GeometryEdit {
        level: id.level,
        half_edge: map.to_app_a(id.level, slot),
        vertex: Some(map.vertex(id.level, id.slot)),
        a,
        b,
        frame: Frame::Boundary,
    })
}

/// Index of the geometry edit of a vertex in the scene.
pub fn edit_of(scene: &Scene, map: &IndexMap, level: u32, slot: Slot) -> Option<usize> {
    let wanted = least_slot(map, level, slot);
    scene.geometry.iter().position(|e| {
        e.level == level && moved_slot(map, e).is_some_and(|s| s == wanted || least_slot(map, level, s) == wanted)
    })
}

/// A slot that leaves the vertex that an edit moves.
fn moved_slot(map: &IndexMap, e: &GeometryEdit) -> Option<Slot> {
    match (map.from_app_a(e.level, e.half_edge), e.frame) {
        (Some(d), Frame::Sector) => Some(d),
        (Some(d), Frame::Boundary) => Some(map.next(e.level, d)),
        (None, _) => {
            let twin = map.boundary_twin_app_a(e.level, e.half_edge)?;
            map.from_app_a(e.level, twin).map(|d| map.next(e.level, d))
        }
    }
}

/// Replaces, adds or removes the edit of the vertex of `id`.
fn set_edit(scene: &mut Scene, map: &IndexMap, id: Id, edit: Option<GeometryEdit>) {
    match (edit_of(scene, map, id.level, id.slot), edit) {
        (Some(i), Some(edit)) => scene.geometry[i] = edit,
        (Some(i), None) => {
            scene.geometry.remove(i);
        }
        (None, Some(edit)) => scene.geometry.push(edit),
        (None, None) => {}
    }
}

/// Takes a vertex's own edit away, so that it lies where the coarser levels put it. `false`: it had none.
pub fn reset(scene: &mut Scene, mesh: &HalfEdgeMesh, id: Id) -> bool {
    let map = IndexMap::new(mesh);
    let before = (scene.geometry.len(), scene.handles.len(), scene.face_points.len());
    match (id.kind, origin_of_id(mesh, id)) {
        (Kind::Vertex, _) => set_edit(scene, &map, id, None),
        (Kind::Gradient, Some(Origin::EdgePoint(h))) => scene.handles.retain(|x| x.half_edge != h),
        (Kind::FacePoint, Some(Origin::FacePoint(h))) => scene.face_points.retain(|x| x.half_edge != h),
        _ => {}
    }
    before != (scene.geometry.len(), scene.handles.len(), scene.face_points.len())
}

fn origin_of_id(mesh: &HalfEdgeMesh, id: Id) -> Option<Origin> {
    (id.level == 0).then(|| origin_of(mesh, id.slot))
}

/// Where the point of the input stage lies.
fn input_point(scene: &Scene, mesh: &HalfEdgeMesh, id: Id) -> Result<DVec2, EditError> {
    let wrong = || EditError::refused("this handle does not belong to the input mesh");
    let origin = origin_of_id(mesh, id).ok_or_else(wrong)?;
    match (id.kind, origin) {
        (Kind::Input, Origin::Vertex(v)) => Ok(scene.mesh.positions[v as usize]),
        (Kind::Gradient, Origin::EdgePoint(_)) | (Kind::FacePoint, Origin::FacePoint(_)) => {
            // With the handles of the file, but before any edit.
            let plain = crate::subdiv::ternary::ternary(mesh, scene.corners, &scene.handles, &scene.face_points);
            Ok(plain.position(id.slot as u32))
        }
        _ => Err(wrong()),
    }
}

fn put_input(scene: &mut Scene, mesh: &HalfEdgeMesh, id: Id, x: DVec2) {
    fn set(list: &mut Vec<Handle>, half_edge: u32, at: DVec2) {
        match list.iter_mut().find(|handle| handle.half_edge == half_edge) {
            Some(handle) => handle.at = at,
            None => list.push(Handle { half_edge, at }),
        }
    }
    match origin_of(mesh, id.slot) {
        Origin::Vertex(v) => {
            let step = x - scene.mesh.positions[v as usize];
            scene.mesh.positions[v as usize] = x;
            let (edges, faces) = (edge_points_of(mesh, v), input_spokes(mesh, v));
            scene.handles.iter_mut().filter(|h| edges.contains(&h.half_edge)).for_each(|h| h.at += step);
            scene.face_points.iter_mut().filter(|h| faces.contains(&h.half_edge)).for_each(|h| h.at += step);
        }
        Origin::EdgePoint(h) => set(&mut scene.handles, h, x),
        Origin::FacePoint(h) => set(&mut scene.face_points, h, x),
    }
}
