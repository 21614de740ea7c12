//! The triangles that the device's tessellator makes of a domain with integer levels and equal spacing.
//!
//! The order of the D3D11 reference tessellator, which Mesa's software device and most hardware follow: rings around
//! rings, each side of a ring stitched to the next ring inwards, at last a point, a quad or a triangle. Between the border
//! and the first ring, either row steps on where the next finer split of an edge would put a vertex (the ruler function),
//! the second half mirroring the first; between inner rings, quads are cut by diagonals that lean inwards. Coordinates
//! inside have 16 bits, those on the border are exact, as the evaluation shaders make them.

/// Vertices and triangles of a domain, counter-clockwise in its coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Domain {
    /// u, v; in a triangle the weights of its second and third corner.
    pub points: Vec<[f64; 2]>,
    /// Three of `points` each.
    pub triangles: Vec<[u32; 3]>,
}

/// 1 in the tessellator's numbers.
const ONE: u32 = 1 << 16;

/// k / n as the tessellator has it: a rounded reciprocal is multiplied, up to the middle, and mirrored.
fn placed(k: u32, n: u32) -> u32 {
    match 2 * k {
        twice if twice == n => ONE / 2,
        twice if twice < n => k * ((ONE + n / 2) / n),
        _ => ONE - placed(n - k, n),
    }
}

/// A quad with `outer` segments along v = 0, u = 1, v = 1 and u = 0 and `inner` ones both ways, from 1 to 64 each.
pub fn quad(outer: [u32; 4], inner: u32) -> Domain {
    let border = |side: usize, t: f64| match side {
        0 => [t, 0.0],
        1 => [1.0, t],
        2 => [1.0 - t, 1.0],
        _ => [0.0, 1.0 - t],
    };
    let inside = |n: u32, ring: u32, side: usize, k: u32| {
        let [near, far] = [ring, n - ring];
        let [u, v] = match side {
            0 => [near + k, near],
            1 => [far, near + k],
            2 => [far - k, far],
            _ => [near, far - k],
        };
        [u, v].map(|i| f64::from(placed(i, n)) / f64::from(ONE))
    };
    rings(&outer, inner, &border, &inside)
}

/// A triangle with `outer` segments from its first corner to the second, on to the third and back, and `inner` ones.
pub fn triangle(outer: [u32; 3], inner: u32) -> Domain {
    let border = |side: usize, t: f64| match side {
        0 => [t, 0.0],
        1 => [1.0 - t, t],
        _ => [0.0, 1.0 - t],
    };
    let inside = |n: u32, ring: u32, side: usize, k: u32| {
        // The weight that is constant along the side, and the one that a row of points is placed by. First corner's: x.
        let away = (placed(ring, n) * 0xAAAB + ONE / 2) >> 16;
        let along = |i: u32| placed(i, n) - away.div_ceil(2);
        let [x, y] = match side {
            _ if 2 * ring == n => [0x5555; 2],
            0 => {
                let x = along(n - ring - k);
                [x, ONE - x - away]
            }
            1 => [away, along(n - ring - k)],
            _ => [along(ring + k), away],
        };
        [y, ONE - x - y].map(|i| f64::from(i) / f64::from(ONE))
    };
    rings(&outer, inner, &border, &inside)
}

fn rings(
    outer: &[u32],
    inner: u32,
    border: &dyn Fn(usize, f64) -> [f64; 2],
    inside: &dyn Fn(u32, u32, usize, u32) -> [f64; 2],
) -> Domain {
    let mut made = Domain::default();
    // The tessellator raises an inner level of 1 when another level is greater.
    let n = if outer.iter().all(|&n| n == 1) { inner } else { inner.max(2) };
    let mut rows = ring(&mut made, outer, &|side, k| border(side, f64::from(k) / f64::from(outer[side])));
    for r in 1..=n / 2 {
        let next = ring(&mut made, &vec![n - 2 * r; outer.len()], &|side, k| inside(n, r, side, k));
        for (outer, inner) in rows.iter().zip(&next) {
            let mut stitch = Stitch { outer, inner, at: [0; 2], triangles: &mut made.triangles };
            if r == 1 {
                stitch.by_ruler(n);
            } else {
                stitch.by_quads();
            }
        }
        rows = next;
    }
    if n % 2 == 1 {
        match rows.iter().map(|row| row[0]).collect::<Vec<u32>>()[..] {
            [a, b, c, d] => made.triangles.extend([[d, b, c], [d, a, b]]),
            ref corners => made.triangles.push(std::array::from_fn(|i| corners[i])),
        }
    }
    made
}

