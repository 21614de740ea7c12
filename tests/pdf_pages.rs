//! PDF pages as two other programs draw them: Ghostscript and MuPDF, at four times our resolution, averaged.
//!
//! The bar for either is 0.6/255 + 1.1 x (change of colour per pixel) / 4, three pixels inside the outline and all seams.
//! One page is drawn by both: Ghostscript with 16 bits a channel, MuPDF with its 8, which are cut off.
//!
//! MuPDF composes layers with 8 bits: colours and masks are cut off, and what comes of them once more. That is proved by flat
//! squares, whose values it draws one by one as [`pdf_readers::over`] computes them, and no choice of numbers on the page
//! helps: [`mupdf_composes_with_8_bits`] has a square that is more than 1.3/255 off with each of the colours and alphas next
//! to its own. Translucent pages by MuPDF are therefore held to what that arithmetic makes of our colours.

use exchange::{draw, draw_table, square};
use glam::{DVec2, DVec4};
use gpu_support::with_gpu;
use gradtess::ferguson::fit::Target;
use gradtess::ferguson::table::table;
use gradtess::ferguson::Mesh;
use gradtess::patch::space::Interpolation;
use gradtess::timing::random::Random;
use gradtess::vector::cells::Cell;
use gradtess::vector::{bicubics, cells, flatten, folded, layers, pdf};
use pdf_readers::{over, reach, rendered, there, Theirs};
use std::path::Path;

mod exchange;
mod ferguson_meshes;
mod gpu_support;
mod models;
mod pdf_readers;

/// Pixels of our pictures. Pages are 600 points, so 72 dots an inch are four times as many.
const SIZE: u32 = 150;
/// What `convert` cuts patches to.
const TOLERANCE: f64 = 0.15 / 255.0;

struct Scene {
    name: String,
    mesh: Mesh,
    /// Its layers from the bottom where one is translucent.
    layers: Vec<Mesh>,
    /// Colours jump within the outline.
    seams: bool,
}

fn scenes() -> Vec<Scene> {
    let opaque = |name: &str, mesh: Mesh| Scene { name: name.to_owned(), mesh, layers: Vec::new(), seams: false };
    let mut all = vec![opaque("wavy", ferguson_meshes::wavy(2, 2))];
    // Hardly any change of colour to hide behind.
    for (k, contrast) in [4.0, 6.0, 8.0, 10.0, 14.0, 30.0].into_iter().enumerate() {
        let mut random = Random::new(k as u64);
        let corners: [[f64; 3]; 4] = std::array::from_fn(|_| std::array::from_fn(|_| random.unit()));
        let colour = |i: u32, j: u32| {
            let channel =
                |c: usize| 0.2 + 0.25 * c as f64 + contrast / 255.0 * (corners[(i + 2 * j) as usize][c] - 0.5);
            DVec4::new(channel(0), channel(1), channel(2), 1.0)
        };
        all.push(opaque(&format!("faint {contrast}"), Mesh::grid(1, 1, [0.0, 0.0, 1.0, 1.0], colour).unwrap()));
    }
    let clear = Mesh::grid(2, 1, [0.0, 0.0, 1.0, 1.0], |i, j| {
        DVec4::new(f64::from(i) / 2.0, 0.3, f64::from(j), 0.2 + 0.4 * f64::from(i))
    });
    let clear = clear.unwrap();
    all.push(Scene { layers: vec![clear.clone()], ..opaque("translucent", clear) });
    // A translucent mesh over an opaque one of the same outline.
    let [below, above] = [["#f00", "#ff0", "#0a0", "#00f"], ["#fff8", "#0004", "#fff0", "#000c"]].map(gradient);
    let layers = [&below, &above].map(|one| drawing("layer", one));
    all.push(Scene { layers: layers.into(), ..opaque("pile", drawing("pile", &format!("{below}{above}"))) });
    let files = ["local_refinement", "sections", "colour_spaces", "radial", "branching", "sharp_colours", "still_life"];
    for (k, name) in files.into_iter().enumerate() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/ferguson").join(name).with_extension("json");
        let mesh = gradtess::scene::ferguson::parse(&std::fs::read(path).unwrap(), name).unwrap().0;
        all.push(Scene { seams: k > 2, ..opaque(name, mesh) });
    }
    if let Some(folder) = models::folder("svg", "PDF pages of drawings") {
        for name in ["svgwg-mesh_example", "svgwg-mesh_gradient_patch", "wpt-meshgradient-bicubic-001"] {
            let bytes = std::fs::read(folder.join(name).with_extension("svg")).unwrap();
            all.push(opaque(name, gradtess::scene::ferguson::parse(&bytes, name).unwrap().0));
        }
    }
    all
}

