//! Names for half-edges, faces and vertices of every M^l, and walking between them without building M^l.
//!
//! Two numberings of the interior half-edges of M^l meet here:
//!
//! * **App. A** (ZHHK22 App. A): what files, edits and every report use. The four children of half-edge `i`
//!   are `4 i + 0` (origin to edge point), `4 i + 1` (edge point to target), `4 i + 2` (edge point to face
//!   point) and `4 i + 3` (back). A face takes the number of the half-edge it grew from.
//! * **slots** (DV21): what the code computes with. The child *face* of slot `h` has the slots
//!   `4 h .. 4 h + 3` in order, `4 h` leaving the origin of `h`. So `next` is arithmetic, the parent of
//!   a face is its number shifted by two, and each slot's digits spell the path from M^0 down to it.
//!
//! ```text
//!        slot h, from v to w, in its face        App. A number of the same half-edge
//!   d+-----<-----+c                              4h + 0 : 4 i(h)
//!    |  4h+2     |                               4h + 1 : 4 i(h) + 2
//!    v 4h+3      ^ 4h+1                          4h + 2 : 4 i(prev h) + 3
//!    |    4h     |                               4h + 3 : 4 i(prev h) + 1
//!   v+----->-----+edge point
//! ```
//!
//! Level 0 comes from the ternary step: input half-edge `h` makes the corner quad `8 h .. 8 h + 3` at its
//! origin (`8 h` leaves the input vertex) and the quad of its middle third `8 h + 4 .. 8 h + 7`; the shrunk
//! face has the slots `8 S + h`. Constant time per level and call; nothing is stored.

use crate::mesh::{HalfEdgeMesh, NONE};

/// Half-edge of some M^l as a slot number; the level travels beside it.
pub type Slot = u64;

/// Names of M^0, M^1, ... above one input mesh.
#[derive(Clone, Copy)]
pub struct IndexMap<'a> {
    mesh: &'a HalfEdgeMesh,
    /// S: sum of the input's face valences.
    s: u64,
}

/// A vertex of M^l (l >= 1) in the quarter of an input face around one corner, the "kite".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KitePoint {
    /// Input half-edge that leaves the kite's corner.
    pub half_edge: u32,
    /// Steps from the corner along the half-edge; 0 to `3 * 2^(l - 1)`.
    pub x: u64,
    /// Steps from the corner along the half-edge before, backwards.
    pub y: u64,
}

impl<'a> IndexMap<'a> {
    /// Names above `mesh`.
    pub fn new(mesh: &'a HalfEdgeMesh) -> Self {
        IndexMap { mesh, s: u64::from(mesh.half_edges()) }
    }

