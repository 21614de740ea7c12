//! The authors' own models against what their tool makes of them. Skipped, in words, where the models are absent.

mod models;

use gradtess::mesh::{self, HalfEdgeMesh};
use gradtess::refine::{fate, refine, Mode, Options, Refinement, Rules};
use gradtess::scene::Scene;
use gradtess::subdiv::index_map::IndexMap;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

fn load(path: &Path) -> (Scene, HalfEdgeMesh) {
    let scene = Scene::load(path).unwrap_or_else(|e| panic!("{e}"));
    let mesh = mesh::build(&scene.mesh).unwrap();
    (scene, mesh)
}

/// Rows of a table with a header line, each as name to text.
fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split('\t').collect();
    let row = |l: &str| head.iter().map(|h| h.to_string()).zip(l.split('\t').map(str::to_string)).collect();
    lines.map(row).collect()
}

/// One drawn face as the authors' lists have it: level, face, first half-edge, kind, transition.
fn drawn(r: &Refinement, map: &IndexMap) -> HashSet<String> {
    let mut rows = HashSet::new();
    for (level, fates) in r.levels.iter().zip(&r.fates) {
        for f in 0..level.faces() as u32 {
            let bits = fates[f as usize];
            if bits & fate::DRAWN == 0 {
                continue;
            }
            let slot = gradtess::refine::forest::first_slot(map, level.level, level.face[f as usize]);
            let kind = if bits & fate::IRREGULAR != 0 { "G" } else { "B" };
            let mask = bits >> fate::TRANSITION;
            let digits: String = (0..4).map(|i| if mask >> i & 1 == 1 { '1' } else { '0' }).collect();
            let (c, _) = gradtess::patch::transition::standard_position(mask);
            let transition = if mask == 0 { "-".to_string() } else { format!("C{c}:{digits}") };
            rows.insert(format!(
                "{}\t{}\t{}\t{kind}\t{transition}",
                level.level,
                map.face_app_a(level.level, slot),
                map.to_app_a(level.level, slot)
            ));
        }
    }
    rows
}

#[test]
fn patch_lists_are_the_authors() {
    let Some(folder) = models::folder("paper", "patch_lists_are_the_authors") else { return };
    for entry in std::fs::read_dir(folder.join("patches")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().replace("__", "/");
        let (scene, mesh) = load(&folder.join(format!("{name}.obj")));
        let map = IndexMap::new(&mesh);
        let r = refine(&scene, &mesh, Options { rules: Rules::Authors, mode: Mode::Adaptive { isolate: 0 } }).unwrap();
        let ours = drawn(&r, &map);
        let text = std::fs::read_to_string(&path).unwrap();
        let theirs: HashSet<String> = text.lines().skip(1).map(str::to_string).collect();
        let missing: Vec<_> = theirs.difference(&ours).take(5).collect();
        let extra: Vec<_> = ours.difference(&theirs).take(5).collect();
        assert!(missing.is_empty() && extra.is_empty(), "{name}: missing {missing:?}, extra {extra:?}");
        println!("{name}: {} patches equal", ours.len());
    }
}

#[test]
fn meshes_of_every_level_are_the_authors() {
    let Some(folder) = models::folder("paper", "meshes_of_every_level_are_the_authors") else { return };
    for entry in std::fs::read_dir(folder.join("dumps")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().replace("__", "/");
        let (scene, mesh) = load(&folder.join(format!("{name}.obj")));
        let map = IndexMap::new(&mesh);
        let dump: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        for want in dump["levels"].as_array().unwrap() {
            let l = want["level"].as_u64().unwrap() as u32;
            let r = refine(&scene, &mesh, Options { rules: Rules::Authors, mode: Mode::Global(l) }).unwrap();
            let level = r.levels.last().unwrap();
            let list = |key: &str| want[key].as_array().unwrap();
            assert_eq!(list("vertices").len(), level.vertices());
            assert_eq!(list("face_first_he").len(), level.faces());
            let (mut worst, mut worst_colour) = (0.0f64, 0.0f64);
            for h in 0..level.half_edges() as u32 {
                let slot = 4 * level.face[level.face_of(h) as usize] + u64::from(h & 3);
                let slot = if l == 0 { u64::from(h) } else { slot };
                let id = map.to_app_a(l, slot) as usize;
                let v = map.vertex(l, slot) as usize;
                let p = level.position(h);
                let q = &list("vertices")[v];
                worst = worst.max((p.x - q[0].as_f64().unwrap()).abs()).max((p.y - q[1].as_f64().unwrap()).abs());
                assert_eq!(list("he_target")[id].as_u64().unwrap(), map.vertex(l, map.next(l, slot)));
                assert_eq!(list("he_next")[id].as_u64().unwrap(), map.to_app_a(l, map.next(l, slot)));
                let twin = match map.twin(l, slot) {
                    Some(t) => map.to_app_a(l, t),
                    None => map.boundary_app_a(l, slot),
                };
                assert_eq!(list("he_twin")[id].as_u64().unwrap(), twin);
                assert_eq!(list("he_face")[id].as_u64().unwrap(), map.face_app_a(l, slot));
                let sharp = level.colour_border(h);
                assert_eq!(list("he_sharp")[id].as_u64().unwrap() == 1, sharp, "{name} level {l} half-edge {id}");
                let c = level.corner_colour(h);
                for (k, x) in [c.x, c.y, c.z].into_iter().enumerate() {
                    worst_colour = worst_colour.max((x - list("he_color")[id][k].as_f64().unwrap()).abs());
                }
            }
            println!("{name} level {l}: positions within {worst:.1e}, colours within {worst_colour:.1e}");
            assert!(worst < 2e-5 && worst_colour < 1e-6, "{name} level {l}: {worst} {worst_colour}");
        }
    }
}

