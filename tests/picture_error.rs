//! The error of pictures: known errors are found in full, and exact patches have none.

mod gpu_support;

use glam::DVec2;
use gpu_support::with_gpu;
use gradtess::check::limit_picture::{opaque, LimitPicture};
use gradtess::check::picture_error::{Compared, PictureError};
use gradtess::gpu::{Format, Frame, Gpu, Pixels, Show};
use gradtess::mesh;
use gradtess::patch::build::build;
use gradtess::patch::points::Irregular;
use gradtess::patch::tess::TessRule;
use gradtess::patch::{Kind, PatchTable};
use gradtess::refine::{refine, Mode, Options, Rules};
use gradtess::scene::Scene;

const SIZE: u32 = 96;

/// The error of a scene's picture after `spoil` has changed its patches.
fn error(gpu: &Gpu, file: &str, options: Options, spoil: impl Fn(&mut PatchTable)) -> (PictureError, PatchTable) {
    let scene = Scene::load(format!("{}/scenes/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let mesh = mesh::build(&scene.mesh).unwrap();
    let drawn = refine(&scene, &mesh, options).unwrap();
    let mut table = opaque(&build(&drawn, Irregular::Gregory));
    spoil(&mut table);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for c in &table.control {
        let p = DVec2::new(c[0], c[1]);
        (low, high) = (low.min(p), high.max(p));
    }
    let side = (high - low).max_element() * 0.55;
    let middle = (low + high) * 0.5;
    let view = [middle.x - side, middle.y - side, middle.x + side, middle.y + side];
    let limit = refine(&scene, &mesh, Options::default()).unwrap();
    let frame = |tess| Frame {
        width: SIZE,
        height: SIZE,
        view,
        tess,
        show: Show::Surface,
        background: None,
        samples: 1,
        format: Format::Rgba32f,
        statistics: false,
    };
    let draw = |table: &PatchTable, tess| match gpu.render(&gpu.upload(table).unwrap(), &frame(tess)).unwrap().pixels {
        Pixels::Rgba32f(pixels) => pixels,
        Pixels::Rgba8(_) => panic!("floats were asked for"),
    };
    let tess = TessRule::Fixed(32.0);
    let mut picture = LimitPicture::new(&limit, view, frame(tess).scale());
    let (a, b) = (draw(&table, tess), draw(&picture.table, TessRule::Fixed(1.0)));
    let compared = Compared { drawn: &drawn, table: &table, limit: &limit, view, size: [SIZE; 2], tess };
    (compared.pictures(&mut picture, &a, &b), table)
}

const ADAPTIVE: Options = Options { rules: Rules::Gradtess, mode: Mode::Adaptive { isolate: 0 } };

#[test]
fn exact_patches_have_no_error_and_a_lost_channel_is_one() {
    with_gpu(|gpu| {
        for (file, options) in [
            ("unit/geometry_level_2.json", ADAPTIVE),
            ("unit/geometry_level_2.json", Options { rules: Rules::Authors, ..ADAPTIVE }),
            ("unit/sharp_edge.json", ADAPTIVE),
            ("unit/hole.json", Options { mode: Mode::Global(2), ..ADAPTIVE }),
        ] {
            let (exact, _) = error(gpu, file, options, |_| ());
            assert!(exact.all.pixels > 1000 && exact.coverage == 0, "{file}: {:?}", exact.all);
            assert!(exact.by_kind[0].max < 0.02, "{file}: {:?}", exact.by_kind);
            // Twice full is shown as full: off by what each pixel lacks of blue, at most the whole channel.
            let (blue, _) = error(gpu, file, options, |table| {
                table.control.iter_mut().for_each(|c| c[6] = 2.0);
            });
            assert!(blue.all.mean > 10.0 && blue.all.max <= 100.0 / 3f64.sqrt(), "{file}: {:?}", blue.all);
        }
    });
}

#[test]
fn the_worst_pixel_lies_in_the_patch_that_was_spoiled() {
    with_gpu(|gpu| {
        let spoiled = 5;
        let (error, table) = error(gpu, "quad.json", ADAPTIVE, |table| {
            // An inner point belongs to one patch only: 4/9 squared of its step is seen at (1/3, 1/3).
            let first = table.faces[spoiled].first as usize;
            let point = table.indices[first + 5] as usize;
            table.control[point][4] += if table.control[point][4] > 0.5 { -0.1 } else { 0.1 };
            table.control[point][0] += 0.01;
        });
        let (_, place) = error.worst.unwrap();
        assert_eq!(place.face, Some(spoiled));
        assert!((place.uv[0] - 1.0 / 3.0).abs() < 0.2 && (place.uv[1] - 1.0 / 3.0).abs() < 0.2, "{place:?}");
        let expected = 100.0 * 0.1 * (4.0 / 9.0f64).powi(2) / 3f64.sqrt();
        assert!((error.all.max / expected - 1.0).abs() < 0.35, "{} for {expected}", error.all.max);
        assert_eq!(error.shift_at.unwrap().face, Some(spoiled));
        assert_eq!(table.faces[spoiled].kind, Kind::Bicubic);
    });
}

#[test]
fn darts_and_meeting_sharp_edges_are_drawn_within_a_twentieth_of_a_per_cent_and_isolation_halves_the_rest() {
    with_gpu(|gpu| {
        for file in ["unit/sharp_dart.json", "unit/sharp_two_meet.json", "unit/sharp_three_meet.json"] {
            let (ours, _) = error(gpu, file, ADAPTIVE, |_| ());
            assert!(ours.all.max < 0.05 && ours.coverage == 0, "{file}: {:?}", ours.all);
        }
        for file in ["unit/valence_6.json", "hexagon.json"] {
            let at = |isolate: u32| {
                let options = Options { mode: Mode::Adaptive { isolate }, ..ADAPTIVE };
                error(gpu, file, options, |_| ()).0.all.max
            };
            assert!(at(1) < 0.5 * at(0), "{file}: {} to {}", at(0), at(1));
        }
    });
}

#[test]
fn pixels_where_the_surface_folds_over_are_counted_apart_and_the_others_agree() {
    with_gpu(|gpu| {
        let isolated = Options { mode: Mode::Adaptive { isolate: 3 }, ..ADAPTIVE };
        let (folded, _) = error(gpu, "unit/concave_face.json", isolated, |_| ());
        // The two pictures show different layers somewhere, which is no error of the patches.
        assert!(folded.folds.pixels > 20 && folded.folds.max > 1.0, "{:?}", folded.folds);
        assert!(folded.all.pixels > 20 * folded.folds.pixels && folded.all.max < 0.02, "{:?}", folded.all);
        for file in ["quad.json", "unit/sharp_edge.json", "unit/valence_6.json"] {
            assert_eq!(error(gpu, file, ADAPTIVE, |_| ()).0.folds.pixels, 0, "{file}");
        }
    });
}