fn gradient(colours: [&str; 4]) -> String {
    let stops: String = ["l 1,0", "l 0,1", "l -1,0", "l 0,-1"]
        .iter()
        .zip(colours)
        .map(|(path, colour)| format!("<stop path='{path}' stop-color='{colour}'/>"))
        .collect();
    format!(
        "<meshgradient gradientUnits='userSpaceOnUse'><meshrow><meshpatch>{stops}</meshpatch></meshrow></meshgradient>"
    )
}

fn drawing(name: &str, gradients: &str) -> Mesh {
    let text = format!("<svg xmlns='http://www.w3.org/2000/svg'>{gradients}</svg>");
    gradtess::scene::ferguson::parse(text.as_bytes(), name).unwrap().0
}

/// Which pixels are compared: three inside the outline, and as far from where colours bend as they do at seams.
fn compared(ours: &[DVec4], seams: bool) -> Vec<usize> {
    let n = SIZE as usize;
    let bend = |a: usize, b: usize, c: usize| {
        let at = |i: usize| ours[i].truncate() * ours[i].w;
        (at(a) - at(b) * 2.0 + at(c)).abs().max_element()
    };
    let sound = |i: usize| {
        let whole = ours[i].w > 0.0;
        whole && (!seams || bend(i - 1, i, i + 1).max(bend(i - n, i, i + n)) < 2.0 / 255.0)
    };
    (4 * n..n * n - 4 * n)
        .filter(|i| (4..n - 4).contains(&(i % n)))
        .filter(|i| (0..49).all(|k| sound(i + k / 7 * n + k % 7 - 3 * n - 3)))
        .collect()
}

struct Agreement {
    values: usize,
    /// Greatest difference beyond the bar, 1/255; negative where all is well.
    excess: f64,
    /// The same beyond what MuPDF can draw, with `TOLERANCE` in place of 0.6/255.
    unreached: f64,
    mean: f64,
}

/// Compares over white; `layers` are our pictures of them.
fn compare(ours: &[DVec4], layers: &[Vec<DVec4>], theirs: &Theirs, seams: bool) -> Agreement {
    let n = SIZE as usize;
    assert_eq!(theirs.size, [4 * SIZE; 2]);
    let shown =
        |i: usize| (ours[i].truncate() * ours[i].w + (1.0 - ours[i].w)).clamp(glam::DVec3::ZERO, glam::DVec3::ONE);
    let mut a = Agreement { values: 0, excess: f64::NEG_INFINITY, unreached: f64::NEG_INFINITY, mean: 0.0 };
    for i in compared(ours, seams) {
        let at = shown(i);
        for c in 0..3 {
            let corner = (i / n * 4 * n + i % n) * 4;
            let mean: f64 = (0..16).map(|k| theirs.rgb[corner + k / 4 * 4 * n + k % 4][c]).sum::<f64>() / 16.0;
            let around = [i - 1, i + 1, i - n, i + n].map(|i| (shown(i)[c] - at[c]).abs());
            let change = 1.1 * around.into_iter().fold(0.0, f64::max) * 255.0 / 4.0;
            let off = (mean - at[c] * 255.0).abs();
            let [low, high] = layers
                .iter()
                .fold([255.0; 2], |below, layer| reach(layer[i][c].clamp(0.0, 1.0), pdf::RAISE, layer[i].w, below));
            a.values += 1;
            a.excess = a.excess.max(off - 0.6 - change);
            a.unreached = a.unreached.max((low - mean).max(mean - high) - TOLERANCE * 255.0 - change);
            a.mean += off;
        }
    }
    a.mean /= a.values.max(1) as f64;
    a
}

