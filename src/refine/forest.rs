//! Which faces are affected, before any level is built: a forest of face names (ZHHK22 4.2).
//!
//! A node is a face that will be refined. Marking a face marks its ancestors, so the forest is a quadtree with
//! the faces of M^0 as roots; its size is the number of refined faces. The regions that an edit affects one
//! level up follow from where its vertex came from:
//!
//! | vertex of M^l is | parents of its 2-ring | parents of its 3-ring |
//! |---|---|---|
//! | a vertex of M^(l-1) | its 1-ring | its 2-ring |
//! | the point of edge a-b, faces F, G | 1-rings of a and b | 1-rings of all vertices of F and G |
//! | the point of face F | 1-rings of F's vertices | the same |

mod shares;

use super::edits::{Edits, Paint, MAX_LEVEL};
use super::isolation;
use super::meetings;
use super::Rules;
use crate::mesh::NONE;
use crate::scene::CornerRule;
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::threads;
use shares::Reasons;
use std::ops::Range;

/// The faces to refine.
#[derive(Clone, Debug)]
pub struct Forest {
    /// One flag for each face of M^0.
    level0: Vec<bool>,
    /// Node of each face of M^1 (by slot of level 0), [`NONE`] where there is none.
    root: Vec<u32>,
    /// Children of each node by slot.
    child: Vec<[u32; 4]>,
    /// Names of the nodes of each level, from level 0.
    by_level: Vec<Vec<u64>>,
}

/// A face's place in the forest while levels are built from the top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node(u32);

impl Node {
    /// Not in the forest: nothing below this face is refined.
    pub const NONE: Node = Node(NONE);
}

impl Forest {
    fn new(map: &IndexMap) -> Self {
        Forest {
            level0: vec![false; map.faces(0) as usize],
            root: threads::collect(map.half_edges(0) as usize, |_| NONE),
            child: Vec::new(),
            by_level: vec![Vec::new()],
        }
    }

    /// Unmarks everything. Time linear in the marks.
    fn clear(&mut self) {
        for &f in &self.by_level[0] {
            self.level0[f as usize] = false;
        }
        for &root in self.by_level.get(1).into_iter().flatten() {
            self.root[root as usize] = NONE;
        }
        self.child.clear();
        self.by_level.iter_mut().for_each(Vec::clear);
    }

    /// Whether a face of M^0 is to be refined.
    pub fn wants0(&self, face: u64) -> bool {
        self.level0[face as usize]
    }

    /// Node of the child that grows from half-edge `slot` of M^0.
    pub fn root(&self, slot: Slot) -> Node {
        Node(self.root[slot as usize])
    }

    /// Node of the child at slot `s` (0 to 3) of a face of level 1 or above.
    pub fn child(&self, node: Node, s: u32) -> Node {
        match node {
            Node::NONE => Node::NONE,
            Node(n) => Node(self.child[n as usize][s as usize]),
        }
    }

    /// Names of the faces of `level` that are to be refined, in no particular order.
    pub fn at(&self, level: u32) -> &[u64] {
        self.by_level.get(level as usize).map_or(&[], |v| v)
    }

    /// Whether the face of slot `d` of M^level is marked.
    fn has(&self, map: &IndexMap, level: u32, d: Slot) -> bool {
        if level == 0 {
            return self.level0[map.face(0, d) as usize];
        }
        let face = d >> 2;
        let mut node = Node(self.root[(face >> (2 * (level - 1))) as usize]);
        for l in 2..=level {
            node = self.child(node, (face >> (2 * (level - l))) as u32 & 3);
        }
        node != Node::NONE
    }

    /// Marks the face of slot `d` of M^level and its ancestors.
    fn mark(&mut self, map: &IndexMap, level: u32, d: Slot) {
        if level == 0 {
            let f = map.face(0, d);
            if !self.level0[f as usize] {
                self.level0[f as usize] = true;
                self.by_level[0].push(f);
            }
            return;
        }
        let face = d >> 2;
        let root = face >> (2 * (level - 1));
        let mut node = self.root[root as usize];
        if node == NONE {
            self.mark(map, 0, root);
            node = self.grow(1, root);
            self.root[root as usize] = node;
        }
        for l in 2..=level {
            let name = face >> (2 * (level - l));
            let s = (name & 3) as usize;
            let next = self.child[node as usize][s];
            node = if next == NONE {
                let n = self.grow(l, name);
                self.child[node as usize][s] = n;
                n
            } else {
                next
            };
        }
    }

