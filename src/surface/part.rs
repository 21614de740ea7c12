//! Some faces of a level as a level of its own, so that a step costs what it refines.
//!
//! Where other faces were, the part has edges without a twin that are not sharp. What is near them comes out wrong in a
//! step; a ring of faces around those that matter keeps that away.

use super::level::{Level, Scheme};
use super::refine::{child_face, refine_some};
use crate::mesh::NONE;
use std::borrow::Cow;

/// A part of a level.
#[derive(Clone, Debug)]
pub struct Narrowed<'a> {
    /// The part.
    pub level: Cow<'a, Level>,
    /// The whole level's half-edge of each of the part's.
    pub half_edge: Vec<u32>,
    /// The whole level's vertex of each of the part's.
    pub vertex: Vec<u32>,
    /// The part's half-edge of each of the whole level's, or [`NONE`].
    pub inside: Vec<u32>,
}

/// The faces of `level` of which `keep` holds, in their order.
pub fn narrow<'a>(level: &'a Level, keep: &[bool]) -> Narrowed<'a> {
    if keep.iter().all(|&k| k) {
        let all = |n: usize| (0..n as u32).collect::<Vec<u32>>();
        return Narrowed {
            level: Cow::Borrowed(level),
            half_edge: all(level.half_edges()),
            vertex: all(level.vertices()),
            inside: all(level.half_edges()),
        };
    }
    let mut part = Level { scheme: level.scheme, depth: level.depth, sides: level.sides, ..Level::default() };
    let (mut half_edge, mut inside) = (Vec::new(), vec![NONE; level.half_edges()]);
    if level.sides == 0 {
        part.face_start.push(0);
    }
    for f in (0..level.faces()).filter(|&f| keep[f]) {
        for h in level.of_face(f) {
            inside[h as usize] = half_edge.len() as u32;
            half_edge.push(h);
            if level.sides == 0 {
                part.face.push(part.face_start.len() as u32 - 1);
            }
        }
        if level.sides == 0 {
            part.face_start.push(half_edge.len() as u32);
        }
    }
    let (mut vertex, mut edge) = (Vec::new(), Vec::new());
    let (mut new_vertex, mut new_edge) = (vec![NONE; level.vertices()], vec![NONE; level.edges()]);
    let number = |new: &mut Vec<u32>, old: &mut Vec<u32>, i: u32| {
        if new[i as usize] == NONE {
            new[i as usize] = old.len() as u32;
            old.push(i);
        }
        new[i as usize]
    };
    for &h in &half_edge {
        part.origin.push(number(&mut new_vertex, &mut vertex, level.origin[h as usize]));
        part.edge.push(number(&mut new_edge, &mut edge, level.edge[h as usize]));
        let t = level.twin[h as usize];
        part.twin.push(if t == NONE { NONE } else { inside[t as usize] });
    }
    part.position = vertex.iter().map(|&v| level.position[v as usize]).collect();
    part.sharpness = edge.iter().map(|&e| level.sharpness[e as usize]).collect();
    part.border = edge.iter().map(|&e| level.border[e as usize]).collect();
    if !level.corner.is_empty() {
        part.corner = vertex.iter().map(|&v| level.corner_sharpness(v)).collect();
    }
    part.make_spokes();
    part.count();
    Narrowed { level: Cow::Owned(part), half_edge, vertex, inside }
}

/// `faces` and all that share a vertex with them.
pub fn around(level: &Level, faces: &[bool]) -> Vec<bool> {
    touching(level, &vertices_of(level, faces))
}

/// Faces with a vertex of which `vertices` holds.
pub fn touching(level: &Level, vertices: &[bool]) -> Vec<bool> {
    let any = |f: usize| level.of_face(f).any(|h| vertices[level.origin[h as usize] as usize]);
    (0..level.faces()).map(any).collect()
}

/// Vertices of `faces`.
pub fn vertices_of(level: &Level, faces: &[bool]) -> Vec<bool> {
    let mut vertices = vec![false; level.vertices()];
    for f in (0..level.faces()).filter(|&f| faces[f]) {
        for h in level.of_face(f) {
            vertices[level.origin[h as usize] as usize] = true;
        }
    }
    vertices
}

/// A step of some faces of a level.
pub struct Step<'a> {
    /// The part that was refined: the faces and those around them.
    pub from: Narrowed<'a>,
    /// The next level, of the part.
    pub next: Level,
    /// Faces of `next` that are children of the faces asked for; the others are padding.
    pub owned: Vec<bool>,
    /// Vertices of `next` that are right: those of owned faces and of all that touch them.
    pub wanted: Vec<bool>,
}

impl Step<'_> {
    /// Face of `next` at the corner of the whole level's half-edge `h`, which is one of the part's.
    pub fn child(&self, h: u32) -> u32 {
        child_face(&self.from.level, self.from.inside[h as usize])
    }
}

/// Refines `faces` of `level`, whose ring has to be there.
pub fn step<'a>(level: &'a Level, faces: &[bool]) -> Step<'a> {
    let from = narrow(level, &around(level, faces));
    let owned: Vec<bool> = match level.scheme {
        Scheme::CatmullClark => from.half_edge.iter().map(|&h| faces[level.face_of(h)]).collect(),
        Scheme::Loop => from.half_edge.chunks(3).flat_map(|h| [faces[level.face_of(h[0])]; 4]).collect(),
    };
    let (next, wanted) = refine_some(&from.level, |next| vertices_of(next, &around(next, &owned)));
    Step { from, next, owned, wanted }
}