    /// The input mesh.
    pub fn mesh(&self) -> &'a HalfEdgeMesh {
        self.mesh
    }

    /// Interior half-edges of M^level: `9 S 4^level`.
    pub fn half_edges(&self, level: u32) -> u64 {
        (9 * self.s) << (2 * level)
    }

    /// Boundary half-edges of M^level: `3 B 2^level`.
    pub fn boundary_half_edges(&self, level: u32) -> u64 {
        (3 * u64::from(self.mesh.boundary_edges())) << level
    }

    /// Faces of M^level: `2 S + F`, then `9 S 4^(level - 1)`.
    pub fn faces(&self, level: u32) -> u64 {
        match level {
            0 => 2 * self.s + u64::from(self.mesh.faces()),
            _ => self.half_edges(level - 1),
        }
    }

    /// Edges of M^level (boundary edges counted once).
    pub fn edges(&self, level: u32) -> u64 {
        (self.half_edges(level) + self.boundary_half_edges(level)) / 2
    }

    /// Vertices of M^level.
    pub fn vertices(&self, level: u32) -> u64 {
        let input_all = self.s + u64::from(self.mesh.boundary_edges());
        let mut n = u64::from(self.mesh.vertices()) + input_all + self.s;
        for l in 0..level {
            n += self.edges(l) + self.faces(l);
        }
        n
    }

    /// First slot of the shrunk faces of M^0.
    fn inner0(&self) -> u64 {
        8 * self.s
    }

    /// Slot after `d` in its face.
    pub fn next(&self, level: u32, d: Slot) -> Slot {
        if level == 0 && d >= self.inner0() {
            self.inner0() + u64::from(self.mesh.next((d - self.inner0()) as u32))
        } else {
            (d & !3) | ((d + 1) & 3)
        }
    }

    /// Slot before `d` in its face.
    pub fn prev(&self, level: u32, d: Slot) -> Slot {
        if level == 0 && d >= self.inner0() {
            self.inner0() + u64::from(self.mesh.prev((d - self.inner0()) as u32))
        } else {
            (d & !3) | ((d + 3) & 3)
        }
    }

    /// Opposite slot; `None` on the boundary.
    pub fn twin(&self, level: u32, d: Slot) -> Option<Slot> {
        // Up to the first ancestor whose twin is known: slots 0 and 3 lie along an edge of the face above, slots 1 and 2
        // inside it. Then down again on the other side, where each step runs the other way.
        let (mut l, mut h, mut path) = (level, d, 0u32);
        let mut t = loop {
            if l == 0 {
                break self.twin0(h)?;
            }
            let parent = h >> 2;
            match h & 3 {
                1 => break 4 * self.next(l - 1, parent) + 2,
                2 => break 4 * self.prev(l - 1, parent) + 1,
                digit => {
                    h = if digit == 0 { parent } else { self.prev(l - 1, parent) };
                    path = path << 1 | u32::from(digit == 0);
                }
            }
            l -= 1;
        };
        while l < level {
            t = if path & 1 == 1 { 4 * self.next(l, t) + 3 } else { 4 * t };
            path >>= 1;
            l += 1;
        }
        Some(t)
    }

    fn twin0(&self, d: Slot) -> Option<Slot> {
        let m = self.mesh;
        if d >= self.inner0() {
            return Some(8 * (d - self.inner0()) + 6);
        }
        let h = (d >> 3) as u32;
        let across = |h: u32| Some(m.twin[h as usize]).filter(|&t| t != NONE);
        match d & 7 {
            0 => across(h).map(|t| 8 * u64::from(m.next(t)) + 3),
            1 => Some(d + 6),
            2 => Some(8 * u64::from(m.prev(h)) + 5),
            3 => across(m.prev(h)).map(|t| 8 * u64::from(t)),
            4 => across(h).map(|t| 8 * u64::from(t) + 4),
            5 => Some(8 * u64::from(m.next(h)) + 2),
            6 => Some(self.inner0() + u64::from(h)),
            _ => Some(d - 6),
        }
    }

    /// Face of a slot, as a slot-numbered face: at level 0 the number of the face in M^0, above that the slot
    /// one level up that it grew from.
    pub fn face(&self, level: u32, d: Slot) -> u64 {
        match level {
            0 if d >= self.inner0() => 2 * self.s + u64::from(self.mesh.face[(d - self.inner0()) as usize]),
            _ => d >> 2,
        }
    }

    /// Half-edge of the input mesh in whose part of M^0 a slot of M^level lies.
    pub fn home(&self, level: u32, d: Slot) -> u32 {
        let root = d >> (2 * level);
        (if root >= self.inner0() { root - self.inner0() } else { root >> 3 }) as u32
    }

    /// Corners of the face of a slot.
    pub fn face_valence(&self, level: u32, d: Slot) -> u32 {
        if level == 0 && d >= self.inner0() {
            self.mesh.valence(self.mesh.face[(d - self.inner0()) as usize])
        } else {
            4
        }
    }

    /// Next spoke around the origin of `d`, twin of the slot before it; `None` past the boundary.
    pub fn spoke_after(&self, level: u32, d: Slot) -> Option<Slot> {
        self.twin(level, self.prev(level, d))
    }

    /// Calls `visit` with each slot that leaves the origin of `d`, once.
    pub fn around(&self, level: u32, d: Slot, mut visit: impl FnMut(Slot)) {
        let mut spoke = d;
        loop {
            visit(spoke);
            match self.spoke_after(level, spoke) {
                Some(s) if s == d => return,
                Some(s) => spoke = s,
                None => break,
            }
        }
        let mut spoke = d;
        while let Some(t) = self.twin(level, spoke) {
            spoke = self.next(level, t);
            visit(spoke);
        }
    }

    /// App. A number of a slot.
    pub fn to_app_a(&self, level: u32, d: Slot) -> u64 {
        if level > 0 {
            let h = d >> 2;
            return match d & 3 {
                0 => 4 * self.to_app_a(level - 1, h),
                1 => 4 * self.to_app_a(level - 1, h) + 2,
                2 => 4 * self.to_app_a(level - 1, self.prev(level - 1, h)) + 3,
                _ => 4 * self.to_app_a(level - 1, self.prev(level - 1, h)) + 1,
            };
        }
        if d >= self.inner0() {
            return 9 * (d - self.inner0()) + 8;
        }
        let h = d >> 3;
        let p = || u64::from(self.mesh.prev(h as u32));
        match d & 7 {
            0 => 9 * h,
            1 => 9 * h + 3,
            2 => 9 * p() + 6,
            3 => 9 * p() + 2,
            4 => 9 * h + 1,
            5 => 9 * h + 5,
            6 => 9 * h + 7,
            _ => 9 * h + 4,
        }
    }

    /// Slot of an App. A number; `None` if it is not an interior half-edge of M^level.
    pub fn from_app_a(&self, level: u32, id: u64) -> Option<Slot> {
        if id >= self.half_edges(level) {
            return None;
        }
        let root = id >> (2 * level);
        let h = root / 9;
        let n = || u64::from(self.mesh.next(h as u32));
        let mut d = match root % 9 {
            0 => 8 * h,
            1 => 8 * h + 4,
            2 => 8 * n() + 3,
            3 => 8 * h + 1,
            4 => 8 * h + 7,
            5 => 8 * h + 5,
            6 => 8 * n() + 2,
            7 => 8 * h + 6,
            _ => self.inner0() + h,
        };
        for l in 0..level {
            d = match (id >> (2 * (level - 1 - l))) & 3 {
                0 => 4 * d,
                1 => 4 * self.next(l, d) + 3,
                2 => 4 * d + 1,
                _ => 4 * self.next(l, d) + 2,
            };
        }
        Some(d)
    }

    /// For the App. A number of a boundary half-edge of M^level: its interior twin's App. A number.
    pub fn boundary_twin_app_a(&self, level: u32, id: u64) -> Option<u64> {
        let rank = id.checked_sub(self.half_edges(level))?;
        if rank >= self.boundary_half_edges(level) {
            return None;
        }
        let root = rank >> level;
        let t = u64::from(self.mesh.boundary_twin((root / 3) as u32));
        let mut twin = 9 * t + 2 - root % 3;
        for l in (0..level).rev() {
            twin = 4 * twin + 1 - ((rank >> l) & 1);
        }
        Some(twin)
    }

    /// App. A number of the boundary half-edge opposite an interior one.
    ///
    /// # Panics
    /// If `d` is not on the boundary.
    pub fn boundary_app_a(&self, level: u32, d: Slot) -> u64 {
        let mut id = self.to_app_a(level, d);
        let mut low = 0;
        for l in 0..level {
            low |= (1 - (id & 3)) << l;
            id >>= 2;
        }
        let (h, k) = ((id / 9) as usize, id % 9);
        assert!(k < 3 && self.mesh.twin[h] == NONE, "slot {d} of level {level} is not on the boundary");
        let root = 3 * u64::from(self.mesh.boundary_before[h]) + 2 - k;
        self.half_edges(level) + (root << level) + low
    }

    /// App. A number of the face that a slot belongs to.
    pub fn face_app_a(&self, level: u32, d: Slot) -> u64 {
        match level {
            0 => self.face(0, d),
            _ => self.to_app_a(level - 1, d >> 2),
        }
    }

    /// Number of the vertex that a slot leaves: old vertices keep theirs, then edge points in the order of
    /// their edges, then face points.
    ///
    /// ZHHK22 App. A writes `n_v + min(I(e), I(e_twin))` for edge points, which is not dense; as in the
    /// authors' tool the edge's rank stands in its place.
    pub fn vertex(&self, level: u32, d: Slot) -> u64 {
        if level > 0 {
            let (l, h) = (level - 1, d >> 2);
            return match d & 3 {
                0 => self.vertex(l, h),
                1 => self.vertices(l) + self.edge_rank(l, h),
                2 => self.vertices(l) + self.edges(l) + self.face_app_a(l, h),
                _ => self.vertices(l) + self.edge_rank(l, self.prev(l, h)),
            };
        }
        let m = self.mesh;
        let v = u64::from(m.vertices());
        let edge_point = |h: u32| v + u64::from(h);
        let face_point = |h: u32| v + self.s + u64::from(m.boundary_edges()) + u64::from(h);
        if d >= self.inner0() {
            return face_point((d - self.inner0()) as u32);
        }
        let h = (d >> 3) as u32;
        match d & 7 {
            0 => u64::from(m.origin[h as usize]),
            1 | 4 => edge_point(h),
            2 | 7 => face_point(h),
            3 => edge_point(m.twin_number(m.prev(h))),
            5 => edge_point(m.twin_number(h)),
            _ => face_point(m.next(h)),
        }
    }

    /// Rank of a slot's edge among the edges of M^level, in the order of the lesser App. A number.
    pub fn edge_rank(&self, level: u32, d: Slot) -> u64 {
        let mut id = self.to_app_a(level, d);
        if let Some(t) = self.twin(level, d) {
            id = id.min(self.to_app_a(level, t));
        }
        self.edges_before(level, id)
    }

    /// Interior half-edges of M^level with a number below `id` that come before their twins.
    fn edges_before(&self, level: u32, id: u64) -> u64 {
        if level == 0 {
            let (h, k) = ((id / 9) as usize, id % 9);
            let first = self.mesh.edges_before[h];
            let whole = 3 * u64::from(first) + 3 * h as u64;
            if k == 0 {
                return whole;
            }
            let own = u64::from(self.mesh.edges_before[h + 1] - first);
            // 9h + 0, 1, 2 come first where h does; 9h + 3, 5, 7 always do.
            return whole + own * k.min(3) + (k.saturating_sub(2)) / 2;
        }
        let (h, k) = (id >> 2, id & 3);
        let before = self.edges_before(level - 1, h);
        let whole = 2 * before + h;
        if k == 0 {
            return whole;
        }
        let own = self.edges_before(level - 1, h + 1) - before;
        whole + own * k.min(2) + u64::from(k == 3)
    }

    /// Where the vertex that a slot of M^level leaves lies in its kite; level >= 1.
    pub fn kite_point(&self, level: u32, d: Slot) -> KitePoint {
        debug_assert!(level >= 1);
        let root = d >> (2 * level);
        // Level-1 face in its kite: the corner it grew from and how its first slot runs (0: +x, 1: +y, ...).
        let (half_edge, mut x, mut y, mut turn) = if root >= self.inner0() {
            ((root - self.inner0()) as u32, 2i64, 2i64, 0u64)
        } else {
            let h = (root >> 3) as u32;
            match root & 7 {
                0 => (h, 0, 0, 0),
                1 => (h, 2, 0, 1),
                2 => (h, 2, 2, 2),
                3 => (h, 0, 2, 3),
                4 => (h, 2, 0, 0),
                5 => (self.mesh.next(h), 0, 2, 0),
                6 => (self.mesh.next(h), 2, 2, 1),
                _ => (h, 2, 2, 3),
            }
        };
        const STEP: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
        for l in (0..level).rev() {
            let s = (d >> (2 * l)) & 3;
            let (e0, e1) = (STEP[(turn & 3) as usize], STEP[((turn + 1) & 3) as usize]);
            if s == 1 || s == 2 {
                (x, y) = (x + e0.0, y + e0.1);
            }
            if s >= 2 {
                (x, y) = (x + e1.0, y + e1.1);
            }
            if l > 0 {
                (x, y, turn) = (2 * x, 2 * y, turn + s);
            }
        }
        KitePoint { half_edge, x: x as u64, y: y as u64 }
    }

    /// Whether the vertex that a slot leaves belongs to C^l of the input mesh, so that its colour may be edited
    /// (ZHHK22 3.3, 5.1: they lie three steps apart).
    pub fn is_colour_vertex(&self, level: u32, d: Slot) -> bool {
        if level == 0 {
            return d < self.inner0() && d & 7 == 0;
        }
        let k = self.kite_point(level, d);
        k.x % 3 == 0 && k.y % 3 == 0
    }

    /// Level and slots at which the vertex that `d` leaves first appeared, the least of the slots leaving it
    /// there: the same for every slot and every level of one vertex.
    pub fn birth(&self, mut level: u32, mut d: Slot) -> (u32, Slot) {
        while level > 0 && d & 3 == 0 {
            (level, d) = (level - 1, d >> 2);
        }
        let mut least = d;
        self.around(level, d, |s| least = least.min(s));
        (level, least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::build;
    use crate::scene::InputMesh;
    use glam::DVec2;
    use std::collections::{HashMap, HashSet};

    /// A triangle, a quad and a pentagon around a common vertex, open.
    pub fn fan() -> HalfEdgeMesh {
        build(&InputMesh {
            positions: (0..7).map(|i| DVec2::new(f64::from(i), f64::from(i * i))).collect(),
            corners: vec![0, 1, 2, 0, 2, 3, 4, 0, 4, 5, 6, 1],
            face_start: vec![0, 3, 7, 12],
            face_line: vec![],
        })
        .unwrap()
    }

    #[test]
    fn numberings_are_bijections_and_walks_agree_with_appendix_a() {
        let mesh = fan();
        let map = IndexMap::new(&mesh);
        for level in 0..4 {
            let n = map.half_edges(level);
            let mut boundary = HashSet::new();
            for id in 0..n {
                let d = map.from_app_a(level, id).unwrap();
                assert_eq!(map.to_app_a(level, d), id);
                assert_eq!(map.prev(level, map.next(level, d)), d);
                match map.twin(level, d) {
                    Some(t) => assert_eq!(map.twin(level, t), Some(d)),
                    None => {
                        let b = map.boundary_app_a(level, d);
                        assert!(boundary.insert(b));
                        assert_eq!(map.boundary_twin_app_a(level, b), Some(id));
                    }
                }
            }
            assert_eq!(boundary.len() as u64, map.boundary_half_edges(level));
            assert!(boundary.iter().all(|&b| b >= n && b < n + map.boundary_half_edges(level)));
            assert_eq!(map.from_app_a(level, n), None);
        }
    }

    #[test]
    fn vertices_and_edges_are_dense_and_shared() {
        let mesh = fan();
        let map = IndexMap::new(&mesh);
        for level in 0..3 {
            let mut vertices = HashMap::new();
            let mut edges = HashSet::new();
            for d in 0..map.half_edges(level) {
                edges.insert(map.edge_rank(level, d));
                let v = map.vertex(level, d);
                map.around(level, d, |s| assert_eq!(map.vertex(level, s), v));
                vertices.entry(v).or_insert(d);
                assert_eq!(map.birth(level, d), map.birth(level + 1, 4 * d));
            }
            assert_eq!(edges.len() as u64, map.edges(level));
            assert_eq!(edges.iter().max().unwrap() + 1, map.edges(level));
            // The unused numbers: edge points of boundary half-edges are used, so all are.
            assert_eq!(vertices.len() as u64, map.vertices(level));
            assert_eq!(vertices.keys().max().unwrap() + 1, map.vertices(level));
        }
    }

    #[test]
    fn colour_vertices_are_those_of_catmull_clark_on_the_input() {
        let mesh = fan();
        let map = IndexMap::new(&mesh);
        let (mut v, mut e, mut f, mut s) = (7, 9, 3, 12);
        for level in 0..4 {
            let mut found = HashSet::new();
            for d in 0..map.half_edges(level) {
                if map.is_colour_vertex(level, d) {
                    found.insert(map.birth(level, d));
                }
            }
            assert_eq!(found.len(), v, "level {level}");
            (v, e, f) = (v + e + f, 2 * e + s, s);
            s *= 4;
        }
    }
}