    fn grow(&mut self, level: u32, name: u64) -> u32 {
        self.child.push([NONE; 4]);
        if self.by_level.len() <= level as usize {
            self.by_level.resize(level as usize + 1, Vec::new());
        }
        self.by_level[level as usize].push(name);
        self.child.len() as u32 - 1
    }

    /// Marks all faces around the origin of `d`.
    fn mark_star(&mut self, map: &IndexMap, level: u32, d: Slot) {
        map.around(level, d, |s| self.mark(map, level, s));
    }

    /// Marks all faces around the vertices of the face of `d`.
    fn mark_face_ring(&mut self, map: &IndexMap, level: u32, d: Slot) {
        let mut g = d;
        loop {
            self.mark_star(map, level, g);
            g = map.next(level, g);
            if g == d {
                return;
            }
        }
    }

    /// Marks the parents of the 2-ring of the vertex that `d` leaves at `level` (>= 1).
    fn mark_two_ring(&mut self, map: &IndexMap, level: u32, d: Slot) {
        let (l, h) = (level - 1, d >> 2);
        match d & 3 {
            0 => self.mark_star(map, l, h),
            2 => self.mark_face_ring(map, l, h),
            s => {
                let e = if s == 1 { h } else { map.prev(l, h) };
                self.mark_star(map, l, e);
                self.mark_star(map, l, map.next(l, e));
            }
        }
    }

    /// Marks the parents of the 3-ring of the vertex that `d` leaves at `level` (>= 1).
    fn mark_three_ring(&mut self, map: &IndexMap, level: u32, d: Slot) {
        let (l, h) = (level - 1, d >> 2);
        match d & 3 {
            0 => {
                let mut spokes = Vec::with_capacity(8);
                map.around(l, h, |s| spokes.push(s));
                for s in spokes {
                    self.mark_face_ring(map, l, s);
                }
            }
            2 => self.mark_face_ring(map, l, h),
            s => {
                let e = if s == 1 { h } else { map.prev(l, h) };
                self.mark_face_ring(map, l, e);
                if let Some(t) = map.twin(l, e) {
                    self.mark_face_ring(map, l, t);
                }
            }
        }
    }

    /// Marks the parents of the 3 by 3 faces of M^level that lie in one face of C^level of the input, `d`
    /// leaving its corner.
    fn mark_block(&mut self, map: &IndexMap, level: u32, d: Slot) {
        let mut row = d;
        for i in 0..3 {
            let mut h = row;
            for j in 0..3 {
                self.mark(map, level - 1, h >> 2);
                if j < 2 {
                    match map.twin(level, map.next(level, h)) {
                        Some(t) => h = map.next(level, t),
                        None => break,
                    }
                }
            }
            if i < 2 {
                match map.twin(level, map.next(level, map.next(level, row))) {
                    Some(t) => row = t,
                    None => break,
                }
            }
        }
    }

    /// Marks the parents of all faces that touch the three edges straight on from `d`, which leaves a colour vertex.
    fn mark_along(&mut self, map: &IndexMap, level: u32, d: Slot) {
        let mut e = d;
        map.around(level, e, |s| self.mark(map, level - 1, s >> 2));
        for _ in 0..3 {
            let end = map.next(level, e);
            map.around(level, end, |s| self.mark(map, level - 1, s >> 2));
            match map.twin(level, end) {
                Some(t) => e = map.next(level, t),
                None => return,
            }
        }
    }
}

