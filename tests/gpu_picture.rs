//! Pictures of hand-made tables: where pixels lie, that each is covered exactly once, what they show, and how many times
//! shaders ran.

mod gpu_support;

use gpu_support::*;
use gradtess::gpu::{level_colour, patch_colour, Format, Frame, Gpu, GpuError, Pixels, Show, WIRE_COLOUR};
use gradtess::image::Picture;
use gradtess::patch::tess::{quad_vertices, triangle_vertices, TessRule};
use gradtess::patch::transition::{parts_of, Side, PARTS};
use gradtess::patch::{eval, ControlPoint, DrawRange, Kind, PatchTable};

/// A face that is the rectangle [x0, y0, x1, y1] itself, red as x, green as y, blue 0, with this alpha.
fn flat(kind: Kind, [x0, y0, x1, y1]: [f64; 4], alpha: f64) -> Vec<ControlPoint> {
    (0..kind.points())
        .map(|i| {
            let grid = [5, 6, 10, 9].get(i.wrapping_sub(16)).copied().unwrap_or(i);
            let x = x0 + (x1 - x0) * (grid % 4) as f64 / 3.0;
            let y = y0 + (y1 - y0) * (grid / 4) as f64 / 3.0;
            [x, y, 0.0, 0.0, x, y, 0.0, alpha]
        })
        .collect()
}

fn table_of(kind: Kind, faces: &[Vec<ControlPoint>]) -> PatchTable {
    let mut builder = Builder::default();
    for face in faces {
        builder.whole(kind, 0, face);
    }
    builder.table
}

fn floats(pixels: Pixels) -> Vec<[f32; 4]> {
    match pixels {
        Pixels::Rgba32f(floats) => floats.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect(),
        Pixels::Rgba8(_) => panic!("floats were asked for"),
    }
}

fn picture(rendered: gradtess::gpu::Rendered) -> Picture {
    let (width, height) = (rendered.width, rendered.height);
    rendered.pixels.into_picture(width, height)
}

#[test]
fn pixels_sample_the_view_at_their_centres() {
    with_gpu(|gpu| {
        for kind in KINDS {
            let table = gpu.upload(&table_of(kind, &[flat(kind, [-1.0, -1.0, 2.0, 2.0], 1.0)])).unwrap();
            for samples in [1, 4] {
                let view = [0.1, 0.25, 0.7, 0.9];
                let (width, height) = (61, 37);
                let frame = Frame { width, height, view, samples, format: Format::Rgba32f, ..frame(1) };
                let drawn = floats(gpu.render(&table, &frame).unwrap().pixels);
                assert_eq!(drawn.len(), 61 * 37);
                // The rasteriser snaps vertices to 1/256 of a pixel.
                let within = 0.6 / 61.0 / 100.0;
                for (at, pixel) in drawn.into_iter().enumerate() {
                    let (i, j) = ((at % 61) as f64, (at / 61) as f64);
                    let x = view[0] + (i + 0.5) * (view[2] - view[0]) / f64::from(width);
                    let y = view[3] - (j + 0.5) * (view[3] - view[1]) / f64::from(height);
                    for (got, expected) in pixel.into_iter().zip([x, y, 0.0, 1.0]) {
                        assert!((f64::from(got) - expected).abs() < within, "{i},{j}: {pixel:?} for {x},{y}");
                    }
                }
            }
        }
    });
}

