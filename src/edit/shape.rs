//! Modelling: changes of the input mesh's polygons. Edits and colours under faces that stay follow them to their new
//! numbers (ZHHK22 App. A: a half-edge's number on any level is its input half-edge's and a few digits).

use super::EditError;
use crate::mesh::{self, HalfEdgeMesh, NONE};
use crate::scene::{ColourEdit, Frame, GeometryEdit, Handle, InputMesh, Scene};
use crate::subdiv::index_map::IndexMap;
use glam::{DVec2, DVec4};

/// Polygons to be, with where they come from.
struct Draft {
    positions: Vec<DVec2>,
    /// For each vertex: the old vertices whose colours it has, in the mean.
    from: Vec<Vec<u32>>,
    /// Corners of each face.
    faces: Vec<Vec<u32>>,
}

impl Draft {
    fn of(scene: &Scene) -> Draft {
        let m = &scene.mesh;
        Draft {
            positions: m.positions.clone(),
            from: (0..m.positions.len() as u32).map(|v| vec![v]).collect(),
            faces: m.face_start.windows(2).map(|f| m.corners[f[0] as usize..f[1] as usize].to_vec()).collect(),
        }
    }

    fn add(&mut self, at: DVec2, from: Vec<u32>) -> u32 {
        self.positions.push(at);
        self.from.push(from);
        self.positions.len() as u32 - 1
    }
}

/// Puts a vertex in the middle of the edge between two vertices.
///
/// # Errors
/// They share no edge.
pub fn split_edge(scene: &mut Scene, a: u32, b: u32) -> Result<(), EditError> {
    let mut draft = Draft::of(scene);
    let middle = draft.positions[a as usize].midpoint(draft.positions[b as usize]);
    let new = draft.add(middle, vec![a, b]);
    let mut any = false;
    for face in &mut draft.faces {
        if let Some(i) = edge_in(face, a, b).or(edge_in(face, b, a)) {
            face.insert(i + 1, new);
            any = true;
        }
    }
    if !any {
        return Err(EditError::refused("these two vertices share no edge"));
    }
    rebuild(scene, draft)
}

/// Place of the first of two corners that follow each other.
fn edge_in(face: &[u32], a: u32, b: u32) -> Option<usize> {
    (0..face.len()).find(|&i| face[i] == a && face[(i + 1) % face.len()] == b)
}

/// Cuts a face from one corner to another.
///
/// # Errors
/// No face has both, or they are neighbours in it.
pub fn split_face(scene: &mut Scene, a: u32, b: u32) -> Result<(), EditError> {
    let mut draft = Draft::of(scene);
    let found = draft
        .faces
        .iter()
        .position(|f| f.contains(&a) && f.contains(&b) && edge_in(f, a, b).is_none() && edge_in(f, b, a).is_none());
    let Some(f) = found else {
        return Err(EditError::refused("no face has these two as corners that are not neighbours"));
    };
    let face = draft.faces[f].clone();
    let at = |v| face.iter().position(|&c| c == v).expect("found above");
    let walk = |from: usize, to: usize| -> Vec<u32> {
        let n = face.len();
        (0..=(to + n - from) % n).map(|i| face[(from + i) % n]).collect()
    };
    draft.faces[f] = walk(at(a), at(b));
    draft.faces.insert(f + 1, walk(at(b), at(a)));
    rebuild(scene, draft)
}

/// Adds a quad outside a boundary edge, as deep as the edge is long.
///
/// # Errors
/// The two vertices share no edge of the boundary.
pub fn extrude(scene: &mut Scene, a: u32, b: u32) -> Result<(), EditError> {
    let mut draft = Draft::of(scene);
    let runs = |x, y| draft.faces.iter().any(|f| edge_in(f, x, y).is_some());
    let (a, b) = match (runs(a, b), runs(b, a)) {
        (true, false) => (a, b),
        (false, true) => (b, a),
        _ => return Err(EditError::refused("these two vertices share no edge of the boundary")),
    };
    let (pa, pb) = (draft.positions[a as usize], draft.positions[b as usize]);
    // The face lies on one side of its edge; its corners' mean tells which.
    let face = draft.faces.iter().find(|f| edge_in(f, a, b).is_some()).expect("found above");
    let mean = face.iter().map(|&v| draft.positions[v as usize]).sum::<DVec2>() / face.len() as f64;
    let mut out = (pb - pa).perp();
    if out.dot(mean - pa) > 0.0 {
        out = -out;
    }
    let (na, nb) = (draft.add(pa + out, vec![a]), draft.add(pb + out, vec![b]));
    draft.faces.push(vec![b, a, na, nb]);
    rebuild(scene, draft)
}

