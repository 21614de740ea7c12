//! Region of influence: what an edit of a handle would change (ZHHK22 4.2, 5.1, Fig. 10).

use super::handle::{Id, Kind};
use super::overlay::slot_of;
use super::place::limit_in;
use super::EditError;
use crate::mesh::HalfEdgeMesh;
use crate::refine::region::region;
use crate::scene::{CornerRule, Scene};
use crate::subdiv::fan::{position_fan, Fan};
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::Level;
use crate::subdiv::limit::edge_point;
use glam::DVec2;
use std::collections::{BTreeSet, HashSet};

/// Faces of M^l that a change of some handles changes, and the curves around them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Influence {
    /// Names: number in M^0 at level 0, else the slot one level up.
    pub faces: BTreeSet<u64>,
    /// Bezier points of the boundary's edges over the surface.
    pub outline: Vec<[DVec2; 4]>,
}

/// What moving the geometry handles among `ids` (all of one level) would change, and what painting the colour handles.
///
/// A control point reaches the faces of its 2-ring. A colour goes to its vertex and the one-ring, which reach the
/// 3-ring, and across no sharp edge. Points of the input mesh move every point that the ternary step makes of them.
///
/// # Errors
/// As [`region`].
pub fn influence(scene: &Scene, mesh: &HalfEdgeMesh, ids: &[Id]) -> Result<[Influence; 2], EditError> {
    let mut both = [Influence::default(), Influence::default()];
    let Some(first) = ids.first() else {
        return Ok(both);
    };
    let level = first.level;
    let map = IndexMap::new(mesh);
    // Faces above the region: three rings around the vertex lie in the parents of three rings.
    let mut above: Vec<HashSet<u64>> = vec![HashSet::new(); level as usize];
    for id in ids {
        for l in 0..level {
            let slot = id.slot >> (2 * (level - l));
            around_faces(&map, l, slot, 2, &mut above[l as usize]);
        }
    }
    let slots: Vec<Slot> = ids.iter().map(|id| id.slot).collect();
    let made = region(scene, mesh, level, &slots, |l, f| above[l.level as usize].contains(&l.face[f as usize]))?;
    let last = made.last();
    for (id, h) in ids.iter().zip(&made.followed) {
        let Some(h) = *h else { continue };
        let out = &mut both[usize::from(!id.kind.is_geometry())];
        let mut faces = HashSet::new();
        match id.kind {
            Kind::Vertex | Kind::Gradient | Kind::FacePoint => rings(last, &[h], 2, &mut faces),
            Kind::Input => {
                // Every edge and face point in the faces around it reads the vertex.
                let mut seeds = Vec::new();
                last.around(h, |s| {
                    let input = mesh.face[(slot_of(&map, last, s) >> 3) as usize];
                    for g in mesh.face_start[input as usize]..mesh.face_start[input as usize + 1] {
                        seeds.extend([8 * g + 1, 8 * g + 2, 8 * g + 5, 8 * g + 6]);
                    }
                });
                rings(last, &seeds, 2, &mut faces);
            }
            Kind::Colour => last.around(h, |s| colour_faces(last, s, &mut faces)),
            Kind::Sector => {
                colour_faces(last, h, &mut faces);
                // The first edit of a vertex spreads the colours of its other sectors, too (VK18 4.2).
                if !painted_before(scene, &map, *id) {
                    last.around(h, |s| colour_faces(last, s, &mut faces));
                }
                // Colours that differ make both spokes sharp, three edges on.
                along(last, h, &mut faces);
                if let Some(s) = last.spoke_after(h) {
                    along(last, s, &mut faces);
                }
            }
        }
        out.faces.extend(faces.iter().map(|&f| last.face[f as usize]));
    }
    for out in &mut both {
        out.outline = outline(last, &out.faces, scene.corners);
    }
    Ok(both)
}

