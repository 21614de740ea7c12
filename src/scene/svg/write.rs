//! Export. Rectangular meshes become one `<meshgradient>` for each grid, and read back equal; all meshes get a picture
//! under them, which is what browsers show, for they draw no mesh gradients.
//!
//! SVG has no words for colours that are not bilinear, nor for other spaces than sRGB. A namespace of our own carries them
//! beside the stops; other programs draw the bilinear colours of the corners.

use super::patches::coons;
use crate::ferguson::mesh::{HalfEdge, Jet, Mesh};
use crate::patch::space::Interpolation;
use glam::DVec2;
use std::collections::HashSet;
use std::fmt::Write;

/// Patches of a rectangular grid, row by row.
pub struct GridOf {
    /// Patches of each row; all rows are as long as the first.
    pub rows: Vec<Vec<u32>>,
}

/// The grids that a mesh consists of; `None` when part of it is no grid: T-sections, branches, loops, or points whose
/// sectors have colours of their own.
pub fn grids(mesh: &Mesh) -> Option<Vec<GridOf>> {
    if (0..mesh.curves.len() as u32).any(|c| mesh.has_sections(c)) {
        return None;
    }
    let mut seen: HashSet<u32> = HashSet::new();
    let mut found = Vec::new();
    let edge = |p: u32, side: usize| mesh.opposite(HalfEdge::new(p, side)).is_none();
    for start in mesh.live().filter(|&p| edge(p, 0) && edge(p, 3)) {
        let mut rows: Vec<Vec<u32>> = Vec::new();
        let mut first = Some(start);
        while let Some(p) = first {
            let mut row = Vec::new();
            let mut at = Some(p);
            while let Some(p) = at {
                if !seen.insert(p) {
                    return None;
                }
                row.push(p);
                at = across(mesh, p, 1, 3)?;
            }
            if rows.first().is_some_and(|r| r.len() != row.len()) {
                return None;
            }
            rows.push(row);
            first = across(mesh, p, 2, 0)?;
        }
        // What is beside each other in the grid has to be so in the mesh, and nothing else.
        for (r, row) in rows.iter().enumerate() {
            for (c, &p) in row.iter().enumerate() {
                let below = across(mesh, p, 2, 0)?;
                if below != rows.get(r + 1).map(|next| next[c]) || (c == 0) != edge(p, 3) || (r == 0) != edge(p, 0) {
                    return None;
                }
            }
        }
        found.push(GridOf { rows });
    }
    let smooth = mesh.points.iter().all(|point| {
        let mut colours = point.corners.iter().map(|&h| mesh.corner(h).colour.value);
        let first = colours.next();
        colours.all(|c| Some(c) == first)
    });
    (seen.len() == mesh.live().count() && smooth).then_some(found)
}

/// The patch across side `side`, which meets it with its side `other`; `None` inside where it meets it otherwise.
fn across(mesh: &Mesh, p: u32, side: usize, other: usize) -> Option<Option<u32>> {
    match mesh.opposite(HalfEdge::new(p, side)) {
        None => Some(None),
        Some(o) if o.side() == other => Some(Some(o.patch())),
        Some(_) => None,
    }
}

/// A drawing of the mesh: its grids, if it has that form, over `picture`, a PNG that fills `view` (x0, y0, x1, y1 of the
/// scene).
pub fn write(mesh: &Mesh, grids: Option<&[GridOf]>, picture: &[u8], [x0, y0, x1, y1]: [f64; 4]) -> String {
    use base64::Engine;
    let (width, height) = (x1 - x0, y1 - y0);
    let mut out = String::new();
    let mut line = |text: std::fmt::Arguments| {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{text}");
    };
    line(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         xmlns:gradtess=\"urn:gradtess\" viewBox=\"{x0} {} {width} {height}\">",
        -y1
    ));
    let data = base64::engine::general_purpose::STANDARD.encode(picture);
    line(format_args!(
        "<image x=\"{x0}\" y=\"{}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         xlink:href=\"data:image/png;base64,{data}\"/>",
        -y1
    ));
    for (i, grid) in grids.unwrap_or(&[]).iter().enumerate() {
        for text in gradient(mesh, grid, i) {
            line(format_args!("{text}"));
        }
        line(format_args!(
            "<rect x=\"{x0}\" y=\"{}\" width=\"{width}\" height=\"{height}\" fill=\"url(#mesh{i}) none\"/>",
            -y1
        ));
    }
    line(format_args!("</svg>"));
    out
}

