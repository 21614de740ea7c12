//! `gradtess stats` of a gradient mesh: patches beside those of a traditional one, as Table 1 of BLHK18.

use super::open::Ferguson;
use crate::command::{print, print_json, Failure, Global};
use crate::ferguson::table::table;
use crate::ferguson::traditional::traditional;
use serde::Serialize;

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    scene: String,
    technique: &'static str,
    patches: usize,
    /// Patches when every split runs through its whole row or column.
    traditional: u64,
    roots: usize,
    points: usize,
    sections: usize,
    curves: usize,
    components: usize,
    deepest_level: u32,
    patches_by_level: Vec<usize>,
    space: &'static str,
    blend: &'static str,
    control_points: usize,
    indices: usize,
    device_bytes: usize,
}

/// Counts and prints.
pub fn run(ferguson: &Ferguson, global: &Global) -> Result<(), Failure> {
    let mesh = &ferguson.mesh;
    let table = table(mesh, &Default::default());
    let live = mesh.points.iter().filter(|p| !p.corners.is_empty());
    let levels: Vec<usize> = mesh.live().map(|p| mesh.patch(p).level() as usize).collect();
    let mut by_level = vec![0; levels.iter().max().unwrap_or(&0) + 1];
    levels.iter().for_each(|&l| by_level[l] += 1);
    let report = Report {
        schema: "gradtess.stats/1",
        scene: mesh.name.clone(),
        technique: "ferguson",
        patches: mesh.live().count(),
        traditional: traditional(mesh),
        roots: mesh.live().map(|p| mesh.patch(p).root).collect::<std::collections::BTreeSet<u32>>().len(),
        points: live.clone().count(),
        sections: live.filter(|p| p.on.is_some()).count(),
        curves: mesh.curves.iter().filter(|c| c.sides.iter().any(|list| !list.is_empty())).count(),
        components: mesh.components(),
        deepest_level: by_level.len() as u32 - 1,
        patches_by_level: by_level,
        space: mesh.colour.space.name(),
        blend: mesh.blend.name(),
        control_points: table.control.len(),
        indices: table.indices.len(),
        device_bytes: 32 * table.control.len() + 4 * table.indices.len(),
    };
    if global.json {
        return print_json(&report);
    }
    print(&format!(
        "{}: {} patches, {} in a traditional gradient mesh\n    {} points of which {} T-sections, {} curves, {} \
         components, {} patches of level 0\n    patches by level: {:?}\n    {} control points, {} indices, {} bytes on \
         the device\n",
        report.scene,
        report.patches,
        report.traditional,
        report.points,
        report.sections,
        report.curves,
        report.components,
        report.roots,
        report.patches_by_level,
        report.control_points,
        report.indices,
        report.device_bytes
    ));
    Ok(())
}
