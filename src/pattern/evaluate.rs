//! Evaluation of a triangle at barycentric weights: the CPU twin of `glsl/inc/pattern.glsl`.
//!
//! Sums are grouped so that on an edge, where one weight is 0, exactly two terms of each group are left, and a sum of two
//! does not depend on their order: both triangles of an edge get the same bits.

use super::control::{Control, Evaluator};
use super::displace::Displacement;
use glam::{DVec2, DVec3, DVec4};

/// A point of the refined mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position, displaced.
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    /// sRGB, straight alpha.
    pub colour: DVec4,
    /// Texture coordinates.
    pub uv: DVec2,
}

/// Position before displacement: b(u, v) of eq. (1), with the binomial factors that the paper's sum leaves out.
pub fn position(c: &Control, evaluator: Evaluator, [w, u, v]: [f64; 3]) -> DVec3 {
    let b = &c.points;
    if evaluator == Evaluator::Linear {
        return (b[0] * w + b[1] * u) + b[2] * v;
    }
    let corners = (b[0] * (w * w * w) + b[1] * (u * u * u)) + b[2] * (v * v * v);
    let e01 = b[3] * (w * w * u) + b[4] * (u * u * w);
    let e12 = b[5] * (u * u * v) + b[6] * (v * v * u);
    let e20 = b[7] * (v * v * w) + b[8] * (w * w * v);
    (corners + ((e01 + e12) + e20) * 3.0) + b[9] * (6.0 * (u * v * w))
}

/// Direction of a field of normals, eq. (2) as printed, without binomial factors; not unit.
pub fn field(n: &[DVec3; 6], [w, u, v]: [f64; 3]) -> DVec3 {
    let corners = (n[0] * (w * w) + n[1] * (u * u)) + n[2] * (v * v);
    let middles = (n[3] * (w * u) + n[4] * (u * v)) + n[5] * (v * w);
    corners + middles
}

/// Evaluates a triangle: position, normal, colour and texture coordinates.
pub fn evaluate(c: &Control, evaluator: Evaluator, displacement: &Displacement, weights: [f64; 3]) -> Point {
    let [w, u, v] = weights;
    let base = position(c, evaluator, weights);
    let normal = field(&c.normals, weights).normalize_or(DVec3::Z);
    let uv = (c.uv[0] * w + c.uv[1] * u) + c.uv[2] * v;
    let colour = (c.colours[0] * w + c.colours[1] * u) + c.colours[2] * v;
    if matches!(displacement, Displacement::None) {
        return Point { position: base, normal, colour, uv };
    }
    let direction = field(&c.directions, weights).normalize_or(DVec3::Z);
    let (height, gradient) = displacement.at(base, uv, c.uv_gradient);
    // First order: what of the gradient lies in the surface tilts the normal.
    let tilted = normal - (gradient - normal * gradient.dot(normal));
    Point { position: base + direction * height, normal: tilted.normalize_or(normal), colour, uv }
}

#[cfg(test)]
mod tests {
    use super::super::control::NormalField;
    use super::super::displace::{Noise, Sine};
    use super::super::lattice::RefinementPattern;
    use super::super::mesh::{CoarseMesh, Tag};
    use super::*;

    fn pair() -> CoarseMesh {
        let mut mesh = CoarseMesh {
            positions: [[0.1, 0.2, 0.0], [1.3, 0.0, 0.4], [0.2, 1.1, -0.3], [1.5, 1.3, 0.7]].map(DVec3::from).to_vec(),
            normals: [[0.2, -0.3, 1.0], [0.4, 0.1, 0.8], [-0.3, 0.3, 0.9], [0.6, 0.2, 0.5]].map(DVec3::from).to_vec(),
            colours: (0..4).map(|i| DVec4::new(0.2 * f64::from(i), 0.3, 0.9 - 0.1 * f64::from(i), 1.0)).collect(),
            uv: [[0.0, 0.0], [1.0, 0.1], [0.0, 0.9], [1.0, 1.0]].map(DVec2::from).to_vec(),
            tags: Vec::new(),
            triangles: vec![[0, 1, 2], [2, 1, 3]],
        };
        mesh.complete_normals();
        mesh
    }

