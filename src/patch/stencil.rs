//! Control points as weighted sums of the vertices of refined meshes.
//!
//! Where a control point lies depends on the connectivity by its weights and on the mesh by what they weigh. So the CPU makes
//! the weights, and the device the points: once for a table, and again only when sources change. A row is
//! `x_0 + sum w_i (x_i - x_0)`, which holds since its weights have the sum 1: sources that agree in a channel give it
//! unchanged, and single precision loses digits of the small differences only.
//!
//! Points that several patches share are one point, whose sum is made once: seams have the same bits from both sides. Two
//! points in one place that differ in the vector (both sides of a sharp edge) share the row of the position.

use super::ControlPoint;
use crate::camera::bounds;
use crate::mesh::NONE;
use glam::DVec3;

/// Weights less than this are what is left of sums that cancel.
const NOTHING: f64 = 1e-15;

/// Rows of weights, and the control points that use them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StencilTable {
    /// Where each row ends in `indices` and `weights`; it begins where the one before ends. None is empty.
    pub ends: Vec<u32>,
    /// Sources, of each row the one with the greatest weight first.
    pub indices: Vec<u32>,
    /// Of each of these; of a row, the sum is 1.
    pub weights: Vec<f64>,
    /// Of each control point, the row of its position and weight (channels 0 to 3) and that of its vector (4 to 7).
    pub points: Vec<[u32; 2]>,
}

/// A row in the making: weights of the same source become one.
#[derive(Clone, Debug, Default)]
pub struct Row {
    terms: Vec<(u32, f64)>,
    /// Of each source, its place in `terms`, or [`NONE`].
    place: Vec<u32>,
}

impl Row {
    /// Adds `weight` of `source`.
    pub fn add(&mut self, source: u32, weight: f64) {
        let s = source as usize;
        if s >= self.place.len() {
            self.place.resize((s + 1).next_power_of_two(), NONE);
        }
        match self.terms.get_mut(self.place[s] as usize) {
            Some((_, sum)) => *sum += weight,
            None => {
                self.place[s] = self.terms.len() as u32;
                self.terms.push((source, weight));
            }
        }
    }
}

impl StencilTable {
    /// Adds a row, which leaves `row` empty, and returns its number.
    pub fn push(&mut self, row: &mut Row) -> u32 {
        let greatest = (0..row.terms.len()).max_by(|&a, &b| row.terms[a].1.abs().total_cmp(&row.terms[b].1.abs()));
        if let Some(first) = greatest {
            row.terms.swap(0, first);
        }
        for (k, (source, weight)) in row.terms.drain(..).enumerate() {
            row.place[source as usize] = NONE;
            if k == 0 || weight.abs() > NOTHING {
                self.indices.push(source);
                self.weights.push(weight);
            }
        }
        self.ends.push(self.indices.len() as u32);
        self.ends.len() as u32 - 1
    }

    fn range(&self, row: u32) -> std::ops::Range<usize> {
        let first = row.checked_sub(1).map_or(0, |before| self.ends[before as usize]);
        first as usize..self.ends[row as usize] as usize
    }

    /// Sources and weights of a row.
    pub fn row(&self, row: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.range(row);
        self.indices[range.clone()].iter().copied().zip(self.weights[range].iter().copied())
    }

    fn half(&self, sources: &[ControlPoint], row: u32, from: usize) -> [f64; 4] {
        let mut terms = self.row(row);
        let channel = |i: u32| &sources[i as usize][from..from + 4];
        let Some((first, _)) = terms.next() else { return [0.0; 4] };
        let base: [f64; 4] = std::array::from_fn(|c| channel(first)[c]);
        let mut moved = [0.0; 4];
        for (i, w) in terms {
            for (c, x) in channel(i).iter().enumerate() {
                moved[c] += w * (x - base[c]);
            }
        }
        std::array::from_fn(|c| base[c] + moved[c])
    }

    /// Control point `i` of `sources`.
    pub fn point(&self, sources: &[ControlPoint], i: u32) -> ControlPoint {
        let [position, vector] = self.points[i as usize];
        let (p, v) = (self.half(sources, position, 0), self.half(sources, vector, 4));
        std::array::from_fn(|c| if c < 4 { p[c] } else { v[c - 4] })
    }

