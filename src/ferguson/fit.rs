//! Tessellation levels of the sides (BLHK18 6.2), and the virtual subdivision of patches whose sides would need more
//! segments than a device has.
//!
//! Virtual patches are made by the very splits of section 4, in a copy of the mesh: exact, and T-sections between them and
//! their neighbours come by themselves.

use super::mesh::{HalfEdge, Mesh};
use super::split::Axis;
use crate::patch::stitched::{Stitch, MOST_KNOTS};
use crate::patch::tess::TessRule;
use glam::DVec2;
use std::collections::BTreeSet;

/// How finely to tessellate, and what is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Fixed: the level of every free side, and at least that many segments on every curve with T-sections. Base: as Fixed.
    /// Pixels: by the length of the control polygon.
    pub rule: TessRule,
    /// Pixels a model unit along x and y.
    pub scale: [f64; 2],
    /// Model rectangle that is seen; patches outside are not subdivided for their size. `None`: all is seen.
    pub view: Option<[f64; 4]>,
}

impl Target {
    /// Whether a side inside a box of this size, model units, may want more segments than a device has.
    pub fn may_be_cut(&self, size: DVec2) -> bool {
        match self.rule {
            TessRule::Fixed(t) | TessRule::Base(t) => f64::from(t) > f64::from(MOST),
            // A control polygon has three legs.
            TessRule::Pixels(p) => 3.0 * (size * DVec2::from(self.scale)).length() > f64::from(MOST) * f64::from(p),
        }
    }
}

impl Default for Target {
    fn default() -> Target {
        Target { rule: TessRule::Fixed(16.0), scale: [1.0, 1.0], view: None }
    }
}

/// The greatest level of a device, as a whole number.
const MOST: u32 = 64;

/// Patches that virtual subdivision stops at: what a view of any size needs is far less.
const MOST_PATCHES: usize = 1 << 20;

/// Segments that are wanted along a curve with these Bezier points.
pub fn wanted(q: [DVec2; 4], target: &Target) -> f64 {
    match target.rule {
        TessRule::Fixed(t) | TessRule::Base(t) => f64::from(t),
        TessRule::Pixels(p) => {
            let length: f64 = q.windows(2).map(|w| ((w[1] - w[0]) * DVec2::from(target.scale)).length()).sum();
            length / f64::from(p)
        }
    }
}

/// Level of a free side. CPU twin of `level_of` in `glsl/stitched.tesc`.
pub fn free_level(q: [DVec2; 4], target: &Target) -> f64 {
    let rule = match target.rule {
        TessRule::Fixed(t) | TessRule::Base(t) => f64::from(t.ceil()),
        TessRule::Pixels(_) => wanted(q, target),
    };
    rule.clamp(2.0, f64::from(MOST))
}

/// Segments of a curve with T-sections: (K, t) at every end of a side along it, from (0, 0) to (n, 1). The shortest side
/// has a whole even number of segments, the others multiples of it, by powers of 2 where splits are dyadic. `even` says
/// that all segments are equal.
struct Knots {
    all: Vec<(u32, f64)>,
    even: bool,
}

impl Mesh {
    /// Whether a curve has T-sections on it, from either side.
    pub fn has_sections(&self, c: u32) -> bool {
        self.curve(c).sides.iter().any(|list| list.len() > 1)
    }

    fn knots(&self, c: u32, target: &Target) -> Knots {
        let mut ends: Vec<f64> = vec![0.0, 1.0];
        let mut widest = 0.0f64;
        for &h in self.curve(c).sides.iter().flatten() {
            let side = self.side(h);
            ends.extend([side.from, side.to]);
            widest = widest.max(side.to - side.from);
        }
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let want = wanted(self.bezier(c), target);
        // The least power of 2 that all ends are multiples of.
        let division = (0..=20).map(|d| 1u32 << d).find(|&d| ends.iter().all(|t| (t * f64::from(d)).fract() == 0.0));
        if let Some(d) = division {
            let step = 2.0 * f64::from(d);
            let fits = (f64::from(MOST) / (step * widest)).floor();
            let times = (want / step).ceil().min(fits).max(1.0);
            let n = times * step;
            return Knots { all: ends.iter().map(|&t| ((t * n) as u32, t)).collect(), even: true };
        }
        let shares = |density: f64| -> Vec<(u32, f64)> {
            let mut k = 0;
            let mut all = vec![(0, 0.0)];
            for pair in ends.windows(2) {
                k += 2 * ((0.5 * density * (pair[1] - pair[0])).round() as u32).clamp(1, MOST);
                all.push((k, pair[1]));
            }
            all
        };
        // A side of several pieces may round up past the limit.
        let mut density = want.min(f64::from(MOST) / widest);
        let mut all = shares(density);
        while density > 2.0 && self.longest_share(c, &all) > MOST {
            density *= 0.9;
            all = shares(density);
        }
        Knots { all, even: false }
    }

