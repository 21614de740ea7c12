//! Meshes a scene may name instead of listing vertices and faces.
//!
//! All are counter-clockwise with y up and about two units wide, so that unit scenes look alike.

use super::InputMesh;
use glam::DVec2;
use std::f64::consts::TAU;

/// Most face corners a named mesh may have: a few bytes of text must not fill the memory.
const MOST_CORNERS: usize = 1 << 22;

/// All names, for messages.
pub const NAMES: &str = "triangle, quad, pentagon, hexagon, grid:WxH, fan:N, ring:N or strip:N";

/// The mesh called `name` (see [`NAMES`]):
///
/// - `triangle`, `quad`, `pentagon`, `hexagon`: one face; vertex 0 is the topmost (the upper right one of the quad);
/// - `grid:WxH`: W times H squares, vertices row by row from the lower left;
/// - `fan:N` (N >= 3): N quads around vertex 0;
/// - `ring:N` (N >= 3): N quads around a hole, inner vertices first;
/// - `strip:N`: N squares in a row, the same as `grid:Nx1`.
///
/// # Errors
/// (what, fix) when the name is unknown, or a number is missing, too small or too large.
pub fn builtin(name: &str) -> Result<InputMesh, (String, String)> {
    let (kind, size) = name.split_once(':').unwrap_or((name, ""));
    let unknown = || (format!("no built-in mesh is called {}", super::error::quoted(name)), format!("use {NAMES}"));
    let mesh = match (kind, size) {
        ("triangle", "") => polygon(3, 0.25),
        ("quad", "") => polygon(4, 0.125),
        ("pentagon", "") => polygon(5, 0.25),
        ("hexagon", "") => polygon(6, 0.25),
        ("grid", _) => {
            let (w, h) = size.split_once('x').ok_or_else(unknown)?;
            let (w, h) = (number(name, w, 1)?, number(name, h, 1)?);
            within(name, w.saturating_mul(h).saturating_mul(4))?;
            grid(w, h)
        }
        ("strip", _) => {
            let n = number(name, size, 1)?;
            within(name, n.saturating_mul(4))?;
            grid(n, 1)
        }
        ("fan" | "ring", _) => {
            let n = number(name, size, 3)?;
            within(name, n.saturating_mul(4))?;
            if kind == "fan" {
                fan(n)
            } else {
                ring(n)
            }
        }
        _ => return Err(unknown()),
    };
    Ok(mesh)
}

fn number(name: &str, text: &str, least: usize) -> Result<usize, (String, String)> {
    text.parse().ok().filter(|&n| n >= least).ok_or_else(|| {
        (
            format!("{} is no size for a built-in mesh", super::error::quoted(name)),
            format!("give whole numbers from {least}, as in grid:3x2, fan:5, ring:8 or strip:4"),
        )
    })
}

fn within(name: &str, corners: usize) -> Result<(), (String, String)> {
    if corners <= MOST_CORNERS {
        return Ok(());
    }
    Err((
        format!("built-in mesh {} has too many faces", super::error::quoted(name)),
        format!("at most {MOST_CORNERS} face corners are allowed"),
    ))
}

/// One regular polygon with `n` sides on the unit circle; vertex 0 at the angle `turn` (in full turns).
fn polygon(n: usize, turn: f64) -> InputMesh {
    let positions = (0..n).map(|k| on_circle(k as f64 / n as f64 + turn, 1.0)).collect();
    from_faces(positions, [(0..n as u32).collect::<Vec<_>>()])
}

fn grid(w: usize, h: usize) -> InputMesh {
    let scale = 2.0 / w.max(h) as f64;
    let mut positions = Vec::with_capacity((w + 1) * (h + 1));
    for y in 0..=h {
        for x in 0..=w {
            positions.push(DVec2::new(x as f64 - 0.5 * w as f64, y as f64 - 0.5 * h as f64) * scale);
        }
    }
    let row = w as u32 + 1;
    from_faces(
        positions,
        (0..h as u32).flat_map(|y| {
            (0..w as u32).map(move |x| {
                let v = y * row + x;
                [v, v + 1, v + 1 + row, v + row]
            })
        }),
    )
}

/// `n` quads around vertex 0. Odd ring vertices lie on spokes, even ones between spokes.
fn fan(n: usize) -> InputMesh {
    let mut positions = vec![DVec2::ZERO];
    positions.extend((0..2 * n).map(|k| on_circle(k as f64 / (2 * n) as f64 + 0.25, 1.0)));
    let ring = |k: usize| 1 + (k % (2 * n)) as u32;
    from_faces(positions, (0..n).map(|k| [0, ring(2 * k), ring(2 * k + 1), ring(2 * k + 2)]))
}

fn ring(n: usize) -> InputMesh {
    let circle = |radius| (0..n).map(move |k| on_circle(k as f64 / n as f64 + 0.25, radius));
    let positions = circle(0.5).chain(circle(1.0)).collect();
    let (inner, outer) = (|k: usize| (k % n) as u32, |k: usize| (n + k % n) as u32);
    from_faces(positions, (0..n).map(|k| [inner(k), outer(k), outer(k + 1), inner(k + 1)]))
}

fn on_circle(turns: f64, radius: f64) -> DVec2 {
    DVec2::from_angle(turns * TAU) * radius
}

fn from_faces<F: AsRef<[u32]>>(positions: Vec<DVec2>, faces: impl IntoIterator<Item = F>) -> InputMesh {
    let mut mesh = InputMesh { positions, face_start: vec![0], ..InputMesh::default() };
    for face in faces {
        mesh.corners.extend_from_slice(face.as_ref());
        mesh.face_start.push(mesh.corners.len() as u32);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_is_counter_clockwise_and_uses_every_vertex() {
        for name in
            ["triangle", "quad", "pentagon", "hexagon", "grid:3x2", "fan:3", "fan:6", "ring:3", "ring:8", "strip:4"]
        {
            let mesh = builtin(name).unwrap();
            let mut used = vec![false; mesh.positions.len()];
            for face in mesh.face_start.windows(2) {
                let corners = &mesh.corners[face[0] as usize..face[1] as usize];
                let at = |k: usize| mesh.positions[corners[k % corners.len()] as usize];
                let area: f64 = (0..corners.len()).map(|k| at(k).perp_dot(at(k + 1))).sum();
                assert!(area > 1e-3, "{name}");
                corners.iter().for_each(|&v| used[v as usize] = true);
            }
            assert!(used.iter().all(|&u| u), "{name}");
        }
    }

    #[test]
    fn wrong_names_and_sizes_are_refused() {
        for name in ["", "cube", "fan", "fan:2", "fan:x", "grid:3", "grid:0x4", "grid:-1x2", "triangle:3", "ring:1e9"] {
            assert!(builtin(name).is_err(), "{name}");
        }
        for name in ["grid:99999999x99999999", "grid:18446744073709551615x2", "fan:99999999", "strip:4000000"] {
            assert!(builtin(name).unwrap_err().0.contains("too many"), "{name}");
        }
    }
}
