//! One vertex of the next level from the level above: what [`super::ternary`] and [`super::catmull_clark`] do for a
//! whole mesh, turned round, so that an edit recomputes only what depends on it.
//!
//! Those scatter in the order of the half-edges; here the same terms are gathered in the same order, so both give the
//! same bits.

use super::level::{vertex_bits, Level, Value};
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::scene::CornerRule;
use glam::{DVec2, DVec4};
use vertex_bits::{BOUNDARY, CORNER, DART, EXTRAORDINARY, SECTORS};

/// The half-edges that leave each vertex of a level, in slot order; across cuts too, where no walk gets. Lists grow and
/// shrink in place; one that outgrows its room moves to the end.
#[derive(Clone, Debug, Default)]
pub struct Around {
    /// Of each vertex: where its list begins, how long it is, and what there is room for.
    list: Vec<[u32; 3]>,
    half_edge: Vec<u32>,
}

impl Around {
    /// Time linear in the level, whose faces stand in slot order.
    pub fn new(level: &Level) -> Around {
        // A sixteenth more: the first edit that refines would copy both lists.
        let room = |length: usize| length + 64 + length / 16;
        let mut list = Vec::with_capacity(room(level.vertices()));
        list.resize(level.vertices(), [0u32; 3]);
        for &v in &level.origin {
            list[v as usize][2] += 1;
        }
        let mut end = 0;
        for [begin, _, room] in &mut list {
            *begin = end;
            end += *room;
        }
        let mut half_edge = vec![0; room(level.half_edges())];
        half_edge.truncate(level.half_edges());
        for (h, &v) in level.origin.iter().enumerate() {
            let [begin, length, _] = &mut list[v as usize];
            half_edge[(*begin + *length) as usize] = h as u32;
            *length += 1;
        }
        Around { list, half_edge }
    }

    /// Half-edges that leave `v`.
    #[inline]
    pub fn of(&self, v: u32) -> &[u32] {
        let [begin, length, _] = self.list[v as usize];
        &self.half_edge[begin as usize..(begin + length) as usize]
    }

    /// Empty lists for vertices up to this many.
    pub fn extend_to(&mut self, vertices: usize) {
        let more = vertices.saturating_sub(self.list.len());
        if vertices > self.list.capacity() {
            self.list.reserve_exact(more + 64 + self.list.len() / 16);
        }
        self.list.extend(std::iter::repeat_n([0; 3], more));
    }

    /// Puts `h` in its place in the list of `v`.
    pub fn insert(&mut self, level: &Level, v: u32, h: u32) {
        let [begin, length, room] = self.list[v as usize];
        if length == room {
            // A regular vertex has four.
            let room = (2 * room).max(4);
            let to = self.half_edge.len();
            if to + room as usize > self.half_edge.capacity() {
                // A sixteenth more: doubling would hold more memory than all lists need.
                self.half_edge.reserve_exact(room as usize + 64 + to / 16);
            }
            self.half_edge.extend_from_within(begin as usize..(begin + length) as usize);
            self.half_edge.resize(to + room as usize, 0);
            self.list[v as usize] = [to as u32, length, room];
        }
        let [begin, length, _] = &mut self.list[v as usize];
        let at = *begin as usize;
        let list = &mut self.half_edge[at..=at + *length as usize];
        let place = list[..*length as usize].partition_point(|&g| level.is_before(g, h));
        list[place..].rotate_right(1);
        list[place] = h;
        *length += 1;
    }

