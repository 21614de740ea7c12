//! PDF pages as two other programs draw them: Ghostscript and MuPDF, at four times our resolution, averaged.
//!
//! The bar for either is 0.6/255 + 1.1 x (change of colour per pixel) / 4. Both draw 8-bit pixels by cutting off what is
//! below a step. Ghostscript can be asked for 16 bits, MuPDF cannot: flat squares come out up to a whole step too dark, half
//! a step on average, whatever the number of bits, the colour space or the program's options are, so that the way colours
//! are written has no part in it. What it would draw with more bits can be measured all the same: for whole n,
//! floor(x) + floor(x + 1/n) + ... + floor(x + (n - 1)/n) = floor(n x) (Hermite), so the mean of n pages whose colours are
//! raised by half a step of n, and by one more each time, is within 1/(2 n) of x. They are the page itself but for the ranges
//! in `/Decode`. So measured, opaque pages by MuPDF meet the bar.
//!
//! Masks are multiplied and layers are laid over one another with 8 bits inside MuPDF, which no raise of the page's numbers
//! reaches: [`CUT_OFF`] has what is left of flat squares. Translucent pages are held to that in place of 0.6/255.

use exchange::{draw, draw_table, square};
use glam::{DVec2, DVec4};
use gpu_support::with_gpu;
use gradtess::ferguson::fit::Target;
use gradtess::ferguson::table::table;
use gradtess::ferguson::Mesh;
use gradtess::image::Picture;
use gradtess::patch::space::Interpolation;
use gradtess::vector::cells::Cell;
use gradtess::vector::{bicubics, cells, folded, layers, pdf};
use std::path::Path;
use std::process::Command;

mod exchange;
mod ferguson_meshes;
mod gpu_support;
mod models;

/// Pixels of our pictures. Pages are 600 points, so 72 dots an inch are four times as many.
const SIZE: u32 = 150;

fn there(program: &str) -> bool {
    let found = Command::new(program).arg("-v").output().is_ok();
    if !found {
        println!("PDF pages: skipped for {program}, which is not installed");
    }
    found
}

/// A picture by another program: width, height, and red, green, blue from 0 to 255, rows from the top.
struct Theirs {
    size: [u32; 2],
    rgb: Vec<[f64; 3]>,
}

/// Ghostscript cuts 8-bit values off instead of rounding them (half a step too dark everywhere), so it gives 16 bits.
fn rendered(program: &str, page: &Path, out: &Path) -> Theirs {
    let done = match program {
        "gs" => Command::new("gs")
            .args(["-q", "-dNOPAUSE", "-dBATCH", "-dSAFER", "-sDEVICE=tiff48nc", "-sCompression=none", "-r72"])
            .arg(format!("-sOutputFile={}", out.display()))
            .arg(page)
            .output(),
        _ => Command::new("mutool").args(["draw", "-q", "-F", "png", "-r", "72", "-o"]).arg(out).arg(page).output(),
    };
    let done = done.unwrap();
    assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
    if program == "gs" {
        return tiff(&std::fs::read(out).unwrap());
    }
    let picture = Picture::read_png(out).unwrap();
    let all = (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (x, y)));
    let rgb = all.map(|(x, y)| [0, 1, 2].map(|c| f64::from(picture.pixel(x, y)[c]))).collect();
    Theirs { size: [picture.width, picture.height], rgb }
}

/// An uncompressed TIFF of 16 bits a channel, in strips.
fn tiff(bytes: &[u8]) -> Theirs {
    let little = &bytes[..2] == b"II";
    let number = |at: usize, n: usize| {
        let part = bytes[at..at + n].iter().copied();
        let step = |all: usize, b: u8| all << 8 | usize::from(b);
        if little {
            part.rev().fold(0, step)
        } else {
            part.fold(0, step)
        }
    };
    let directory = number(4, 4);
    // All values of a tag.
    let values = |tag: usize| -> Vec<usize> {
        let entry = (0..number(directory, 2)).map(|i| directory + 2 + 12 * i).find(|&e| number(e, 2) == tag);
        let entry = entry.expect("a tag");
        let (width, count) = (if number(entry + 2, 2) == 3 { 2 } else { 4 }, number(entry + 4, 4));
        let start = if width * count <= 4 { entry + 8 } else { number(entry + 8, 4) };
        (0..count).map(|i| number(start + width * i, width)).collect()
    };
    assert_eq!((values(258), values(259)), (vec![16, 16, 16], vec![1]));
    let strips = values(273).into_iter().zip(values(279)).flat_map(|(start, n)| (start..start + n).step_by(6));
    let channel = |at: usize| number(at, 2) as f64 / 257.0;
    let rgb = strips.map(|at| [channel(at), channel(at + 2), channel(at + 4)]).collect();
    Theirs { size: [values(256)[0] as u32, values(257)[0] as u32], rgb }
}

