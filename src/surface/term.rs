//! Sums of values that are not known yet: what masks make of them are stencils.
//!
//! The masks of limits, tangents and face points take anything that adds and scales ([`Linear`]). Given a [`Term`] for every
//! value they write down what they do on a [`Tape`], and the tape says what each value weighs in the end.

use crate::subdiv::fan::Linear;
use std::cell::RefCell;
use std::ops::{Add, Mul, Sub};

/// What sums are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaf {
    /// The value at the origin of a half-edge, in the region of its face.
    Value(u32),
    /// A row of a stencil table.
    Row(u32),
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Leaf(Leaf),
    /// The first, and the second times the factor.
    Sum(u32, u32, f64),
    Scaled(u32, f64),
}

/// What has been done.
#[derive(Debug, Default)]
pub struct Tape {
    nodes: RefCell<Vec<Node>>,
    /// What is left to be looked at.
    stack: RefCell<Vec<(u32, f64)>>,
}

/// A sum; nothing by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct Term<'a>(Option<(&'a Tape, u32)>);

impl Tape {
    fn note(&self, node: Node) -> Term<'_> {
        let mut nodes = self.nodes.borrow_mut();
        nodes.push(node);
        Term(Some((self, nodes.len() as u32 - 1)))
    }

    /// A leaf.
    pub fn leaf(&self, leaf: Leaf) -> Term<'_> {
        self.note(Node::Leaf(leaf))
    }

    /// Calls `add` with all leaves of `term` and what they weigh, one or more times each.
    pub fn expand(&self, term: Term, mut add: impl FnMut(Leaf, f64)) {
        let (nodes, mut stack) = (self.nodes.borrow(), self.stack.borrow_mut());
        stack.extend(term.0.map(|(_, node)| (node, 1.0)));
        while let Some((node, weight)) = stack.pop() {
            match nodes[node as usize] {
                Node::Leaf(leaf) => add(leaf, weight),
                Node::Sum(a, b, factor) => stack.extend([(b, weight * factor), (a, weight)]),
                Node::Scaled(a, factor) => stack.push((a, weight * factor)),
            }
        }
    }

    /// Forgets everything: terms made before mean nothing any more.
    pub fn clear(&self) {
        self.nodes.borrow_mut().clear();
    }
}

impl<'a> Term<'a> {
    fn plus(self, other: Term<'a>, factor: f64) -> Term<'a> {
        match (self.0, other.0) {
            (_, None) => self,
            (None, Some(_)) if factor == 1.0 => other,
            (None, Some(_)) => other * factor,
            (Some((tape, a)), Some((_, b))) => tape.note(Node::Sum(a, b, factor)),
        }
    }
}

impl<'a> Add for Term<'a> {
    type Output = Term<'a>;
    fn add(self, other: Term<'a>) -> Term<'a> {
        self.plus(other, 1.0)
    }
}

impl<'a> Sub for Term<'a> {
    type Output = Term<'a>;
    fn sub(self, other: Term<'a>) -> Term<'a> {
        self.plus(other, -1.0)
    }
}

impl<'a> Mul<f64> for Term<'a> {
    type Output = Term<'a>;
    fn mul(self, factor: f64) -> Term<'a> {
        match self.0 {
            Some((tape, a)) => tape.note(Node::Scaled(a, factor)),
            None => self,
        }
    }
}

impl Linear for Term<'_> {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::CornerRule;
    use crate::subdiv::fan::Fan;
    use crate::subdiv::limit::{edge_point, limit};
    use glam::DVec2;

    #[test]
    fn masks_of_terms_weigh_what_masks_of_values_add_up() {
        let value = |i: u32| DVec2::new(f64::from(i).sin(), f64::from(i * i).cos());
        for (closed, faces, dart) in
            [(true, 3, None), (true, 4, None), (true, 7, Some(2)), (false, 1, None), (false, 5, None)]
        {
            let tape = Tape::default();
            let spokes = faces + u32::from(!closed);
            fn fan<V: Linear>(n: [u32; 2], closed: bool, dart: Option<usize>, at: impl Fn(u32) -> V) -> Fan<V> {
                let [faces, spokes] = n;
                Fan {
                    centre: at(0),
                    closed,
                    spoke: (0..spokes).map(|i| at(1 + i)).collect(),
                    opposite: (0..faces).map(|i| at(50 + i)).collect(),
                    face: (0..faces)
                        .map(|i| (at(0) + at(1 + i) + at(50 + i) + at(1 + (i + 1) % spokes)) * 0.25)
                        .collect(),
                    half_edge: (0..faces).collect(),
                    dart,
                }
            }
            let values = fan([faces, spokes], closed, dart, value);
            let terms = fan([faces, spokes], closed, dart, |i| tape.leaf(Leaf::Value(i)));
            for (sum, wanted) in [
                (limit(&terms, CornerRule::Smooth), limit(&values, CornerRule::Smooth)),
                (edge_point(&terms, 1, CornerRule::Smooth), edge_point(&values, 1, CornerRule::Smooth)),
            ] {
                let (mut found, mut total) = (DVec2::ZERO, 0.0);
                tape.expand(sum, |leaf, weight| {
                    let Leaf::Value(i) = leaf else { panic!("no rows were given") };
                    found += value(i) * weight;
                    total += weight;
                });
                assert!((found - wanted).length() < 1e-14 && (total - 1.0).abs() < 1e-14, "{closed} {faces}");
            }
        }
    }

    #[test]
    fn nothing_adds_nothing() {
        let tape = Tape::default();
        let a = tape.leaf(Leaf::Row(5));
        let none = Term::default();
        for (sum, weight) in [(a + none, 1.0), (none + a, 1.0), (none - a, -1.0), ((none * 3.0 - a) * 2.0, -2.0)] {
            let mut seen = Vec::new();
            tape.expand(sum, |leaf, weight| seen.push((leaf, weight)));
            assert_eq!(seen, [(Leaf::Row(5), weight)]);
        }
        tape.expand(none * 2.0 + none, |_, _| panic!("nothing is there"));
    }
}