/// The vertices of a ring by sides, each with the next one's first at its end; of a ring without segments, its only one.
fn ring(made: &mut Domain, segments: &[u32], place: &dyn Fn(usize, u32) -> [f64; 2]) -> Vec<Vec<u32>> {
    let first = made.points.len() as u32;
    if segments.iter().all(|&n| n == 0) {
        made.points.push(place(0, 0));
        return vec![vec![first]; segments.len()];
    }
    let mut rows: Vec<Vec<u32>> = Vec::new();
    for (side, &n) in segments.iter().enumerate() {
        let start = made.points.len() as u32;
        made.points.extend((0..n).map(|k| place(side, k)));
        rows.push((start..=start + n).collect());
    }
    if let Some(end) = rows.last_mut().and_then(|row| row.last_mut()) {
        *end = first;
    }
    rows
}

/// When the vertex at k/32 of half an edge comes, where halves are split again and again: first the middle (1), then the
/// quarters (2, 3), and on. k from 1 to 31.
fn ruler(k: u32) -> usize {
    let zeros = k.trailing_zeros();
    (1 << (4 - zeros)) + (k as usize >> (zeros + 1))
}

/// Two rows of vertices and how far along them triangles are.
struct Stitch<'a> {
    outer: &'a [u32],
    inner: &'a [u32],
    /// In `outer`, in `inner`.
    at: [usize; 2],
    triangles: &'a mut Vec<[u32; 3]>,
}

impl Stitch<'_> {
    fn step_outer(&mut self) {
        let [o, i] = self.at;
        self.triangles.push([self.outer[o], self.outer[o + 1], self.inner[i]]);
        self.at[0] += 1;
    }

    fn step_inner(&mut self) {
        let [o, i] = self.at;
        self.triangles.push([self.inner[i], self.outer[o], self.inner[i + 1]]);
        self.at[1] += 1;
    }

    /// The border to the first ring of a domain with inner level `n`.
    fn by_ruler(&mut self, n: u32) {
        let outer = self.outer.len() as u32 - 1;
        let [outer_half, inner_half] = [outer, n].map(|n| n as usize / 2);
        if outer_half > 0 {
            self.step_outer();
        }
        for k in 1..32 {
            if ruler(k) < inner_half {
                self.step_inner();
            }
            if ruler(k) < outer_half {
                self.step_outer();
            }
        }
        // The middle: of odd rows a segment each.
        if n % 2 == 1 {
            self.step_inner();
        }
        if outer % 2 == 1 {
            self.step_outer();
        }
        for k in (1..32).rev() {
            if ruler(k) < outer_half {
                self.step_outer();
            }
            if ruler(k) < inner_half {
                self.step_inner();
            }
        }
        if outer_half > 0 {
            self.step_outer();
        }
    }

    /// A ring to the next, which has two segments a side less.
    fn by_quads(&mut self) {
        let quads = self.inner.len() - 1;
        self.step_outer();
        for k in 0..quads {
            // Outwards to inwards up to the middle, then the other way.
            if k < self.inner.len() / 2 {
                self.step_inner();
                self.step_outer();
            } else {
                self.step_outer();
                self.step_inner();
            }
        }
        self.step_outer();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::triangles;

    fn covered(domain: &Domain, whole: f64) {
        let at = |i: u32| domain.points[i as usize];
        let areas: Vec<f64> = domain
            .triangles
            .iter()
            .map(|t| t.map(at))
            .map(|[a, b, c]| 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])))
            .collect();
        assert!(areas.iter().all(|&area| area > 1e-6), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-12);
    }

    #[test]
    fn domains_are_covered_once_by_as_many_triangles_as_the_formula_has() {
        for n in (1..=12).chain([31, 32, 63, 64]) {
            for m in [1, 2, 3, 5, 8, 2 * n.min(32)] {
                for outer in [[n; 4], [m, n, n, n], [n, m, n, m], [1, 1, m, 1]] {
                    let made = quad(outer, n);
                    assert_eq!(made.triangles.len() as u64, triangles::quad(outer.map(u64::from), [n.into(); 2]));
                    covered(&made, 1.0);
                    let outer = [outer[0], outer[1], outer[2]];
                    let made = triangle(outer, n);
                    assert_eq!(made.triangles.len() as u64, triangles::triangle(outer.map(u64::from), n.into()));
                    covered(&made, 0.5);
                }
            }
        }
    }

    #[test]
    fn the_ruler_puts_every_split_once() {
        let mut seen: Vec<usize> = (1..32).map(ruler).collect();
        assert_eq!([16, 8, 24, 4, 12].map(ruler), [1, 2, 3, 4, 5]);
        seen.sort_unstable();
        assert_eq!(seen, (1..32).collect::<Vec<_>>());
    }

    #[test]
    fn inner_coordinates_are_the_tessellators() {
        assert_eq!([1, 2, 3, 4].map(|k| placed(k, 6)), [10923, 21846, 32768, 43690]);
        assert_eq!(placed(3, 7), 3 * 9362);
    }
}