/// Deletes vertices. One with two edges goes out of its faces; around any other the faces go.
///
/// # Errors
/// No face would be left, or no mesh.
pub fn delete(scene: &mut Scene, vertices: &[u32]) -> Result<(), EditError> {
    let mesh = mesh::build(&scene.mesh)?;
    let mut draft = Draft::of(scene);
    for &v in vertices {
        let mut edges = 0;
        for h in 0..mesh.half_edges() {
            edges += u32::from(mesh.origin[h as usize] == v);
            edges += u32::from(mesh.twin[h as usize] == NONE && mesh.target(h) == v);
        }
        if edges == 2 && draft.faces.iter().filter(|f| f.contains(&v)).all(|f| f.len() > 3) {
            draft.faces.iter_mut().for_each(|f| f.retain(|&c| c != v));
        } else {
            draft.faces.retain(|f| !f.contains(&v));
        }
    }
    rebuild(scene, draft)
}

/// Joins two vertices in the middle between them.
///
/// # Errors
/// The result is no mesh.
pub fn weld(scene: &mut Scene, a: u32, b: u32) -> Result<(), EditError> {
    let mut draft = Draft::of(scene);
    draft.positions[a as usize] = draft.positions[a as usize].midpoint(draft.positions[b as usize]);
    draft.from[a as usize].push(b);
    for face in &mut draft.faces {
        face.iter_mut().filter(|c| **c == b).for_each(|c| *c = a);
        face.dedup();
        if face.len() > 1 && face.first() == face.last() {
            face.pop();
        }
    }
    draft.faces.retain(|f| f.len() > 2);
    rebuild(scene, draft)
}

/// Adds a face between vertices that are there, in the order of their angle around their middle, the way round that its
/// neighbours ask for.
///
/// # Errors
/// Fewer than three, or no mesh either way round.
pub fn add_face(scene: &mut Scene, vertices: &[u32]) -> Result<(), EditError> {
    if vertices.len() < 3 {
        return Err(EditError::refused("a face needs at least three vertices"));
    }
    let at = |v: u32| scene.mesh.positions[v as usize];
    let mean = vertices.iter().map(|&v| at(v)).sum::<DVec2>() / vertices.len() as f64;
    let mut corners = vertices.to_vec();
    corners.sort_by(|&a, &b| (at(a) - mean).to_angle().total_cmp(&(at(b) - mean).to_angle()));
    let mut attempt = |corners: Vec<u32>| {
        let mut draft = Draft::of(scene);
        draft.faces.push(corners);
        rebuild(scene, draft)
    };
    let reversed = corners.iter().rev().copied().collect();
    attempt(corners).or_else(|_| attempt(reversed))
}

/// Adds a polygon of its own: a regular one with `n` corners (at least 3), or through given points.
///
/// # Errors
/// Fewer than three points.
pub fn add_polygon(scene: &mut Scene, points: &[DVec2]) -> Result<(), EditError> {
    if points.len() < 3 {
        return Err(EditError::refused("a polygon needs at least three points"));
    }
    let mut draft = Draft::of(scene);
    let corners: Vec<u32> = points.iter().map(|&p| draft.add(p, Vec::new())).collect();
    draft.faces.push(corners);
    rebuild(scene, draft)
}

