//! Several handles moved as one body: every limit point by the same step.
//!
//! A limit point is an affine function of the control points (App. B), with the same weights for x and y. So there is
//! one number a handle, found once when the handles are taken, by which its control point goes further than the pointer:
//! `J w = 1`, where `J_ij` is the weight of control point j in limit point i. Inside a selection that has all of a limit
//! point's control points the number is 1; at its rim the neighbours stay behind, and it is more.

use super::drag::{size_of, Drag};
use super::handle::Kind;
use super::place::exact_limit;
use super::EditError;
use crate::mesh::HalfEdgeMesh;
use crate::scene::Scene;
use glam::DVec2;

/// Most handles whose weights are solved for: a measurement for each pair. More of them move by control point.
pub const MOST_SOLVED: usize = 24;

/// Handles held together. The pointer is at the first.
pub struct Together {
    drags: Vec<Drag>,
    weights: Vec<f64>,
    // Points that carry others along come before those: a gradient handle is put last where it belongs.
    order: Vec<usize>,
}

impl Together {
    /// Takes hold of handles.
    ///
    /// # Errors
    /// As [`Drag::begin`] of each.
    pub fn begin(scene: &Scene, mesh: &HalfEdgeMesh, drags: Vec<Drag>) -> Result<Together, EditError> {
        let mut order: Vec<usize> = (0..drags.len()).collect();
        order.sort_by_key(|&i| drags[i].id().kind != Kind::Input);
        let weights = vec![1.0; drags.len()];
        let mut all = Together { drags, weights, order };
        if (2..=MOST_SOLVED).contains(&all.drags.len()) {
            if let Some(weights) = all.solve(scene, mesh)? {
                all.weights = weights;
            }
        }
        Ok(all)
    }

    /// The handles.
    pub fn drags(&self) -> &[Drag] {
        &self.drags
    }

    /// Makes `scene` the one in which every limit point lies by `step` from where it was at the beginning.
    pub fn shift(&self, scene: &mut Scene, mesh: &HalfEdgeMesh, step: DVec2) {
        self.put(scene, mesh, |i| self.weights[i] * step);
    }

    fn put(&self, scene: &mut Scene, mesh: &HalfEdgeMesh, step: impl Fn(usize) -> DVec2) {
        for &i in &self.order {
            self.drags[i].shift(scene, mesh, step(i));
        }
    }

    /// Steps of the limit points when control points make theirs, x of each.
    fn measure(&self, scene: &Scene, mesh: &HalfEdgeMesh, step: impl Fn(usize) -> f64) -> Result<Vec<f64>, EditError> {
        let mut moved = scene.clone();
        self.put(&mut moved, mesh, |i| DVec2::new(step(i), 0.0));
        let mut at = mesh.clone();
        at.positions.clone_from(&moved.mesh.positions);
        let limit = |d: &Drag| Ok(exact_limit(&moved, &at, d.id().level, d.id().slot)?.x - d.start().x);
        self.drags.iter().map(limit).collect()
    }

    /// `None`: the points do not follow their control points well enough to tell.
    fn solve(&self, scene: &Scene, mesh: &HalfEdgeMesh) -> Result<Option<Vec<f64>>, EditError> {
        let n = self.drags.len();
        let probe = 0.01 * size_of(scene);
        let mut rows = vec![vec![0.0; n + 1]; n];
        for j in 0..n {
            let moved = self.measure(scene, mesh, |i| if i == j { probe } else { 0.0 })?;
            rows.iter_mut().zip(moved).for_each(|(row, m)| row[j] = m / probe);
        }
        rows.iter_mut().for_each(|row| row[n] = 1.0);
        let Some(weights) = eliminate(rows) else { return Ok(None) };
        // A vertex of M has its own gradient handles and face points with it, held or not, so that measured weights of
        // those that are held are of no use for it; and eq. 2 is not affine. What does not come true is not used.
        let moved = self.measure(scene, mesh, |i| weights[i] * probe)?;
        let sound = weights.iter().all(|w| w.abs() < 8.0) && moved.iter().all(|m| (m - probe).abs() < 1e-6 * probe);
        Ok(sound.then_some(weights))
    }
}

/// Gaussian elimination with pivots; the last column is the right-hand side. `None`: singular.
fn eliminate(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k].abs() < 1e-9 {
            return None;
        }
        let upper = rows[k].clone();
        for row in &mut rows[k + 1..] {
            let factor = row[k] / upper[k];
            row.iter_mut().zip(&upper).skip(k).for_each(|(x, u)| *x -= factor * u);
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * x[j]).sum();
        x[k] = (rows[k][n] - known) / rows[k][k];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_solves_and_refuses() {
        // The first pivot is zero.
        let x = eliminate(vec![vec![0.0, 2.0, 4.0], vec![3.0, 1.0, 5.0]]).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
        assert!(eliminate(vec![vec![1.0, 2.0, 1.0], vec![2.0, 4.0, 1.0]]).is_none());
    }
}
