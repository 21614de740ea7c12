//! Writer of OBJ surfaces: sharp edges as the authors' `fs` lines, one a face.

use super::SurfaceScene;
use crate::scene::CornerRule;
use std::fmt::Write;

/// `scene` as an OBJ that [`SurfaceScene::parse`] reads back. Sharpness of edges goes into `fs` lines, of every face, so that
/// the file says what it is even where none is sharp; crease tags stay tags.
pub fn write(scene: &SurfaceScene) -> String {
    let mut out = String::new();
    for p in &scene.positions {
        let _ = writeln!(out, "v {} {} {}", p.x, p.y, p.z);
    }
    for n in &scene.normals {
        let _ = writeln!(out, "vn {} {} {}", n.x, n.y, n.z);
    }
    for range in scene.face_start.windows(2) {
        let (start, end) = (range[0] as usize, range[1] as usize);
        out += "f";
        for k in start..end {
            let _ = write!(out, " {}", scene.corners[k] + 1);
            if !scene.normals.is_empty() {
                let _ = write!(out, "//{}", k + 1);
            }
        }
        // The first digit is of the edge that ends in the last corner.
        out += "\nfs";
        for k in std::iter::once(end - 1).chain(start..end - 1) {
            let _ = write!(out, " {}", scene.edge_sharpness.get(k).copied().unwrap_or(0.0));
        }
        out += "\n";
    }
    for crease in &scene.creases {
        let [a, b] = crease.ends;
        let _ = writeln!(out, "t crease 2/1/0 {a} {b} {}", crease.sharpness);
    }
    for (v, &s) in scene.corner_sharpness.iter().enumerate().filter(|(_, &s)| s > 0.0) {
        let _ = writeln!(out, "t corner 1/1/0 {v} {s}");
    }
    let rule = match scene.boundary_corners {
        Some(CornerRule::Sharp) => 1,
        Some(CornerRule::Smooth) => 2,
        None => return out,
    };
    let _ = writeln!(out, "t interpolateboundary 1/0/0 {rule}");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let text = "v 0 0 0\nv 1 0 0.1\nv 1 1 0\nv 0 1 1e-7\nv 0.5 2 0\nvn 0 0 1\nvn 0 0.6 0.8\n\
            f 1//1 2//2 3 4//1\nf 4 3 5\nfs 1 2.25 0 inf\nfs 3 0 0\n\
            t crease 2/1/0 0 1 0.5\nt corner 1/1/0 2 1.5\nt interpolateboundary 1/0/0 1\n";
        let read = |text: &str| SurfaceScene::parse(text.as_bytes(), "a.obj").unwrap();
        let (first, again) = (read(text), read(&write(&read(text))));
        assert_eq!(
            (&first.positions, &first.corners, &first.face_start),
            (&again.positions, &again.corners, &again.face_start)
        );
        assert_eq!((&first.edge_sharpness, &first.normals), (&again.edge_sharpness, &again.normals));
        assert_eq!(
            (&first.corner_sharpness, first.boundary_corners),
            (&again.corner_sharpness, again.boundary_corners)
        );
        assert_eq!(again.creases[0].ends, [0, 1]);
        assert_eq!(again.edge_sharpness, [2.25, 0.0, f64::INFINITY, 1.0, 0.0, 0.0, 3.0]);
        assert!(again.notes.is_empty(), "{:?}", again.notes);
    }
}
