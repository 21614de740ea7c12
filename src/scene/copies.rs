//! Many copies of a scene in one sheet: large meshes with real edits, for measuring.

use super::{ColourEdit, Frame, GeometryEdit, Handle, InputMesh, Scene};
use crate::mesh::{build, HalfEdgeMesh, MeshError, NONE};
use crate::subdiv::index_map::IndexMap;
use glam::{DVec2, DVec4};

/// `n` copies of `scene` in rows, each with all of its edits, welded to its neighbours by quads between boundary edges:
/// right to left in a row, first to first from row to row. A scene without boundary stays apart from its copies. Edits
/// on a boundary edge that is welded are left out. Copy `i` has the half-edges from `i` times those of the scene.
///
/// # Errors
/// The polygons form no mesh.
pub fn copies(scene: &Scene, n: u32) -> Result<Scene, MeshError> {
    let mesh = build(&scene.mesh)?;
    let (low, high) = scene
        .mesh
        .positions
        .iter()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let pitch = 1.25 * (high - low);
    let columns = f64::from(n).sqrt().ceil() as u32;
    let (v, s) = (mesh.vertices(), mesh.half_edges());
    let mut sheet = InputMesh { face_start: vec![0], ..InputMesh::default() };
    for i in 0..n {
        let place = pitch * DVec2::new(f64::from(i % columns), f64::from(i / columns));
        sheet.positions.extend(mesh.positions.iter().map(|&p| p + place));
        sheet.corners.extend(scene.mesh.corners.iter().map(|c| c + i * v));
        sheet.face_start.extend(scene.mesh.face_start[1..].iter().map(|f| f + i * s));
    }
    let [right, left, top, bottom] = outermost(&mesh);
    for i in 0..n {
        let mut weld = |from: Option<u32>, other: u32, to: Option<u32>| {
            let (Some(a), Some(b)) = (from, to) else { return };
            let ends = |h: u32, i: u32| [mesh.origin[h as usize] + i * v, mesh.target(h) + i * v];
            // Against both half-edges.
            let ([a0, a1], [b0, b1]) = (ends(a, i), ends(b, other));
            sheet.corners.extend([a1, a0, b1, b0]);
            sheet.face_start.push(sheet.corners.len() as u32);
        };
        if i % columns + 1 < columns && i + 1 < n {
            weld(right, i + 1, left);
        }
        if i % columns == 0 && i + columns < n {
            weld(top, i + columns, bottom);
        }
    }
    let whole = build(&sheet)?;
    let mut made = Scene { name: scene.name.clone(), corners: scene.corners, reference: None, ..Scene::default() };
    let (map, big) = (IndexMap::new(&mesh), IndexMap::new(&whole));
    if !scene.corner_colours.is_empty() {
        made.corner_colours = scene.corner_colours.repeat(n as usize);
        made.corner_colours.resize(whole.half_edges() as usize, DVec4::ONE);
    }
    for i in 0..n {
        let place = pitch * DVec2::new(f64::from(i % columns), f64::from(i / columns));
        made.sharp.extend(scene.sharp.iter().map(|h| h + i * s));
        let shifted = |h: &Handle| Handle {
            half_edge: match h.half_edge.checked_sub(s) {
                Some(rank) => whole.twin_number(mesh.boundary_twin(rank) + i * s),
                None => h.half_edge + i * s,
            },
            at: h.at + place,
        };
        made.handles.extend(scene.handles.iter().map(shifted));
        made.face_points.extend(scene.face_points.iter().map(shifted));
        let shift = |level: u32, half_edge: u64| half_edge + ((9 * u64::from(s) * u64::from(i)) << (2 * level));
        made.colours.extend(scene.colours.iter().map(|e| ColourEdit { half_edge: shift(e.level, e.half_edge), ..*e }));
        for e in &scene.geometry {
            let beyond = map.boundary_twin_app_a(e.level, e.half_edge);
            let Some(slot) = big.from_app_a(e.level, shift(e.level, beyond.unwrap_or(e.half_edge))) else { continue };
            let open = big.twin(e.level, slot).is_none();
            let half_edge = match (beyond, e.frame) {
                (Some(_), _) if open => big.boundary_app_a(e.level, slot),
                (None, Frame::Sector) => shift(e.level, e.half_edge),
                (None, Frame::Boundary) if open => shift(e.level, e.half_edge),
                _ => continue,
            };
            made.geometry.push(GeometryEdit { half_edge, vertex: None, ..*e });
        }
    }
    made.mesh = sheet;
    Ok(made)
}

/// Boundary half-edges outermost to the right, left, top and bottom, all different; `None` where there are too few.
fn outermost(mesh: &HalfEdgeMesh) -> [Option<u32>; 4] {
    let mut free: Vec<u32> = (0..mesh.half_edges()).filter(|&h| mesh.twin[h as usize] == NONE).collect();
    [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|way| {
        let far = |h: u32| {
            (mesh.positions[mesh.origin[h as usize] as usize] + mesh.positions[mesh.target(h) as usize]).dot(way)
        };
        let best = (0..free.len()).max_by(|&a, &b| far(free[a]).total_cmp(&far(free[b])))?;
        Some(free.swap_remove(best))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::{refine, Options};
    use crate::scene::shapes::builtin;

    #[test]
    fn a_sheet_is_one_piece_with_all_edits() {
        let edit =
            |level, half_edge| GeometryEdit { level, half_edge, vertex: None, a: 0.1, b: 0.1, frame: Frame::Sector };
        let colour = ColourEdit { level: 0, half_edge: 9, colour: DVec4::ZERO };
        let one = Scene {
            mesh: builtin("grid:2x2").unwrap(),
            geometry: vec![edit(2, 100), edit(1, 31)],
            colours: vec![colour],
            sharp: vec![5],
            ..Scene::default()
        };
        let sheet = copies(&one, 7).unwrap();
        let mesh = build(&sheet.mesh).unwrap();
        // 3 x 3 places, the last two empty: four welds in rows, two between rows.
        assert_eq!(mesh.faces(), 7 * 4 + 4 + 2);
        assert_eq!((sheet.geometry.len(), sheet.colours.len(), sheet.sharp.len()), (14, 7, 7));
        let mut reached = vec![false; mesh.faces() as usize];
        let mut queue = vec![0];
        while let Some(f) = queue.pop() {
            if std::mem::replace(&mut reached[f as usize], true) {
                continue;
            }
            for h in mesh.face_start[f as usize]..mesh.face_start[f as usize + 1] {
                queue.extend(Some(mesh.twin[h as usize]).filter(|&t| t != NONE).map(|t| mesh.face[t as usize]));
            }
        }
        assert!(reached.iter().all(|&r| r));
        assert!(refine(&sheet, &mesh, Options::default()).unwrap().levels.len() > 2);
    }
}
