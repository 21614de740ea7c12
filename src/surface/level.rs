//! One level of a uniformly subdivided surface: half-edges in plain arrays.

use super::SurfaceError;
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::scene::surface::{SurfaceScene, INFINITE};
use crate::scene::CornerRule;
use glam::DVec3;
use std::collections::HashMap;

/// Which subdivision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// Catmull-Clark: any polygons, quads from level 1 on.
    #[default]
    CatmullClark,
    /// Loop: triangles, with Loop's own vertex weights.
    Loop,
}

/// A level. Half-edge `h` leaves `origin[h]`; fans go counter-clockwise, that is, in the sense of the faces.
#[derive(Clone, Debug, Default)]
pub struct Level {
    /// The scheme that made it and goes on.
    pub scheme: Scheme,
    /// Steps from the control mesh.
    pub depth: u32,
    /// One a vertex.
    pub position: Vec<DVec3>,
    /// Vertex that each half-edge leaves.
    pub origin: Vec<u32>,
    /// Opposite half-edge, or [`NONE`] on the boundary.
    pub twin: Vec<u32>,
    /// Edge of each half-edge.
    pub edge: Vec<u32>,
    /// Corners of every face, where all have as many; else 0.
    pub sides: u32,
    /// Face `f` has half-edges `face_start[f]..face_start[f + 1]`; empty unless `sides` is 0.
    pub face_start: Vec<u32>,
    /// Face of each half-edge; empty unless `sides` is 0.
    pub face: Vec<u32>,
    /// A half-edge that leaves each vertex; on the boundary the one without a twin, where the fan begins.
    pub spoke: Vec<u32>,
    /// Of each edge, at least 0; infinite on the boundary.
    pub sharpness: Vec<f64>,
    /// Of each vertex, at least 0; empty when none is sharp.
    pub corner: Vec<f64>,
    /// Edges that the normals do not cross: where the step to this level was sharp; at level 0 the sharp ones.
    pub border: Vec<bool>,
    /// Sharp edges at each vertex, 255 for more.
    pub sharp_edges: Vec<u8>,
    /// Borders at each vertex, 255 for more.
    pub border_edges: Vec<u8>,
    /// Faces at each vertex, 255 for more.
    pub faces_at: Vec<u8>,
}

impl Level {
    /// The control mesh of `scene`, whose polygons are `mesh`.
    ///
    /// # Errors
    /// A tag names two vertices without an edge, or a face does not go with the scheme.
    pub fn new(scene: &SurfaceScene, mesh: &HalfEdgeMesh, scheme: Scheme) -> Result<Level, SurfaceError> {
        let n = mesh.half_edges() as usize;
        let all = |k: u32| (0..mesh.faces()).all(|f| mesh.valence(f) == k);
        if scheme == Scheme::Loop {
            if let Some(f) = (0..mesh.faces()).find(|&f| mesh.valence(f) != 3) {
                return Err(SurfaceError::NotATriangle { corners: mesh.valence(f), line: scene.face_line[f as usize] });
            }
        }
        let sides = if all(3) {
            3
        } else if all(4) {
            4
        } else {
            0
        };
        let mut level = Level {
            scheme,
            position: scene.positions.clone(),
            // The mesh's own convention: corner k of a face is where its half-edge k ends.
            origin: mesh.origin.clone(),
            twin: mesh.twin.clone(),
            edge: vec![0; n],
            sides,
            face_start: if sides == 0 { mesh.face_start.clone() } else { Vec::new() },
            face: if sides == 0 { mesh.face.clone() } else { Vec::new() },
            ..Level::default()
        };
        let mut edges = 0;
        for h in 0..n {
            let t = level.twin[h];
            if t == NONE || h < t as usize {
                level.edge[h] = edges;
                edges += 1;
            } else {
                level.edge[h] = level.edge[t as usize];
            }
        }
        level.sharpness = vec![0.0; edges as usize];
        let endless = |s: f64| if s >= INFINITE { f64::INFINITY } else { s };
        for (h, &s) in scene.edge_sharpness.iter().enumerate() {
            let slot = &mut level.sharpness[level.edge[h] as usize];
            *slot = slot.max(endless(s));
        }
        if !scene.creases.is_empty() {
            let ends = |h: u32| {
                let (a, b) = (level.origin[h as usize], level.target(h));
                (a.min(b), a.max(b))
            };
            let by_ends: HashMap<(u32, u32), u32> = (0..n as u32).map(|h| (ends(h), level.edge[h as usize])).collect();
            for crease in &scene.creases {
                let [a, b] = crease.ends;
                let Some(&e) = by_ends.get(&(a.min(b), a.max(b))) else {
                    return Err(SurfaceError::NoSuchEdge { a, b, line: crease.line });
                };
                let slot = &mut level.sharpness[e as usize];
                *slot = slot.max(endless(crease.sharpness));
            }
        }
        level.corner = scene.corner_sharpness.iter().map(|&s| endless(s)).collect();
        level.make_spokes();
        if scene.boundary_corners == Some(CornerRule::Sharp) {
            level.corner.resize(level.vertices(), 0.0);
            for v in 0..level.vertices() {
                let h = level.spoke[v];
                if level.twin[h as usize] == NONE && level.twin[level.prev(h) as usize] == NONE {
                    level.corner[v] = f64::INFINITY;
                }
            }
        }
        for h in 0..n {
            if level.twin[h] == NONE {
                level.sharpness[level.edge[h] as usize] = f64::INFINITY;
            }
        }
        level.border = level.sharpness.iter().map(|&s| s > 0.0).collect();
        level.count();
        Ok(level)
    }