/// Pages that MuPDF's pictures are the mean of.
const EXPOSURES: u32 = 4;

/// How far off flat squares are in MuPDF 1.21, 1/255, opaque and of one and two translucent layers: the page as it is, and
/// the mean of the raised ones. [`mupdf_cuts_off_what_flat_squares_show`] measures it.
const CUT_OFF: [[f64; 2]; 3] = [[1.0, 1.0 / 8.0], [1.95, 1.35], [2.75, 1.9]];

/// The page with all colours and alphas raised by `raise`: other numbers in `/Decode`, and the offsets that follow from it.
fn raised(page: &[u8], raise: f64) -> Vec<u8> {
    let find = |from: usize, what: &[u8]| page[from..].windows(what.len()).position(|w| w == what).map(|i| from + i);
    let (mut out, mut from, mut edits) = (Vec::new(), 0, Vec::new());
    while let Some(at) = find(from, b"/Decode [") {
        let end = find(at, b"]").unwrap();
        let numbers: Vec<&str> = std::str::from_utf8(&page[at + 9..end]).unwrap().split_whitespace().collect();
        assert!(numbers.len() >= 6 && numbers[4..].chunks(2).all(|range| range == ["0", "1"]), "{numbers:?}");
        out.extend_from_slice(&page[from..at + 9]);
        let ranges = (4..numbers.len() / 2 + 2).map(|_| format!(" {raise:.8} {:.8}", 1.0 + raise));
        let text = numbers[..4].join(" ") + &ranges.collect::<String>();
        edits.push((end, text.len() as isize - (end - at - 9) as isize));
        out.extend_from_slice(text.as_bytes());
        from = end;
    }
    assert!(!edits.is_empty());
    let place = |old: usize| {
        let shift: isize = edits.iter().filter(|(at, _)| *at < old).map(|(_, by)| by).sum();
        (old as isize + shift) as usize
    };
    let table = page.windows(5).rposition(|w| w == b"\nxref").unwrap() + 1;
    out.extend_from_slice(&page[from..table]);
    for line in std::str::from_utf8(&page[table..]).unwrap().split_inclusive('\n') {
        let entry = line.trim_end();
        let old: Option<usize> = entry.split(' ').next().and_then(|n| n.parse().ok());
        match old {
            Some(old) if entry.ends_with(" n") => out.extend(format!("{:010}{}", place(old), &line[10..]).bytes()),
            Some(old) if old == table => out.extend(format!("{}\n", place(old)).bytes()),
            _ => out.extend(line.bytes()),
        }
    }
    out
}

/// What MuPDF would draw of a page with some bits more.
fn exposed(page: &[u8], folder: &Path) -> Theirs {
    let (file, out) = (folder.join("raised.pdf"), folder.join("raised.png"));
    let mut sum: Option<Theirs> = None;
    for k in 0..EXPOSURES {
        let raise = (f64::from(k) + 0.5) / f64::from(EXPOSURES) / 255.0;
        std::fs::write(&file, raised(page, raise)).unwrap();
        let one = rendered("mutool", &file, &out);
        match &mut sum {
            None => sum = Some(one),
            Some(sum) => {
                sum.rgb.iter_mut().zip(one.rgb).for_each(|(a, b)| (0..3).for_each(|c| a[c] += b[c]));
            }
        }
    }
    let mut mean = sum.unwrap();
    mean.rgb.iter_mut().for_each(|p| *p = p.map(|x| x / f64::from(EXPOSURES)));
    mean
}

struct Agreement {
    compared: usize,
    /// Greatest difference beyond what is allowed, 1/255; negative where all is well.
    excess: f64,
    mean: f64,
}

