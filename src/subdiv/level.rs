//! One level of a refined mesh: the faces of M^l that exist there, as flat arrays.
//!
//! Half-edges stand face by face. All faces are quads, `4 f .. 4 f + 3`, except the shrunk faces at the
//! end of level 0. What exists is a subset of M^l in slot order ([`super::index_map`]), so a sum over the
//! half-edges of a vertex runs in the same order here and in the whole M^l: local and global refinement
//! agree to the last bit.
//!
//! Positions belong to vertices, colours to *tints*: `tint[h]` is the colour of the corner at the origin of
//! `h` in its face. The corners of one vertex share one tint within each colour sector, and a vertex
//! without sharp edges has the tint of its own number.

use glam::{DVec2, DVec4};

/// Twin of a half-edge whose neighbour was not refined: the mesh goes on, but not here.
pub const CUT: u32 = u32::MAX - 1;

/// Facts about a vertex, as bits. They pass unchanged to the next level.
pub mod vertex_bits {
    /// On the boundary.
    pub const BOUNDARY: u8 = 1;
    /// Extraordinary: valence other than 4 inside, above 3 on the boundary (ZHHK22 3.1).
    pub const EXTRAORDINARY: u8 = 2;
    /// One interior sharp edge ends here: smooth colour rules (DKT98).
    pub const DART: u8 = 4;
    /// Sharp edges (with the boundary) part the faces here into colour sectors, each with a tint of its own.
    pub const SECTORS: u8 = 8;
    /// A boundary vertex of one face.
    pub const CORNER: u8 = 16;
}

/// Position and colour: one cache line, since the rules want both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Value {
    /// Position, scene units.
    pub p: DVec2,
    /// Colour with straight alpha, in the scene's colour space.
    pub c: DVec4,
}

impl std::ops::Add for Value {
    type Output = Value;
    #[inline]
    fn add(self, other: Value) -> Value {
        Value { p: self.p + other.p, c: self.c + other.c }
    }
}

impl std::ops::Sub for Value {
    type Output = Value;
    #[inline]
    fn sub(self, other: Value) -> Value {
        Value { p: self.p - other.p, c: self.c - other.c }
    }
}

impl std::ops::Mul<f64> for Value {
    type Output = Value;
    #[inline]
    fn mul(self, by: f64) -> Value {
        Value { p: self.p * by, c: self.c * by }
    }
}

/// A level of a refined mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Level {
    /// Which one; 0 is the mesh after the ternary step.
    pub level: u32,
    /// Name of each face: number in M^0 at level 0, above it the slot one level up that the face grew from.
    pub face: Vec<u64>,
    /// Each face: whether it belongs to a refined face (true) or only surrounds one.
    pub inside: Vec<bool>,
    /// Leading faces that are quads; all of them above level 0.
    pub quads: u32,
    /// First half-edge of the faces from `quads` on, and the end; empty above level 0.
    pub polygon_start: Vec<u32>,
    /// Face of each half-edge from `4 * quads` on.
    pub polygon_face: Vec<u32>,
    /// Vertex that each half-edge leaves.
    pub origin: Vec<u32>,
    /// Opposite half-edge, [`NONE`](crate::mesh::NONE) on the boundary, or [`CUT`].
    pub twin: Vec<u32>,
    /// Colour of the corner at each half-edge's origin, an index into `colour`.
    pub tint: Vec<u32>,
    /// Each half-edge: whether its edge is sharp for colour (both sides are set). Empty while no edge is.
    pub sharp: Vec<bool>,
    /// Positions and colours of the vertices, then of further tints, which repeat the position of their vertex: a corner's
    /// tint alone gives both.
    pub value: Vec<Value>,
    /// [`vertex_bits`] of each vertex.
    pub bits: Vec<u8>,
    /// After refinement: the child face of each half-edge in the next level, [`NONE`](crate::mesh::NONE) where there is none.
    pub child: Vec<u32>,
}