    /// Vertices.
    pub fn vertices(&self) -> usize {
        self.position.len()
    }

    /// Vertices of the next level.
    pub fn vertices_after(&self) -> usize {
        let faces = if self.scheme == Scheme::CatmullClark { self.faces() } else { 0 };
        self.vertices() + faces + self.edges()
    }

    /// Edges.
    pub fn edges(&self) -> usize {
        self.sharpness.len()
    }

    /// Half-edges.
    pub fn half_edges(&self) -> usize {
        self.origin.len()
    }

    /// Faces.
    pub fn faces(&self) -> usize {
        match self.sides {
            0 => self.face_start.len() - 1,
            n => self.origin.len() / n as usize,
        }
    }

    /// Half-edges of face `f`.
    #[inline]
    pub fn of_face(&self, f: usize) -> std::ops::Range<u32> {
        match self.sides {
            0 => self.face_start[f]..self.face_start[f + 1],
            n => f as u32 * n..(f as u32 + 1) * n,
        }
    }

    /// Face of half-edge `h`.
    #[inline]
    pub fn face_of(&self, h: u32) -> usize {
        match self.sides {
            0 => self.face[h as usize] as usize,
            n => (h / n) as usize,
        }
    }

    /// Half-edge after `h` in its face.
    #[inline(always)]
    pub fn next(&self, h: u32) -> u32 {
        match self.sides {
            4 => h & !3 | (h + 1) & 3,
            3 => h - h % 3 + (h + 1) % 3,
            _ => {
                let face = self.of_face(self.face_of(h));
                if h + 1 == face.end {
                    face.start
                } else {
                    h + 1
                }
            }
        }
    }

    /// Half-edge before `h` in its face.
    #[inline(always)]
    pub fn prev(&self, h: u32) -> u32 {
        match self.sides {
            4 => h & !3 | (h + 3) & 3,
            3 => h - h % 3 + (h + 2) % 3,
            _ => {
                let face = self.of_face(self.face_of(h));
                if h == face.start {
                    face.end - 1
                } else {
                    h - 1
                }
            }
        }
    }

    /// Vertex that `h` ends in.
    #[inline]
    pub fn target(&self, h: u32) -> u32 {
        self.origin[self.next(h) as usize]
    }

    /// Whether the edge of `h` is sharp in the step from this level.
    #[inline]
    pub fn is_sharp(&self, h: u32) -> bool {
        self.sharpness[self.edge[h as usize] as usize] > 0.0
    }

