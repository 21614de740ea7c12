//! Polygons to triangles, for Loop subdivision.

use crate::scene::surface::SurfaceScene;

/// `scene` with every polygon cut into a fan from its first corner; the new edges are smooth. Returns how many polygons
/// were cut, too.
pub fn triangulate(scene: &SurfaceScene) -> (SurfaceScene, usize) {
    let mut out = SurfaceScene {
        corners: Vec::new(),
        face_start: vec![0],
        face_line: Vec::new(),
        edge_sharpness: Vec::new(),
        normals: Vec::new(),
        ..scene.clone()
    };
    let mut cut = 0;
    for f in 0..scene.faces() {
        let (start, end) = (scene.face_start[f] as usize, scene.face_start[f + 1] as usize);
        cut += usize::from(end - start > 3);
        for k in start + 1..end - 1 {
            // The sharpness at a corner is that of the edge that ends there.
            let corners = [start, k, k + 1];
            let kept = [k + 2 == end, k == start + 1, true];
            for (i, kept) in corners.into_iter().zip(kept) {
                out.corners.push(scene.corners[i]);
                let s = scene.edge_sharpness.get(i).copied().unwrap_or(0.0);
                out.edge_sharpness.push(if kept { s } else { 0.0 });
                if let Some(&n) = scene.normals.get(i) {
                    out.normals.push(n);
                }
            }
            out.face_start.push(out.corners.len() as u32);
            out.face_line.push(scene.face_line[f]);
        }
    }
    (out, cut)
}
