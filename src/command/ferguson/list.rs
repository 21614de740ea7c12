//! `gradtess patches` and `gradtess sample` of a gradient mesh.

use super::open::Ferguson;
use crate::command::sample::{Row, Samples, MOST};
use crate::command::{print, print_json, Failure, Global};
use crate::ferguson::mesh::HalfEdge;
use serde::Serialize;

#[derive(Serialize)]
struct Patches {
    schema: &'static str,
    scene: String,
    patches: Vec<Patch>,
}

#[derive(Serialize)]
struct Patch {
    patch: u32,
    level: u32,
    kind: &'static str,
    /// The patch of level 0 that it is part of, and the part: u0, v0, u1, v1.
    root: u32,
    part: [f64; 4],
    /// Points at corners A to D.
    points: [u32; 4],
    /// Of the corners, which are T-sections of another patch's side.
    inherits: [bool; 4],
    /// T-sections on sides 0 to 3.
    sections: [usize; 4],
    /// x, y, and the colour channels in the scene's space, of 16 points: row by row from corner A, u first.
    control: Vec<[f64; 6]>,
}

/// Lists the patches.
pub fn patches(ferguson: &Ferguson, global: &Global) -> Result<(), Failure> {
    let mesh = &ferguson.mesh;
    let patches = mesh.live().map(|p| {
        let (patch, net, colours) = (mesh.patch(p), mesh.geometry(p), mesh.colours(p));
        let control = net.iter().zip(colours).map(|(at, c)| [at.x, at.y, c.x, c.y, c.z, c.w]);
        Patch {
            patch: p,
            level: patch.level(),
            kind: "bicubic",
            root: patch.root,
            part: patch.rect,
            points: patch.corners.map(|c| c.point),
            inherits: patch.corners.map(|c| mesh.points[c.point as usize].on.is_some()),
            sections: [0, 1, 2, 3].map(|i| mesh.sections(HalfEdge::new(p, i)).len()),
            control: control.collect(),
        }
    });
    let report = Patches { schema: "gradtess.patches/1", scene: mesh.name.clone(), patches: patches.collect() };
    if global.json {
        return print_json(&report);
    }
    let mut out = String::from("patch\tlevel\troot\tu0\tv0\tu1\tv1\tpoints\tsections\n");
    for p in &report.patches {
        let [u0, v0, u1, v1] = p.part;
        out += &format!(
            "{}\t{}\t{}\t{u0}\t{v0}\t{u1}\t{v1}\t{:?}\t{:?}\n",
            p.patch, p.level, p.root, p.points, p.sections
        );
    }
    print(&out);
    Ok(())
}

/// Samples every patch of the mesh at n by n parameters; colours are sRGB, not clamped.
pub fn sample(ferguson: &Ferguson, n: u32, exact: bool, global: &Global) -> Result<(), Failure> {
    let mesh = &ferguson.mesh;
    let all = mesh.live().count() as u64 * u64::from(n).pow(2);
    if all > MOST {
        return Err(Failure::input(format_args!("{all} samples are too many; at most {MOST}, choose a smaller --n")));
    }
    let step = |i: u32| if n == 1 { 0.5 } else { f64::from(i) / f64::from(n - 1) };
    let mut samples = Vec::new();
    for p in mesh.live() {
        let (net, colours) = (mesh.geometry(p), mesh.colours(p));
        for (u, v) in (0..n).flat_map(|j| (0..n).map(move |i| (step(i), step(j)))) {
            let at = crate::ferguson::mesh::tensor(&net, u, v);
            let c = mesh.colour.decode(crate::ferguson::mesh::tensor(&colours, u, v));
            samples.push(Row {
                face: p,
                corner: None,
                u,
                v,
                position: at.to_array(),
                colour: c.to_array(),
                level: mesh.patch(p).level(),
                kind: "bicubic",
            });
        }
    }
    // The patches are exact, so both kinds of samples are the same.
    Samples { schema: "gradtess.sample/1", scene: mesh.name.clone(), exact, samples }.print(global)
}
