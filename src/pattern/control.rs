//! Coefficients of curved triangles: curved PN triangles (BS05 App. A) and scalar tagged ones (App. B).

use super::mesh::{CoarseMesh, Tag};
use glam::{DVec2, DVec3, DVec4};

/// What a coarse triangle becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Evaluator {
    /// The flat triangle with linear normals (BS05 3.2).
    Linear,
    /// Curved PN triangles (App. A).
    #[default]
    Pn,
    /// Scalar tagged PN triangles (App. B).
    St,
}

/// The field of normals of curved triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalField {
    /// Quadratic as in Vlachos et al. 2001: the middle coefficients are N_i + N_j reflected in the plane across the edge
    /// (factor 2) and made unit.
    #[default]
    Vlachos,
    /// Quadratic as BS05 App. A prints it (factor 4): the normal in the *middle* of an edge is that reflection.
    Boubekeur,
    /// N_i interpolated linearly.
    Linear,
}

/// Everything that the evaluation of one triangle needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Bezier points, in the order of [`super`]; of a flat triangle the corners alone count.
    pub points: [DVec3; 10],
    /// Normals at corners 0, 1, 2, then coefficients of u w, u v, v w: edges 01, 12, 20.
    pub normals: [DVec3; 6],
    /// The same of the normals that a crease does not part: along these, points are displaced, so that a crease stays
    /// closed.
    pub directions: [DVec3; 6],
    /// Colours of the corners.
    pub colours: [DVec4; 3],
    /// Texture coordinates of the corners.
    pub uv: [DVec2; 3],
    /// Gradients of the two texture coordinates in the plane of the corners.
    pub uv_gradient: [DVec3; 2],
}

/// Ends of points 3 to 8: each is near the first and on the way to the second.
pub const TANGENT_ENDS: [[usize; 2]; 6] = [[0, 1], [1, 0], [1, 2], [2, 1], [2, 0], [0, 2]];

/// N + sign sigma Delta, unit: the normal on one side of a crease.
fn sharp_normal(normal: DVec3, tag: &Tag, side: f64) -> DVec3 {
    if !tag.is_crease() || tag.sharpness == 0.0 || side == 0.0 {
        return normal;
    }
    (normal + tag.deviation * (tag.sharpness * side)).try_normalize().unwrap_or(normal)
}