/// Marks what the edits and, at level 0, the shape of the mesh affect.
///
/// Under [`Rules::Authors`] that is what the authors' tool marks; the cascade around extraordinary vertices
/// depends there on colours and is left to the levels. Under [`Rules::Gradtess`] the forest is complete: cascaded
/// and graded. Time linear in the marks.
///
/// `sharp` are the input's tagged half-edges. Around extraordinary vertices and meeting sharp edges ([`meetings`])
/// `isolate` levels more are refined than without.
pub fn plan(map: &IndexMap, edits: &Edits, sharp: &[u32], rules: Rules, corners: CornerRule, isolate: u32) -> Forest {
    let extraordinary = if rules == Rules::Gradtess { extraordinary0(map, corners) } else { Vec::new() };
    let (mut forest, meetings) = Reasons::new(map, edits, sharp, rules, corners, &extraordinary).mark();
    if rules == Rules::Gradtess && isolate > 0 {
        let meetings = meetings.iter().map(|m| (m.level, m.slot));
        let irregular: Vec<_> = irregular_vertices(map, &extraordinary).into_iter().chain(meetings).collect();
        isolate_vertices(&mut forest, map, &irregular, isolate);
        close(&mut forest, map, &extraordinary);
    }
    forest
}

/// All colour edits of one vertex, level by level.
fn mark_paints(forest: &mut Forest, map: &IndexMap, group: &[Paint], rules: Rules) {
    // Around an input vertex, and around any vertex that was painted at a coarser level, the one-ring has one
    // colour a sector already, so a sector that is not edited spreads nothing new.
    let mut settled = group[0].vertex.0 == 0 && map.is_colour_vertex(0, group[0].vertex.1);
    for same in group.chunk_by(|a, b| a.level == b.level) {
        let level = same[0].level;
        if level > 0 {
            if rules == Rules::Authors || !settled {
                forest.mark_three_ring(map, level, same[0].slot);
            }
            if rules == Rules::Gradtess {
                let painted = |d: Slot| same.iter().rev().find(|p| p.slot == d).map(|p| p.colour);
                for p in same {
                    forest.mark_block(map, level, p.slot);
                    // A spoke stays smooth only if both sides get the same colour; across any other the rules
                    // may change from smooth to sharp as far as the far end's faces.
                    if let Some(t) = map.twin(level, p.slot) {
                        if painted(map.next(level, t)) != Some(p.colour) {
                            forest.mark_along(map, level, p.slot);
                        }
                    }
                    // Where both sides are painted, the other one has seen to that.
                    let last = painted(p.slot) == Some(p.colour);
                    if let Some(t) = map.spoke_after(level, p.slot) {
                        if painted(t).is_none_or(|colour| !last && colour != p.colour) {
                            forest.mark_along(map, level, t);
                        }
                    }
                }
            }
        }
        settled = true;
    }
}

/// The faces of M^0 that are no quads, and their edge neighbours: of input faces whose first half-edge is in `run`.
fn mark_polygons(forest: &mut Forest, map: &IndexMap, run: &Range<u32>) {
    let mesh = map.mesh();
    let s = u64::from(mesh.half_edges());
    let start = |f: u32| mesh.face_start[f as usize];
    let first = mesh.face_start.partition_point(|&h| h < run.start) as u32;
    for f in (first..mesh.faces()).take_while(|&f| start(f) < run.end) {
        if mesh.valence(f) == 4 {
            continue;
        }
        for h in mesh.face_start[f as usize]..mesh.face_start[f as usize + 1] {
            let d = 8 * s + u64::from(h);
            forest.mark(map, 0, d);
            if let Some(t) = map.twin(0, d) {
                forest.mark(map, 0, t);
            }
        }
    }
}

/// For each input half-edge: whether its origin is extraordinary.
fn extraordinary0(map: &IndexMap, corners: CornerRule) -> Vec<bool> {
    let mesh = map.mesh();
    let mut faces = vec![0u32; mesh.positions.len()];
    let mut boundary = vec![false; mesh.positions.len()];
    for h in 0..mesh.half_edges() {
        faces[mesh.origin[h as usize] as usize] += 1;
        if mesh.twin[h as usize] == NONE {
            boundary[mesh.origin[h as usize] as usize] = true;
        }
    }
    mesh.origin
        .iter()
        .map(|&v| match (boundary[v as usize], faces[v as usize]) {
            (false, n) => n != 4,
            (true, 1) => corners == CornerRule::Smooth,
            (true, n) => n > 2,
        })
        .collect()
}