#[test]
fn a_rectangle_covers_its_pixels_and_no_others() {
    with_gpu(|gpu| {
        let table = table_of(Kind::Bicubic, &[flat(Kind::Bicubic, [0.25, 0.5, 0.75, 1.0], 1.0)]);
        let table = gpu.upload(&table).unwrap();
        for samples in [1, 4] {
            for format in [Format::Rgba8, Format::Rgba32f] {
                let picture = picture(gpu.render(&table, &Frame { samples, format, ..frame(16) }).unwrap());
                for y in 0..16 {
                    for x in 0..16 {
                        let inside = (4..12).contains(&x) && y < 8;
                        assert_eq!(picture.pixel(x, y)[3], if inside { 255 } else { 0 }, "{x},{y}");
                    }
                }
            }
        }
        // Half a pixel more on every side: four samples see it in part, with the colour of the patch unchanged.
        let edge = 0.5 / 16.0;
        let rectangle = [0.25 - edge, 0.5 - edge, 0.75 + edge, 0.9];
        let table = gpu.upload(&table_of(Kind::Bicubic, &[flat(Kind::Bicubic, rectangle, 1.0)])).unwrap();
        let picture = picture(gpu.render(&table, &Frame { samples: 4, ..frame(16) }).unwrap());
        let [r, _, b, a] = picture.pixel(3, 6);
        assert!(a.abs_diff(128) <= 1 && b == 0, "{:?}", picture.pixel(3, 6));
        // Straight alpha: the red of x near 0.23, not half of it.
        assert!((50..=62).contains(&r), "{:?}", picture.pixel(3, 6));
    });
}

/// A face in the middle of a square with its neighbours all around: two finer ones along each transition edge.
fn mosaic(kind: Kind, constellation: u8, spread: f64, random: &mut Random) -> PatchTable {
    let mut builder = Builder::default();
    let mut face = random_face(kind, random, [0.35, 0.35, 0.3, 0.3], spread);
    for point in &mut face {
        point[7] = 0.5;
    }
    builder.transition(kind, 1, &face, constellation);
    let is_split = |e: u8| !parts_of(constellation).any(|number| PARTS[number].sides.contains(&Side::Full(e)));
    // Corners and midpoints of the outer square, out of the view.
    let outer = |e: usize, half: usize| -> [f64; 2] {
        let corners = [[-0.1, -0.1], [1.1, -0.1], [1.1, 1.1], [-0.1, 1.1]];
        let (a, b): ([f64; 2], [f64; 2]) = (corners[e], corners[(e + 1) % 4]);
        [0, 1].map(|c| a[c] + (b[c] - a[c]) * half as f64 / 2.0)
    };
    for e in 0..4 {
        let cubic = eval::FACE_EDGES[e].map(|i| face[i]);
        let cubics = if is_split(e as u8) {
            vec![
                (half_of(cubic, false), outer(e, 0), outer(e, 1), 2),
                (half_of(cubic, true), outer(e, 1), outer(e, 2), 2),
            ]
        } else {
            vec![(cubic, outer(e, 0), outer(e, 2), 1)]
        };
        for (inner, from, to, level) in cubics {
            // Ruled from the outer line (row 0) to the cubic (row 3), so that it is counter-clockwise too.
            let points: Vec<ControlPoint> = (0..16)
                .map(|i| {
                    let (column, row) = (i % 4, (i / 4) as f64 / 3.0);
                    let mut p = f32_exact(inner[column]);
                    for c in 0..2 {
                        let far = from[c] + (to[c] - from[c]) * column as f64 / 3.0;
                        p[c] = if i / 4 == 3 { p[c] } else { far + (p[c] - far) * row };
                    }
                    p
                })
                .collect();
            builder.whole(Kind::Bicubic, level, &points);
        }
    }
    builder.table
}

/// Least and greatest alpha of a mosaic's pixels at several levels, each pixel drawn with 1 and 4 samples. A patch has
/// alpha 1/2: a sample that nothing covers has 0, one that two patches cover 3/4.
fn alpha_range(gpu: &Gpu, spread: f64, seed: u64) -> (f32, f32) {
    let mut random = Random::new(seed);
    let (mut least, mut most) = (1.0f32, 0.0f32);
    for kind in KINDS {
        for constellation in 1..=5 {
            let table = gpu.upload(&mosaic(kind, constellation, spread, &mut random)).unwrap();
            let rules = [1.0, 2.0, 3.0, 5.0, 7.0, 16.0].map(TessRule::Fixed);
            let mut rules: Vec<TessRule> = rules.into_iter().chain([TessRule::Pixels(6.0)]).collect();
            if constellation == 5 {
                // Only here are all the neighbours of one level, so that they meet each other by this rule too.
                rules.extend([TessRule::Base(12.0), TessRule::Base(5.0)]);
            }
            for tess in rules {
                for samples in [1, 4] {
                    let frame = Frame { tess, samples, format: Format::Rgba32f, ..frame(200) };
                    for pixel in floats(gpu.render(&table, &frame).unwrap().pixels) {
                        least = least.min(pixel[3]);
                        most = most.max(pixel[3]);
                    }
                }
            }
        }
    }
    (least, most)
}

