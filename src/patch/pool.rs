//! Where control points go as they are made: at the end of the table, or into a piece of it.
//!
//! A piece is what a run of faces adds to the table. Some points of its faces are made by a face of an earlier run; the
//! piece makes them too, since others may depend on them, and *lends* them a number that is replaced by the maker's once
//! all runs are done.

use super::ControlPoint;

/// Says of a number that it is lent.
pub(super) const LENT: u32 = 1 << 30;

/// Who makes what was lent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Maker {
    /// Somebody makes the corner of this tint.
    Corner(u32),
    /// The face of this half-edge makes the two points of its edge; lent are the near and the far one of its twin.
    Edge(u32),
}

/// Control points so far.
pub trait Pool {
    /// Whether it is one of several runs', so that points may be those of others.
    const SHARED: bool;
    /// Adds a point; its number.
    fn push(&mut self, point: ControlPoint) -> u32;
    /// A point by its number.
    fn at(&self, number: u32) -> &ControlPoint;
    /// There will be this many more.
    fn reserve(&mut self, _more: usize) {}
    /// Points that an earlier run makes; the number of the first.
    #[doc(hidden)]
    fn lend(&mut self, points: &[ControlPoint], maker: Lent) -> u32;
}

/// Opaque outside this room.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Lent(pub(super) Maker);

impl Pool for Vec<ControlPoint> {
    const SHARED: bool = false;

    #[inline(always)]
    fn push(&mut self, point: ControlPoint) -> u32 {
        Vec::push(self, point);
        self.len() as u32 - 1
    }

    #[inline(always)]
    fn at(&self, number: u32) -> &ControlPoint {
        &self[number as usize]
    }

    fn reserve(&mut self, more: usize) {
        Vec::reserve(self, more);
    }

    fn lend(&mut self, _: &[ControlPoint], _: Lent) -> u32 {
        unreachable!("no run is before the only one")
    }
}

/// The piece of a table that one run of faces fills.
pub(super) struct Piece<'a> {
    /// What was there before any run began.
    before: &'a [ControlPoint],
    /// Number of the first own point.
    base: u32,
    own: &'a mut [ControlPoint],
    made: usize,
    lent: Vec<ControlPoint>,
    makers: Vec<Maker>,
}

impl<'a> Piece<'a> {
    /// Room for exactly as many points as the run will make.
    pub fn new(before: &'a [ControlPoint], base: u32, own: &'a mut [ControlPoint]) -> Self {
        Piece { before, base, own, made: 0, lent: Vec::new(), makers: Vec::new() }
    }

    /// What was lent, in order.
    ///
    /// # Panics
    /// If fewer points were made than there is room for.
    pub fn finish(self) -> (Vec<Maker>, Vec<ControlPoint>) {
        assert_eq!(self.made, self.own.len(), "a run makes the points that were counted");
        (self.makers, self.lent)
    }
}

impl Pool for Piece<'_> {
    const SHARED: bool = true;

    #[inline(always)]
    fn push(&mut self, point: ControlPoint) -> u32 {
        self.own[self.made] = point;
        self.made += 1;
        self.base + self.made as u32 - 1
    }

    #[inline(always)]
    fn at(&self, number: u32) -> &ControlPoint {
        if number & LENT != 0 {
            &self.lent[(number & !LENT) as usize]
        } else if number >= self.base {
            &self.own[(number - self.base) as usize]
        } else {
            &self.before[number as usize]
        }
    }

    fn lend(&mut self, points: &[ControlPoint], maker: Lent) -> u32 {
        self.lent.extend_from_slice(points);
        self.makers.push(maker.0);
        LENT | (self.lent.len() - points.len()) as u32
    }
}