/// Compares over white, three pixels inside the outline.
fn compare(ours: &[DVec4], theirs: &Theirs) -> Agreement {
    let n = SIZE as usize;
    assert_eq!(theirs.size, [4 * SIZE; 2]);
    let shown =
        |i: usize| (ours[i].truncate() * ours[i].w + (1.0 - ours[i].w)).clamp(glam::DVec3::ZERO, glam::DVec3::ONE);
    let mut a = Agreement { compared: 0, excess: f64::NEG_INFINITY, mean: 0.0 };
    for (y, x) in (3..n - 3).flat_map(|y| (3..n - 3).map(move |x| (y, x))) {
        let inside = |dy: usize, dx: usize| ours[(y + dy - 3) * n + x + dx - 3].w > 0.0;
        if !(0..49).all(|k| inside(k / 7, k % 7)) {
            continue;
        }
        let at = shown(y * n + x);
        let around = [y * n + x - 1, y * n + x + 1, (y - 1) * n + x, (y + 1) * n + x];
        for c in 0..3 {
            let mean: f64 = (0..16).map(|k| theirs.rgb[(4 * y + k / 4) * 4 * n + 4 * x + k % 4][c]).sum::<f64>() / 16.0;
            let per_pixel = around.iter().map(|&i| (shown(i)[c] - at[c]).abs()).fold(0.0, f64::max) * 255.0;
            let off = (mean - at[c] * 255.0).abs();
            let excess = off - (0.6 + 1.1 * per_pixel / 4.0);
            a.compared += 1;
            a.excess = a.excess.max(excess);
            a.mean += off;
        }
    }
    a.mean /= a.compared.max(1) as f64;
    a
}

fn scenes() -> Vec<(String, Mesh)> {
    let mut all = vec![("wavy".to_owned(), ferguson_meshes::wavy(2, 2))];
    let clear = Mesh::grid(2, 1, [0.0, 0.0, 1.0, 1.0], |i, j| {
        DVec4::new(f64::from(i) / 2.0, 0.3, f64::from(j), 0.2 + 0.4 * f64::from(i))
    });
    all.push(("translucent".to_owned(), clear.unwrap()));
    all.push(("pile".to_owned(), pile()));
    if let Some(folder) = models::folder("svg", "PDF pages of drawings") {
        for name in ["svgwg-mesh_example", "svgwg-mesh_gradient_patch", "wpt-meshgradient-bicubic-001"] {
            let bytes = std::fs::read(folder.join(name).with_extension("svg")).unwrap();
            all.push((name.to_owned(), gradtess::scene::ferguson::parse(&bytes, name).unwrap().0));
        }
    }
    all
}

/// A translucent mesh over an opaque one of the same outline.
fn pile() -> Mesh {
    let gradient = |colours: [&str; 4]| {
        let stops: String = ["l 1,0", "l 0,1", "l -1,0", "l 0,-1"]
            .iter()
            .zip(colours)
            .map(|(path, colour)| format!("<stop path='{path}' stop-color='{colour}'/>"))
            .collect();
        format!("<meshgradient gradientUnits='userSpaceOnUse'><meshrow><meshpatch>{stops}</meshpatch></meshrow></meshgradient>")
    };
    let below = gradient(["#f00", "#ff0", "#0a0", "#00f"]);
    let above = gradient(["#fff8", "#0004", "#fff0", "#000c"]);
    let drawing = format!("<svg xmlns='http://www.w3.org/2000/svg'>{below}{above}</svg>");
    gradtess::scene::ferguson::parse(drawing.as_bytes(), "pile").unwrap().0
}