#[test]
fn every_pixel_of_a_mosaic_is_covered_exactly_once() {
    with_gpu(|gpu| {
        let (least, most) = alpha_range(gpu, 0.03, 21);
        assert!(least > 0.499 && most < 0.501, "alpha {least} to {most}");
    });
}

#[test]
fn a_mosaic_of_strongly_curved_patches_has_no_holes() {
    with_gpu(|gpu| {
        // A coarse chord can cut off the patch's own inner vertices here, so some samples are covered twice.
        let (least, most) = alpha_range(gpu, 0.12, 24);
        assert!(least > 0.499, "alpha {least} to {most}");
    });
}

#[test]
fn shaders_run_as_often_as_the_formulas_say() {
    with_gpu(|gpu| {
        let mut random = Random::new(22);
        let rectangle = [0.0, 0.0, 1.0, 1.0];
        for kind in KINDS {
            for constellation in 0..=5 {
                let mut builder = Builder::default();
                for _ in 0..3 {
                    let face = random_face(kind, &mut random, rectangle, 0.1);
                    match constellation {
                        0 => builder.whole(kind, 0, &face),
                        _ => builder.transition(kind, 0, &face, constellation),
                    }
                }
                let table = gpu.upload(&builder.table).unwrap();
                for t in [1.0, 2.0, 3.0, 3.5, 4.0, 5.0, 8.0, 16.0, 63.0, 64.0f32] {
                    let n = t.ceil() as u64;
                    let (mut patches, mut vertices, mut points) = (0, 0, 0);
                    for range in &builder.table.ranges {
                        let triangle = range.part.is_some_and(|number| PARTS[number as usize].triangle);
                        let each = if triangle { triangle_vertices(n) } else { quad_vertices(n) };
                        patches += u64::from(range.count);
                        vertices += u64::from(range.count) * each;
                        points += u64::from(range.count) * range.stride() as u64;
                    }
                    let frame = Frame { tess: TessRule::Fixed(t), statistics: true, ..frame(32) };
                    let counts = gpu.render(&table, &frame).unwrap().statistics.unwrap();
                    let name = format!("{kind:?} C{constellation} level {t}");
                    assert_eq!(counts.ia_vertices, points, "{name}");
                    assert_eq!(counts.tcs_patches, patches, "{name}");
                    if gpu.device().kind == "cpu" {
                        assert_eq!(counts.tes_invocations, vertices, "{name}");
                    } else {
                        // Hardware may evaluate a vertex again.
                        assert!(counts.tes_invocations >= vertices, "{name}");
                    }
                }
            }
        }
    });
}

#[test]
fn alpha_is_straight_and_blends_over_the_background() {
    with_gpu(|gpu| {
        let mut face = flat(Kind::Bicubic, [-1.0, -1.0, 2.0, 2.0], 0.25);
        for point in &mut face {
            point[4..7].copy_from_slice(&[1.0, 0.5, 0.0]);
        }
        let table = gpu.upload(&table_of(Kind::Bicubic, &[face])).unwrap();
        for (background, expected) in [
            (None, [255, 128, 0, 64]),
            (Some([0.0, 0.0, 1.0, 1.0]), [64, 32, 191, 255]),
            (Some([0.0, 0.0, 1.0, 0.0]), [255, 128, 0, 64]),
        ] {
            for samples in [1, 4] {
                let picture = picture(gpu.render(&table, &Frame { background, samples, ..frame(3) }).unwrap());
                for (got, expected) in picture.pixel(1, 1).into_iter().zip(expected) {
                    assert!(got.abs_diff(expected) <= 1, "{background:?}: {:?}", picture.pixel(1, 1));
                }
            }
        }
    });
}