impl Level {
    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.face.len()
    }

    /// Number of half-edges.
    pub fn half_edges(&self) -> usize {
        self.origin.len()
    }

    /// First half-edge of face `f`.
    #[inline]
    pub fn first(&self, f: u32) -> u32 {
        if f <= self.quads {
            4 * f
        } else {
            self.polygon_start[(f - self.quads) as usize]
        }
    }

    /// Face of half-edge `h`.
    #[inline]
    pub fn face_of(&self, h: u32) -> u32 {
        if h < 4 * self.quads {
            h >> 2
        } else {
            self.polygon_face[(h - 4 * self.quads) as usize]
        }
    }

    /// Corners of face `f`.
    #[inline]
    pub fn valence(&self, f: u32) -> u32 {
        self.first(f + 1) - self.first(f)
    }

    /// Half-edge after `h` in its face.
    #[inline]
    pub fn next(&self, h: u32) -> u32 {
        if h < 4 * self.quads {
            (h & !3) | ((h + 1) & 3)
        } else {
            let f = self.face_of(h);
            if h + 1 == self.first(f + 1) {
                self.first(f)
            } else {
                h + 1
            }
        }
    }

    /// Half-edge before `h` in its face.
    #[inline]
    pub fn prev(&self, h: u32) -> u32 {
        if h < 4 * self.quads {
            (h & !3) | ((h + 3) & 3)
        } else {
            let f = self.face_of(h);
            if h == self.first(f) {
                self.first(f + 1) - 1
            } else {
                h - 1
            }
        }
    }

    /// Half-edges of face `f`.
    #[inline]
    pub fn of_face(&self, f: u32) -> std::ops::Range<u32> {
        self.first(f)..self.first(f + 1)
    }

    /// Whether `g` comes before `h` in slot order, which is that of the numbers unless faces came and went in place.
    #[inline]
    pub fn is_before(&self, g: u32, h: u32) -> bool {
        match self.level {
            0 => g < h,
            _ => (self.face[g as usize >> 2], g & 3) < (self.face[h as usize >> 2], h & 3),
        }
    }

    /// Opposite half-edge, `None` on the boundary and at a cut.
    #[inline]
    pub fn across(&self, h: u32) -> Option<u32> {
        let t = self.twin[h as usize];
        (t < CUT).then_some(t)
    }

    /// Vertex that `h` ends in.
    #[inline]
    pub fn target(&self, h: u32) -> u32 {
        self.origin[self.next(h) as usize]
    }

    /// Four numbers of quad `f` from an array with one entry a half-edge.
    #[inline]
    pub fn quad(array: &[u32], f: u32) -> [u32; 4] {
        let first = 4 * f as usize;
        array[first..first + 4].try_into().expect("four entries")
    }

    /// Values at the corners of quad `f`.
    #[inline]
    pub fn quad_values(&self, f: u32) -> [Value; 4] {
        let tint = Level::quad(&self.tint, f);
        let at = |i: usize| self.value[tint[i] as usize];
        [at(0), at(1), at(2), at(3)]
    }

    /// Number of vertices.
    #[inline]
    pub fn vertices(&self) -> usize {
        self.bits.len()
    }

    /// Position of the vertex that `h` leaves.
    #[inline]
    pub fn position(&self, h: u32) -> DVec2 {
        self.value[self.origin[h as usize] as usize].p
    }

    /// Colour of the corner at the origin of `h`.
    #[inline]
    pub fn corner_colour(&self, h: u32) -> DVec4 {
        self.value[self.tint[h as usize] as usize].c
    }

    /// Position and corner colour at the origin of `h`.
    #[inline]
    pub fn at(&self, h: u32) -> Value {
        self.value[self.tint[h as usize] as usize]
    }

    /// A new tint of the vertex `v`.
    pub fn new_tint(&mut self, v: u32, c: DVec4) -> u32 {
        self.value.push(Value { p: self.value[v as usize].p, c });
        self.value.len() as u32 - 1
    }

    /// Moves the vertex that `h` leaves by `step`, with all of its tints.
    pub fn shift(&mut self, h: u32, step: DVec2) {
        let v = self.origin[h as usize] as usize;
        let p = self.value[v].p + step;
        self.value[v].p = p;
        if self.bits[v] & vertex_bits::SECTORS != 0 {
            let mut tints = Vec::new();
            self.around(h, |s| tints.push(self.tint[s as usize]));
            tints.iter().for_each(|&t| self.value[t as usize].p = p);
        }
    }

    /// Whether colour takes the boundary rules along the edge of `h`.
    #[inline]
    pub fn colour_border(&self, h: u32) -> bool {
        self.twin[h as usize] >= CUT || (!self.sharp.is_empty() && self.sharp[h as usize])
    }

    /// Next spoke around the origin of `h`: twin of the half-edge before.
    #[inline]
    pub fn spoke_after(&self, h: u32) -> Option<u32> {
        self.across(self.prev(h))
    }

    /// The spoke before `h`: the one after its twin.
    #[inline]
    pub fn spoke_before(&self, h: u32) -> Option<u32> {
        self.across(h).map(|t| self.next(t))
    }

    /// Calls `visit` with every half-edge that leaves the origin of `h`.
    pub fn around(&self, h: u32, mut visit: impl FnMut(u32)) {
        let mut spoke = h;
        loop {
            visit(spoke);
            match self.spoke_after(spoke) {
                Some(s) if s == h => return,
                Some(s) => spoke = s,
                None => break,
            }
        }
        let mut spoke = h;
        while let Some(s) = self.spoke_before(spoke) {
            visit(s);
            spoke = s;
        }
    }

    /// First half-edge of the open fan around the origin of `h` as far as `border` edges let it reach, or `h`
    /// itself if the fan is closed.
    pub fn fan_start(&self, h: u32, border: impl Fn(u32) -> bool) -> u32 {
        let mut spoke = h;
        while !border(spoke) {
            match self.spoke_before(spoke) {
                Some(s) if s == h => return h,
                Some(s) => spoke = s,
                None => break,
            }
        }
        spoke
    }

    /// Marks an edge as sharp for colour, both sides.
    pub fn set_sharp(&mut self, h: u32) {
        if self.sharp.is_empty() {
            self.sharp.resize(self.origin.len(), false);
        }
        self.sharp[h as usize] = true;
        if let Some(t) = self.across(h) {
            self.sharp[t as usize] = true;
        }
    }

    /// After colours or sharp edges around the origin of `h` changed: sets the vertex's colour bits and gives
    /// each of its sectors one tint. `spokes` is scratch.
    pub fn settle_colours(&mut self, h: u32, spokes: &mut Vec<u32>) {
        use vertex_bits::{BOUNDARY, DART, SECTORS};
        let v = self.origin[h as usize] as usize;
        spokes.clear();
        self.around(h, |s| spokes.push(s));
        let sharp = match self.sharp.is_empty() {
            true => 0,
            false => spokes.iter().filter(|&&s| self.sharp[s as usize]).count(),
        };
        // The last spoke of an open fan leaves no half-edge from here, but then it is on the boundary, not sharp.
        let boundary = self.bits[v] & BOUNDARY != 0;
        self.bits[v] &= !(DART | SECTORS);
        match (sharp, boundary) {
            (0, _) | (1, false) => {
                self.bits[v] |= if sharp == 1 { DART } else { 0 };
                self.value[v].c = self.corner_colour(h);
                spokes.iter().for_each(|&s| self.tint[s as usize] = v as u32);
            }
            _ => {
                self.bits[v] |= SECTORS;
                self.part_into_sectors(h);
            }
        }
    }

    fn part_into_sectors(&mut self, h: u32) {
        let v = self.origin[h as usize];
        // Of an open fan, all of it: `h` may lie in any of its sectors.
        let first = self.fan_start(h, |_| false);
        let start = match self.spoke_before(first) {
            None => first,
            Some(_) => self.fan_start(h, |s| self.colour_border(s)),
        };
        let mut spoke = start;
        let mut tint = self.tint[start as usize];
        loop {
            if self.colour_border(spoke) {
                tint = self.new_tint(v, self.corner_colour(spoke));
            }
            self.tint[spoke as usize] = tint;
            match self.spoke_after(spoke) {
                Some(s) if s != start => spoke = s,
                _ => return,
            }
        }
    }
}