#[test]
fn other_programs_draw_the_pages_as_we_draw_the_scenes() {
    let programs: Vec<&str> = ["gs", "mutool"].into_iter().filter(|p| there(p)).collect();
    let folder = std::env::temp_dir().join(format!("gradtess-pdf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut short = Vec::new();
    with_gpu(|gpu| {
        for Scene { name, mesh, layers: sheets, seams } in scenes() {
            let view = square(&mesh);
            let patches = table(&mesh, &Target::default());
            let (nets, _) = bicubics(&patches);
            assert_eq!(folded(&nets), None, "{name}");
            let of = mesh.component();
            let component: Vec<u32> = patches.faces.iter().map(|face| of[face.name as usize]).collect();
            let cells = cells::cells(&nets, mesh.colour, TOLERANCE);
            assert!(cells.error <= TOLERANCE, "{name}: {}", cells.error);
            let page = folder.join("page.pdf");
            std::fs::write(&page, pdf::page(&layers::layers(&cells, &component), view, &name).unwrap()).unwrap();
            let ours = draw(gpu, &mesh, view, SIZE);
            let sheets: Vec<Vec<DVec4>> = sheets.iter().map(|sheet| draw(gpu, sheet, view, SIZE)).collect();
            if !sheets.is_empty() {
                // The same, flattened: nothing is left to compose, and the bar holds by either.
                let flat = flatten::cells(&nets, &component, mesh.colour, TOLERANCE).unwrap();
                assert!(flat.error <= TOLERANCE, "{name}: {}", flat.error);
                let bytes = pdf::page(&layers::layers(&flat, &component), view, &name).unwrap();
                assert!(!bytes.windows(6).any(|part| part == b"/SMask"), "{name}");
                let page = folder.join("flat.pdf");
                std::fs::write(&page, bytes).unwrap();
                for program in &programs {
                    let a = compare(&ours, &[], &rendered(program, &page, &folder.join("flat.png")), seams);
                    let (count, excess) = (flat.all.len(), a.excess);
                    println!(
                        "{name} flattened, {program}: {count} cells, mean {:.3}/255; {excess:.3} beyond the bar",
                        a.mean
                    );
                    assert!(a.values > 1000, "{name}");
                    if excess > 0.0 {
                        short.push(format!("{name} flattened by {program}: {excess:.3}"));
                    }
                }
            }
            for program in &programs {
                let a = compare(&ours, &sheets, &rendered(program, &page, &folder.join("page.png")), seams);
                println!(
                    "{name}, {program}: {} cells within {:.3}/255; {} values, mean {:.3}/255 off; {:.3} beyond the bar{}",
                    cells.all.len(),
                    cells.error * 255.0,
                    a.values,
                    a.mean,
                    a.excess,
                    if sheets.is_empty() { String::new() } else { format!(", {:.3} beyond MuPDF's reach", a.unreached) }
                );
                assert!(a.values > 1000, "{name}");
                let composed = *program == "mutool" && !sheets.is_empty();
                let beyond = if composed { a.unreached } else { a.excess };
                if beyond > 0.0 {
                    short.push(format!("{name} by {program}: {beyond:.3}"));
                }
            }
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(short.is_empty(), "{short:#?}");
}

/// Flat squares, 16 by 16, of several layers.
fn flat(layers: &[Vec<DVec4>]) -> Vec<u8> {
    let square = |(k, &colour): (usize, &DVec4)| {
        let corner = DVec2::new((k % 16) as f64, 15.0 - (k / 16) as f64);
        let at = |i: usize| corner + DVec2::new((i % 4) as f64, (i / 4) as f64) / 3.0;
        Cell { geometry: std::array::from_fn(at), colours: [colour; 4] }
    };
    let cells: Vec<Vec<Cell>> = layers.iter().map(|layer| layer.iter().enumerate().map(square).collect()).collect();
    pdf::page(&cells, [0.0, 0.0, 16.0, 16.0], "flat").unwrap()
}

/// The colours in the middles of the squares.
fn middles(theirs: &Theirs) -> Vec<[f64; 3]> {
    let side = theirs.size[0] as usize / 16;
    (0..256)
        .map(|k| theirs.rgb[(k / 16 * side + side / 2) * theirs.size[0] as usize + k % 16 * side + side / 2])
        .collect()
}

/// Draws pages in a folder of their own.
fn with_pages(name: &str, run: impl FnOnce(&dyn Fn(&str, &[Vec<DVec4>]) -> Vec<[f64; 3]>)) {
    let folder = std::env::temp_dir().join(format!("gradtess-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    run(&|program, layers| {
        let file = folder.join("flat.pdf");
        std::fs::write(&file, flat(layers)).unwrap();
        middles(&rendered(program, &file, &folder.join("flat.out")))
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

fn random_layer(random: &mut Random, translucent: bool) -> Vec<DVec4> {
    let channel = |random: &mut Random| (random.unit() * 65535.0).round() / 65535.0;
    let colour = |_| {
        let alpha = if translucent { channel(random) } else { 1.0 };
        DVec4::new(channel(random), channel(random), channel(random), alpha)
    };
    (0..256).map(colour).collect()
}

/// Least and greatest difference.
fn range(theirs: &[[f64; 3]], wanted: impl Fn(usize, usize) -> f64) -> [f64; 2] {
    let all = theirs.iter().enumerate().flat_map(|(k, rgb)| (0..3).map(move |c| (k, c, rgb[c])));
    all.map(|(k, c, x)| x - wanted(k, c)).fold([f64::INFINITY, f64::NEG_INFINITY], |r, x| [r[0].min(x), r[1].max(x)])
}

#[test]
fn flat_colours_are_within_the_raise_or_what_it_leaves_of_a_step() {
    let mut random = Random::new(9);
    let any = random_layer(&mut random, false);
    let of_8_bits: Vec<DVec4> = any.iter().map(|c| (*c * 255.0).round() / 255.0).collect();
    with_pages("flat", |page| {
        for program in ["gs", "gs8", "mutool"] {
            if !there(program.trim_end_matches('8')) {
                continue;
            }
            let off = range(&page(program, std::slice::from_ref(&any)), |k, c| any[k][c] * 255.0);
            // Ghostscript with 8 bits rounds pieces of one colour, and cuts off in all others.
            let bound = match program {
                "gs" => [0.01, 0.48],
                "gs8" => [0.04, 0.98],
                _ => [0.54, 0.48],
            };
            println!("flat squares by {program}: {off:.3?}");
            assert!(-off[0] <= bound[0] && off[1] <= bound[1], "{program}: {off:?}");
            let theirs: Vec<[f64; 3]> =
                page(program, std::slice::from_ref(&of_8_bits)).into_iter().map(|rgb| rgb.map(f64::round)).collect();
            assert_eq!(range(&theirs, |k, c| (of_8_bits[k][c] * 255.0).round()), [0.0; 2], "{program}");
        }
    });
}

#[test]
fn mupdf_composes_with_8_bits() {
    // Flat squares by the thousand, over white and over one another, are what `over` says.
    let mut random = Random::new(3);
    let stack: Vec<Vec<DVec4>> = (0..3).map(|k| random_layer(&mut random, k > 0)).collect();
    // Of the 65,535 steps of a range from 0 to `top`.
    let cut = |x: f64, top: f64| ((x / top * 65535.0).round() / 65535.0 * top * 255.0).floor() as i32;
    let raised = |x: f64| cut(x + pdf::RAISE, 1.0 + pdf::RAISE);
    let composed = |layers: &[Vec<DVec4>], k: usize, c: usize| {
        layers.iter().fold(255, |below, layer| over(raised(layer[k][c]), cut(layer[k].w, 1.0), below))
    };
    let exact = |layers: &[Vec<DVec4>], k: usize, c: usize| {
        layers.iter().fold(255.0, |below, layer| below + layer[k].w * (layer[k][c] * 255.0 - below))
    };
    with_pages("composed", |page| {
        for layers in [&stack[..1], &stack[1..2], &stack[..2], &stack[1..], &stack[..]] {
            if there("mutool") {
                let theirs = page("mutool", layers);
                let off = range(&theirs, |k, c| exact(layers, k, c));
                println!("{} layers by MuPDF: {off:.3?}", layers.len());
                assert_eq!(range(&theirs, |k, c| f64::from(composed(layers, k, c))), [0.0; 2]);
                let reached = range(&theirs, |k, c| {
                    let below = |below, layer: &Vec<DVec4>| reach(layer[k][c], pdf::RAISE, layer[k].w, below);
                    let [low, high] = layers.iter().fold([255.0; 2], below);
                    theirs[k][c].clamp(low - 1e-2, high + 1e-2)
                });
                assert_eq!(reached, [0.0; 2]);
            }
            if there("gs") {
                let off = range(&page("gs", layers), |k, c| exact(layers, k, c));
                println!("{} layers by Ghostscript: {off:.3?}", layers.len());
                assert!(-off[0] <= 0.03 && off[1] <= 0.49, "{off:?}");
            }
        }
    });
    // A grey of 7.909/255 with an alpha of 140.007/255 over white: with either step next to the colour and to the alpha.
    let (grey, alpha) = (7.908_746_98, 0.549_047_47 * 255.0);
    let wanted = 255.0 - alpha / 255.0 * (255.0 - grey);
    let next = |x: f64| [x.floor() as i32, x.ceil() as i32];
    let all = next(grey).into_iter().flat_map(|g| next(alpha).map(|a| f64::from(over(g, a, 255)) - wanted));
    let least = all.map(f64::abs).fold(f64::INFINITY, f64::min);
    assert!(least > 1.3, "{least}");
}

#[test]
fn folded_patches_are_refused_and_collapsed_ones_are_not() {
    let mut mesh = Mesh::grid(1, 1, [0.0, 0.0, 1.0, 1.0], |_, _| DVec4::ONE).unwrap();
    mesh.colour = Interpolation::default();
    let nets = |mesh: &Mesh| bicubics(&table(mesh, &Target::default())).0;
    assert_eq!(folded(&nets(&mesh)), None);
    let mut flat = nets(&mesh);
    // One side in one point.
    for k in 12..16 {
        flat[0].geometry[k] = DVec2::new(0.5, 1.0);
    }
    assert_eq!(folded(&flat), None);
    let mut over = nets(&mesh);
    over[0].geometry[5] = DVec2::new(3.0, 0.3);
    over[0].geometry[9] = DVec2::new(3.0, 0.6);
    let message = folded(&over).expect("a fold").to_string();
    assert!(message.contains("patch 0 folds over near") && message.contains("; "), "{message}");
}

/// Gregory patches are converted, and the error that is stated is what the pictures differ by.
#[test]
fn the_error_of_converted_gregory_patches_is_stated() {
    let scene = gradtess::scene::Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/triangle.json")).unwrap();
    let mesh = gradtess::mesh::build(&scene.mesh).unwrap();
    let options = gradtess::refine::Options {
        rules: gradtess::refine::Rules::Gradtess,
        mode: gradtess::refine::Mode::Adaptive { isolate: 0 },
    };
    let levels = gradtess::refine::refine(&scene, &mesh, options).unwrap();
    let full = gradtess::patch::build::build(&levels, gradtess::patch::points::Irregular::Gregory);
    let (nets, conversion) = bicubics(&full);
    assert!(
        conversion.gregory > 0 && conversion.position > 0.0 && conversion.position < 0.1 && conversion.colour < 0.1
    );
    assert_eq!(nets.len(), full.faces.len());
    with_gpu(|gpu| {
        let pixels = draw_table(gpu, &full, [-2.0, -2.0, 2.0, 2.0], 64);
        assert!(pixels.iter().any(|p| p.w > 0.0));
    });
}