    /// The box of all points' positions, and how many had to be made for it. A point whose weights are not negative lies in the
    /// box of its sources, another no farther from it than its negative weights reach; most lie well inside a box that six
    /// points span.
    pub fn bounds(&self, sources: &[ControlPoint]) -> (Option<[DVec3; 2]>, usize) {
        let at = |i: u32| DVec3::from_slice(&sources[i as usize]);
        let made = |row: u32| DVec3::from_slice(&self.half(sources, row, 0));
        let rows = || self.points.iter().map(|&[position, _]| position);
        let mut spanning = [[0; 2]; 3];
        let mut extreme = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for row in rows() {
            let base = at(self.indices[self.range(row).start]);
            for axis in 0..3 {
                if base[axis] < extreme[axis][0] {
                    (extreme[axis][0], spanning[axis][0]) = (base[axis], row);
                }
                if base[axis] > extreme[axis][1] {
                    (extreme[axis][1], spanning[axis][1]) = (base[axis], row);
                }
            }
        }
        if self.points.is_empty() {
            return (None, 0);
        }
        let spanned = bounds(spanning.as_flattened().iter().map(|&row| made(row)));
        let Some([mut low, mut high]) = spanned else { return (None, 0) };
        let outside: Vec<bool> =
            (0..sources.len() as u32).map(|i| at(i).cmplt(low).any() || at(i).cmpgt(high).any()).collect();
        let mut count = 6;
        for row in rows() {
            let (mut negative, mut out) = (0.0f64, false);
            for (i, w) in self.row(row) {
                negative -= w.min(0.0);
                out |= outside[i as usize];
            }
            if !out && negative == 0.0 {
                continue;
            }
            let [a, b] = bounds(self.row(row).map(|(i, _)| at(i))).unwrap_or_default();
            let reach = (b - a) * negative;
            if (a - reach).cmplt(low).any() || (b + reach).cmpgt(high).any() {
                let p = made(row);
                (low, high) = (low.min(p), high.max(p));
                count += 1;
            }
        }
        (Some([low, high]), count)
    }

    /// What the device gets.
    pub fn packed(&self) -> PackedStencils {
        let range = |row: u32| {
            let range = self.range(row);
            [range.start as u32, range.end as u32]
        };
        PackedStencils {
            points: self
                .points
                .iter()
                .map(|&[p, v]| [range(p), range(v)])
                .map(|[p, v]| [p[0], p[1], v[0], v[1]])
                .collect(),
            terms: self.indices.iter().zip(&self.weights).map(|(&i, &w)| [i, (w as f32).to_bits()]).collect(),
        }
    }
}

/// Stencils as `glsl/stencil.comp` has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedStencils {
    /// Of each control point: first and end in `terms` of the row of its first vec4, and of that of its second.
    pub points: Vec<[u32; 4]>,
    /// Source, and the bits of its weight (f32).
    pub terms: Vec<[u32; 2]>,
}

