//! The structure of locally refinable gradient meshes: exact splits, their removal, the chain of updates, undo.

use ferguson_meshes::{change, close, random_split, ring, wavy, Random};
use glam::{DVec2, DVec4};
use gradtess::ferguson::inherit::Continuity;
use gradtess::ferguson::mesh::{HalfEdge, Mesh};
use gradtess::ferguson::split::Axis;

mod ferguson_meshes;

#[test]
fn a_thousand_random_splits_change_nothing() {
    for (name, mesh) in [("grid", wavy(2, 3)), ("one patch", wavy(1, 1)), ("ring", ring(5, 2))] {
        for dyadic in [true, false] {
            let mut split = mesh.clone();
            let mut random = Random::new(7);
            for _ in 0..1000 {
                random_split(&mut split, &mut random, dyadic);
            }
            assert_eq!(split.fault(), None, "{name}");
            let worst = change(&mesh, &split, &mut random);
            println!("{name}, dyadic {dyadic}: position {:.1e} of the canvas, colour {:.1e}", worst[0], worst[1]);
            assert!(worst.iter().all(|&w| w <= 1e-12), "{name} {worst:?}");
        }
    }
}

#[test]
fn removing_all_splits_gives_the_mesh_back() {
    let original = wavy(2, 2);
    let mut mesh = original.clone();
    let mut random = Random::new(3);
    for _ in 0..60 {
        random_split(&mut mesh, &mut random, true);
    }
    loop {
        let before = mesh.live().count();
        for c in 0..mesh.curves.len() as u32 {
            let _ = mesh.remove_split(c);
            assert_eq!(mesh.fault(), None);
        }
        if mesh.live().count() == before {
            break;
        }
    }
    assert_eq!(mesh.live().count(), 4);
    for root in 0..4 {
        for (u, v) in [(0.1, 0.9), (0.5, 0.5), (0.77, 0.13)] {
            let (a, b) = (original.evaluate(root, u, v), mesh.evaluate(root, u, v));
            assert!(close(a.0, b.0, 1e-10) && (a.1 - b.1).abs().max_element() < 1e-9);
        }
    }
}

#[test]
fn an_edited_split_stays() {
    let mut mesh = wavy(1, 1);
    let split = mesh.split(0, Axis::U, 0.5).unwrap();
    let end = mesh.curve(split.curve).ends[0];
    mesh.set_colour(end, DVec4::new(1.0, 0.0, 0.0, 1.0), Continuity::C1).unwrap();
    assert!(mesh.remove_split(split.curve).is_err());
    assert_eq!(mesh.fault(), None);
}

/// Fig. 10: the opposite is not symmetric near T-sections, and the outgoing link of one is its stem.
#[test]
fn links_near_sections_are_those_of_the_figure() {
    let mut mesh = wavy(2, 1);
    // The right patch is cut twice across the curve in the middle.
    let first = mesh.split(1, Axis::V, 0.5).unwrap();
    mesh.split(first.first, Axis::V, 0.5).unwrap();
    let long = HalfEdge::new(0, 1);
    let sections = mesh.sections(long);
    assert_eq!(sections.len(), 2);
    let opposite = mesh.opposite(long).unwrap();
    assert_eq!(opposite, HalfEdge::new(first.first, 3), "the one that ends where the long one begins");
    for (o, _) in sections {
        let point = mesh.corner(o).point;
        assert_eq!(mesh.opposite(o), Some(long));
        let stem = mesh.outgoing(point).unwrap();
        assert_ne!(mesh.side(stem).curve, mesh.side(long).curve);
    }
    assert_eq!(mesh.side(HalfEdge::new(first.first, 3)).level, 2);
    // Fig. 12: handles of the short parts are the long one's, scaled.
    let (q, s) = (mesh.half_edge(long), mesh.half_edge(HalfEdge::new(first.first, 3)));
    assert!(close((s[3] - s[2]) * 4.0, q[0] - q[1], 1e-15));
}

