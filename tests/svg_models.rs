//! Real drawings with mesh gradients, and what their pictures have to be.

use exchange::{centre, draw, exact, square};
use glam::{DVec2, DVec4};
use gpu_support::with_gpu;
use gradtess::ferguson::Mesh;
use gradtess::scene::ferguson::parse;

mod exchange;
mod gpu_support;
mod models;

fn all(test: &str) -> Vec<(String, Mesh)> {
    let Some(folder) = models::folder("svg", test) else { return Vec::new() };
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    let read = |path: std::path::PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let mesh = parse(&std::fs::read(&path).unwrap(), &name).unwrap_or_else(|e| panic!("{e}")).0;
        (name, mesh)
    };
    paths.into_iter().filter(|p| p.extension().is_some_and(|e| e == "svg")).map(read).collect()
}

#[test]
fn every_pixel_centre_has_the_exact_colour() {
    with_gpu(|gpu| {
        for (name, mesh) in all("exact colours of drawings") {
            let (size, view) = (200, square(&mesh));
            let pixels = draw(gpu, &mesh, view, size);
            let (mut worst, mut compared, mut differ) = (0.0f64, 0, 0);
            for (i, drawn) in pixels.iter().enumerate() {
                match (exact(&mesh, centre(i, size, view)), drawn.w > 0.0) {
                    (Some(c), true) => {
                        compared += 1;
                        worst = worst.max((*drawn - c).abs().max_element());
                    }
                    (None, false) => {}
                    _ => differ += 1,
                }
            }
            println!(
                "{name}: {compared} pixels, at most {:.4}/255 off; {differ} on the outline only in one",
                worst * 255.0
            );
            // Straight sides may run through pixel centres; the outline has at most 4 * 200 pixels.
            assert!(compared > 4000 && worst < 0.51 / 255.0 && differ < 100, "{name}: {compared} {worst} {differ}");
        }
    });
}

/// The square patches of the web platform tests are functions that can be written down.
#[test]
fn square_patches_are_bilinear_functions_of_the_place() {
    for (name, mesh) in all("squares") {
        if name != "wpt-meshgradient-basic-001.svg" {
            continue;
        }
        let (blue, lime, yellow) = (DVec4::new(0., 0., 1., 1.), DVec4::new(0., 1., 0., 1.), DVec4::new(1., 1., 0., 1.));
        for x0 in [20.0, 260.0] {
            for (u, v) in [(0.1, 0.1), (0.5, 0.3), (0.9, 0.7)] {
                let wanted = (blue * (1.0 - u) + lime * u) * (1.0 - v) + (lime * (1.0 - u) + yellow * u) * v;
                let at = DVec2::new(x0 + 200.0 * u, -140.0 - 200.0 * v);
                let found = exact(&mesh, at).expect("inside");
                // Handles at thirds have six digits in the file.
                assert!((found - wanted).abs().max_element() < 1e-5, "{at}: {found} {wanted}");
            }
        }
    }
}