impl PackedStencils {
    /// Adds a control point that is `source` itself, and returns its number.
    pub fn alone(&mut self, source: u32) -> u32 {
        let first = self.terms.len() as u32;
        self.terms.push([source, 1.0f32.to_bits()]);
        self.points.push([first, first + 1, first, first + 1]);
        self.points.len() as u32 - 1
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(self.points.as_slice()) + size_of_val(self.terms.as_slice())) as u64
    }

    /// What is wrong with them for so many sources.
    pub fn fault(&self, sources: usize) -> Option<String> {
        let whole = |first: u32, end: u32| first < end && end as usize <= self.terms.len();
        if let Some(p) = self.points.iter().find(|p| !whole(p[0], p[1]) || !whole(p[2], p[3])) {
            return Some(format!("stencil {p:?} of {} terms", self.terms.len()));
        }
        let bad = |t: &&[u32; 2]| t[0] as usize >= sources || !f32::from_bits(t[1]).is_finite();
        self.terms.iter().find(bad).map(|[i, w]| format!("source {i} of {sources}, weight {}", f32::from_bits(*w)))
    }

    /// All control points of `sources`, in the device's numbers and order. Twin of `main` in `glsl/stencil.comp`.
    pub fn points_of(&self, sources: &[[f32; 8]]) -> Vec<[f32; 8]> {
        let half = |first: u32, end: u32, from: usize| -> [f32; 4] {
            let terms = &self.terms[first as usize..end as usize];
            let base = &sources[terms[0][0] as usize][from..from + 4];
            let mut moved = [0.0f32; 4];
            for &[i, w] in &terms[1..] {
                let x = &sources[i as usize][from..from + 4];
                for c in 0..4 {
                    moved[c] += f32::from_bits(w) * (x[c] - base[c]);
                }
            }
            std::array::from_fn(|c| base[c] + moved[c])
        };
        let point = |p: &[u32; 4]| {
            let (a, b) = (half(p[0], p[1], 0), half(p[2], p[3], 4));
            std::array::from_fn(|c| if c < 4 { a[c] } else { b[c - 4] })
        };
        self.points.iter().map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(x: f64, y: f64) -> ControlPoint {
        [x, y, x * y, 0.25, y, -x, 1.0, 0.0]
    }

    fn table(rows: &[&[(u32, f64)]]) -> StencilTable {
        let (mut table, mut row) = (StencilTable::default(), Row::default());
        for terms in rows {
            for &(i, w) in *terms {
                row.add(i, w);
            }
            let r = table.push(&mut row);
            table.points.push([r, r]);
        }
        table
    }

    #[test]
    fn weights_of_one_source_are_one_and_the_greatest_comes_first() {
        let table = table(&[&[(3, 0.25), (1, 0.5), (3, 0.25), (0, 0.1), (3, 0.25), (0, -0.1)], &[(7, 1.0)]]);
        assert_eq!(table.row(0).collect::<Vec<_>>(), [(3, 0.75), (1, 0.5)]);
        assert_eq!(table.row(1).collect::<Vec<_>>(), [(7, 1.0)]);
    }

    #[test]
    fn a_point_is_its_sum_and_keeps_what_its_sources_agree_in() {
        let table = table(&[&[(0, 0.2), (1, 0.7), (2, 0.1)], &[(2, 1.5), (0, -0.5)]]);
        let sources = [source(0.1, 0.7), source(1.3, -0.4), source(2.9, 5.5)];
        for (i, weights) in [[0.2, 0.7, 0.1], [-0.5, 0.0, 1.5]].into_iter().enumerate() {
            let found = table.point(&sources, i as u32);
            for c in 0..8 {
                let sum: f64 = (0..3).map(|s| weights[s] * sources[s][c]).sum();
                assert!((found[c] - sum).abs() < 1e-14);
            }
            assert_eq!((found[3], found[6]), (0.25, 1.0));
        }
        let single = sources.map(|s| s.map(|x| x as f32));
        let packed = table.packed();
        assert_eq!(packed.fault(3), None);
        assert!(packed.fault(2).is_some());
        for (i, p) in packed.points_of(&single).iter().enumerate() {
            let exact = table.point(&sources, i as u32);
            assert!(p.iter().zip(exact).all(|(&a, b)| (f64::from(a) - b).abs() < 2e-6));
            assert_eq!((p[3], p[6]), (0.25, 1.0));
        }
    }

    #[test]
    fn the_box_is_that_of_all_points_and_most_are_not_made() {
        let n = 24;
        let at = |i: u32, j: u32| i * n + j;
        let sources: Vec<ControlPoint> = (0..n * n)
            .map(|k| {
                let (a, b) = (f64::from(k / n) / f64::from(n) - 0.5, f64::from(k % n) / f64::from(n) - 0.5);
                source(3.0 * a + b * b, 2.0 * b - a * a)
            })
            .collect();
        let mut rows: Vec<Vec<(u32, f64)>> = Vec::new();
        for (i, j) in (1..n - 1).flat_map(|i| (1..n - 1).map(move |j| (i, j))) {
            let ring = [at(i - 1, j), at(i + 1, j), at(i, j - 1), at(i, j + 1)];
            rows.push(ring.into_iter().map(|k| (k, 0.125)).chain([(at(i, j), 0.5)]).collect());
        }
        // Sticks out by a negative weight.
        rows.push(vec![(at(5, 5), -3.0), (at(9, 9), 4.0)]);
        let rows: Vec<&[(u32, f64)]> = rows.iter().map(Vec::as_slice).collect();
        let table = table(&rows);
        let all = (0..rows.len() as u32).map(|i| DVec3::from_slice(&table.point(&sources, i)));
        let (found, made) = table.bounds(&sources);
        assert_eq!(found, bounds(all));
        assert!(made < rows.len() / 2, "{made} of {}", rows.len());
        assert_eq!(StencilTable::default().bounds(&[]), (None, 0));
    }
}
