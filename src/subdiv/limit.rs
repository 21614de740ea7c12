//! Limit points, limit tangents and their inverses (ZHHK22 App. B; tangents LSNC09 3.2).

use super::fan::{Fan, Linear};
use crate::scene::CornerRule;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Limit of the vertex in the middle of `fan`: (B.1) with face centroids, right for n-gons; `(a + 4 v + b) / 6`
/// in an open fan; the vertex itself where one face is a sharp corner; a rule of its own at a dart.
pub fn limit<V: Linear>(fan: &Fan<V>, corners: CornerRule) -> V {
    if !fan.closed {
        if fan.faces() == 1 && corners == CornerRule::Sharp {
            return fan.centre;
        }
        let ends = fan.spoke[0] + fan.spoke[fan.spoke.len() - 1];
        return ends * (1.0 / 6.0) + fan.centre * (4.0 / 6.0);
    }
    if let Some(sharp) = fan.dart {
        let (own, rest, total) = dart_weights(fan, sharp);
        return (fan.centre * own + rest) * (1.0 / total);
    }
    let n = fan.faces() as f64;
    let mut sum = V::default();
    for (spoke, face) in fan.spoke.iter().zip(&fan.face) {
        sum = sum + (fan.centre + *spoke) * 0.5 + *face;
    }
    fan.centre * ((n - 3.0) / (n + 5.0)) + sum * (4.0 / (n * (n + 5.0)))
}

/// The limit at a dart, where the smooth rule (B.1) is off by about a hundredth of the jump: the far end of the
/// sharp spoke does not hear of the faces beside it. Weight of the vertex, weighted sum of the ring, sum of weights.
///
/// The weights are the left eigenvector of the ring's step. With the vertex at n^2, spoke i from the sharp one has
/// b_i where `7 b_i = 20 + b_(i-1) + b_(i+1)`, b_0 = b_n = 0, face corner i has `c_i = (4 + b_i + b_(i+1)) / 12`, and
/// each side of the sharp spoke `1 + 2 c_0`. Without a sharp spoke b would be 4 and c 1, which is (B.1).
fn dart_weights<V: Linear>(fan: &Fan<V>, sharp: usize) -> (f64, V, f64) {
    let n = fan.faces();
    // b - 4 solves x_(i-1) + x_(i+1) = 7 x_i.
    let rate = 3.5f64.acosh();
    let half = 0.5 * n as f64;
    let spoke = |i: usize| 4.0 - 4.0 * ((i as f64 - half) * rate).cosh() / (half * rate).cosh();
    let corner = |i: usize| (4.0 + spoke(i) + spoke(i + 1)) / 12.0;
    let own = (n * n) as f64;
    let (mut rest, mut total) = (V::default(), own);
    for i in 0..n {
        let k = (sharp + i) % n;
        let along = if i == 0 { 2.0 * (1.0 + 2.0 * corner(0)) } else { spoke(i) };
        rest = rest + fan.spoke[k] * along + fan.opposite[k] * corner(i);
        total += along + corner(i);
    }
    (own, rest, total)
}

/// The control value that gives the limit `wanted` while the neighbours stay: (B.2) and its boundary forms.
/// `face_valence[i]` are the corners of face i, which hold the vertex too.
pub fn control_for_limit<V: Linear>(fan: &Fan<V>, face_valence: &[u32], wanted: V, corners: CornerRule) -> V {
    if !fan.closed {
        if fan.faces() == 1 && corners == CornerRule::Sharp {
            return wanted;
        }
        let ends = fan.spoke[0] + fan.spoke[fan.spoke.len() - 1];
        return (wanted * 6.0 - ends) * 0.25;
    }
    if let Some(sharp) = fan.dart {
        let (own, rest, total) = dart_weights(fan, sharp);
        return (wanted * total - rest) * (1.0 / own);
    }
    let n = fan.faces() as f64;
    let weight = 4.0 / (n * (n + 5.0));
    let mut rest = V::default();
    let mut own = n / 2.0;
    for ((spoke, face), &corners) in fan.spoke.iter().zip(&fan.face).zip(face_valence) {
        let share = 1.0 / f64::from(corners);
        rest = rest + *spoke * 0.5 + (*face - fan.centre * share);
        own += share;
    }
    (wanted - rest * weight) * (1.0 / ((n - 3.0) / (n + 5.0) + weight * own))
}

