//! Writer of the JSON form: the complete one, which reads back bit for bit.

use super::document::{CurveEntry, Document, PatchEntry, SideEntry};
use crate::ferguson::mesh::{Mesh, Side};
use crate::scene::native::VERSION;

/// The mesh as JSON. What is gone is left out, so numbers may change.
pub fn write(mesh: &Mesh) -> String {
    let numbers = |alive: Vec<bool>| {
        let mut next = 0u32;
        let new: Vec<u32> = alive
            .iter()
            .map(|&a| {
                next += u32::from(a);
                next.wrapping_sub(1)
            })
            .collect();
        new
    };
    let live_curve = |c: &crate::ferguson::mesh::Curve| c.sides.iter().any(|list| !list.is_empty());
    let points = numbers(mesh.points.iter().map(|p| !p.corners.is_empty()).collect());
    let curves = numbers(mesh.curves.iter().map(live_curve).collect());
    let side = |s: Side| {
        let (start, end) = if s.against { (s.to, s.from) } else { (s.from, s.to) };
        SideEntry(curves[s.curve as usize], start, end, s.level)
    };
    let document = Document {
        gradtess: VERSION,
        schema: None,
        technique: "ferguson".to_owned(),
        name: mesh.name.clone(),
        space: Some(mesh.colour.space.name().to_owned()),
        alpha: Some(if mesh.colour.premultiplied { "premultiplied" } else { "straight" }.to_owned()),
        blend: Some(mesh.blend.name().to_owned()),
        points: mesh.points.iter().filter(|p| !p.corners.is_empty()).map(|p| p.at.to_array()).collect(),
        colours: Vec::new(),
        curves: mesh
            .curves
            .iter()
            .filter(|c| live_curve(c))
            .map(|c| CurveEntry {
                points: c.ends.map(|p| points[p as usize]),
                handles: c.handles.map(|h| h.to_array()),
            })
            .collect(),
        patches: mesh
            .live()
            .map(|p| {
                let patch = mesh.patch(p);
                let corners = &patch.corners;
                PatchEntry {
                    points: corners.map(|c| points[c.point as usize]),
                    colours: None,
                    jets: Some(corners.map(|c| {
                        let j = c.colour;
                        [j.value, j.du, j.dv, j.duv].map(|x| x.to_array())
                    })),
                    twists: Some(corners.map(|c| c.twist.to_array())),
                    sides: Some(patch.sides.map(side)),
                    inherits: Some(corners.map(|c| c.inherits)),
                    root: Some(patch.root),
                    part: Some(patch.rect),
                }
            })
            .collect(),
        operations: Vec::new(),
    };
    // One patch, curve or point a line would need a writer of its own; a mesh is read by programs.
    serde_json::to_string(&document).unwrap_or_default() + "\n"
}
