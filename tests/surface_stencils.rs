//! Control points of surfaces as weighted sums: what the weights add up to, and seams bit by bit.

use glam::DVec3;
use gradtess::camera::bounds;
use gradtess::mesh;
use gradtess::scene::surface::SurfaceScene;
use gradtess::surface::adaptive::{Depth, Part};
use gradtess::surface::drawing;
use gradtess::surface::level::{Level, Scheme};
use gradtess::surface::patches::{first_level, patches, Patches};
use gradtess::surface::shade::Settings;
use gradtess::surface::triangulate::triangulate;
use std::collections::HashMap;

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1.1 0\nv 0 1 0\nv 0 0 1\nv 1 0.2 1\nv 1 1 1.3\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Smooth, creased, with a dart and a semi-sharp edge, and with corners.
const TAGS: [&str; 4] = [
    "",
    "t crease 5/1/0 0 1 5 4 0 10\nt crease 2/1/0 2 6 1.5\n",
    "t crease 2/1/0 2 6 10\nt corner 1/1/0 4 2.5\n",
    "t crease 3/1/0 0 1 2 3.25\nt crease 3/1/0 2 6 7 99\nt crease 3/1/0 1 5 6 99\n",
];

/// An open mesh with triangles, too.
const OPEN: &str = "v 0 0 0\nv 1 0 1\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 1 2 0\n\
    f 1 2 5 4\nf 2 3 6 5\nf 4 5 7\nf 5 6 7\nt crease 2/1/0 1 4 3\nt interpolateboundary 1/0/0 1\n";

fn all(test: impl Fn(&str, &[Part], &Patches)) {
    let texts: Vec<String> = TAGS.iter().map(|tags| format!("{CUBE}{tags}")).chain([OPEN.to_string()]).collect();
    for text in &texts {
        let scene = SurfaceScene::parse(text.as_bytes(), "test").unwrap();
        for (scene, scheme) in [(scene.clone(), Scheme::CatmullClark), (triangulate(&scene).0, Scheme::Loop)] {
            let control = Level::new(&scene, &mesh::build(&scene.polygons()).unwrap(), scheme).unwrap();
            let settings = Settings::default();
            for extra in [0, 3] {
                let depth = Depth::adaptive(first_level(&control) + extra, &settings);
                let (parts, made) = patches(&control, &scene.normals, &settings, depth);
                test(&format!("{scheme:?} +{extra} {text}"), &parts, &made);
            }
        }
    }
}

#[test]
fn weights_have_the_sum_1() {
    all(|name, _, made| {
        for row in 0..made.stencils.ends.len() as u32 {
            let sum: f64 = made.stencils.row(row).map(|(_, w)| w).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{name}: {sum}");
            assert!(made.stencils.row(row).all(|(i, _)| (i as usize) < made.sources.len()), "{name}");
        }
        let used: std::collections::HashSet<u32> = made.stencils.indices.iter().copied().collect();
        assert_eq!(used.len(), made.sources.len(), "{name}: sources that nothing needs");
    });
}

/// Control points along each side, from corner to corner.
fn sides(made: &Patches) -> HashMap<(u32, u32), Vec<u32>> {
    let quad = [vec![0, 1, 2, 3], vec![3, 7, 11, 15], vec![15, 14, 13, 12], vec![12, 8, 4, 0]];
    let triangle = gradtess::patch::quartic::SIDES.map(|side| side.to_vec());
    let mut sides = HashMap::new();
    let mut add = |ids: &[u32], place: gradtess::surface::patches::Place, along: &[Vec<usize>]| {
        for (e, side) in along.iter().enumerate() {
            let h = along.len() as u32 * place.face + e as u32;
            sides.insert((place.level, h), side.iter().map(|&k| ids[k]).collect());
        }
    };
    made.bicubic.iter().for_each(|(ids, place)| add(ids, *place, &quad));
    made.transition.iter().for_each(|t| add(&t.points, t.place, &quad));
    made.gregory.iter().for_each(|(ids, place)| add(ids, *place, &quad));
    made.quartic.iter().for_each(|(ids, place)| add(ids, *place, &triangle));
    made.quartic_transition.iter().for_each(|t| add(&t.points, t.place, &triangle));
    made.quartic_gregory.iter().for_each(|(ids, place)| add(ids, *place, &triangle));
    sides
}