/// `cos(i pi / n)`, from a table for the valences one meets.
pub fn cosine(i: usize, n: usize) -> f64 {
    const TABLED: usize = 16;
    static TABLE: OnceLock<Vec<f64>> = OnceLock::new();
    if n > TABLED || n == 0 {
        return (PI * i as f64 / n as f64).cos();
    }
    let table = TABLE.get_or_init(|| {
        let row =
            |n: usize| (0..2 * TABLED).map(move |i| if 2 * i == n { 0.0 } else { (PI * i as f64 / n as f64).cos() });
        (1..=TABLED).flat_map(row).collect()
    });
    table[(n - 1) * 2 * TABLED + i % (2 * n)]
}

/// `lambda(n)`, the subdominant eigenvalue of Catmull-Clark at valence n (LSNC09 eq. 5 has 16 times this plus 5).
pub fn subdominant(n: usize) -> f64 {
    let (c, c2) = (cosine(1, n), cosine(2, n));
    (5.0 + c2 + c * (18.0 + 2.0 * c2).sqrt()) / 16.0
}

/// Weights of the tangent across a boundary or crease with `k` faces (two or more) on one side: of the vertex, of both end
/// spokes each, of inner spoke i per `sin(i pi / k)`. The corner opposite in face i weighs `sin(i pi / k) + sin((i + 1) pi / k)`.
///
/// It is the left eigenvector of the step that vanishes towards both ends; inside it is that of a smooth vertex with 2 k
/// faces. With `l` the eigenvalue, the entries of vertex and ends follow from their own columns:
/// `(l - 1/2) end - vertex / 8 = sin(pi / k) (edge / 16 + 1/4)`, `(l - 3/4) vertex - end = cot(pi / 2 k) (3 edge / 8 + 1/2)`.
pub fn across_weights(k: usize) -> [f64; 3] {
    let theta = PI / k as f64;
    let (sin, cos) = theta.sin_cos();
    let root = (0.5 * theta).cos() * (2.0 * (9.0 + cos)).sqrt();
    let (edge, l) = (1.0 + cos + root, (5.0 + cos + root) / 16.0);
    let of_end = sin * (edge / 16.0 + 0.25);
    let of_vertex = (0.375 * edge + 0.5) / (0.5 * theta).tan();
    let (a, d) = (l - 0.5, l - 0.75);
    let determinant = a * d - 0.125;
    [(a * of_vertex + of_end) / determinant, (of_end * d + 0.125 * of_vertex) / determinant, edge]
}

/// Limit tangent along spoke `j` as it enters a Gregory patch: `q` of LSNC09 3.3 inside; in an open fan the same on a plane
/// through the limit's tangents along and across the boundary.
pub fn tangent<V: Linear>(fan: &Fan<V>, j: usize) -> V {
    if fan.closed {
        return closed_tangent(fan, j);
    }
    let k = fan.faces();
    let along = (fan.spoke[0] - fan.spoke[k]) * 0.5;
    if k == 1 {
        // The boundary curve runs straight through.
        return along * (PI * j as f64).cos();
    }
    let theta = PI / k as f64;
    let [vertex, end, edge] = across_weights(k);
    let mut across = fan.centre * vertex + (fan.spoke[0] + fan.spoke[k]) * end;
    for i in 1..k {
        across = across + fan.spoke[i] * (edge * (theta * i as f64).sin());
    }
    for (i, opposite) in fan.opposite.iter().enumerate() {
        across = across + *opposite * ((theta * i as f64).sin() + (theta * (i + 1) as f64).sin());
    }
    // As long as inside a fan of 2 k faces that is the mirror image of itself.
    let c = (0.5 * theta).cos();
    across = across * (1.0 / (2.0 * k as f64 * c * (4.0 + c * c).sqrt()));
    along * (theta * j as f64).cos() + across * (theta * j as f64).sin()
}

fn closed_tangent<V: Linear>(fan: &Fan<V>, j: usize) -> V {
    let mut q = V::default();
    let n = fan.faces();
    let c = cosine(1, n);
    let sigma = 1.0 / (4.0 + c * c).sqrt();
    for i in 0..n {
        let k = (j + i) % n;
        let middle = (fan.centre + fan.spoke[k]) * 0.5;
        let along = (1.0 - sigma * c) * cosine(2 * i, n);
        let aside = 2.0 * sigma * cosine(2 * i + 1, n);
        q = q + middle * along + fan.face[k] * aside;
    }
    q * (2.0 / n as f64)
}