    fn displacements() -> [Displacement; 3] {
        [
            Displacement::None,
            Displacement::Sine(Sine { amplitude: 0.1, frequency: 7.0 }),
            Displacement::Noise(Noise { amplitude: 0.2, frequency: 2.0, octaves: 4, ..Noise::default() }),
        ]
    }

    #[test]
    fn corners_are_interpolated_exactly() {
        let mesh = pair();
        for evaluator in [Evaluator::Linear, Evaluator::Pn, Evaluator::St] {
            for field in [NormalField::Vlachos, NormalField::Boubekeur, NormalField::Linear] {
                let c = Control::new(&mesh, 0, evaluator, field);
                for corner in 0..3 {
                    let mut weights = [0.0; 3];
                    weights[corner] = 1.0;
                    let point = evaluate(&c, evaluator, &Displacement::None, weights);
                    assert_eq!(point.position, mesh.positions[corner]);
                    assert!((point.normal - mesh.normals[corner]).length() < 1e-15);
                    assert_eq!(point.colour, mesh.colours[corner]);
                }
            }
        }
    }

    #[test]
    fn neighbours_share_their_edge_bit_for_bit() {
        let mut mesh = pair();
        let crease = Tag { tension: 0.3, sharpness: 0.8, bias: 0.4, deviation: DVec3::new(0.3, 0.2, 0.1) };
        for tags in [vec![], vec![Tag::NEUTRAL, crease, crease, Tag::NEUTRAL]] {
            mesh.tags = tags;
            for evaluator in [Evaluator::Linear, Evaluator::Pn, Evaluator::St] {
                let [a, b] = [0, 1].map(|t| Control::new(&mesh, t, evaluator, NormalField::Vlachos));
                for displacement in displacements() {
                    for level in [1, 3, 64, 100] {
                        for k in 0..=level {
                            let (s, t) = ((level - k) as f32 / level as f32, k as f32 / level as f32);
                            let (s, t) = (f64::from(s), f64::from(t));
                            // Edge 1-2 of the first is edge 1-0 of the second.
                            let p = evaluate(&a, evaluator, &displacement, [0.0, s, t]);
                            let q = evaluate(&b, evaluator, &displacement, [t, s, 0.0]);
                            assert_eq!(p.position, q.position);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn linear_coefficients_give_the_flat_triangle() {
        let mesh = pair();
        let c = Control::new(&mesh, 0, Evaluator::Linear, NormalField::Vlachos);
        for w in RefinementPattern::triangle(9).unwrap().weights {
            let w = w.map(f64::from);
            let cubic = position(&c, Evaluator::Pn, w);
            assert!((cubic - position(&c, Evaluator::Linear, w)).length() < 1e-6);
        }
    }

    #[test]
    fn tilted_normals_agree_with_differences() {
        // On a flat triangle, where the first-order formula is exact.
        let mut mesh = pair();
        mesh.positions.iter_mut().for_each(|p| p.z = 0.0);
        mesh.normals.iter_mut().for_each(|n| *n = DVec3::Z);
        let c = Control::new(&mesh, 0, Evaluator::Linear, NormalField::Linear);
        for displacement in displacements() {
            for weights in [[0.2, 0.5, 0.3], [0.6, 0.15, 0.25]] {
                let at = |du: f64, dv: f64| {
                    let [w, u, v] = weights;
                    evaluate(&c, Evaluator::Linear, &displacement, [w - du - dv, u + du, v + dv])
                };
                let e = 1e-5;
                let du = at(e, 0.0).position - at(-e, 0.0).position;
                let dv = at(0.0, e).position - at(0.0, -e).position;
                let expected = du.cross(dv).normalize();
                assert!((at(0.0, 0.0).normal - expected).length() < 1e-6, "{displacement:?}");
            }
        }
    }
}