    /// Whether normals stop at the edge of `h` on this level.
    #[inline]
    pub fn is_border(&self, h: u32) -> bool {
        self.border[self.edge[h as usize] as usize]
    }

    /// Sharpness of vertex `v` itself.
    #[inline]
    pub fn corner_sharpness(&self, v: u32) -> f64 {
        self.corner.get(v as usize).copied().unwrap_or(0.0)
    }

    /// Whether `v` lies on the boundary.
    #[inline]
    pub fn on_boundary(&self, v: u32) -> bool {
        self.twin[self.spoke[v as usize] as usize] == NONE
    }

    /// The half-edges that leave `v`, counter-clockwise from its spoke.
    #[inline]
    pub fn fan(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.spoke[v as usize];
        std::iter::successors(Some(first), move |&h| self.spoke_after(h).filter(|&g| g != first))
    }

    /// The fan of `v` where it is a whole one of four quads.
    #[inline(always)]
    pub fn cross(&self, v: u32) -> Option<[u32; 4]> {
        if self.sides != 4 {
            return None;
        }
        let after = |h: u32| self.twin[(h & !3 | (h + 3) & 3) as usize];
        let first = self.spoke[v as usize];
        let mut spokes = [first; 4];
        for k in 1..4 {
            spokes[k] = after(spokes[k - 1]);
            if spokes[k] == NONE {
                return None;
            }
        }
        (after(spokes[3]) == first && spokes[2] != first).then_some(spokes)
    }

    /// The half-edge of each edge with the lower number, at whose origin the edge's own numbers begin.
    pub fn lower(&self) -> Vec<u32> {
        let mut lower = vec![NONE; self.edges()];
        for (h, (&t, &e)) in self.twin.iter().zip(&self.edge).enumerate() {
            // Without a twin, too.
            if (h as u32) < t {
                lower[e as usize] = h as u32;
            }
        }
        lower
    }

    /// The next half-edge counter-clockwise around the origin of `h`; `None` past the last face at a boundary.
    #[inline(always)]
    pub fn spoke_after(&self, h: u32) -> Option<u32> {
        Some(self.twin[self.prev(h) as usize]).filter(|&t| t != NONE)
    }

    /// The next half-edge clockwise around the origin of `h`; `None` past the first face at a boundary.
    #[inline]
    pub fn spoke_before(&self, h: u32) -> Option<u32> {
        match self.twin[h as usize] {
            NONE => None,
            t => Some(self.next(t)),
        }
    }

    /// Edges at `v`.
    pub fn valence(&self, v: u32) -> u32 {
        self.fan(v).count() as u32 + u32::from(self.on_boundary(v))
    }

    pub(super) fn make_spokes(&mut self) {
        self.spoke = vec![NONE; self.position.len()];
        for h in 0..self.origin.len() {
            let slot = &mut self.spoke[self.origin[h] as usize];
            if *slot == NONE || self.twin[h] == NONE {
                *slot = h as u32;
            }
        }
    }

    /// Sharp edges, borders and faces at each vertex.
    pub(super) fn count(&mut self) {
        self.sharp_edges = self.count_edges(&self.sharpness, |&s| s > 0.0);
        self.border_edges = self.count_edges(&self.border, |&b| b);
        self.faces_at = vec![0; self.vertices()];
        for &v in &self.origin {
            let n = &mut self.faces_at[v as usize];
            *n = n.saturating_add(1);
        }
    }

    /// Edges at each vertex of which `is` holds, 255 for more. `of`: one an edge.
    pub fn count_edges<T>(&self, of: &[T], is: impl Fn(&T) -> bool) -> Vec<u8> {
        let mut count = vec![0u8; self.vertices()];
        if !of.iter().any(&is) {
            return count;
        }
        for h in 0..self.half_edges() as u32 {
            let t = self.twin[h as usize];
            if (t == NONE || h < t) && is(&of[self.edge[h as usize] as usize]) {
                for v in [self.origin[h as usize], self.target(h)] {
                    count[v as usize] = count[v as usize].saturating_add(1);
                }
            }
        }
        count
    }
}