/// On which side of the crease through a vertex a direction lies: 1, -1, or 0 for along it.
fn side(tag: &Tag, direction: DVec3) -> f64 {
    let dot = tag.deviation.dot(direction);
    if dot > 0.0 {
        1.0
    } else if dot < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// The tangent coefficient near vertex j on the way to k (eq. 3). It depends on the edge alone, so that both of its
/// triangles make the same one: the paper leaves open which of the two normals an edge takes, and here it is that of the
/// side to which the edge leaves. delta is 1 on edges along a crease, which are those between two tagged vertices.
fn tangent(p: [DVec3; 2], n: DVec3, tag: &Tag, along_crease: bool) -> DVec3 {
    let [pj, pk] = p;
    let d = pj + (pk - pj) * ((1.0 - tag.tension) / 3.0);
    let rise = |normal: DVec3| -normal.dot(d - pj);
    if !tag.is_crease() {
        return d + n * rise(n);
    }
    if along_crease {
        let y = (n + tag.deviation * tag.bias).try_normalize().unwrap_or(n);
        return d + y * rise(n);
    }
    let sharp = sharp_normal(n, tag, side(tag, pk - pj));
    let x = if sharp == n { n } else { (n * (1.0 - tag.sharpness) + sharp).try_normalize().unwrap_or(n) };
    d + x * rise(x)
}

/// Middle coefficient of the normals between two ends. The same bits from either side.
fn middle_normal(p: [DVec3; 2], n: [DVec3; 2], field: NormalField) -> DVec3 {
    let (edge, sum) = (p[1] - p[0], n[0] + n[1]);
    let square = edge.dot(edge);
    let factor = match field {
        // w N_0 + u N_1 = N_0 w^2 + (N_0 + N_1) w u + N_1 u^2 where u + w = 1.
        NormalField::Linear => return sum,
        NormalField::Vlachos => 2.0,
        NormalField::Boubekeur => 4.0,
    };
    let t = if square > 0.0 { factor * (edge.dot(sum) / square) } else { 0.0 };
    let reflected = sum - edge * t;
    match field {
        NormalField::Vlachos => reflected.try_normalize().unwrap_or(reflected),
        _ => reflected,
    }
}

fn normals(p: [DVec3; 3], n: [DVec3; 3], field: NormalField) -> [DVec3; 6] {
    let middle = |i: usize, j: usize| middle_normal([p[i], p[j]], [n[i], n[j]], field);
    [n[0], n[1], n[2], middle(0, 1), middle(1, 2), middle(2, 0)]
}

impl Control {
    /// The coefficients of a triangle of `mesh`. With [`Evaluator::Pn`] tags do not count; with [`Evaluator::Linear`]
    /// normals are linear.
    pub fn new(mesh: &CoarseMesh, triangle: usize, evaluator: Evaluator, field: NormalField) -> Control {
        let v = mesh.triangles[triangle];
        let p = v.map(|v| mesh.positions[v as usize]);
        let n = v.map(|v| mesh.normals[v as usize]);
        let tags = v.map(|v| if evaluator == Evaluator::St { mesh.tag(v) } else { Tag::NEUTRAL });
        let field = if evaluator == Evaluator::Linear { NormalField::Linear } else { field };
        let mut points = [DVec3::ZERO; 10];
        points[..3].copy_from_slice(&p);
        for (i, [j, k]) in TANGENT_ENDS.into_iter().enumerate() {
            let along_crease = tags[j].is_crease() && tags[k].is_crease();
            points[3 + i] = match evaluator {
                Evaluator::Linear => p[j] + (p[k] - p[j]) / 3.0,
                _ => tangent([p[j], p[k]], n[j], &tags[j], along_crease),
            };
        }
        // b_111 = E + (E - V) / 2; the paper's last bracket lacks b_003.
        let edges: DVec3 = points[3..9].iter().sum();
        points[9] = edges / 4.0 - (p[0] + p[1] + p[2]) / 6.0;
        // The side on which the triangle lies: that of the sum of its two edges from the corner.
        let sharp = std::array::from_fn(|i| {
            let across = (p[(i + 1) % 3] - p[i]) + (p[(i + 2) % 3] - p[i]);
            sharp_normal(n[i], &tags[i], side(&tags[i], across))
        });
        let uv = v.map(|v| mesh.uv.get(v as usize).copied().unwrap_or_default());
        Control {
            points,
            normals: normals(p, sharp, field),
            directions: normals(p, n, field),
            colours: v.map(|v| mesh.colours.get(v as usize).copied().unwrap_or(DVec4::ONE)),
            uv,
            uv_gradient: uv_gradient(p, uv),
        }
    }
}

/// Vectors g_s and g_t in the triangle's plane with g . (P_j - P_i) = the difference of the coordinate; null where the
/// triangle has no area.
fn uv_gradient(p: [DVec3; 3], uv: [DVec2; 3]) -> [DVec3; 2] {
    let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
    let (a, b, c) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
    let det = a * c - b * b;
    if det.is_nan() || det <= 1e-24 * a * c {
        return [DVec3::ZERO; 2];
    }
    let (f1, f2) = (uv[1] - uv[0], uv[2] - uv[0]);
    [0, 1].map(|i| (e1 * (c * f1[i] - b * f2[i]) + e2 * (a * f2[i] - b * f1[i])) / det)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> CoarseMesh {
        CoarseMesh {
            positions: vec![DVec3::new(0.1, 0.2, 0.0), DVec3::new(1.3, 0.0, 0.4), DVec3::new(0.2, 1.1, -0.3)],
            normals: [[0.2, -0.3, 1.0], [0.4, 0.1, 0.8], [-0.3, 0.3, 0.9]].map(|n| DVec3::from(n).normalize()).to_vec(),
            triangles: vec![[0, 1, 2]],
            ..CoarseMesh::default()
        }
    }

    #[test]
    fn pn_coefficients_are_those_of_the_paper() {
        let mesh = triangle();
        let c = Control::new(&mesh, 0, Evaluator::Pn, NormalField::Vlachos);
        let (p, n) = (&mesh.positions, &mesh.normals);
        let b = |i: usize, j: usize| (2.0 * p[i] + p[j] - n[i] * (p[j] - p[i]).dot(n[i])) / 3.0;
        let mut sum = DVec3::ZERO;
        for (k, [i, j]) in TANGENT_ENDS.into_iter().enumerate() {
            assert!((c.points[3 + k] - b(i, j)).length() < 1e-15);
            // In the tangent plane of its vertex.
            assert!((c.points[3 + k] - p[i]).dot(n[i]).abs() < 1e-15);
            sum += b(i, j);
        }
        assert!((c.points[9] - (sum / 4.0 - (p[0] + p[1] + p[2]) / 6.0)).length() < 1e-15);
    }

    #[test]
    fn middle_normals_are_reflections() {
        let mesh = triangle();
        for (field, factor) in [(NormalField::Vlachos, 2.0), (NormalField::Boubekeur, 4.0)] {
            let c = Control::new(&mesh, 0, Evaluator::Pn, field);
            for (k, [i, j]) in [(3, [0, 1]), (4, [1, 2]), (5, [2, 0])] {
                let edge = mesh.positions[j] - mesh.positions[i];
                let sum = mesh.normals[i] + mesh.normals[j];
                let formula = sum - edge * (factor * edge.dot(sum) / edge.dot(edge));
                let axis = edge.normalize();
                let mirrored = sum - axis * (2.0 * axis.dot(sum));
                match field {
                    NormalField::Vlachos => {
                        assert!((c.normals[k] - formula.normalize()).length() < 1e-14);
                        assert!((c.normals[k] * sum.length() - mirrored).length() < 1e-14);
                    }
                    _ => {
                        assert!((c.normals[k] - formula).length() < 1e-14);
                        let middle = (c.normals[i] + c.normals[j] + c.normals[k]) / 4.0;
                        assert!((middle - mirrored / 2.0).length() < 1e-14);
                    }
                }
            }
        }
    }

    #[test]
    fn neutral_tags_change_no_bit() {
        let mut mesh = triangle();
        let pn = Control::new(&mesh, 0, Evaluator::Pn, NormalField::Vlachos);
        mesh.tags = vec![Tag::NEUTRAL; 3];
        assert_eq!(Control::new(&mesh, 0, Evaluator::St, NormalField::Vlachos), pn);
        mesh.tags[1] = Tag { deviation: DVec3::X, ..Tag::NEUTRAL };
        assert_eq!(Control::new(&mesh, 0, Evaluator::St, NormalField::Vlachos), pn, "a crease of sharpness 0");
    }

    #[test]
    fn tension_one_pulls_coefficients_into_the_vertex_and_a_crease_parts_normals() {
        let mut mesh = triangle();
        mesh.tags = vec![Tag { tension: 1.0, ..Tag::NEUTRAL }, Tag::NEUTRAL, Tag::NEUTRAL];
        let c = Control::new(&mesh, 0, Evaluator::St, NormalField::Vlachos);
        assert!(
            (c.points[3] - mesh.positions[0]).length() < 1e-15 && (c.points[8] - mesh.positions[0]).length() < 1e-15
        );

        // Two triangles on either side of the edge from 0 to 1, a crease.
        mesh.positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::Y];
        mesh.normals = vec![DVec3::Z; 4];
        let crease = Tag { sharpness: 1.0, deviation: DVec3::Y, bias: 0.5, ..Tag::NEUTRAL };
        mesh.tags = vec![crease, crease, Tag::NEUTRAL, Tag::NEUTRAL];
        mesh.triangles = vec![[0, 1, 2], [1, 0, 3]];
        let [a, b] = [0, 1].map(|t| Control::new(&mesh, t, Evaluator::St, NormalField::Vlachos));
        assert!((a.normals[0] - DVec3::new(0.0, 1.0, 1.0).normalize()).length() < 1e-15);
        assert!((b.normals[1] - DVec3::new(0.0, -1.0, 1.0).normalize()).length() < 1e-15);
        assert_eq!((a.points[3], a.points[4]), (b.points[4], b.points[3]), "the crease curve is shared");
        assert_eq!(a.directions[0], b.directions[1], "displacement does not part the crease");
    }

    #[test]
    fn gradients_of_texture_coordinates_give_their_differences() {
        let mesh = triangle();
        let p = [0, 1, 2].map(|i| mesh.positions[i]);
        let uv = [DVec2::new(0.1, 0.7), DVec2::new(0.9, 0.2), DVec2::new(0.4, 0.4)];
        let g = uv_gradient(p, uv);
        for i in 0..2 {
            for k in 1..3 {
                assert!((g[i].dot(p[k] - p[0]) - (uv[k][i] - uv[0][i])).abs() < 1e-14);
            }
        }
        assert_eq!(uv_gradient([DVec3::ZERO; 3], uv), [DVec3::ZERO; 2]);
    }
}