fn gradient(mesh: &Mesh, grid: &GridOf, number: usize) -> Vec<String> {
    let origin = flipped(mesh.at(mesh.corner(HalfEdge::new(grid.rows[0][0], 0)).point));
    let Interpolation { space, premultiplied } = mesh.colour;
    let mut ours = format!(" gradtess:blend=\"{}\"", mesh.blend.name());
    if space != Default::default() {
        ours += &format!(" gradtess:space=\"{}\"", space.name());
    }
    if premultiplied {
        ours += " gradtess:alpha=\"premultiplied\"";
    }
    let mut lines = vec![format!(
        "<meshgradient id=\"mesh{number}\" x=\"{}\" y=\"{}\" gradientUnits=\"userSpaceOnUse\"{ours}>",
        origin.x, origin.y
    )];
    for (r, row) in grid.rows.iter().enumerate() {
        lines.push("<meshrow>".to_owned());
        for (c, &p) in row.iter().enumerate() {
            lines.push(patch(mesh, p, [r == 0, true, true, c == 0]));
        }
        lines.push("</meshrow>".to_owned());
    }
    lines.push("</meshgradient>".to_owned());
    lines
}

fn patch(mesh: &Mesh, p: u32, sides: [bool; 4]) -> String {
    let net = mesh.geometry(p).map(flipped);
    let inner = [5, 6, 10, 9];
    let size = net.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let mut out = String::from("<meshpatch");
    let plain = coons(&net);
    if (0..4).any(|i| (net[inner[i]] - plain[i]).abs().max_element() > 1e-12 * size) {
        let offsets = [(5, 0), (6, 3), (10, 15), (9, 12)].map(|(i, corner)| net[i] - net[corner]);
        out += &format!(" tensor=\"{}\"", offsets.map(|o| format!("{},{}", o.x, o.y)).join(" "));
    }
    let jets = mesh.patch(p).corners.map(|c| c.colour);
    if !is_bilinear(&jets) || mesh.colour != Interpolation::default() {
        let numbers: Vec<String> = jets
            .iter()
            .flat_map(|j| [j.value, j.du, j.dv, j.duv])
            .flat_map(|v| v.to_array())
            .map(|x| format!("{x}"))
            .collect();
        out += &format!(" gradtess:jets=\"{}\"", numbers.join(" "));
    }
    out += ">";
    for side in (0..4).filter(|&i| sides[i]) {
        let [_, a, b, end] = crate::patch::eval::FACE_EDGES[side].map(|i| net[i]);
        let c = mesh.colour.decode(jets[side].value).clamp(glam::DVec4::ZERO, glam::DVec4::ONE);
        out += &format!(
            "<stop path=\"C {},{} {},{} {},{}\" stop-color=\"rgb({}%, {}%, {}%)\" stop-opacity=\"{}\"/>",
            a.x,
            a.y,
            b.x,
            b.y,
            end.x,
            end.y,
            c.x * 100.0,
            c.y * 100.0,
            c.z * 100.0,
            c.w
        );
    }
    out + "</meshpatch>"
}

fn flipped(p: DVec2) -> DVec2 {
    // Adding 0 makes one zero of two.
    DVec2::new(p.x, 0.0 - p.y)
}

/// Whether the stops say all of the colours: bilinear, and from 0 to 1.
fn is_bilinear(jets: &[Jet; 4]) -> bool {
    let q = jets.map(|j| j.value);
    let twist = q[0] - q[1] + q[2] - q[3];
    let near = |a: glam::DVec4, b: glam::DVec4| (a - b).abs().max_element() < 1e-12;
    (0..4).all(|k| {
        let du = if k < 2 { q[1] - q[0] } else { q[2] - q[3] };
        let dv = if k == 1 || k == 2 { q[2] - q[1] } else { q[3] - q[0] };
        let inside = q[k].min_element() >= 0.0 && q[k].max_element() <= 1.0;
        inside && near(jets[k].du, du) && near(jets[k].dv, dv) && near(jets[k].duv, twist)
    })
}
