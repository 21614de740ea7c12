//! What can be selected of a gradient mesh, where it is, and what is under the pointer.
//!
//! Every patch has a box around its own Bezier points and those of the curves that it lies along. What is near a place is
//! looked for in patches whose box is, so that a look costs one comparison a patch and little more.

use super::{Gradient, Op};
use crate::ferguson::hermite;
use crate::ferguson::mesh::{tensor, HalfEdge, Mesh};
use glam::DVec2;
use std::collections::BTreeSet;

/// What can be selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// A control point.
    Point(u32),
    /// A handle of a curve, at its end 0 or 1.
    Handle(u32, usize),
    /// The twist of a corner.
    Twist(HalfEdge),
    /// The colour of a corner.
    Sector(HalfEdge),
    /// A curve.
    Curve(u32),
}

/// Boxes of patches by number, lower and upper corner; those of patches that are gone hold nothing.
pub(super) struct Boxes(Vec<[DVec2; 2]>);

impl Boxes {
    pub(super) fn new(mesh: &Mesh) -> Boxes {
        Boxes((0..mesh.patches.len() as u32).map(|p| around(mesh, p)).collect())
    }

    /// Follows an edit.
    pub(super) fn follow(&mut self, mesh: &Mesh, touched: &BTreeSet<u32>) {
        let before = self.0.len().min(mesh.patches.len());
        self.0.truncate(before);
        self.0.extend((before as u32..mesh.patches.len() as u32).map(|p| around(mesh, p)));
        for &p in touched.iter().filter(|&&p| (p as usize) < before) {
            self.0[p as usize] = around(mesh, p);
        }
    }

    /// The box around all, x0, y0, x1, y1.
    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        let join = |a: [DVec2; 2], b: &[DVec2; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let [low, high] = self.0.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], join);
        (low.x <= high.x).then_some([low.x, low.y, high.x, high.y])
    }

    /// Patches whose boxes meet a rectangle x0, y0, x1, y1 and are as large as `large` says.
    pub(super) fn large(&self, [x0, y0, x1, y1]: [f64; 4], large: impl Fn(DVec2) -> bool) -> Vec<u32> {
        let met = self.meeting(DVec2::new(x0, y0), DVec2::new(x1, y1));
        met.filter(|&p| large(self.0[p as usize][1] - self.0[p as usize][0])).collect()
    }

    /// Patches whose boxes meet a rectangle, ascending.
    fn meeting(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = u32> + '_ {
        let meets = move |b: &[DVec2; 2]| b[0].x <= high.x && b[0].y <= high.y && low.x <= b[1].x && low.y <= b[1].y;
        self.0.iter().zip(0..).filter(move |(b, _)| meets(b)).map(|(_, p)| p)
    }
}

fn around(mesh: &Mesh, p: u32) -> [DVec2; 2] {
    let mut b = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    if mesh.patch(p).alive {
        let curves = mesh.patch(p).sides.map(|side| mesh.bezier(side.curve));
        for q in mesh.geometry(p).into_iter().chain(curves.into_iter().flatten()) {
            b = [b[0].min(q), b[1].max(q)];
        }
    }
    b
}