/// Writes the draft into the scene.
fn rebuild(scene: &mut Scene, draft: Draft) -> Result<(), EditError> {
    let old = mesh::build(&scene.mesh)?;
    // Vertices that no face has any more go.
    let mut number = vec![NONE; draft.positions.len()];
    for &v in draft.faces.iter().flatten() {
        number[v as usize] = 0;
    }
    let mut input = InputMesh { face_start: vec![0], ..InputMesh::default() };
    let mut from = Vec::new();
    for (v, n) in number.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
        *n = input.positions.len() as u32;
        input.positions.push(draft.positions[v]);
        from.push(&draft.from[v]);
    }
    for face in &draft.faces {
        input.corners.extend(face.iter().map(|&v| number[v as usize]));
        input.face_start.push(input.corners.len() as u32);
    }
    let new = mesh::build(&input)?;
    let kept = kept_half_edges(&scene.mesh, &old, &draft);
    let follow = Follow { old: &old, new: &new, kept: &kept };
    let mut next = Scene { mesh: input, name: scene.name.clone(), corners: scene.corners, ..Scene::default() };
    next.reference.clone_from(&scene.reference);
    if !scene.corner_colours.is_empty() {
        next.corner_colours = follow.colours(&scene.corner_colours, &from);
    }
    // Tags and handles belong to edges: by their ends, in vertices that the draft still has as they were.
    let same = |v: u32| number.get(v as usize).copied().filter(|&n| n != NONE && draft.from[v as usize] == [v]);
    let by_ends = |a: u32, b: u32| {
        let (a, b) = (same(a)?, same(b)?);
        (0..new.half_edges()).find_map(|h| match (new.origin[h as usize], new.target(h)) {
            (o, t) if (o, t) == (a, b) => Some(h),
            (o, t) if (t, o) == (a, b) && new.twin[h as usize] == NONE => Some(new.twin_number(h)),
            _ => None,
        })
    };
    let ends = |h: u32| match h.checked_sub(old.half_edges()) {
        None => (old.origin[h as usize], old.target(h)),
        Some(rank) => {
            let t = old.boundary_twin(rank);
            (old.target(t), old.origin[t as usize])
        }
    };
    next.sharp = scene.sharp.iter().filter_map(|&h| by_ends(ends(h).0, ends(h).1)).collect();
    next.sharp.retain(|&h| h < new.half_edges());
    let moved = |h: &Handle| Some(Handle { half_edge: by_ends(ends(h.half_edge).0, ends(h.half_edge).1)?, ..*h });
    next.handles = scene.handles.iter().filter_map(moved).collect();
    next.face_points = scene
        .face_points
        .iter()
        .filter_map(|p| Some(Handle { half_edge: kept[p.half_edge as usize]?, ..*p }))
        .collect();
    next.geometry = scene.geometry.iter().filter_map(|e| follow.geometry(e)).collect();
    next.colours = scene.colours.iter().filter_map(|e| follow.colour(e)).collect();
    *scene = next;
    Ok(())
}

/// For each old half-edge its new number, where its face has the same corners as before.
fn kept_half_edges(input: &InputMesh, old: &HalfEdgeMesh, draft: &Draft) -> Vec<Option<u32>> {
    let mut kept = vec![None; old.half_edges() as usize];
    let mut first = 0;
    let mut search = 0;
    for face in &draft.faces {
        // Faces keep their order, so that the next old one is nearly always the one.
        let corners = |f: usize| &input.corners[input.face_start[f] as usize..input.face_start[f + 1] as usize];
        let faces = old.faces() as usize;
        let found = (0..faces).map(|i| (search + i) % faces).find(|&f| corners(f) == face.as_slice());
        if let Some(f) = found.filter(|_| face.iter().all(|&v| draft.from[v as usize] == [v])) {
            for (i, h) in (old.face_start[f]..old.face_start[f + 1]).enumerate() {
                kept[h as usize] = Some(first + i as u32);
            }
            search = f + 1;
        }
        first += face.len() as u32;
    }
    kept
}

/// From old numbers to new ones.
struct Follow<'a> {
    old: &'a HalfEdgeMesh,
    new: &'a HalfEdgeMesh,
    kept: &'a [Option<u32>],
}