#[test]
fn colours_are_clamped_at_output_only() {
    with_gpu(|gpu| {
        // Red runs from -1 to 2 across the picture.
        let table = table_of(Kind::Bicubic, &[flat(Kind::Bicubic, [-1.0, -1.0, 2.0, 2.0], 1.0)]);
        let table = gpu.upload(&table).unwrap();
        let view = [-1.0, -1.0, 2.0, 2.0];
        let eight = picture(gpu.render(&table, &Frame { view, ..frame(30) }).unwrap());
        assert_eq!((eight.pixel(2, 2)[0], eight.pixel(28, 2)[0]), (0, 255));
        assert!(eight.pixel(15, 2)[0].abs_diff(140) <= 1, "{:?}", eight.pixel(15, 2));
        let frame = Frame { view, format: Format::Rgba32f, ..frame(30) };
        let drawn = floats(gpu.render(&table, &frame).unwrap().pixels);
        assert!(drawn[0][0] < -0.9 && drawn[29][0] > 1.9);
    });
}

#[test]
fn flat_colours_tell_kinds_parts_and_levels() {
    with_gpu(|gpu| {
        let to_bytes = |colour: [f32; 4]| colour.map(|c| (c * 255.0).round() as u8);
        let rectangle = [-0.5, -0.5, 1.5, 1.5];
        for kind in KINDS {
            let mut builder = Builder::default();
            builder.transition(kind, 3, &flat(kind, rectangle, 1.0), 3);
            let table = gpu.upload(&builder.table).unwrap();
            let patches = picture(gpu.render(&table, &Frame { show: Show::Patches, ..frame(16) }).unwrap());
            assert_eq!(patches.pixel(3, 8), to_bytes(patch_colour(kind, Some(7))));
            assert_eq!(patches.pixel(12, 8), to_bytes(patch_colour(kind, Some(8))));
            let levels = picture(gpu.render(&table, &Frame { show: Show::Levels, ..frame(16) }).unwrap());
            assert_eq!(levels.pixel(12, 8), to_bytes(level_colour(3)));
            for (show, opaque) in [(Show::Wire, false), (Show::SurfaceWire, true)] {
                let wire = picture(gpu.render(&table, &Frame { show, ..frame(64) }).unwrap());
                let line = to_bytes(WIRE_COLOUR);
                let drawn = wire.rgba.chunks_exact(4).filter(|p| *p == line).count();
                assert!((200..3000).contains(&drawn), "{show:?}: {drawn} pixels of lines");
                assert_eq!(wire.rgba.chunks_exact(4).all(|p| p[3] == 255), opaque, "{show:?}");
            }
        }
    });
}

#[test]
fn later_ranges_cover_earlier_ones() {
    with_gpu(|gpu| {
        let mut builder = Builder::default();
        for level in [0, 5] {
            builder.whole(Kind::Bicubic, level, &flat(Kind::Bicubic, [0.0, 0.0, 1.0, 1.0], 1.0));
        }
        let table = gpu.upload(&builder.table).unwrap();
        let drawn = picture(gpu.render(&table, &Frame { show: Show::Levels, ..frame(4) }).unwrap());
        assert_eq!(drawn.pixel(2, 2), level_colour(5).map(|c| (c * 255.0).round() as u8));
    });
}

#[test]
fn empty_tables_give_the_background() {
    with_gpu(|gpu| {
        let empty_range = DrawRange { kind: Kind::Gregory, part: Some(3), level: 0, first: 0, count: 0 };
        for ranges in [vec![], vec![empty_range]] {
            let table = gpu.upload(&PatchTable { ranges, ..PatchTable::default() }).unwrap();
            assert_eq!((table.bytes(), table.upload_ns()), (0, None));
            assert_eq!(gpu.evaluate(&table, TessRule::Fixed(1.0), [1.0; 2]).unwrap(), []);
            for show in [Show::Surface, Show::SurfaceWire] {
                let frame = Frame { show, statistics: true, ..frame(5) };
                let rendered = gpu.render(&table, &frame).unwrap();
                assert_eq!(rendered.statistics.unwrap().tes_invocations, 0);
                assert_eq!(picture(rendered), Picture::filled(5, 5, [0; 4]));
            }
            let background = Some([1.0, 0.0, 0.2, 1.0]);
            let drawn = picture(gpu.render(&table, &Frame { background, samples: 4, ..frame(5) }).unwrap());
            assert_eq!(drawn, Picture::filled(5, 5, [255, 0, 51, 255]));
        }
    });
}

