//! New meshes: quads with straight or given curves.

use super::mesh::{Corner, Curve, HalfEdge, Jet, Mesh, Patch, Point, Side, NONE};
use super::FergusonError;
use glam::{DVec2, DVec4};
use std::collections::hash_map::Entry;
use std::collections::HashMap;

impl Mesh {
    /// Adds quads with straight curves between `points` and the colours of their corners (coordinates in the mesh's
    /// space). Twists are zero, as in a Ferguson patch (3.1); two quads that name the same two points share a curve.
    /// Quads run round the same way. An edge has one quad or two; any number of quads meet in a point: that is how
    /// branches, loops and holes are made (7.1).
    ///
    /// # Errors
    /// A quad names a point that is not there, twice the same, or runs the other way round than its neighbour.
    pub fn from_quads(points: &[DVec2], quads: &[[u32; 4]], colours: &[[DVec4; 4]]) -> Result<Mesh, FergusonError> {
        let mut mesh = Mesh {
            points: points.iter().map(|&at| Point { at, on: None, corners: Vec::new() }).collect(),
            ..Mesh::default()
        };
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        for (p, quad) in quads.iter().enumerate() {
            let p = p as u32;
            let fault = |what: String| FergusonError::Topology { patch: p, what };
            let mut sides = [Side { curve: NONE, against: false, from: 0.0, to: 1.0, level: 0 }; 4];
            for i in 0..4 {
                let (a, b) = (quad[i], quad[(i + 1) & 3]);
                if a as usize >= points.len() {
                    return Err(fault(format!("point {a} does not exist; there are {}", points.len())));
                }
                if quad[..i].contains(&a) {
                    return Err(fault(format!("point {a} is named twice; name four different points")));
                }
                let h = HalfEdge::new(p, i);
                if let Some(&c) = edges.get(&(b, a)) {
                    let across = &mut mesh.curves[c as usize].sides[1];
                    if !across.is_empty() {
                        return Err(fault(format!(
                            "a third patch along the edge from point {a} to point {b}; an edge has two"
                        )));
                    }
                    across.push(h);
                    (sides[i].curve, sides[i].against) = (c, true);
                } else if let Entry::Vacant(edge) = edges.entry((a, b)) {
                    let c = mesh.curves.len() as u32;
                    let [from, to] = [a, b].map(|x| points.get(x as usize).copied().unwrap_or_default());
                    let handles = [from + (to - from) / 3.0, to - (to - from) / 3.0];
                    mesh.curves.push(Curve { ends: [a, b], handles, sides: [vec![h], Vec::new()] });
                    edge.insert(c);
                    sides[i].curve = c;
                } else {
                    let fix = "list the points of all patches the same way round, and not more than two along an edge";
                    return Err(fault(format!("a second patch runs from point {a} to point {b}; {fix}")));
                }
                mesh.points[a as usize].corners.push(h);
            }
            let values = colours.get(p as usize).copied().unwrap_or([DVec4::ONE; 4]);
            let corners = [0, 1, 2, 3].map(|i| Corner {
                point: quad[i],
                twist: DVec2::ZERO,
                colour: Jet { value: values[i], ..Jet::default() },
                inherits: false,
            });
            mesh.patches.push(Patch { sides, corners, root: p, rect: [0.0, 0.0, 1.0, 1.0], alive: true });
        }
        mesh.apply_blend();
        mesh.take_journal();
        Ok(mesh)
    }

    /// Gives every corner the colour derivatives of the mesh's blending function: the function along u times that along
    /// v. For the paper's own function all of them are zero, twists included (3.2); for the linear one the patch becomes
    /// bilinear, as in SVG and PDF. Only for meshes without splits, whose derivatives carry what splits put there.
    pub fn apply_blend(&mut self) {
        for p in self.live().collect::<Vec<_>>() {
            for i in 0..4 {
                let jet = self.blended(p, [0, 1, 2, 3].map(|k| self.patch(p).corners[k].colour.value), i);
                self.patch_mut(p).corners[i].colour = jet;
            }
        }
    }

    /// The jet at corner `i` of a patch whose corners have these colours.
    pub(super) fn blended(&self, p: u32, value: [DVec4; 4], i: usize) -> Jet {
        let slopes = self.blend.slopes();
        let turned = [slopes[1], slopes[0]];
        // The function runs along the curve, whichever way that is: slope at the corner's end of the side along u, v.
        let slope = |side: usize, far_end: bool| {
            let along = self.patch(p).sides[side].against != (side < 2);
            (if along { slopes } else { turned })[usize::from(far_end)]
        };
        let [a, b, c, d] = value;
        let (low, right) = (i == 0 || i == 1, i == 1 || i == 2);
        let ku = slope(if low { 0 } else { 2 }, right);
        let kv = slope(if right { 1 } else { 3 }, !low);
        let du = if low { b - a } else { c - d };
        let dv = if right { c - b } else { d - a };
        Jet { value: value[i], du: du * ku, dv: dv * kv, duv: (c - d - b + a) * (ku * kv) }
    }

    /// A grid of `columns` by `rows` patches over a rectangle; `colour(i, j)` in grid points from the lower left.
    pub fn grid(
        columns: u32,
        rows: u32,
        [x0, y0, x1, y1]: [f64; 4],
        colour: impl Fn(u32, u32) -> DVec4,
    ) -> Result<Mesh, FergusonError> {
        let id = |i: u32, j: u32| j * (columns + 1) + i;
        let mut points = Vec::new();
        for j in 0..=rows {
            for i in 0..=columns {
                let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
                points.push(DVec2::new(x0 + (x1 - x0) * u, y0 + (y1 - y0) * v));
            }
        }
        let cells: Vec<(u32, u32)> = (0..rows).flat_map(|j| (0..columns).map(move |i| (i, j))).collect();
        let ring = |i: u32, j: u32| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let quads: Vec<[u32; 4]> = cells.iter().map(|&(i, j)| ring(i, j).map(|(i, j)| id(i, j))).collect();
        let colours: Vec<[DVec4; 4]> = cells.iter().map(|&(i, j)| ring(i, j).map(|(i, j)| colour(i, j))).collect();
        Mesh::from_quads(&points, &quads, &colours)
    }
}