/// How far a cubic is from a place, by 32 chords; infinite where that is certainly more than `reach`.
fn distance(q: [DVec2; 4], at: DVec2, reach: f64) -> f64 {
    let (low, high) = q.iter().fold((q[0], q[0]), |(l, h), p| (l.min(*p), h.max(*p)));
    if (at - at.clamp(low, high)).length() > reach {
        return f64::INFINITY;
    }
    let mut best = f64::INFINITY;
    let mut a = q[0];
    for k in 1..=32 {
        let b = hermite::point(q, f64::from(k) / 32.0);
        let along = b - a;
        let t = ((at - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        best = best.min((a + along * t).distance(at));
        a = b;
    }
    best
}

impl Gradient {
    /// Where a thing is shown. A twist is the inner Bezier point that it moves.
    pub fn place(&self, pick: Pick) -> DVec2 {
        match pick {
            Pick::Point(p) => self.mesh.at(p),
            Pick::Handle(c, end) => self.mesh.curve(c).handles[end],
            Pick::Twist(h) => self.mesh.geometry(h.patch())[[5, 6, 10, 9][h.side()]],
            Pick::Sector(h) => {
                let [u, v] = [[0.12, 0.12], [0.88, 0.12], [0.88, 0.88], [0.12, 0.88]][h.side()];
                self.mesh.evaluate(h.patch(), u, v).0
            }
            Pick::Curve(c) => hermite::point(self.mesh.bezier(c), 0.5),
        }
    }

    /// The operation that brings a thing to a place; `None`: it cannot be moved.
    pub fn moving(&self, pick: Pick, to: DVec2) -> Option<Op> {
        match pick {
            Pick::Point(p) => Some(Op::Point(p, to)),
            Pick::Handle(c, end) => Some(Op::Handle(c, end, to)),
            Pick::Twist(h) => {
                let sign = if h.side() % 2 == 0 { 9.0 } else { -9.0 };
                let change = (to - self.place(pick)) * sign;
                Some(Op::Twist(h, self.mesh.corner(h).twist + change))
            }
            Pick::Sector(_) | Pick::Curve(_) => None,
        }
    }

    /// Points, handles and curves of the patches whose boxes meet a rectangle x0, y0, x1, y1, each once; twists and sectors
    /// where they are shown. Sectors first, curves last.
    pub fn picks(&self, [x0, y0, x1, y1]: [f64; 4]) -> Vec<Pick> {
        let mut all: Vec<Pick> = self.sectors().into_iter().map(Pick::Sector).collect();
        let (mut points, mut curves, mut twists) = (Vec::new(), Vec::new(), Vec::new());
        for p in self.boxes.meeting(DVec2::new(x0, y0), DVec2::new(x1, y1)) {
            let patch = self.mesh.patch(p);
            points.extend(patch.corners.iter().map(|c| c.point));
            curves.extend(patch.sides.iter().map(|s| s.curve));
            if self.twists {
                twists.extend([0, 1, 2, 3].map(|i| Pick::Twist(HalfEdge::new(p, i))));
            }
        }
        for list in [&mut points, &mut curves] {
            list.sort_unstable();
            list.dedup();
        }
        all.extend(points.into_iter().map(Pick::Point));
        all.extend(curves.iter().flat_map(|&c| [Pick::Handle(c, 0), Pick::Handle(c, 1)]));
        all.extend(twists);
        all.extend(curves.into_iter().map(Pick::Curve));
        all
    }

    /// Corners around the point that is selected.
    pub fn sectors(&self) -> Vec<HalfEdge> {
        let point = match self.selected {
            Some(Pick::Point(p)) => p,
            Some(Pick::Sector(h)) => self.mesh.corner(h).point,
            _ => return Vec::new(),
        };
        self.mesh.points[point as usize].corners.clone()
    }

    /// What is within `reach` of a place: the nearest of the picks, else the nearest curve.
    pub fn at(&self, at: DVec2, reach: f64) -> Option<Pick> {
        let near = self.picks([at.x - reach, at.y - reach, at.x + reach, at.y + reach]);
        let mut best = (reach, None);
        for &pick in near.iter().filter(|pick| !matches!(pick, Pick::Curve(_))) {
            let far = self.place(pick).distance(at);
            if far < best.0 {
                best = (far, Some(pick));
            }
        }
        if best.1.is_some() {
            return best.1;
        }
        for pick in near {
            if let Pick::Curve(c) = pick {
                let far = distance(self.mesh.bezier(c), at, best.0);
                if far < best.0 {
                    best = (far, Some(pick));
                }
            }
        }
        best.1
    }

    /// The topmost patch at a place, with its parameters there.
    pub fn patch_at(&self, at: DVec2) -> Option<(u32, f64, f64)> {
        let mut found = None;
        for p in self.boxes.meeting(at, at) {
            let net = self.mesh.geometry(p);
            let (low, high) = net.iter().fold((net[0], net[0]), |(l, h), q| (l.min(*q), h.max(*q)));
            if at.cmplt(low).any() || at.cmpgt(high).any() {
                continue;
            }
            let place = |u: f64, v: f64| tensor(&net, u, v);
            let grid = (0..81).map(|k| (f64::from(k % 9) / 8.0, f64::from(k / 9) / 8.0));
            let near = |x: &(f64, f64)| place(x.0, x.1).distance_squared(at);
            let Some((mut u, mut v)) = grid.min_by(|a, b| near(a).total_cmp(&near(b))) else { continue };
            for _ in 0..20 {
                let e = 1e-6;
                let du = (place(u + e, v) - place(u - e, v)) / (2.0 * e);
                let dv = (place(u, v + e) - place(u, v - e)) / (2.0 * e);
                let (off, det) = (at - place(u, v), du.perp_dot(dv));
                if det.abs() < 1e-300 {
                    break;
                }
                u = (u + off.perp_dot(dv) / det).clamp(0.0, 1.0);
                v = (v + du.perp_dot(off) / det).clamp(0.0, 1.0);
            }
            if place(u, v).distance(at) < 1e-6 * (high - low).max_element() {
                found = Some((p, u, v));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ferguson::split::Axis;
    use crate::timing::random::Random;
    use glam::DVec4;
    use std::time::Instant;

    fn grid(n: u32) -> Gradient {
        Gradient::new(Mesh::grid(n, n, [0.0, 0.0, 1.0, 1.0], |_, _| DVec4::ONE).unwrap())
    }

    /// Boxes follow splits, moves and their undoing, so that everything is found where it is.
    #[test]
    fn everything_is_found_where_it_is_after_edits_and_undo() {
        let mut g = grid(4);
        g.twists = true;
        let mut random = Random::new(5);
        let mut below = |n: usize| (random.unit() * n as f64) as usize;
        for k in 0..200 {
            let live: Vec<u32> = g.mesh.live().collect();
            let p = live[below(live.len())];
            let corner = g.mesh.patch(p).corners[below(4)].point;
            let by = DVec2::new(0.02 * below(3) as f64, 0.02 * below(3) as f64) - DVec2::splat(0.02);
            let _ = match below(4) {
                0 if g.mesh.patch(p).extent().iter().all(|&e| e > 0.1) => {
                    g.act(Op::Split(p, [Axis::U, Axis::V][below(2)], 0.5))
                }
                1 => g.act(Op::Point(corner, g.mesh.at(corner) + by)),
                2 => g.act(Op::Remove(g.mesh.patch(p).sides[0].curve)),
                _ => {
                    g.step(below(2) == 0);
                    Ok(())
                }
            };
            assert!(g.boxes.0 == Boxes::new(&g.mesh).0, "after {k}");
            let all = g.picks([-9.0, -9.0, 9.0, 9.0]);
            let used = g.mesh.curves.iter().filter(|c| c.sides.iter().any(|s| !s.is_empty())).count();
            let points = g.mesh.points.iter().filter(|p| !p.corners.is_empty()).count();
            assert_eq!(all.len(), points + 3 * used + 4 * g.mesh.live().count());
            for pick in all.into_iter().step_by(7) {
                let at = g.place(pick);
                let found = g.at(at, 1e-3).expect("something is there");
                assert!(g.place(found).distance(at) < 1e-3 || matches!(found, Pick::Curve(_)), "{pick:?} {found:?}");
            }
        }
    }

    /// Nothing but the patches that change is computed, looked at or sent: the same counts in a mesh a hundred times as large.
    #[test]
    fn a_drag_a_split_and_their_undoing_cost_what_they_touch() {
        let mut counts = Vec::new();
        for n in [10, 100] {
            let mut g = grid(n);
            let cell = 1.0 / f64::from(n);
            let middle = DVec2::splat(0.5);
            let (p, _, _) = g.patch_at(middle + DVec2::splat(0.4 * cell)).unwrap();
            let sent = |g: &Gradient| g.changed_since(g.revision - 1).map(|changed| changed.control.len());
            let mut begun = Instant::now();
            let mut took = |what: &str| {
                println!("{} patches, {what}: {:?}", n * n, begun.elapsed());
                begun = Instant::now();
            };
            g.act(Op::Split(p, Axis::U, 0.5)).unwrap();
            let mut all = vec![sent(&g)];
            took("split");
            let pick = g.at(middle, 1e-9).unwrap();
            took("pick");
            let drawn = g.revision;
            for k in 1..=10 {
                assert!(!g.drag(pick, middle + DVec2::splat(0.01 * f64::from(k) * cell), Some(1e-9)).unwrap());
            }
            took("ten steps of a drag with fold tests");
            all.extend([
                g.changed_since(drawn).map(|changed| changed.control.len()),
                Some(g.gesture.as_ref().unwrap().touched.len()),
            ]);
            g.commit();
            g.step(false);
            all.push(sent(&g));
            took("undo");
            let rule = crate::patch::tess::TessRule::Pixels(6.0);
            g.look(rule, 0.02 * cell, [0.0, 0.0, 0.9, 0.9]);
            took("a first view");
            g.look(rule, 0.02 * cell, [0.1, 0.0, 1.0, 0.9]);
            all.push(sent(&g));
            took("another view");
            g.look(rule, 0.03 * cell, [0.1, 0.0, 1.0, 0.9]);
            all.push(sent(&g));
            took("a smaller one");
            counts.push(all);
            g.look(rule, 0.002 * cell, [0.5, 0.5, 0.5 + cell, 0.5 + cell]);
            took("so near that patches are cut");
            g.drag(pick, middle + DVec2::splat(0.02 * cell), Some(1e-9)).unwrap();
            took("a step of a drag there");
        }
        assert_eq!(counts[0], counts[1]);
        // Of 32 points each: both halves and the neighbours that have a T-section now; the patches around the point, one of
        // which was halved, and no more were looked at; again; none for a view that moves, those with T-sections for one of
        // another scale.
        assert_eq!(counts[1], [128, 160, 5, 160, 0, 128].map(Some));
    }

    #[test]
    fn a_look_in_ten_thousand_patches_is_at_those_nearby() {
        let g = grid(100);
        let mut times = [Vec::new(), Vec::new(), Vec::new()];
        for k in 0..60 {
            let at = DVec2::new(0.2037 + 0.01 * f64::from(k), 0.8061 - 0.01 * f64::from(k));
            let begun = Instant::now();
            // Nothing is that near, so that curves are looked at as well.
            assert_eq!(g.at(at, 1e-6), None);
            times[0].push(begun.elapsed());
            let begun = Instant::now();
            assert!(g.at(at, 0.01).is_some());
            times[1].push(begun.elapsed());
            let begun = Instant::now();
            assert!(g.patch_at(at).is_some());
            times[2].push(begun.elapsed());
            // A patch is as wide as the reach.
            let near = DVec2::splat(0.01);
            let looked_at = g.boxes.meeting(at - near, at + near).count();
            assert!((1..=16).contains(&looked_at), "{looked_at} patches at {at}");
        }
        let [far, near, patch] = times.map(|mut all| {
            all.sort();
            all[all.len() / 2]
        });
        println!("10,000 patches: nothing under the pointer {far:?}, a thing {near:?}, the patch {patch:?}");
    }
}
