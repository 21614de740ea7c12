//! Meshes for the figures, as OBJ text. Creases are paths of vertices, counted from 0.

use std::fmt::Write;

fn obj(points: &[[f64; 3]], faces: &[&[u32]], creases: &[&str], sharpness: u32) -> String {
    let mut text = String::new();
    for [x, y, z] in points {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for face in faces {
        text += "f";
        for v in *face {
            let _ = write!(text, " {}", v + 1);
        }
        text += "\n";
    }
    for path in creases {
        let n = path.split(' ').count();
        let _ = writeln!(text, "t crease {n}/1/0 {path} {sharpness}");
    }
    text
}

/// A tetrahedron; its base is 0, 1, 2.
pub fn tetrahedron(creases: &[&str], sharpness: u32) -> String {
    let points = [[1.0, -0.4, -0.6], [-1.0, -0.4, -0.6], [0.0, -0.4, 1.15], [0.0, 1.2, 0.0]];
    obj(&points, &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]], creases, sharpness)
}

/// A cube; its base is 0, 1, 2, 3, and 4 to 7 are above.
pub fn cube(creases: &[&str], sharpness: u32) -> String {
    let points: Vec<[f64; 3]> = (0..8)
        .map(|i| {
            [
                if matches!(i % 4, 1 | 2) { 1.0 } else { -1.0 },
                if i < 4 { -1.0 } else { 1.0 },
                if i % 4 < 2 { 1.0 } else { -1.0 },
            ]
        })
        .collect();
    let faces: [&[u32]; 6] = [&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];
    obj(&points, &faces, creases, sharpness)
}

/// Seven cubes as a cross in space; the rim of the upper end is sharp.
pub fn cross(sharpness: u32) -> String {
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut number = |p: [f64; 3]| match points.iter().position(|q| *q == p) {
        Some(i) => i as u32,
        None => {
            points.push(p);
            points.len() as u32 - 1
        }
    };
    let mut faces: Vec<[u32; 4]> = Vec::new();
    let mut rim = String::new();
    for axis in 0..3usize {
        for side in [-1.0, 1.0] {
            // Around the arm, as seen from its end.
            let mut around = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            if side < 0.0 {
                around.reverse();
            }
            let mut ring = |along: f64| {
                around.map(|[a, b]| {
                    let mut p = [0.0; 3];
                    p[axis] = along * side;
                    p[(axis + 1) % 3] = a;
                    p[(axis + 2) % 3] = b;
                    number(p)
                })
            };
            let (near, far) = (ring(1.0), ring(3.0));
            faces.push(far);
            for k in 0..4 {
                let next = (k + 1) % 4;
                faces.push([near[k], near[next], far[next], far[k]]);
            }
            if axis == 1 && side > 0.0 {
                let [a, b, c, d] = far;
                rim = format!("{a} {b} {c} {d} {a}");
            }
        }
    }
    let faces: Vec<&[u32]> = faces.iter().map(|f| &f[..]).collect();
    obj(&points, &faces, &[&rim], sharpness)
}

/// An open hat of triangles: a top, a crown and a brim around six corners; three edges of the crown's foot are sharp.
pub fn hat(sharpness: u32) -> String {
    let mut points = vec![[0.0, 1.3, 0.0]];
    for (radius, height) in [(0.7, 1.1), (0.8, 0.0), (1.6, -0.1)] {
        for k in 0..6 {
            let a = std::f64::consts::TAU * f64::from(k) / 6.0;
            points.push([radius * a.cos(), height, -radius * a.sin()]);
        }
    }
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for k in 0..6 {
        let next = (k + 1) % 6;
        faces.push([0, 1 + k, 1 + next]);
        for ring in 0..2 {
            let [a, b] = [1 + 6 * ring + k, 1 + 6 * ring + next];
            faces.push([a, a + 6, b]);
            faces.push([b, a + 6, b + 6]);
        }
    }
    let faces: Vec<&[u32]> = faces.iter().map(|f| &f[..]).collect();
    obj(&points, &faces, &["10 11 12 7"], sharpness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::build;
    use crate::scene::surface::SurfaceScene;
    use crate::surface::level::{Level, Scheme};

    #[test]
    fn meshes_are_closed_or_open_as_meant() {
        let level = |text: &str| {
            let scene = SurfaceScene::parse(text.as_bytes(), "mesh").unwrap();
            let mesh = build(&scene.polygons()).unwrap();
            (Level::new(&scene, &mesh, Scheme::CatmullClark).unwrap(), mesh.boundary_edges())
        };
        let sharp = |l: &Level| l.sharpness.iter().filter(|&&s| s == 4.0).count();
        for (text, vertices, faces, boundary, creases) in [
            (tetrahedron(&["0 1 2 0"], 4), 4, 4, 0, 3),
            (cube(&["0 1 2 3 0", "0 4", "1 5", "2 6"], 4), 8, 6, 0, 7),
            (cross(4), 32, 30, 0, 4),
            (hat(4), 19, 30, 6, 3),
        ] {
            let (l, open) = level(&text);
            assert_eq!((l.vertices(), l.faces(), open, sharp(&l)), (vertices, faces, boundary, creases), "{text}");
            // Outside is in front: the volume over the origin is positive.
            let p = |h: u32| l.position[l.origin[h as usize] as usize];
            let volume: f64 = (0..l.faces())
                .map(|f| {
                    let face = l.of_face(f);
                    (face.start + 1..face.end - 1).map(|h| p(face.start).dot(p(h).cross(p(h + 1)))).sum::<f64>()
                })
                .sum();
            assert!(volume > 0.0, "{text}");
        }
    }
}
