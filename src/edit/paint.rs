//! Colours and sharp edges (ZHHK22 3.3, 4.4, 5.1).

use super::handle::{Id, Kind};
use super::EditError;
use crate::mesh::{HalfEdgeMesh, NONE};
use crate::scene::{ColourEdit, Scene};
use crate::subdiv::index_map::{IndexMap, Slot};
use glam::DVec4;
use std::collections::HashMap;

/// Slots of the sectors that a colour handle stands for.
pub fn sectors(map: &IndexMap, id: Id) -> Vec<Slot> {
    let mut slots = Vec::new();
    match id.kind {
        Kind::Sector => slots.push(id.slot),
        _ => map.around(id.level, id.slot, |s| slots.push(s)),
    }
    slots
}

/// Gives every handle its colour. Straight alpha, 0 to 1.
///
/// # Errors
/// A handle that has no colour of its own; the scene is then as it was.
pub fn paint(scene: &mut Scene, mesh: &HalfEdgeMesh, colours: &[(Id, DVec4)]) -> Result<(), EditError> {
    let map = IndexMap::new(mesh);
    if let Some((id, _)) = colours.iter().find(|(id, _)| !map.is_colour_vertex(id.level, id.slot)) {
        return Err(EditError::refused(format_args!(
            "a vertex of level {} between colour vertices has no colour",
            id.level
        )));
    }
    let mut index: HashMap<(u32, u64), usize> =
        scene.colours.iter().enumerate().map(|(i, e)| ((e.level, e.half_edge), i)).collect();
    for &(id, colour) in colours {
        for slot in sectors(&map, id) {
            let half_edge = map.to_app_a(id.level, slot);
            match index.get(&(id.level, half_edge)) {
                Some(&i) => scene.colours[i].colour = colour,
                // The file's own colours of M^0, where it has them and no edit hides them.
                None if id.level == 0 && !scene.corner_colours.is_empty() => {
                    scene.corner_colours[(slot >> 3) as usize] = colour;
                }
                None => {
                    index.insert((id.level, half_edge), scene.colours.len());
                    scene.colours.push(ColourEdit { level: id.level, half_edge, colour });
                }
            }
        }
    }
    Ok(())
}

/// Takes the colour edits of a handle away. `false`: it had none.
pub fn unpaint(scene: &mut Scene, mesh: &HalfEdgeMesh, id: Id) -> bool {
    let map = IndexMap::new(mesh);
    let names: Vec<u64> = sectors(&map, id).into_iter().map(|s| map.to_app_a(id.level, s)).collect();
    let before = scene.colours.len();
    scene.colours.retain(|e| e.level != id.level || !names.contains(&e.half_edge));
    before != scene.colours.len()
}

/// Whether the input edge of half-edge `h` is tagged sharp.
pub fn is_sharp(scene: &Scene, mesh: &HalfEdgeMesh, h: u32) -> bool {
    let twin = mesh.twin[h as usize];
    scene.sharp.iter().any(|&s| s == h || s == twin)
}

/// Tags the input edge of half-edge `h` as sharp, or removes the tag; without the tag its two ends also get one colour
/// across the edge where they are told apart only by it.
///
/// # Errors
/// The edge is on the boundary, where colours end anyway.
pub fn set_sharp(scene: &mut Scene, mesh: &HalfEdgeMesh, h: u32, sharp: bool) -> Result<(), EditError> {
    let twin = mesh.twin[h as usize];
    if twin == NONE {
        return Err(EditError::refused("an edge of the boundary parts no colours"));
    }
    if sharp {
        if !is_sharp(scene, mesh, h) {
            scene.sharp.push(h.min(twin));
        }
        return Ok(());
    }
    scene.sharp.retain(|&s| s != h && s != twin);
    // Both sides of the edge at either end: colours that differ across an edited spoke would make it sharp again.
    let map = IndexMap::new(mesh);
    for (left, right) in [(h, mesh.next(twin)), (mesh.next(h), twin)] {
        let colour = |scene: &Scene, g: u32| {
            let name = map.to_app_a(0, 8 * u64::from(g));
            let edit = scene.colours.iter().find(|e| e.level == 0 && e.half_edge == name).map(|e| e.colour);
            edit.or(scene.corner_colours.get(g as usize).copied())
        };
        if let (Some(a), Some(b)) = (colour(scene, left), colour(scene, right)) {
            if a != b {
                let mean = (a + b) * 0.5;
                let id = |g: u32| Id { kind: Kind::Sector, level: 0, slot: 8 * u64::from(g) };
                paint(scene, mesh, &[(id(left), mean), (id(right), mean)])?;
            }
        }
    }
    Ok(())
}