#[test]
fn both_sides_of_every_edge_have_the_same_bits_in_single_precision() {
    all(|name, parts, made| {
        let table = drawing::patches(made, made.bounds().0);
        let stencils = table.stencils.as_ref().unwrap();
        let points = stencils.points_of(&table.vertices);
        let bits = |i: &u32| -> [u32; 4] { std::array::from_fn(|c| points[*i as usize][c].to_bits()) };
        let sides = sides(made);
        let mut met = 0;
        for (&(level, h), side) in &sides {
            let own = &parts[level as usize];
            let t = own.level.twin[h as usize];
            if let Some(other) = sides.get(&(level, t)) {
                assert!(side.iter().map(bits).eq(other.iter().rev().map(bits)), "{name}: level {level}, edge of {h}");
                met += 1;
            }
        }
        // Halves are the finer patches' sides.
        let mut halves_of = |halves: &[u32], sides_with: u8, corners: &[u32], level: u32, face: u32| {
            let n = corners.len() as u32;
            let each = if n == 4 { 5 } else { 7 };
            let with = (0..n).filter(|e| sides_with >> e & 1 == 1);
            for (k, e) in with.enumerate() {
                let half = &halves[each * k..][..each];
                let part = &parts[level as usize];
                let t = part.level.twin[(n * face + e) as usize];
                let [first, second] = [part.level.next(t), t].map(|h| n * part.child[h as usize]);
                let middle = each / 2;
                let ours = [
                    [&[corners[e as usize]], &half[..=middle]].concat(),
                    [&half[middle..], &[corners[(e as usize + 1) % n as usize]]].concat(),
                ];
                for (ours, finer) in ours.iter().zip([first + n - 1, second]) {
                    let theirs = &sides[&(level + 1, finer)];
                    assert!(ours.iter().map(bits).eq(theirs.iter().rev().map(bits)), "{name}: level {level}, {face}");
                    met += 1;
                }
            }
        };
        for t in &made.transition {
            let corners = [0, 3, 15, 12].map(|k: usize| t.points[k]);
            halves_of(&t.halves, t.sides, &corners, t.place.level, t.place.face);
        }
        for t in &made.quartic_transition {
            let corners = gradtess::patch::quartic::CORNERS.map(|k| t.points[k]);
            halves_of(&t.halves, t.sides, &corners, t.place.level, t.place.face);
        }
        assert!(met > made.len(), "{name}: {met}");
    });
}

#[test]
fn the_box_is_that_of_all_control_points() {
    all(|name, _, made| {
        let all = (0..made.points() as u32).map(|i| DVec3::from_slice(&made.control(i)));
        let (found, computed) = made.bounds();
        assert_eq!(Some(found), bounds(all), "{name}");
        assert!(computed <= made.points() + 6, "{name}: {computed} of {}", made.points());
    });
}

#[test]
fn weights_are_those_of_the_connectivity() {
    // The same cube elsewhere: other sources, the same stencils.
    let moved = CUBE.replace("v 1 1.1 0", "v 2 3.5 -1");
    let [a, b] = [CUBE, &moved].map(|text| {
        let scene = SurfaceScene::parse(format!("{text}{}", TAGS[1]).as_bytes(), "test").unwrap();
        let control = Level::new(&scene, &mesh::build(&scene.polygons()).unwrap(), Scheme::CatmullClark).unwrap();
        patches(&control, &[], &Settings::default(), Depth::adaptive(4, &Settings::default())).1
    });
    assert_eq!(a.stencils, b.stencils);
    assert_ne!(a.sources, b.sources);
}