/// Whether the origin of slot `d` of M^level is extraordinary, or (at level 0) touches a face that is no quad.
fn is_extraordinary(map: &IndexMap, extraordinary: &[bool], mut level: u32, mut d: Slot) -> bool {
    let mesh = map.mesh();
    let s = u64::from(mesh.half_edges());
    let input_corner = |d: Slot| d < 8 * s && d & 7 == 0 && extraordinary[(d >> 3) as usize];
    if level == 0 {
        // Face points touch the shrunk face; nothing else touches one.
        let face_point = match d {
            _ if d >= 8 * s => Some(d - 8 * s),
            _ if matches!(d & 7, 2 | 7) => Some(d >> 3),
            _ if d & 7 == 6 => Some(u64::from(mesh.next((d >> 3) as u32))),
            _ => None,
        };
        return match face_point {
            Some(h) => mesh.valence(mesh.face[h as usize]) != 4,
            None => input_corner(d),
        };
    }
    while level > 0 {
        let h = d >> 2;
        match d & 3 {
            0 => (level, d) = (level - 1, h),
            2 if level == 1 => return map.face_valence(0, h) != 4,
            _ => return false,
        }
    }
    input_corner(d)
}

/// The first level at which faces around an extraordinary vertex can be drawn, and a slot that leaves it there: level 0
/// for the input's own, level 1 for those that faces other than quads bring.
fn irregular_vertices(map: &IndexMap, extraordinary: &[bool]) -> Vec<(u32, Slot)> {
    let s = u64::from(map.mesh().half_edges());
    let own = (0..s).filter(|&h| extraordinary[h as usize]).map(|h| (0, 8 * h));
    // The face point's corner in the child of slot 8 S + h, one level down at slot 2.
    let of_faces = (0..s).filter(|&h| map.face_valence(0, 8 * s + h) != 4).map(|h| (1, 4 * (8 * s + h) + 2));
    own.chain(of_faces).collect()
}

/// Refines the faces around each of the vertices `depth` times more than the forest has it, at higher valences as often as
/// has the same effect.
fn isolate_vertices(forest: &mut Forest, map: &IndexMap, vertices: &[(u32, Slot)], depth: u32) {
    let drawn: Vec<(u32, u32)> = vertices
        .iter()
        .map(|&(level, d)| {
            let mut deepest = level;
            let (mut valence, mut interior) = (0, true);
            map.around(level, d, |spoke| {
                valence += 1;
                interior &= map.twin(level, spoke).is_some();
                let refined = (level..MAX_LEVEL).take_while(|l| forest.has(map, *l, spoke << (2 * (l - level))));
                deepest = deepest.max(level + refined.count() as u32);
            });
            (deepest, if interior { isolation::levels(valence, depth) } else { depth })
        })
        .collect();
    for (&(level, d), (drawn, depth)) in vertices.iter().zip(drawn) {
        for l in level..(drawn + depth).min(MAX_LEVEL) {
            forest.mark_star(map, l, d << (2 * (l - level)));
        }
    }
}

/// From the finest level up: all faces around an extraordinary vertex share one level (ZHHK22 4.2, cascading),
/// and neighbours across an edge differ by one level at most.
fn close(forest: &mut Forest, map: &IndexMap, extraordinary: &[bool]) {
    for level in (0..forest.by_level.len() as u32).rev() {
        let mut done = 0;
        while done < forest.by_level[level as usize].len() {
            let name = forest.by_level[level as usize][done];
            done += 1;
            let first = first_slot(map, level, name);
            let mut d = first;
            loop {
                if is_extraordinary(map, extraordinary, level, d) {
                    forest.mark_star(map, level, d);
                }
                if level > 0 {
                    if let Some(t) = map.twin(level, d) {
                        forest.mark(map, level - 1, t >> 2);
                    }
                }
                d = map.next(level, d);
                if d == first {
                    break;
                }
            }
        }
    }
}

/// First slot of a face given by name.
pub fn first_slot(map: &IndexMap, level: u32, name: u64) -> Slot {
    let s = u64::from(map.mesh().half_edges());
    match level {
        0 if name >= 2 * s => 8 * s + u64::from(map.mesh().face_start[(name - 2 * s) as usize]),
        _ => 4 * name,
    }
}