/// [`tangent`] by OpenSubdiv's and the authors' formula, which in open fans of other than two faces is not the limit's.
fn authors_tangent<V: Linear>(fan: &Fan<V>, j: usize) -> V {
    if fan.closed {
        return closed_tangent(fan, j);
    }
    let k = fan.faces();
    let kf = k as f64;
    let (c, s) = ((PI / kf).cos(), (PI / kf).sin());
    let (first, last) = (fan.spoke[0], fan.spoke[k]);
    let r0 = (first - last) * 0.5;
    // At k = 1 the root is 0 / 2: no transversal tangent, the boundary curve runs straight through.
    let root = ((1.0 + c) / (1.0 - c)).max(0.0).sqrt();
    let mut r1 = fan.centre * (-4.0 * s) - (first + last) * ((1.0 + 2.0 * c) * root);
    for i in 1..k {
        r1 = r1 + fan.spoke[i] * (4.0 * (PI * i as f64 / kf).sin());
    }
    for (i, opposite) in fan.opposite.iter().enumerate() {
        r1 = r1 + *opposite * ((PI * i as f64 / kf).sin() + (PI * (i + 1) as f64 / kf).sin());
    }
    r1 = r1 * (1.0 / (3.0 * kf + c));
    r0 * (PI * j as f64 / kf).cos() + r1 * (PI * j as f64 / kf).sin()
}

/// Bezier point next to the vertex on spoke `j` of a Gregory patch: `e = p + 2/3 lambda q` (LSNC09 3.3);
/// at a sharp corner a third of the way along the edge.
pub fn edge_point<V: Linear>(fan: &Fan<V>, j: usize, corners: CornerRule) -> V {
    edge_point_by(fan, j, corners, tangent)
}

/// [`edge_point`] as the authors' tool has it.
pub fn authors_edge_point<V: Linear>(fan: &Fan<V>, j: usize, corners: CornerRule) -> V {
    edge_point_by(fan, j, corners, authors_tangent)
}