#[test]
fn a_prepared_frame_runs_again_and_reports_its_times() {
    with_gpu(|gpu| {
        let table = gpu.upload(&mosaic(Kind::Gregory, 4, 0.1, &mut Random::new(23))).unwrap();
        let frame = Frame { background: Some([1.0; 4]), show: Show::SurfaceWire, ..frame(100) };
        let prepared = gpu.prepare(&table, &frame).unwrap();
        let first = prepared.run(true).unwrap();
        let pixels = prepared.pixels().unwrap();
        for _ in 0..3 {
            prepared.run(false).unwrap();
        }
        let again = prepared.run(true).unwrap();
        assert_eq!(prepared.pixels().unwrap(), pixels);
        for times in [first, again] {
            println!("{times:?}");
            assert!(times.wait_ns > 0 && times.record_ns > 0);
            if gpu.device().limits.timestamp_valid_bits > 0 {
                assert!(times.gpu.frame_ns.unwrap() > 0 && times.gpu.upload_ns.is_some());
                assert!(times.gpu.bicubic_ns.is_some() && times.gpu.gregory_transition_ns.is_some());
                assert!(times.gpu.overlay_ns.is_some());
                assert!(times.gpu.gregory_ns.is_none() && times.gpu.bicubic_transition_ns.is_none());
            }
        }
    });
}

#[test]
fn senseless_requests_are_refused_by_name() {
    with_gpu(|gpu| {
        let table = gpu.upload(&PatchTable::default()).unwrap();
        let [max, _] = gpu.device().limits.max_image;
        let frames = [
            (Frame { width: 0, ..frame(8) }, "0x8"),
            (Frame { width: max + 1, ..frame(1) }, "too large"),
            (Frame { samples: 2, ..frame(8) }, "2 samples"),
            (Frame { view: [0.0, 0.0, 0.0, 1.0], ..frame(8) }, "view"),
            (Frame { view: [0.0, 0.0, f64::NAN, 1.0], ..frame(8) }, "view"),
            (Frame { tess: TessRule::Fixed(65.0), ..frame(8) }, "64"),
            (Frame { tess: TessRule::Pixels(0.0), ..frame(8) }, "positive"),
            (Frame { background: Some([f32::INFINITY; 4]), ..frame(8) }, "background"),
        ];
        for (frame, word) in frames {
            let error = gpu.render(&table, &frame).unwrap_err();
            assert!(error.is_request() && error.to_string().contains(word), "{error}");
        }
        let range = DrawRange { kind: Kind::Bicubic, part: None, level: 0, first: 0, count: 1 };
        let good =
            PatchTable { control: vec![[0.0; 8]], indices: vec![0; 16], ranges: vec![range], ..PatchTable::default() };
        assert!(gpu.upload(&good).is_ok());
        let tables = [
            PatchTable { indices: vec![1; 16], ..good.clone() },
            PatchTable { indices: vec![0; 15], ..good.clone() },
            PatchTable { ranges: vec![DrawRange { part: Some(17), ..range }], ..good.clone() },
            PatchTable { ranges: vec![DrawRange { first: u32::MAX, ..range }], ..good.clone() },
        ];
        for table in tables {
            assert!(matches!(gpu.upload(&table), Err(GpuError::Request(_))), "{table:?}");
        }
    });
}

#[test]
fn points_that_are_not_numbers_do_no_harm() {
    with_gpu(|gpu| {
        let mut faces = vec![flat(Kind::Gregory, [0.0, 0.0, 1.0, 1.0], 1.0); 3];
        faces[0][5] = [f64::NAN; 8];
        faces[1][6] = [1e300; 8];
        faces[2] = vec![[0.0; 8]; 20];
        let table = gpu.upload(&table_of(Kind::Gregory, &faces)).unwrap();
        for tess in [TessRule::Fixed(5.0), TessRule::Pixels(2.0)] {
            gpu.render(&table, &Frame { tess, ..frame(8) }).unwrap();
        }
    });
}