/// Largest difference across all curves of position, cross derivative per unit of the roots' domains, and colour.
fn jumps(mesh: &Mesh) -> [f64; 3] {
    let mut worst = [0.0f64; 3];
    for p in mesh.live() {
        for i in 0..4 {
            let h = HalfEdge::new(p, i);
            for k in 1..8 {
                let s = f64::from(k) / 8.0;
                let side = mesh.side(h);
                let t = if side.against {
                    side.to - s * (side.to - side.from)
                } else {
                    side.from + s * (side.to - side.from)
                };
                let across = &mesh.curve(side.curve).sides[usize::from(!side.against)];
                let Some(&o) = across.iter().find(|&&o| mesh.side(o).from <= t && t <= mesh.side(o).to) else {
                    continue;
                };
                let so = mesh.side(o);
                let fraction = (t - so.from) / (so.to - so.from);
                let fraction = if so.against { 1.0 - fraction } else { fraction };
                let at = |h: HalfEdge, s: f64| [[s, 0.0], [1.0, s], [1.0 - s, 1.0], [0.0, 1.0 - s]][h.side()];
                let e = 1e-5;
                let inward = |h: HalfEdge, [u, v]: [f64; 2]| {
                    let [du, dv] = [[0.0, e], [-e, 0.0], [0.0, -e], [e, 0.0]][h.side()];
                    [u + du, v + dv]
                };
                let depth = |p: u32, h: HalfEdge| mesh.patch(p).extent()[usize::from(h.side() % 2 == 0)];
                let (a, b) = (at(h, s), at(o, fraction));
                let (xa, xb) = (mesh.evaluate(p, a[0], a[1]), mesh.evaluate(o.patch(), b[0], b[1]));
                worst[0] = worst[0].max((xa.0 - xb.0).abs().max_element());
                worst[2] = worst[2].max((xa.1 - xb.1).abs().max_element());
                let (ia, ib) = (inward(h, a), inward(o, b));
                let (ya, yb) = (mesh.evaluate(p, ia[0], ia[1]), mesh.evaluate(o.patch(), ib[0], ib[1]));
                let da = (ya.0 - xa.0) / (e * depth(p, h));
                let db = (yb.0 - xb.0) / (e * depth(o.patch(), o));
                worst[1] = worst[1].max((da + db).abs().max_element());
            }
        }
    }
    worst
}

/// Fig. 10: moving a handle of a long curve updates T1 and T2 on it, then T3, then T4.
#[test]
fn chains_of_sections_stay_smooth_in_c1_mode() {
    let mut mesh = Mesh::grid(3, 3, [0.0, 0.0, 3.0, 3.0], |i, j| {
        DVec4::new(f64::from(i) / 3.0, f64::from(j) / 3.0, f64::from((i + j) % 2), 1.0)
    })
    .unwrap();
    // Right of the first column: a chain of patches that get smaller from bar to bar.
    let a = mesh.split(4, Axis::V, 0.5).unwrap();
    let b = mesh.split(a.first, Axis::U, 0.5).unwrap();
    let c = mesh.split(b.second, Axis::V, 0.5).unwrap();
    mesh.split(c.second, Axis::U, 0.5).unwrap();
    mesh.split(a.second, Axis::U, 0.25).unwrap();
    mesh.take_journal();
    assert!(jumps(&mesh)[1] < 1e-4);
    let mut random = Random::new(11);
    for round in 0..40 {
        let c = random.below(mesh.curves.len()) as u32;
        let end = random.below(2);
        let by = DVec2::new(random.unit() - 0.5, random.unit() - 0.5) * 0.2;
        let to = mesh.curve(c).handles[end] + by;
        let _ = mesh.move_handle(c, end, to, Continuity::C1);
        let point = random.below(mesh.points.len()) as u32;
        let to = mesh.at(point) + by * 0.5;
        let _ = mesh.move_point(point, to, Continuity::C1);
        let _ = mesh.set_colour(point, DVec4::new(random.unit(), random.unit(), random.unit(), 1.0), Continuity::C1);
        assert_eq!(mesh.fault(), None);
        let j = jumps(&mesh);
        assert!(j[0] < 1e-12 && j[2] < 1e-12, "round {round}: {j:?}");
        assert!(j[1] < 1e-3, "round {round}: {j:?}");
    }
}

