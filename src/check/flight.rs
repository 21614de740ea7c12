//! Scripted camera paths, and what must not be seen along them: background within an outline, and jumps.

use crate::camera::{Camera, Projection};
use crate::image::Picture;
use glam::DVec3;

/// A flight of `frames` frames around and close by what lies within `bounds`: twice around, up and down, near and far.
pub fn flight(bounds: [DVec3; 2], frames: u32, aspect: f64) -> Vec<Camera> {
    let turn = std::f64::consts::TAU;
    (0..frames)
        .map(|k| {
            let t = f64::from(k) / f64::from(frames.max(1));
            let (yaw, pitch) = (720.0 * t, 15.0 + 50.0 * (3.0 * turn * t).sin());
            let fitted = Camera::orbit(bounds, yaw, pitch, Projection::Perspective { fov: 30.0 }, aspect);
            let far = 0.25 + 0.7 * (1.0 + (2.0 * turn * t).cos());
            fitted.at_distance((fitted.eye - fitted.target).length() * far)
        })
        .collect()
}

/// A slow approach to half the distance, through an angle so narrow that the middle fills the picture.
pub fn slow_zoom(bounds: [DVec3; 2], frames: u32, aspect: f64) -> Vec<Camera> {
    let fitted = Camera::orbit(bounds, 30.0, 10.0, Projection::Perspective { fov: 30.0 }, aspect);
    let near = (fitted.eye - fitted.target).length() * 1.1;
    (0..frames)
        .map(|k| {
            let t = f64::from(k) / f64::from(frames.max(2) - 1);
            let camera = Camera { projection: Projection::Perspective { fov: 3.6 }, ..fitted };
            camera.at_distance(near * 2f64.powf(1.0 - t))
        })
        .collect()
}

/// Pixels where the background is seen though all of the pixels at most `reach` away are covered in `reference`, or all
/// eight neighbours are covered in the picture itself. Both pictures are of one size and over a transparent ground.
pub fn background_inside(picture: &Picture, reference: Option<&Picture>, reach: usize) -> usize {
    let (w, h) = (picture.width as usize, picture.height as usize);
    let covered = |p: &Picture, x: usize, y: usize| p.rgba[4 * (y * w + x) + 3] > 0;
    let around = |p: &Picture, x: usize, y: usize, reach: usize, skip: bool| {
        let rows = y.saturating_sub(reach)..=(y + reach).min(h - 1);
        let columns = x.saturating_sub(reach)..=(x + reach).min(w - 1);
        rows.flat_map(|j| columns.clone().map(move |i| (i, j)))
            .all(|(i, j)| (skip && (i, j) == (x, y)) || covered(p, i, j))
    };
    let mut found = 0;
    for y in 0..h {
        for x in 0..w {
            if covered(picture, x, y) {
                continue;
            }
            let inside = reference.is_some_and(|reference| around(reference, x, y, reach, false));
            let inner = x > 0 && y > 0 && x + 1 < w && y + 1 < h;
            found += usize::from(inside || (inner && around(picture, x, y, 1, true)));
        }
    }
    found
}

/// Greatest change of a channel among pixels that both pictures cover, and how many those are.
pub fn greatest_change(a: &Picture, b: &Picture) -> (u8, usize) {
    let both = a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)).filter(|(p, q)| p[3] > 0 && q[3] > 0);
    both.fold((0, 0), |(most, count), (p, q)| {
        let change = (0..3).map(|c| p[c].abs_diff(q[c])).max().unwrap_or(0);
        (most.max(change), count + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(holes: &[(usize, usize)]) -> Picture {
        let mut rgba = vec![255; 4 * 64];
        for &(x, y) in holes {
            rgba[4 * (8 * y + x) + 3] = 0;
        }
        Picture { width: 8, height: 8, rgba }
    }

    #[test]
    fn holes_are_found_by_their_neighbours_and_by_the_reference() {
        let (whole, one) = (picture(&[]), picture(&[(3, 3)]));
        assert_eq!(background_inside(&one, None, 1), 1);
        assert_eq!(background_inside(&whole, None, 1), 0);
        // Two pixels wide: no pixel has eight covered neighbours.
        let wide = picture(&[(3, 3), (4, 3), (3, 4), (4, 4)]);
        assert_eq!(background_inside(&wide, None, 1), 0);
        assert_eq!(background_inside(&wide, Some(&whole), 2), 4);
        // The reference's own outline is not inside.
        assert_eq!(background_inside(&wide, Some(&wide), 2), 0);
    }

    #[test]
    fn changes_count_where_both_are_covered() {
        let (a, mut b) = (picture(&[(0, 0)]), picture(&[(0, 1)]));
        b.rgba[4 * 20 + 1] = 200;
        assert_eq!(greatest_change(&a, &b), (55, 62));
    }

    #[test]
    fn paths_look_at_the_middle_and_the_zoom_halves_the_distance() {
        let bounds = [DVec3::splat(-1.0), DVec3::ONE];
        let far = |c: &Camera| (c.eye - c.target).length();
        let zoom = slow_zoom(bounds, 10, 1.0);
        assert!((far(&zoom[0]) / far(&zoom[9]) - 2.0).abs() < 1e-9);
        assert!(flight(bounds, 50, 1.0).iter().all(|c| c.target.length() < 1e-12 && far(c) > 1.0));
    }
}