#[test]
fn other_programs_draw_the_pages_as_we_draw_the_scenes() {
    let programs: Vec<&str> = ["gs", "mutool"].into_iter().filter(|p| there(p)).collect();
    let folder = std::env::temp_dir().join(format!("gradtess-pdf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut short = Vec::new();
    with_gpu(|gpu| {
        for (name, mesh) in scenes() {
            let view = square(&mesh);
            let patches = table(&mesh, &Target::default());
            let (nets, _) = bicubics(&patches);
            assert_eq!(folded(&nets), None, "{name}");
            let of = mesh.component();
            let component: Vec<u32> = patches.faces.iter().map(|face| of[face.name as usize]).collect();
            let cells = cells::cells(&nets, mesh.colour, 0.5 / 255.0);
            assert!(cells.proved && cells.error <= 0.5 / 255.0, "{name}: {}", cells.error);
            let page = folder.join("page.pdf");
            let bytes = pdf::page(&layers::layers(&cells, &component), view, &name).unwrap();
            std::fs::write(&page, &bytes).unwrap();
            let ours = draw(gpu, &mesh, view, SIZE);
            for program in &programs {
                let masks = match name.as_str() {
                    "translucent" => 1,
                    "pile" => 2,
                    _ => 0,
                };
                let plain = compare(&ours, &rendered(program, &page, &folder.join("page.png")));
                let mut all = vec![("as it is", plain, 0.6f64.max(CUT_OFF[masks][0]))];
                match *program {
                    "gs" => all[0].2 = 0.6,
                    _ => all.push((
                        "measured finer",
                        compare(&ours, &exposed(&bytes, &folder)),
                        0.6f64.max(CUT_OFF[masks][1]),
                    )),
                }
                for (how, a, constant) in all {
                    println!(
                        "{name}, {program} {how}: {} cells within {:.3}/255; {} values, mean {:.3}/255 off; {:.3} beyond the bar",
                        cells.all.len(),
                        cells.error * 255.0,
                        a.compared,
                        a.mean,
                        a.excess
                    );
                    assert!(a.compared > 10_000, "{name}");
                    if a.excess > constant - 0.6 {
                        short.push(format!("{name} by {program} {how}: {:.3}", a.excess));
                    }
                }
            }
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(short.is_empty(), "{short:#?}");
}

/// Flat squares, 16 by 16, of several layers; what they have to look like over white.
fn flat(layers: usize, translucent: bool) -> (Vec<u8>, Vec<[f64; 3]>) {
    let mut random = gradtess::timing::random::Random::new(9);
    let mut shown = vec![[255.0; 3]; 256];
    let mut all = Vec::new();
    for _ in 0..layers {
        let layer = (0..256).map(|k| {
            let mut channel = || (random.unit() * 65535.0).round() / 65535.0;
            let colour = DVec4::new(channel(), channel(), channel(), if translucent { channel() } else { 1.0 });
            let below: [f64; 3] = shown[k];
            shown[k] = [0, 1, 2].map(|c| below[c] + colour.w * (colour[c] * 255.0 - below[c]));
            let corner = DVec2::new((k % 16) as f64, 15.0 - (k / 16) as f64);
            let at = |i: usize| corner + DVec2::new((i % 4) as f64, (i / 4) as f64) / 3.0;
            Cell { geometry: std::array::from_fn(at), colours: [colour; 4] }
        });
        all.push(layer.collect());
    }
    (pdf::page(&all, [0.0, 0.0, 16.0, 16.0], "flat").unwrap(), shown)
}

/// The worst and the mean difference at the middles of the squares.
fn off(theirs: &Theirs, shown: &[[f64; 3]]) -> [f64; 3] {
    let (mut low, mut high, mut mean) = (f64::INFINITY, f64::NEG_INFINITY, 0.0f64);
    let side = theirs.size[0] as usize / 16;
    for (k, wanted) in shown.iter().enumerate() {
        let at = (k / 16 * side + side / 2) * theirs.size[0] as usize + k % 16 * side + side / 2;
        for (theirs, wanted) in theirs.rgb[at].iter().zip(wanted) {
            let off = theirs - wanted;
            (low, high, mean) = (low.min(off), high.max(off), mean + off / 768.0);
        }
    }
    [low, high, mean]
}

/// MuPDF's arithmetic: what flat squares lose, and that Ghostscript loses nothing of the same page.
#[test]
fn mupdf_cuts_off_what_flat_squares_show() {
    if !there("mutool") {
        return;
    }
    let folder = std::env::temp_dir().join(format!("gradtess-flat-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (file, out) = (folder.join("flat.pdf"), folder.join("flat.png"));
    for (masks, cut_off) in CUT_OFF.into_iter().enumerate() {
        let (page, shown) = flat(masks.max(1), masks > 0);
        std::fs::write(&file, &page).unwrap();
        let plain = off(&rendered("mutool", &file, &out), &shown);
        let fine = off(&exposed(&page, &folder), &shown);
        println!("{masks} masks: as it is {plain:.3?}, measured finer {fine:.3?} (least, greatest, mean)");
        for (off, most) in [plain, fine].into_iter().zip(cut_off) {
            assert!(-off[0] <= most + 1e-9 && off[1] <= most + 1e-9, "{masks} masks: {off:?}");
        }
        if there("gs") {
            let gs = off(&rendered("gs", &file, &out), &shown);
            assert!(gs.iter().all(|x| x.abs() < 0.03), "{gs:?}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
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