fn edge_point_by<V: Linear>(fan: &Fan<V>, j: usize, corners: CornerRule, tangent: fn(&Fan<V>, usize) -> V) -> V {
    let k = fan.faces();
    if !fan.closed && k == 1 && corners == CornerRule::Sharp {
        return fan.centre + (fan.spoke[j] - fan.centre) * (1.0 / 3.0);
    }
    let n = if fan.closed { k } else { 2 * k };
    limit(fan, corners) + tangent(fan, j) * (2.0 / 3.0 * subdominant(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec4};

    fn regular() -> Fan<DVec2> {
        let grid = |x: f64, y: f64| DVec2::new(x + 0.1 * y * y, y - 0.2 * x * y);
        let ring = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        let diag = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let mut fan = Fan { centre: grid(0.0, 0.0), closed: true, half_edge: vec![0, 1, 2, 3], ..Default::default() };
        for i in 0..4 {
            let j = (i + 1) % 4;
            fan.spoke.push(grid(ring[i].0, ring[i].1));
            fan.opposite.push(grid(diag[i].0, diag[i].1));
            fan.face.push(
                (fan.centre + grid(ring[i].0, ring[i].1) + grid(diag[i].0, diag[i].1) + grid(ring[j].0, ring[j].1))
                    * 0.25,
            );
        }
        fan
    }

    #[test]
    fn valence_four_is_the_bicubic_b_spline() {
        let fan = regular();
        let spokes: DVec2 = fan.spoke.iter().sum();
        let corners: DVec2 = fan.opposite.iter().sum();
        let p = (16.0 * fan.centre + 4.0 * spokes + corners) / 36.0;
        assert!((limit(&fan, CornerRule::Sharp) - p).length() < 1e-15);
        let e = (8.0 * fan.centre
            + 4.0 * fan.spoke[0]
            + 2.0 * (fan.spoke[1] + fan.spoke[3])
            + (fan.opposite[0] + fan.opposite[3]))
            / 18.0;
        assert!((edge_point(&fan, 0, CornerRule::Sharp) - e).length() < 1e-15);
    }

    #[test]
    fn inverting_a_limit_gives_it_back_at_every_valence() {
        for n in 3..9usize {
            let at = |r: f64, t: f64| DVec2::from_angle(t * 2.0 * PI / n as f64) * r;
            let mut fan = Fan { centre: DVec2::new(0.1, 0.2), closed: true, ..Default::default() };
            for i in 0..n {
                let (a, c, b) = (at(1.0, i as f64), at(1.4, i as f64 + 0.5), at(1.0, i as f64 + 1.0));
                fan.spoke.push(a);
                fan.opposite.push(c);
                fan.face.push((fan.centre + a + c + b) * 0.25);
            }
            let wanted = DVec2::new(-0.3, 0.05);
            let v = control_for_limit(&fan, &vec![4; n], wanted, CornerRule::Sharp);
            for i in 0..n {
                let (a, c, b) = (fan.spoke[i], fan.opposite[i], fan.spoke[(i + 1) % n]);
                fan.face[i] = (v + a + c + b) * 0.25;
            }
            fan.centre = v;
            assert!((limit(&fan, CornerRule::Sharp) - wanted).length() < 1e-14, "valence {n}");
        }
    }

    #[test]
    fn a_smooth_boundary_vertex_has_its_curve() {
        // Two faces: regular boundary. The tangent along the boundary is half the chord, across it the B-spline's.
        let fan = Fan {
            centre: DVec2::ZERO,
            spoke: vec![DVec2::X, DVec2::Y, -DVec2::X],
            opposite: vec![DVec2::new(1.0, 1.0), DVec2::new(-1.0, 1.0)],
            face: vec![DVec2::new(0.5, 0.5), DVec2::new(-0.5, 0.5)],
            closed: false,
            half_edge: vec![0, 1],
            dart: None,
        };
        assert_eq!(limit(&fan, CornerRule::Sharp), DVec2::ZERO);
        assert!((edge_point(&fan, 0, CornerRule::Sharp) - DVec2::X / 3.0).length() < 1e-15);
        assert!((edge_point(&fan, 1, CornerRule::Sharp) - DVec2::Y / 3.0).length() < 1e-15);
    }

    /// The fan one step finer.
    fn step(fan: &Fan<DVec4>) -> Fan<DVec4> {
        let k = fan.faces();
        let mut next = Fan { centre: fan.centre * 0.75 + (fan.spoke[0] + fan.spoke[k]) * 0.125, ..Fan::default() };
        for i in 0..=k {
            let sharp = (fan.centre + fan.spoke[i]) * 0.5;
            next.spoke.push(match i {
                0 => sharp,
                i if i == k => sharp,
                i => sharp * 0.5 + (fan.face[i - 1] + fan.face[i]) * 0.25,
            });
        }
        next.opposite = fan.face.clone();
        for i in 0..k {
            next.face.push((next.centre + next.spoke[i] + next.opposite[i] + next.spoke[i + 1]) * 0.25);
        }
        next.half_edge = fan.half_edge.clone();
        next
    }

    #[test]
    fn tangents_of_open_fans_lie_in_the_plane_that_steps_converge_to() {
        for k in 2..8usize {
            let bumpy = |r: f64, t: f64| {
                let a = t * PI / k as f64;
                DVec4::new(r * a.cos(), 1.2 * r * a.sin(), 0.3 * (2.0 * t + r).sin() + 0.2 * r * t, 0.0)
            };
            let mut fan = Fan { centre: bumpy(0.0, 0.0), half_edge: (0..k as u32).collect(), ..Fan::default() };
            fan.spoke = (0..=k).map(|i| bumpy(1.0, i as f64)).collect();
            fan.opposite = (0..k).map(|i| bumpy(1.5, i as f64 + 0.5)).collect();
            for i in 0..k {
                fan.face.push((fan.centre + fan.spoke[i] + fan.opposite[i] + fan.spoke[i + 1]) * 0.25);
            }
            let normal = |a: DVec4, b: DVec4| a.truncate().cross(b.truncate()).normalize();
            let plane = |fan: &Fan<DVec4>, by: fn(&Fan<DVec4>, usize) -> DVec4| normal(by(fan, 0), by(fan, 1));
            // A step changes neither the plane nor, but for the eigenvalue, the tangent across.
            let here = plane(&fan, tangent);
            assert!(here.angle_between(plane(&step(&fan), tangent)) < 1e-7, "{k}");
            if k % 2 == 0 {
                let [a, b] = [tangent(&fan, k / 2), tangent(&step(&fan), k / 2)];
                assert!((a * subdominant(2 * k) - b).length() < 1e-14, "{k}: {a} {b}");
            }
            // Other eigenvectors fade the slower the more faces there are.
            if k <= 4 {
                let mut deep = fan.clone();
                for _ in 0..36 {
                    deep = step(&deep);
                }
                let p = limit(&fan, CornerRule::Smooth);
                let seen = normal(deep.spoke[0] - deep.spoke[k], deep.spoke[k / 2] - p);
                assert!(seen.angle_between(here) < 2e-3, "{k}: {seen} {here}");
            }
            // With two faces both formulas are the B-spline's; with more the other one is off.
            let off = here.angle_between(plane(&fan, authors_tangent));
            assert_eq!(off < 1e-2, k == 2, "{k}: {off}");
        }
    }
}