/// Names of the faces within `n` rings of the vertex of a slot.
fn around_faces(map: &IndexMap, level: u32, slot: Slot, n: u32, out: &mut HashSet<u64>) {
    let mut spokes = Vec::new();
    map.around(level, slot, |s| spokes.push(s));
    for s in spokes {
        if n == 1 {
            out.insert(map.face(level, s));
            continue;
        }
        let mut g = s;
        loop {
            around_faces(map, level, g, n - 1, out);
            g = map.next(level, g);
            if g == s {
                break;
            }
        }
    }
}

/// Faces within `n` rings of the origins of `seeds`.
fn rings(level: &Level, seeds: &[u32], n: u32, faces: &mut HashSet<u32>) {
    let mut seeds: Vec<u32> = seeds.to_vec();
    for ring in 0..n {
        let mut next = Vec::new();
        for &h in &seeds {
            level.around(h, |s| {
                let f = level.face_of(s);
                faces.insert(f);
                if ring + 1 < n {
                    next.extend(level.of_face(f));
                }
            });
        }
        next.sort_unstable_by_key(|&h| level.origin[h as usize]);
        next.dedup_by_key(|h| level.origin[*h as usize]);
        seeds = next;
    }
}

/// Faces that the colour of the sector of `h` reaches: two rings around the corners of its quad, as far as no border
/// of colours parts them from it.
fn colour_faces(level: &Level, h: u32, faces: &mut HashSet<u32>) {
    // From face to face across edges that let colours through, in a window of three rings around the vertex.
    let mut window = HashSet::new();
    let corners: Vec<u32> = level.of_face(level.face_of(h)).collect();
    rings(level, &corners, 2, &mut window);
    let mut queue = vec![level.face_of(h)];
    faces.insert(queue[0]);
    let mut seen: HashSet<u32> = queue.iter().copied().collect();
    while let Some(f) = queue.pop() {
        for g in level.of_face(f) {
            if level.colour_border(g) {
                continue;
            }
            if let Some(t) = level.across(g) {
                let n = level.face_of(t);
                if window.contains(&n) && seen.insert(n) {
                    faces.insert(n);
                    queue.push(n);
                }
            }
        }
    }
}

/// Faces that touch the three edges straight on from `h`.
fn along(level: &Level, h: u32, faces: &mut HashSet<u32>) {
    let mut e = h;
    rings(level, &[e], 1, faces);
    for _ in 0..3 {
        let end = level.next(e);
        rings(level, &[end], 1, faces);
        match level.across(end) {
            Some(t) => e = level.next(t),
            None => return,
        }
    }
}

/// Whether the one-ring of a colour vertex has one colour a sector already.
fn painted_before(scene: &Scene, map: &IndexMap, id: Id) -> bool {
    let born = map.birth(id.level, id.slot);
    (born.0 == 0 && map.is_colour_vertex(0, born.1))
        || scene.colours.iter().any(|e| {
            e.level <= id.level && map.from_app_a(e.level, e.half_edge).is_some_and(|d| map.birth(e.level, d) == born)
        })
}

fn outline(level: &Level, faces: &BTreeSet<u64>, corners: CornerRule) -> Vec<[DVec2; 4]> {
    let inside = |f: u32| faces.contains(&level.face[f as usize]);
    let mut curves = Vec::new();
    let (mut near, mut far) = (Fan::default(), Fan::default());
    for f in (0..level.faces() as u32).filter(|&f| inside(f)) {
        for h in level.of_face(f) {
            let twin = level.across(h);
            if twin.is_some_and(|t| inside(level.face_of(t))) {
                continue;
            }
            position_fan(level, h, &mut near);
            let at = near.spoke_of(h);
            position_fan(level, level.next(h), &mut far);
            let back = match twin {
                Some(t) => far.spoke_of(t),
                None => far.spoke.len() - 1,
            };
            curves.push([
                limit_in(level, h, corners),
                edge_point(&near, at, corners),
                edge_point(&far, back, corners),
                limit_in(level, level.next(h), corners),
            ]);
        }
    }
    curves
}