    fn longest_share(&self, c: u32, knots: &[(u32, f64)]) -> u32 {
        let number = |t: f64| knots.iter().find(|k| k.1 == t).map_or(0, |k| k.0);
        let shares = self.curve(c).sides.iter().flatten().map(|&h| number(self.side(h).to) - number(self.side(h).from));
        shares.max().unwrap_or(0)
    }

    /// How a side is stitched; `None` where it is free.
    pub fn stitch(&self, h: HalfEdge, target: &Target) -> Option<Stitch> {
        let side = self.side(h);
        if !self.has_sections(side.curve) {
            return None;
        }
        let Knots { all, even } = self.knots(side.curve, target);
        let within: Vec<(u32, f64)> = all.iter().copied().filter(|k| side.from <= k.1 && k.1 <= side.to).collect();
        let (low, high) = (within.first()?.0, within.last()?.0);
        Some(Stitch {
            range: if side.against { [high, low] } else { [low, high] },
            segments: all.last()?.0,
            knots: if even { Vec::new() } else { within },
        })
    }

    /// Where to cut a patch that has to be cut, for its side `h`.
    fn cut_for(&self, h: HalfEdge, target: &Target, seen: bool) -> Option<f64> {
        match self.stitch(h, target) {
            None => (seen && wanted(self.half_edge(h), target) > f64::from(MOST)).then_some(0.5),
            Some(stitch) => {
                let crowded = stitch.knots.len() > MOST_KNOTS;
                let short = seen && wanted(self.half_edge(h), target) > f64::from(MOST);
                if stitch.level() <= MOST && !crowded && !short {
                    return None;
                }
                // At a T-section, which then is none any more; the one nearest the middle.
                let at = self.sections(h).into_iter().map(|s| s.1);
                let far = |x: &f64| (x - 0.5).abs();
                at.min_by(|a, b| far(a).total_cmp(&far(b))).filter(|x| (0.1..=0.9).contains(x)).or(Some(0.5))
            }
        }
    }

    /// Where a patch has to be cut for a target; `None` where a device can draw it as it is.
    pub(super) fn has_to_be_cut(&self, p: u32, target: &Target) -> Option<(Axis, f64)> {
        let seen = target.view.is_none_or(|view| meets(&self.geometry(p), view));
        (0..4).find_map(|i| {
            let at = self.cut_for(HalfEdge::new(p, i), target, seen)?;
            Some(match i {
                0 => (Axis::U, at),
                1 => (Axis::V, at),
                2 => (Axis::U, 1.0 - at),
                _ => (Axis::V, 1.0 - at),
            })
        })
    }

    /// The mesh with patches subdivided as far as the target needs; the record of where they came from is their root.
    /// Time linear in the patches that come out.
    pub fn fit(&self, target: &Target) -> Mesh {
        let mut mesh = self.clone();
        mesh.take_journal();
        let mut waiting: BTreeSet<u32> = mesh.live().collect();
        while let Some(p) = waiting.pop_first() {
            if mesh.patches.len() > MOST_PATCHES {
                break;
            }
            let Some((axis, at)) = mesh.has_to_be_cut(p, target) else { continue };
            let Ok(split) = mesh.split(p, axis, at) else { continue };
            for part in [split.first, split.second] {
                waiting.insert(part);
                for i in 0..4 {
                    let c = mesh.side(HalfEdge::new(part, i)).curve;
                    if mesh.has_sections(c) {
                        waiting.extend(mesh.curve(c).sides.iter().flatten().map(|h| h.patch()));
                    }
                }
            }
        }
        mesh.take_journal();
        mesh
    }
}

/// Whether a patch may show in a view.
fn meets(net: &[DVec2; 16], [x0, y0, x1, y1]: [f64; 4]) -> bool {
    let low = net.iter().copied().reduce(DVec2::min).unwrap_or_default();
    let high = net.iter().copied().reduce(DVec2::max).unwrap_or_default();
    low.x <= x1 && high.x >= x0 && low.y <= y1 && high.y >= y0
}