#[test]
fn counts_are_those_of_table_1() {
    let Some(folder) = models::folder("paper", "counts_are_those_of_table_1") else { return };
    for row in table(&folder.join("counts.tsv")) {
        let (scene, mesh) = load(&folder.join(&row["file"]));
        let r = refine(&scene, &mesh, Options { rules: Rules::Authors, mode: Mode::Adaptive { isolate: 0 } }).unwrap();
        let (mut b, mut bt, mut g, mut gt) = (0, 0, 0, 0);
        let mut constellations = [0; 6];
        for bits in r.fates.iter().flatten().filter(|&b| b & fate::DRAWN != 0) {
            let transition = usize::from(bits >> fate::TRANSITION != 0);
            constellations[gradtess::patch::transition::standard_position(bits >> fate::TRANSITION).0 as usize] += 1;
            if bits & fate::IRREGULAR != 0 {
                (g, gt) = (g + 1, gt + transition);
            } else {
                (b, bt) = (b + 1, bt + transition);
            }
        }
        let number = |key: &str| row[key].parse::<usize>().unwrap();
        assert_eq!(constellations[1..], ["C1", "C2", "C3", "C4", "C5"].map(number), "{}", row["file"]);
        assert_eq!(
            [b, bt, g, gt, b + g],
            [
                number("bicubic"),
                number("bicubic_transition"),
                number("gregory"),
                number("gregory_transition"),
                number("total")
            ],
            "{}",
            row["file"]
        );
    }
}

/// The authors' order: per corner i its point, near and far point of edge i, then what lies inside.
fn authors_order(points: &[[f64; 8]]) -> Vec<[f64; 8]> {
    const CORNER: [usize; 4] = [0, 3, 15, 12];
    const NEAR: [usize; 4] = [1, 7, 14, 8];
    const FAR: [usize; 4] = [2, 11, 13, 4];
    const INNER: [usize; 4] = [5, 6, 10, 9];
    let mut out = Vec::new();
    for i in 0..4 {
        out.extend([CORNER[i], NEAR[i], FAR[i], INNER[i]].map(|k| points[k]));
        if points.len() == 20 {
            out.push(points[16 + (i + 1) % 4]);
        }
    }
    out
}

#[test]
fn control_points_of_every_patch_are_the_authors() {
    use gradtess::patch::{build, points::Irregular, Kind};
    let Some(folder) = models::folder("paper", "control_points_of_every_patch_are_the_authors") else { return };
    for entry in std::fs::read_dir(folder.join("dumps")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().replace("__", "/");
        let (scene, mesh) = load(&folder.join(format!("{name}.obj")));
        let map = IndexMap::new(&mesh);
        let r = refine(&scene, &mesh, Options { rules: Rules::Authors, mode: Mode::Adaptive { isolate: 0 } }).unwrap();
        let table = build::build(&r, Irregular::Gregory);
        let dump: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let mut theirs = BTreeMap::new();
        for p in dump["patches"].as_array().unwrap() {
            theirs.insert((p["level"].as_u64().unwrap() as u32, p["face"].as_u64().unwrap()), p);
        }
        assert_eq!(theirs.len(), table.faces.len());
        let (mut worst, mut worst_colour) = (0.0f64, 0.0f64);
        let mut bad = 0;
        for face in &table.faces {
            let slot = gradtess::refine::forest::first_slot(&map, face.level, face.name);
            let want = theirs[&(face.level, map.face_app_a(face.level, slot))];
            let greg = face.kind == Kind::Gregory;
            assert_eq!(want["kind"].as_str().unwrap(), if greg { "gregory" } else { "bicubic" });
            let mut points = authors_order(&build::face_control(&table, face));
            // Their lists start at the face's first half-edge even where the patch is turned.
            let step = if greg { 5 } else { 4 };
            points.rotate_right(step * face.turn as usize);
            for (k, (p, q)) in points.iter().zip(want["cp"].as_array().unwrap()).enumerate() {
                let q: Vec<f64> = q.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
                let dp = (p[0] - q[0]).abs().max((p[1] - q[1]).abs());
                let dc = (0..3).map(|c| (p[4 + c] - q[2 + c]).abs()).fold(0.0, f64::max);
                if dp > 2e-5 || dc > 2e-6 {
                    bad += 1;
                    if bad < 20 {
                        println!(
                            "{name} level {} face {} {} {:?} point {k}: {p:?} {q:?}",
                            face.level, want["face"], want["kind"], want["transition"]
                        );
                    }
                }
                (worst, worst_colour) = (worst.max(dp), worst_colour.max(dc));
            }
        }
        println!("{name}: control points within {worst:.1e}, colours within {worst_colour:.1e}, {bad} beyond");
        assert!(bad == 0, "{name}");
    }
}