#[test]
fn c0_mode_keeps_the_mesh_whole_and_leaves_stems_free() {
    let mut mesh = wavy(2, 1);
    let split = mesh.split(1, Axis::V, 0.5).unwrap();
    let stem = mesh.curve(split.curve).clone();
    let end = stem.ends.iter().position(|&p| mesh.points[p as usize].on.is_some()).unwrap();
    let to = stem.handles[end] + DVec2::new(0.1, 0.05);
    assert!(mesh.move_handle(split.curve, end, to, Continuity::C1).is_err(), "inherited data cannot be edited");
    mesh.move_handle(split.curve, end, to, Continuity::C0).unwrap();
    assert_eq!(mesh.curve(split.curve).handles[end], to);
    // The bar moves: the T-section with it, the stem's handle too.
    let bar = mesh.side(HalfEdge::new(0, 1)).curve;
    mesh.move_handle(bar, 0, mesh.curve(bar).handles[0] + DVec2::new(0.3, 0.0), Continuity::C0).unwrap();
    assert_ne!(mesh.curve(split.curve).handles[end], to);
    let j = jumps(&mesh);
    assert!(j[0] < 1e-12 && j[2] < 1e-12, "{j:?}");
    assert!(j[1] > 1e-3, "the crease is there");
}

#[test]
fn a_sector_colour_is_sharp_and_local() {
    let mut mesh = wavy(2, 2);
    mesh.take_journal();
    let centre = mesh.points.iter().position(|p| p.corners.len() == 4).unwrap() as u32;
    let corner = mesh.points[centre as usize].corners[0];
    mesh.set_sector_colour(corner, DVec4::new(0.9, 0.1, 0.2, 1.0), Continuity::C1).unwrap();
    assert_eq!(mesh.take_journal().changed().collect::<Vec<_>>(), [corner.patch()]);
    assert!(jumps(&mesh)[2] > 0.05);
}

#[test]
fn edits_touch_what_changes_and_no_more() {
    let mut mesh =
        Mesh::grid(100, 100, [0.0, 0.0, 1.0, 1.0], |i, j| DVec4::new(f64::from(i % 2), f64::from(j % 2), 0.5, 1.0))
            .unwrap();
    assert_eq!(mesh.live().count(), 10_000);
    mesh.take_journal();
    mesh.split(5050, Axis::U, 0.5).unwrap();
    let journal = mesh.take_journal();
    // The patch itself; its neighbours keep their record, for the curves stay whole.
    assert_eq!(journal.changed().collect::<Vec<_>>(), [5050]);
    let side = *mesh.side(HalfEdge::new(5050, 3));
    mesh.move_handle(side.curve, 0, mesh.curve(side.curve).handles[0] + DVec2::new(1e-3, 0.0), Continuity::C1).unwrap();
    let journal = mesh.take_journal();
    // Two along the curve, two along the mirrored one, and the other half of the split at its T-section.
    assert_eq!(journal.changed().collect::<Vec<_>>(), [4949, 4950, 5049, 5050, 10_000]);
    let point = mesh.corner(HalfEdge::new(3333, 0)).point;
    mesh.move_point(point, mesh.at(point) + DVec2::new(1e-3, 1e-3), Continuity::C1).unwrap();
    assert_eq!(mesh.take_journal().changed().count(), 4);
}

#[test]
fn undo_takes_everything_back() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut mesh = if seed % 2 == 0 { wavy(3, 2) } else { ring(6, 2) };
        mesh.take_journal();
        let mut states = Vec::new();
        for _ in 0..30 {
            let before = mesh.clone();
            let mode = if random.below(2) == 0 { Continuity::C1 } else { Continuity::C0 };
            let point = random.below(mesh.points.len()) as u32;
            let c = random.below(mesh.curves.len()) as u32;
            match random.below(6) {
                0 | 1 => random_split(&mut mesh, &mut random, true),
                2 => drop(mesh.remove_split(c)),
                3 => {
                    let to = mesh.at(point) + DVec2::splat(0.01);
                    drop(mesh.move_point(point, to, mode));
                }
                4 => {
                    let to = mesh.curve(c).handles[0] + DVec2::splat(0.01);
                    drop(mesh.move_handle(c, 0, to, mode));
                }
                _ => drop(mesh.set_colour(point, DVec4::new(random.unit(), 0.5, 0.5, 1.0), mode)),
            }
            assert_eq!(mesh.fault(), None, "seed {seed}");
            states.push((before, mesh.take_journal()));
        }
        while let Some((before, journal)) = states.pop() {
            mesh.undo(journal);
            assert!(mesh == before, "seed {seed}, step {}", states.len());
        }
    }
}