impl Follow<'_> {
    /// Colours of all corners: as before in faces that stay, elsewhere the mean of the vertices that a corner came from.
    fn colours(&self, before: &[DVec4], from: &[&Vec<u32>]) -> Vec<DVec4> {
        let mut sums = vec![(DVec4::ZERO, 0.0); self.old.vertices() as usize];
        for (h, &colour) in before.iter().enumerate() {
            let sum = &mut sums[self.old.origin[h] as usize];
            *sum = (sum.0 + colour, sum.1 + 1.0);
        }
        let mean = |v: u32| {
            let (sum, n) = sums[v as usize];
            if n > 0.0 {
                sum / n
            } else {
                DVec4::ONE
            }
        };
        let mut colours: Vec<DVec4> = self
            .new
            .origin
            .iter()
            .map(|&v| match from[v as usize].as_slice() {
                [] => DVec4::new(0.75, 0.75, 0.78, 1.0),
                all => all.iter().map(|&v| mean(v)).sum::<DVec4>() / all.len() as f64,
            })
            .collect();
        for (h, kept) in self.kept.iter().enumerate() {
            if let Some(n) = kept {
                colours[*n as usize] = before[h];
            }
        }
        colours
    }

    /// New number of an interior half-edge of M^level.
    fn half_edge(&self, level: u32, id: u64) -> Option<u64> {
        let root = id >> (2 * level);
        let h = (*self.kept.get((root / 9) as usize)?)?;
        Some(((9 * u64::from(h) + root % 9) << (2 * level)) | (id & ((1 << (2 * level)) - 1)))
    }

    fn geometry(&self, e: &GeometryEdit) -> Option<GeometryEdit> {
        let (old, new) = (IndexMap::new(self.old), IndexMap::new(self.new));
        let interior = e.half_edge < old.half_edges(e.level);
        let inside = if interior { e.half_edge } else { old.boundary_twin_app_a(e.level, e.half_edge)? };
        let half_edge = self.half_edge(e.level, inside)?;
        let slot = new.from_app_a(e.level, half_edge)?;
        let beyond = !interior || e.frame == Frame::Boundary;
        // An edge that is no boundary any more has nothing beyond it.
        if beyond && new.twin(e.level, slot).is_some() {
            return None;
        }
        let moved = if beyond { new.next(e.level, slot) } else { slot };
        let half_edge = if interior { half_edge } else { new.boundary_app_a(e.level, slot) };
        Some(GeometryEdit { half_edge, vertex: e.vertex.map(|_| new.vertex(e.level, moved)), ..*e })
    }

    fn colour(&self, e: &ColourEdit) -> Option<ColourEdit> {
        Some(ColourEdit { half_edge: self.half_edge(e.level, e.half_edge)?, ..*e })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::{refine, Options};
    use crate::scene::shapes::builtin;

    fn strip() -> Scene {
        let mesh = builtin("strip:3").unwrap();
        let corner_colours = (0..mesh.corners.len()).map(|h| DVec4::splat(h as f64 / 12.0).with_w(1.0)).collect();
        let edit = |level, half_edge, frame| GeometryEdit { level, half_edge, vertex: None, a: 0.1, b: 0.02, frame };
        let mut scene = Scene { mesh, corner_colours, ..Scene::default() };
        let m = mesh::build(&scene.mesh).unwrap();
        let map = IndexMap::new(&m);
        // One edit in each face, on levels 0 to 2, and one beyond the boundary of the last.
        for f in 0..3u64 {
            scene.geometry.push(edit(f as u32, map.to_app_a(f as u32, (8 * 4 * f + 4) << (2 * f)), Frame::Sector));
            scene.colours.push(ColourEdit { level: 1, half_edge: map.to_app_a(1, 4 * 8 * 4 * f), colour: DVec4::ONE });
        }
        let boundary = (8..12u32).find(|&h| m.twin[h as usize] == NONE).unwrap();
        scene.geometry.push(edit(1, map.to_app_a(1, 4 * 8 * u64::from(boundary)), Frame::Boundary));
        scene.sharp = vec![(0..12u32).find(|&h| m.twin[h as usize] != NONE).unwrap()];
        scene.handles = vec![Handle { half_edge: 9, at: DVec2::new(0.9, 0.1) }];
        check(&scene);
        scene
    }

    fn check(scene: &Scene) {
        let mesh = mesh::build(&scene.mesh).unwrap();
        refine(scene, &mesh, Options::default()).unwrap();
    }

    #[test]
    fn edits_follow_the_faces_that_stay() {
        let before = strip();
        let mut scene = before.clone();
        // The first face goes: everything else keeps its meaning under new numbers.
        let corners = [0u32, 4];
        delete(&mut scene, &corners).unwrap();
        check(&scene);
        assert_eq!(scene.mesh.face_start.len(), 3);
        assert_eq!((scene.geometry.len(), scene.colours.len(), scene.handles.len()), (3, 2, 1));
        let surface = |scene: &Scene| {
            let mesh = mesh::build(&scene.mesh).unwrap();
            let all =
                refine(scene, &mesh, Options { mode: crate::refine::Mode::Global(2), ..Options::default() }).unwrap();
            let level = all.levels[2].clone();
            let count = level.half_edges();
            // The last input face's last corner quad, far from the face that went.
            (count - 4..count).map(|h| level.at(h as u32)).collect::<Vec<_>>()
        };
        assert_eq!(surface(&before), surface(&scene));
    }

    #[test]
    fn splitting_and_deleting_come_back() {
        let before = strip();
        let mut scene = before.clone();
        split_edge(&mut scene, 0, 1).unwrap();
        check(&scene);
        assert_eq!(scene.mesh.positions.len(), before.mesh.positions.len() + 1);
        delete(&mut scene, &[before.mesh.positions.len() as u32]).unwrap();
        assert_eq!(scene.mesh.corners, before.mesh.corners);
        assert_eq!(scene.mesh.positions, before.mesh.positions);
        split_face(&mut scene, 0, 5).unwrap();
        check(&scene);
        assert_eq!(scene.mesh.face_start.len(), 5);
        assert!(split_face(&mut scene, 0, 7).is_err());
    }

    #[test]
    fn extruded_faces_lie_outside_and_welding_needs_a_mesh() {
        for name in ["quad", "fan:5"] {
            let mut scene = Scene { mesh: builtin(name).unwrap(), ..Scene::default() };
            let m = mesh::build(&scene.mesh).unwrap();
            let h = (0..m.half_edges()).find(|&h| m.twin[h as usize] == NONE).unwrap();
            extrude(&mut scene, m.origin[h as usize], m.target(h)).unwrap();
            check(&scene);
            let notes = mesh::shape_notes(&mesh::build(&scene.mesh).unwrap());
            assert!(notes.is_empty(), "{name}: {notes:?}");
        }
        let mut scene = Scene { mesh: builtin("strip:4").unwrap(), ..Scene::default() };
        // Two ends in one point part the faces around it into two fans: no mesh.
        let before = scene.clone();
        assert!(weld(&mut scene, 0, 4).is_err());
        assert_eq!(scene, before);
        // An edge shrinks to a point, and its quad to a triangle.
        weld(&mut scene, 0, 1).unwrap();
        assert_eq!(scene.mesh.face_start[1], 3);
        check(&scene);
    }

    #[test]
    fn faces_are_added_the_right_way_round() {
        let mut scene = Scene { mesh: builtin("ring:6").unwrap(), ..Scene::default() };
        add_face(&mut scene, &[3, 1, 0, 5, 4, 2]).unwrap();
        check(&scene);
        let m = mesh::build(&scene.mesh).unwrap();
        assert_eq!(m.boundary_edges(), 6);
        assert!(add_face(&mut scene, &[0, 1]).is_err() && add_face(&mut scene, &[0, 1, 2]).is_err());
        add_polygon(&mut scene, &[DVec2::new(3.0, 0.0), DVec2::new(4.0, 0.0), DVec2::new(3.5, 1.0)]).unwrap();
        check(&scene);
        assert!(delete(&mut Scene { mesh: builtin("triangle").unwrap(), ..Scene::default() }, &[0]).is_err());
    }
}