    /// Takes `h` out of the list of `v`.
    pub fn remove(&mut self, v: u32, h: u32) {
        let [begin, length, _] = &mut self.list[v as usize];
        let list = &mut self.half_edge[*begin as usize..(*begin + *length) as usize];
        if let Some(place) = list.iter().position(|&g| g == h) {
            list[place..].rotate_left(1);
            *length -= 1;
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        12 * self.list.capacity() + 4 * self.half_edge.capacity()
    }
}

/// Vertex of M^0 as the ternary step places it without handles; its numbers as in [`super::ternary::ternary`].
pub fn ternary_point(mesh: &HalfEdgeMesh, vertex: u32) -> DVec2 {
    let at = |v: u32| mesh.positions[v as usize];
    let third = |a: u32, b: u32| (2.0 * at(a) + at(b)) / 3.0;
    let (v, s, b) = (mesh.vertices(), mesh.half_edges(), mesh.boundary_edges());
    if vertex < v {
        return at(vertex);
    }
    let h = vertex - v;
    if h < s {
        return third(mesh.origin[h as usize], mesh.target(h));
    }
    if h < s + b {
        let twin = mesh.boundary_twin(h - s);
        return third(mesh.target(twin), mesh.origin[twin as usize]);
    }
    let h = h - s - b;
    let f = mesh.face[h as usize] as usize;
    let (first, end) = (mesh.face_start[f], mesh.face_start[f + 1]);
    let centre = (first..end).map(|h| at(mesh.origin[h as usize])).sum::<DVec2>() / f64::from(end - first);
    let (v0, v1, v2) = (at(mesh.origin[h as usize]), at(mesh.target(h)), at(mesh.origin[mesh.prev(h) as usize]));
    (3.0 * v0 + v1 + v2 + 4.0 * centre) / 9.0
}

/// Calls `visit` with every vertex of M^0 that depends on input vertex `v`, possibly more than once. `leaving` are the
/// half-edges that leave it in the input mesh.
pub fn ternary_dependents(mesh: &HalfEdgeMesh, v: u32, leaving: &[u32], mut visit: impl FnMut(u32)) {
    let edge = mesh.vertices();
    let face = edge + mesh.half_edges() + mesh.boundary_edges();
    visit(v);
    for &h in leaving {
        for e in [h, mesh.prev(h)] {
            visit(edge + e);
            visit(edge + mesh.twin_number(e));
        }
        let f = mesh.face[h as usize] as usize;
        (mesh.face_start[f]..mesh.face_start[f + 1]).for_each(|h| visit(face + h));
    }
}

/// Position that Catmull-Clark gives the origin of slot `s` (0 to 3) of the child of half-edge `h`.
pub fn position(level: &Level, around: &Around, h: u32, s: u32, corners: CornerRule) -> DVec2 {
    match s {
        0 => vertex(level, around, level.origin[h as usize], corners).p,
        1 => edge(level, h).p,
        2 => centre(level, level.face_of(h)).p,
        _ => edge(level, level.prev(h)).p,
    }
}

/// Colour that the same corner has in its own sector.
pub fn colour(level: &Level, around: &Around, h: u32, s: u32, corners: CornerRule) -> DVec4 {
    let along = |e: u32| {
        if !level.sharp.is_empty() && level.sharp[e as usize] {
            (level.corner_colour(e) + level.corner_colour(level.next(e))) * 0.5
        } else {
            edge(level, e).c
        }
    };
    match s {
        0 if level.bits[level.origin[h as usize] as usize] & SECTORS != 0 => sector(level, h, corners),
        0 => vertex(level, around, level.origin[h as usize], corners).c,
        1 => along(h),
        2 => centre(level, level.face_of(h)).c,
        _ => along(level.prev(h)),
    }
}

/// Face point.
fn centre(level: &Level, f: u32) -> Value {
    if f < level.quads {
        let corner = level.quad_values(f);
        return ((corner[0] + corner[1]) + (corner[2] + corner[3])) * 0.25;
    }
    let sum = level.of_face(f).fold(Value::default(), |sum, h| sum + level.at(h));
    sum * (1.0 / f64::from(level.valence(f)))
}

/// Edge point, smooth.
fn edge(level: &Level, h: u32) -> Value {
    let share = |h: u32| (level.at(h) + level.at(level.next(h))) * 0.5;
    match level.across(h) {
        None => share(h),
        Some(t) => {
            let [low, high] = if level.is_before(h, t) { [h, t] } else { [t, h] };
            let [low, high] = [low, high].map(|h| share(h) + centre(level, level.face_of(h)));
            (Value::default() + low + high) * 0.25
        }
    }
}

/// Vertex point, as if no sharp edges parted it.
fn vertex(level: &Level, around: &Around, v: u32, corners: CornerRule) -> Value {
    let bits = level.bits[v as usize];
    let old = level.value[v as usize];
    let mut ring = Value::default();
    if bits & BOUNDARY != 0 {
        if bits & CORNER != 0 && corners == CornerRule::Sharp {
            return old;
        }
        for &h in around.of(v) {
            if level.twin[h as usize] == NONE {
                ring = ring + level.at(level.next(h));
            }
            if level.twin[level.prev(h) as usize] == NONE {
                ring = ring + level.at(level.prev(h));
            }
        }
        return old * 0.75 + ring * 0.125;
    }
    for &h in around.of(v) {
        let mut far = level.at(level.next(h));
        if bits & DART != 0 {
            if let Some(t) = level.across(h) {
                far.c = (far.c + level.corner_colour(t)) * 0.5;
            }
        }
        ring = ring + (far + centre(level, level.face_of(h)));
    }
    let n = if bits & EXTRAORDINARY == 0 { 4.0 } else { around.of(v).len() as f64 };
    old * ((n - 2.0) / n) + ring * (1.0 / (n * n))
}

/// Colour of a vertex in the sector of `h`, which follows the boundary rules.
fn sector(level: &Level, h: u32, corners: CornerRule) -> DVec4 {
    let first = level.fan_start(h, |s| level.colour_border(s));
    let mut last = first;
    while let Some(s) = level.spoke_after(last).filter(|&s| !level.colour_border(s)) {
        last = s;
    }
    let c = level.corner_colour(first);
    if last == first && corners == CornerRule::Sharp {
        return c;
    }
    let ends = level.corner_colour(level.next(first)) + level.corner_colour(level.prev(last));
    c * 0.75 + ends * 0.125
}
