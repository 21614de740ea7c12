//! The equivalent traditional gradient mesh (BLHK18 Table 1): every split runs through its whole row or column.

use super::mesh::{HalfEdge, Mesh, Patch, NONE};
use super::split::Axis;
use std::collections::{BTreeMap, BTreeSet};

/// Sets with a parity: whether two members run the same way.
struct Rows {
    parent: Vec<(usize, bool)>,
}

impl Rows {
    fn find(&mut self, i: usize) -> (usize, bool) {
        let (mut at, mut turned) = (i, false);
        while self.parent[at].0 != at {
            turned ^= self.parent[at].1;
            at = self.parent[at].0;
        }
        self.parent[i] = (at, turned);
        (at, turned)
    }

    fn join(&mut self, a: usize, b: usize, turned: bool) {
        let ((ra, ta), (rb, tb)) = (self.find(a), self.find(b));
        if ra != rb {
            self.parent[rb] = (ra, ta ^ tb ^ turned);
        }
    }
}

/// Number of patches of the traditional mesh. Rows and columns run across the patches of level 0 through opposite sides,
/// round loops and through branches.
pub fn traditional(mesh: &Mesh) -> u64 {
    let mut lines = Lines::of(mesh);
    let roots: Vec<u32> = lines.roots.keys().copied().collect();
    roots.into_iter().map(|root| lines.cuts(root, 0).len() as u64 * lines.cuts(root, 1).len() as u64).sum()
}

/// The traditional mesh itself: every split is continued through its row or column, which changes nothing that is seen.
/// Time linear in the patches that come out.
pub fn propagated(mesh: &Mesh) -> Mesh {
    let mut lines = Lines::of(mesh);
    let mut out = mesh.clone();
    let mut waiting: Vec<u32> = out.live().collect();
    while let Some(p) = waiting.pop() {
        let Patch { root, rect, .. } = *out.patch(p);
        for axis in [Axis::U, Axis::V] {
            let k = usize::from(axis == Axis::V);
            let (low, high) = (grid(rect[k]), grid(rect[k + 2]));
            let cuts = lines.cuts(root, k);
            let Some(&cut) = cuts.iter().find(|&&cut| low < cut && cut < high) else { continue };
            let t = (cut as f64 / FINE - rect[k]) / (rect[k + 2] - rect[k]);
            if let Ok(split) = out.split(p, axis, t) {
                waiting.extend([split.first, split.second]);
                break;
            }
        }
    }
    out.take_journal();
    out
}

/// Steps of a row that cuts are counted in: fine enough for every split and coarse enough for rounding.
const FINE: f64 = (1u64 << 40) as f64;

fn grid(t: f64) -> u64 {
    (t * FINE).round() as u64
}

/// The rows and columns of a mesh and where they are cut.
struct Lines {
    /// Patches of level 0, numbered.
    roots: BTreeMap<u32, usize>,
    /// Of every root: direction u and direction v.
    rows: Rows,
    /// Of a row: all parameters where a side begins.
    cuts: BTreeMap<usize, BTreeSet<u64>>,
}

impl Lines {
    fn of(mesh: &Mesh) -> Lines {
        let roots: BTreeMap<u32, usize> = {
            let all: BTreeSet<u32> = mesh.live().map(|p| mesh.patch(p).root).collect();
            all.into_iter().enumerate().map(|(i, root)| (root, i)).collect()
        };
        let mut rows = Rows { parent: (0..2 * roots.len()).map(|i| (i, false)).collect() };
        for h in mesh.live().flat_map(|p| (0..4).map(move |i| HalfEdge::new(p, i))) {
            let Some(o) = mesh.opposite(h) else { continue };
            let (a, b) = (mesh.patch(h.patch()).root, mesh.patch(o.patch()).root);
            if a == b {
                continue;
            }
            let of = |h: HalfEdge, root: u32| 2 * roots[&root] + h.side() % 2;
            // Sides 2 and 3 run against u and v, and half-edges of one curve against each other.
            let turned = (h.side() > 1) ^ (o.side() > 1) ^ true;
            rows.join(of(h, a), of(o, b), turned);
        }
        let mut lines = Lines { roots, rows, cuts: BTreeMap::new() };
        for p in mesh.live() {
            let patch = mesh.patch(p);
            for axis in 0..2 {
                let (row, turned) = lines.rows.find(2 * lines.roots[&patch.root] + axis);
                for t in [patch.rect[axis], patch.rect[axis + 2]] {
                    lines.cuts.entry(row).or_default().insert(if turned { FINE as u64 - grid(t) } else { grid(t) });
                }
            }
        }
        lines
    }

    /// Where direction `axis` of a root is cut, ascending, its end (1) among them and its beginning not.
    fn cuts(&mut self, root: u32, axis: usize) -> Vec<u64> {
        let (row, turned) = self.rows.find(2 * self.roots[&root] + axis);
        let all = self.cuts.get(&row).into_iter().flatten().map(|&t| if turned { FINE as u64 - t } else { t });
        let mut all: Vec<u64> = all.filter(|&t| t > 0).collect();
        all.sort_unstable();
        all
    }
}

impl Mesh {
    /// Parts of the mesh that no curve connects.
    pub fn components(&self) -> usize {
        self.component().into_iter().filter(|&c| c != NONE).max().map_or(0, |c| c as usize + 1)
    }

    /// Of every patch the component, counted in the order of their first patches; [`NONE`] for patches that are gone.
    pub fn component(&self) -> Vec<u32> {
        let mut of = vec![NONE; self.patches.len()];
        let mut count = 0;
        for start in self.live() {
            if of[start as usize] != NONE {
                continue;
            }
            of[start as usize] = count;
            let mut waiting = vec![start];
            while let Some(p) = waiting.pop() {
                for i in 0..4 {
                    for h in self.curve(self.side(HalfEdge::new(p, i)).curve).sides.iter().flatten() {
                        if std::mem::replace(&mut of[h.patch() as usize], count) == NONE {
                            waiting.push(h.patch());
                        }
                    }
                }
            }
            count += 1;
        }
        of
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec4;

    #[test]
    fn splits_run_through_rows_and_columns() {
        let mut mesh = Mesh::grid(3, 2, [0.0, 0.0, 3.0, 2.0], |_, _| DVec4::ONE).unwrap();
        assert_eq!((traditional(&mesh), mesh.components()), (6, 1));
        mesh.split(0, Axis::U, 0.5).unwrap();
        // One column of two patches more.
        assert_eq!(traditional(&mesh), 8);
        mesh.split(3, Axis::U, 0.5).unwrap();
        assert_eq!(traditional(&mesh), 8, "the same column");
        mesh.split(4, Axis::V, 0.25).unwrap();
        assert_eq!(traditional(&mesh), 12);
        let all = propagated(&mesh);
        assert_eq!((all.live().count(), traditional(&all), all.fault()), (12, 12, None));
        assert!(all.points.iter().all(|p| p.on.is_none()), "no T-section is left");
    }
}
