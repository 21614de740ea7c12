//! From a mesh to a [`PatchTable`] of stitched patches.

use super::fit::Target;
use super::mesh::{HalfEdge, Mesh};
use crate::patch::eval::FACE_EDGES;
use crate::patch::stitched::INNER;
use crate::patch::{ControlPoint, DrawRange, Face, Kind, PatchTable};
use glam::{DVec2, DVec4};
use std::collections::HashMap;

fn control(p: DVec2, c: DVec4) -> ControlPoint {
    [p.x, p.y, 0.0, 0.0, c.x, c.y, c.z, c.w]
}

/// Control points by their bits, so that neighbours share those that are equal.
#[derive(Default)]
struct Pool {
    control: Vec<ControlPoint>,
    known: HashMap<[u64; 8], u32>,
}

impl Pool {
    fn put(&mut self, point: ControlPoint) -> u32 {
        // Adding 0 makes one zero of two.
        let next = self.control.len() as u32;
        let id = *self.known.entry(point.map(|x| (x + 0.0).to_bits())).or_insert(next);
        if id == next {
            self.control.push(point);
        }
        id
    }
}

/// The 32 control points of a patch.
pub fn points(mesh: &Mesh, p: u32, target: &Target) -> [ControlPoint; 32] {
    let (geometry, colours) = (mesh.geometry(p), mesh.colours(p));
    let mut out = [[0.0; 8]; 32];
    for i in 0..16 {
        out[i] = control(geometry[i], colours[i]);
    }
    for side in 0..4 {
        let h = HalfEdge::new(p, side);
        let slot = 16 + 4 * side;
        match mesh.stitch(h, target) {
            None => {
                for (j, from) in FACE_EDGES[side].into_iter().enumerate() {
                    out[slot + j] = out[from];
                }
            }
            Some(stitch) => {
                out[INNER[side]][2] = 1.0;
                let mut curve = mesh.bezier(mesh.side(h).curve).map(|at| control(at, DVec4::ZERO));
                stitch.write(&mut curve);
                out[slot..slot + 4].copy_from_slice(&curve);
            }
        }
    }
    out
}

/// The table of a mesh that was made to fit ([`Mesh::fit`]): components lie over one another in the order of their first
/// patches, whatever is split; in each there is one range for each level, so that levels can be shown. Names of faces are
/// numbers of patches; bit i of `transition` says that side i has T-sections. Time linear in the patches.
pub fn table(mesh: &Mesh, target: &Target) -> PatchTable {
    let component = mesh.component();
    let mut order: Vec<(u32, u32, u32)> =
        mesh.live().map(|p| (component[p as usize], mesh.patch(p).level(), p)).collect();
    order.sort_unstable();
    let mut pool = Pool::default();
    let mut out = PatchTable { colour: mesh.colour, ..PatchTable::default() };
    let mut last = None;
    for (layer, level, p) in order {
        if last.replace((layer, level)) != Some((layer, level)) {
            let first = out.indices.len() as u32;
            out.ranges.push(DrawRange { kind: Kind::Stitched, part: None, level, first, count: 0 });
        }
        if let Some(range) = out.ranges.last_mut() {
            range.count += 1;
        }
        let sections = (0..4).filter(|&i| !mesh.sections(HalfEdge::new(p, i)).is_empty());
        out.faces.push(Face {
            level,
            name: u64::from(p),
            turn: 0,
            kind: Kind::Stitched,
            irregular: false,
            transition: sections.map(|i| 1 << i).sum(),
            first: out.indices.len() as u32,
        });
        out.indices.extend(points(mesh, p, target).map(|point| pool.put(point)));
    }
    out.control = pool.control;
    out
}