/// The plan by its causes: what one edit, one group of colour edits or one meeting of sharp edges marks, closed by itself.
/// Every rule of [`plan`] has a single premise, a marked face, so the plan is the union of what its causes ask for, and an
/// edit that comes or goes changes only its own share. So it is with isolation, since the deepest face at a vertex is that
/// of one cause; but for meetings, which have two premises. [`Rules::Gradtess`] only.
#[derive(Clone, Debug)]
pub(crate) struct Causes {
    /// Scratch, clean between calls.
    forest: Forest,
    extraordinary: Vec<bool>,
    isolate: u32,
}

impl Causes {
    /// Time and memory linear in the input mesh. With isolation, what meetings isolate is not counted.
    pub fn new(map: &IndexMap, corners: CornerRule, isolate: u32) -> Causes {
        Causes { forest: Forest::new(map), extraordinary: extraordinary0(map, corners), isolate }
    }

    /// Names of the faces of each level that a geometry edit asks for. Time linear in their number, as for the others.
    pub fn of_move(&mut self, map: &IndexMap, m: &super::edits::Move) -> &[Vec<u64>] {
        self.closed(map, |forest| {
            if m.level > 0 {
                forest.mark_two_ring(map, m.level, m.vertex);
            }
        })
    }

    /// All colour edits of one vertex.
    pub fn of_paints(&mut self, map: &IndexMap, group: &[Paint]) -> &[Vec<u64>] {
        self.closed(map, |forest| mark_paints(forest, map, group, Rules::Gradtess))
    }

    /// The shape of the mesh.
    pub fn of_shape(&mut self, map: &IndexMap) -> &[Vec<u64>] {
        self.forest.clear();
        mark_polygons(&mut self.forest, map, &(0..map.mesh().half_edges()));
        close(&mut self.forest, map, &self.extraordinary);
        if self.isolate > 0 {
            // Every irregular vertex is isolated, whatever else is refined.
            let vertices = irregular_vertices(map, &self.extraordinary);
            isolate_vertices(&mut self.forest, map, &vertices, self.isolate);
            close(&mut self.forest, map, &self.extraordinary);
        }
        &self.forest.by_level
    }

    /// A meeting of sharp edges.
    pub fn of_meeting(&mut self, map: &IndexMap, m: &meetings::Meeting) -> &[Vec<u64>] {
        self.closed(map, |forest| mark_meeting(forest, map, m))
    }

    /// Bytes held between calls.
    pub fn bytes(&self) -> usize {
        self.forest.level0.capacity() + 4 * self.forest.root.capacity() + self.extraordinary.capacity()
    }

    fn closed(&mut self, map: &IndexMap, mark: impl FnOnce(&mut Forest)) -> &[Vec<u64>] {
        self.forest.clear();
        mark(&mut self.forest);
        close(&mut self.forest, map, &self.extraordinary);
        if self.isolate > 0 {
            let vertices = self.irregular_corners(map);
            isolate_vertices(&mut self.forest, map, &vertices, self.isolate);
            close(&mut self.forest, map, &self.extraordinary);
        }
        &self.forest.by_level
    }

    /// Those of the [`irregular_vertices`] that are corners of marked faces.
    fn irregular_corners(&self, map: &IndexMap) -> Vec<(u32, Slot)> {
        let s = u64::from(map.mesh().half_edges());
        let mut found = Vec::new();
        for (level, names) in (0..).zip(&self.forest.by_level) {
            for &name in names {
                let first = first_slot(map, level, name);
                let mut d = first;
                loop {
                    // The spoke of the level where the vertex was born.
                    let (mut l, mut spoke) = (level, d);
                    while l > 0 && spoke & 3 == 0 {
                        (l, spoke) = (l - 1, spoke >> 2);
                    }
                    let own = l == 0 && spoke < 8 * s && spoke & 7 == 0 && self.extraordinary[(spoke >> 3) as usize];
                    let centre = l == 1 && spoke & 3 == 2 && map.face_valence(0, spoke >> 2) != 4;
                    if own || centre {
                        found.push((l, spoke));
                    }
                    d = map.next(level, d);
                    if d == first {
                        break;
                    }
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

fn mark_meeting(forest: &mut Forest, map: &IndexMap, m: &meetings::Meeting) {
    // Names of faces below the deepest level would not fit.
    for l in (0..meetings::LEVELS).take_while(|l| m.level + l < MAX_LEVEL) {
        forest.mark_star(map, m.level + l, m.slot << (2 * l));
    }
}
