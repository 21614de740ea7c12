//! Control points of a level's patches, written down as stencils of the level's vertices.

use super::adaptive::Part;
use super::patches::Patches;
use super::term::{Leaf, Tape, Term};
use crate::mesh::NONE;
use crate::patch::stencil::Row;
use crate::patch::ControlPoint;

/// What is used again for every control point.
#[derive(Default)]
pub(super) struct Scratch {
    tape: Tape,
    row: Row,
}

/// Makes control points of a part.
pub(super) struct ControlPoints<'a> {
    part: &'a Part,
    tape: &'a Tape,
    row: &'a mut Row,
    /// Of each wedge of the part, its number among the sources, or [`NONE`] before it is used.
    source: Vec<u32>,
    pub made: &'a mut Patches,
}

impl<'a> ControlPoints<'a> {
    /// Those of `part`, added to `made`.
    pub fn new(part: &'a Part, scratch: &'a mut Scratch, made: &'a mut Patches) -> ControlPoints<'a> {
        let Scratch { tape, row } = scratch;
        ControlPoints { part, tape, row, source: vec![NONE; part.live.len()], made }
    }

    /// The value at the origin of `h`, in the region of its face.
    pub fn at(&self, h: u32) -> Term<'a> {
        self.tape.leaf(Leaf::Value(h))
    }

    /// Control point `i`; where both sides of a sharp edge share its position, on its own side.
    pub fn point(&self, i: u32) -> Term<'a> {
        self.tape.leaf(Leaf::Row(self.made.stencils.points[i as usize][1]))
    }

    /// Forgets all terms.
    pub fn clear(&self) {
        self.tape.clear();
    }

    /// Adds a control point.
    pub fn push(&mut self, term: Term) -> u32 {
        let row = self.push_row(term);
        self.push_point([row, row])
    }

    /// Adds a control point that is the sum of values at half-edges, the first of each pair.
    pub fn push_sum<const N: usize>(&mut self, terms: [(u32, f64); N]) -> u32 {
        for (h, weight) in terms {
            add_value(self.part, &mut self.source, &mut self.made.sources, self.row, h, weight);
        }
        let row = self.made.stencils.push(self.row);
        self.push_point([row, row])
    }

    /// Adds a control point in the place of `there`, with a normal of its own.
    pub fn push_beside(&mut self, there: u32, term: Term) -> u32 {
        let vector = self.push_row(term);
        self.push_point([self.made.stencils.points[there as usize][0], vector])
    }

    fn push_point(&mut self, rows: [u32; 2]) -> u32 {
        let points = &mut self.made.stencils.points;
        points.push(rows);
        points.len() as u32 - 1
    }

    fn push_row(&mut self, term: Term) -> u32 {
        let (part, source, row) = (self.part, &mut self.source, &mut *self.row);
        let Patches { sources, stencils, .. } = &mut *self.made;
        self.tape.expand(term, |leaf, weight| match leaf {
            Leaf::Value(h) => add_value(part, source, sources, row, h, weight),
            Leaf::Row(r) => stencils.row(r).for_each(|(i, w)| row.add(i, weight * w)),
        });
        stencils.push(row)
    }
}

/// Adds what the value at `h` weighs to `row`. With its first use, it becomes a source.
fn add_value(part: &Part, source: &mut [u32], sources: &mut Vec<ControlPoint>, row: &mut Row, h: u32, weight: f64) {
    let wedge = part.live.of[h as usize] as usize;
    if source[wedge] == NONE {
        let v = part.level.origin[h as usize] as usize;
        let (p, n) = (part.level.position[v], part.normal[wedge]);
        source[wedge] = sources.len() as u32;
        sources.push([p.x, p.y, p.z, part.weight[v], n.x, n.y, n.z, 0.0]);
    }
    row.add(source[wedge], weight);
}
