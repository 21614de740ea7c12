//! `gradtess sample` of a surface: points of its patches, or of the limit itself.

use super::flags::SurfaceFlags;
use super::open::Surface;
use super::render::{make_patches, MadePatches};
use crate::command::{print, print_json, Failure, Global, Refining};
use crate::surface::adaptive::{Fate, Part};
use crate::surface::exact::Exact;
use crate::surface::patch_eval::point;
use glam::DVec3;
use serde::Serialize;
use std::collections::HashMap;

/// Most samples that one run makes; they are held in memory.
const MOST: u64 = 4_000_000;

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    level: u32,
    exact: bool,
    samples: Vec<Row>,
}

/// `face` is that of the OBJ, `patch` that of the whole level; u runs along the patch's first half-edge. In a triangle, u
/// and v are the weights of its second and third corner.
#[derive(Serialize)]
struct Row {
    face: u32,
    level: u32,
    patch: u64,
    u: f64,
    v: f64,
    position: DVec3,
    /// N_L, N_S, b and N_B of the patch; with `--exact`, N_L is the limit's.
    normal_geometric: DVec3,
    normal_subdivided: DVec3,
    weight: f64,
    normal_blended: DVec3,
    kind: &'static str,
}

/// Samples every patch at `n` x `n` parameters, sides included; of triangles, the half of them that lie inside.
pub fn run(
    surface: &Surface,
    flags: &SurfaceFlags,
    refining: &Refining,
    n: u32,
    exact: bool,
    global: &Global,
) -> Result<(), Failure> {
    let MadePatches { made, scene, patches, parts } = make_patches(surface, flags, refining, global)?;
    let all = patches.len() as u64 * u64::from(n).pow(2);
    if all > MOST {
        return Err(Failure::input(format_args!("{all} samples are too many; at most {MOST}, choose a smaller --n")));
    }
    let limit = match exact {
        false => None,
        true if n >= 2 && (n - 1).is_power_of_two() && n <= 65 => {
            let drawn = |part: &Part| part.fate.iter().map(|&f| f == Fate::Drawn).collect::<Vec<bool>>();
            let exact = |part: &Part| Exact::new(&part.level, &drawn(part), (n - 1).ilog2());
            Some(parts.iter().map(exact).collect::<Vec<Exact>>())
        }
        true => return Err(Failure::input("--exact of surfaces in space needs --n 2, 3, 5, 9, 17, 33 or 65")),
    };
    let power = flags.settings()?.power;
    // Triangles that a polygon was cut into have its line.
    let of_line: HashMap<u32, u32> = surface.scene.face_line.iter().zip(0..).map(|(&line, f)| (line, f)).collect();
    let mut samples = Vec::new();
    for patch in patches.iter() {
        let level = patch.place.level;
        let name = parts[level as usize].name[patch.place.face as usize];
        // The children of a half-edge follow those before it; level 1 has a face for each half-edge of the OBJ.
        let triangle = patch.form.sides() == 3;
        let middle = if triangle { 1.0 / 3.0 } else { 0.5 };
        let step = |i: u32| if n == 1 { middle } else { f64::from(i) / f64::from(n - 1) };
        let face = match triangle {
            true => of_line[&scene.face_line[(name >> (2 * level)) as usize]],
            false => surface.mesh.face[(name >> (2 * (level - 1))) as usize],
        };
        for (j, i) in (0..n).flat_map(|j| (0..if triangle { n - j } else { n }).map(move |i| (j, i))) {
            let mut p = point(patch.form, &patch.control, step(i), step(j), power);
            if let Some(limit) = &limit {
                (p.position, p.geometric) = limit[level as usize].limit(patch.place.face, i, j);
            }
            samples.push(Row {
                face,
                level,
                patch: name,
                u: step(i),
                v: step(j),
                position: p.position,
                normal_geometric: p.geometric,
                normal_subdivided: p.subdivided,
                weight: p.weight,
                normal_blended: p.blended,
                kind: patch.form.name(),
            });
        }
    }
    if global.json {
        return print_json(&Report {
            schema: "gradtess.surface_sample/1",
            scene: surface.scene.name.clone(),
            technique: "surface",
            level: made.level,
            exact,
            samples,
        });
    }
    let mut out =
        String::from("face\tlevel\tpatch\tu\tv\tx\ty\tz\tnlx\tnly\tnlz\tnsx\tnsy\tnsz\tb\tnbx\tnby\tnbz\tkind\n");
    let three = |v: DVec3| format!("{}\t{}\t{}", v.x, v.y, v.z);
    for s in &samples {
        out += &format!(
            "{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\n",
            s.face,
            s.level,
            s.patch,
            s.u,
            s.v,
            three(s.position),
            three(s.normal_geometric),
            three(s.normal_subdivided),
            s.weight,
            three(s.normal_blended),
            s.kind
        );
    }
    print(&out);
    Ok(())
}
