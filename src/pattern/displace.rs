//! Displacement along the normal: a sine (BS05 Fig. 4), gradient noise, a height map (3.2). CPU twin of
//! `glsl/inc/displace.glsl`.

use glam::{DVec2, DVec3};

/// How far points move along their normal.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Displacement {
    /// Not at all.
    #[default]
    None,
    /// By a sine of the distance from the origin.
    Sine(Sine),
    /// By a sum of octaves of gradient noise.
    Noise(Noise),
    /// By a picture over the texture coordinates.
    Height(HeightMap),
}

/// a sin(f |P|), as in Fig. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// a, model units.
    pub amplitude: f64,
    /// f, radians a model unit.
    pub frequency: f64,
}

/// Octaves of gradient noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Of the first octave, model units.
    pub amplitude: f64,
    /// Of the first octave, cells a model unit.
    pub frequency: f64,
    /// 1 to 16.
    pub octaves: u32,
    /// Amplitude of an octave over that of the one before.
    pub gain: f64,
    /// Frequency of an octave over that of the one before.
    pub lacunarity: f64,
    /// Cells that the first octave drifts in a unit of time; the others drift other ways.
    pub speed: f64,
    /// When.
    pub time: f64,
    /// Another seed, other noise.
    pub seed: u32,
}

impl Default for Noise {
    fn default() -> Noise {
        Noise { amplitude: 0.1, frequency: 1.0, octaves: 1, gain: 0.5, lacunarity: 2.0, speed: 1.0, time: 0.0, seed: 0 }
    }
}

/// A grid of heights over the unit square of texture coordinates, rows from the top (v = 1); held at its border outside.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Columns, rows; at least 1.
    pub size: [u32; 2],
    /// 0 to 1, row by row.
    pub heights: Vec<f32>,
    /// Model units from height 0 to 1.
    pub amplitude: f64,
    /// Height that moves nothing.
    pub middle: f64,
}

impl Displacement {
    /// Greatest distance that a point can move.
    pub fn reach(&self) -> f64 {
        match self {
            Displacement::None => 0.0,
            Displacement::Sine(s) => s.amplitude.abs(),
            // A cell's noise stays below 1.
            Displacement::Noise(n) => (0..n.octaves).map(|o| (n.amplitude * n.gain.powi(o as i32)).abs()).sum(),
            Displacement::Height(h) => h.amplitude.abs() * h.middle.abs().max((1.0 - h.middle).abs()),
        }
    }

    /// The same at another time.
    #[must_use]
    pub fn at_time(mut self, time: f64) -> Displacement {
        if let Displacement::Noise(noise) = &mut self {
            noise.time = time;
        }
        self
    }

    /// Height and its gradient in space at a point of the surface before displacement.
    pub fn at(&self, p: DVec3, uv: DVec2, uv_gradient: [DVec3; 2]) -> (f64, DVec3) {
        match self {
            Displacement::None => (0.0, DVec3::ZERO),
            Displacement::Sine(s) => {
                let r = p.length();
                let (sin, cos) = (s.frequency * r).sin_cos();
                let slope = if r > 0.0 { s.amplitude * s.frequency * cos / r } else { 0.0 };
                (s.amplitude * sin, p * slope)
            }
            Displacement::Noise(noise) => octaves(noise, p),
            Displacement::Height(map) => {
                let (h, slope) = map.sample(uv);
                let gradient = uv_gradient[0] * slope.x + uv_gradient[1] * slope.y;
                ((h - map.middle) * map.amplitude, gradient * map.amplitude)
            }
        }
    }
}

/// Ways in which octaves drift: corners of a cube in turn, so that none stands still against the next.
const DRIFT: [DVec3; 4] = [
    DVec3::new(1.0, 0.5, 0.25),
    DVec3::new(-0.75, 0.5, -1.0),
    DVec3::new(0.5, -1.0, 0.75),
    DVec3::new(-0.5, -0.75, 1.0),
];

fn octaves(noise: &Noise, p: DVec3) -> (f64, DVec3) {
    let (mut height, mut gradient) = (0.0, DVec3::ZERO);
    let (mut amplitude, mut frequency) = (noise.amplitude, noise.frequency);
    for octave in 0..noise.octaves {
        let q = p * frequency + DRIFT[octave as usize % 4] * (noise.speed * noise.time);
        let (h, g) = gradient_noise(q, noise.seed.wrapping_add(octave));
        height += amplitude * h;
        gradient += g * (amplitude * frequency);
        amplitude *= noise.gain;
        frequency *= noise.lacunarity;
    }
    (height, gradient)
}

/// Hashes a lattice point to a gradient in the cube from -1 to 1.
fn lattice_gradient(x: i32, y: i32, z: i32, seed: u32) -> DVec3 {
    // Three words that stir one another (M. Jarzynski, M. Olano: Hash Functions for GPU Rendering, 2020, "pcg3d").
    let mut v = [x, y, z].map(|c| (c as u32).wrapping_add(seed.wrapping_mul(0x9E37_79B9)));
    for w in &mut v {
        *w = w.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    }
    let stir = |v: &mut [u32; 3]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[2]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
    };
    stir(&mut v);
    for w in &mut v {
        *w ^= *w >> 16;
    }
    stir(&mut v);
    // 16 bits: exact in single precision too.
    DVec3::from(v.map(|w| f64::from(w >> 16) / 32767.5 - 1.0))
}

/// Gradient noise of one cell size, about -1 to 1, and its gradient; 0 at lattice points.
pub fn gradient_noise(p: DVec3, seed: u32) -> (f64, DVec3) {
    let cell = p.floor();
    let f = p - cell;
    let [x, y, z] = cell.to_array().map(|c| c as i32);
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let slope = |t: f64| 30.0 * t * t * (t * (t - 2.0) + 1.0);
    let (s, d) = (f.to_array().map(fade), f.to_array().map(slope));
    let (mut value, mut gradient) = (0.0, DVec3::ZERO);
    for corner in 0..8 {
        let at = [corner & 1, corner >> 1 & 1, corner >> 2];
        let g = lattice_gradient(x.wrapping_add(at[0]), y.wrapping_add(at[1]), z.wrapping_add(at[2]), seed);
        let ramp = g.dot(f - DVec3::new(f64::from(at[0]), f64::from(at[1]), f64::from(at[2])));
        let weight = |axis: usize| if at[axis] == 1 { s[axis] } else { 1.0 - s[axis] };
        let rate = |axis: usize| if at[axis] == 1 { d[axis] } else { -d[axis] };
        let (wx, wy, wz) = (weight(0), weight(1), weight(2));
        let w = wx * wy * wz;
        value += w * ramp;
        gradient += g * w + DVec3::new(rate(0) * wy * wz, wx * rate(1) * wz, wx * wy * rate(2)) * ramp;
    }
    (value, gradient)
}

impl HeightMap {
    /// Bilinear height at texture coordinates (s, t), and its derivatives; texel centres are at halves.
    pub fn sample(&self, uv: DVec2) -> (f64, DVec2) {
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let q = DVec2::new(uv.x, 1.0 - uv.y) * size - DVec2::splat(0.5);
        let q = q.clamp(DVec2::ZERO, size - DVec2::ONE);
        let cell = q.floor();
        let f = q - cell;
        let [x, y] = [cell.x as u32, cell.y as u32];
        let at = |i: u32, j: u32| {
            let (i, j) = ((x + i).min(self.size[0] - 1), (y + j).min(self.size[1] - 1));
            f64::from(self.heights[(j * self.size[0] + i) as usize])
        };
        let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        let (top, bottom) = (a + (b - a) * f.x, c + (d - c) * f.x);
        let across = (b - a) * (1.0 - f.y) + (d - c) * f.y;
        (top + (bottom - top) * f.y, DVec2::new(across * size.x, (top - bottom) * size.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_null_on_the_lattice_continuous_and_bounded() {
        let mut most: f64 = 0.0;
        for i in 0..400 {
            let t = f64::from(i);
            let p = DVec3::new((t * 0.731).sin() * 9.0, (t * 0.317).cos() * 7.0, t * 0.05 - 10.0);
            assert!(gradient_noise(p.floor(), 3).0.abs() < 1e-15);
            let (h, _) = gradient_noise(p, 3);
            most = most.max(h.abs());
            let edge = DVec3::new(p.x.floor(), p.y, p.z);
            let (below, above) = (gradient_noise(edge - DVec3::X * 1e-9, 3), gradient_noise(edge + DVec3::X * 1e-9, 3));
            assert!((below.0 - above.0).abs() < 1e-7 && (below.1 - above.1).length() < 1e-6);
        }
        assert!(most > 0.2 && most < 1.0, "{most}");
    }

    #[test]
    fn gradients_agree_with_differences() {
        let p = DVec3::new(0.63, -0.41, 1.27);
        let uv = [DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.1, 1.0, 0.3)];
        let heights = (0..20).map(|i| (i * 7 % 11) as f32 / 10.0).collect();
        let all = [
            Displacement::Sine(Sine { amplitude: 0.3, frequency: 5.0 }),
            Displacement::Noise(Noise { octaves: 3, time: 0.7, frequency: 1.7, ..Noise::default() }),
            Displacement::Height(HeightMap { size: [5, 4], heights, amplitude: 0.7, middle: 0.5 }),
        ];
        for displacement in all {
            let at = |p: DVec3| displacement.at(p, DVec2::new(uv[0].dot(p), uv[1].dot(p)), uv);
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let e = 1e-6;
                let slope = (at(p + axis * e).0 - at(p - axis * e).0) / (2.0 * e);
                assert!((at(p).1.dot(axis) - slope).abs() < 1e-6, "{displacement:?}");
            }
            assert!(at(p).0.abs() <= displacement.reach());
        }
    }

    #[test]
    fn height_maps_interpolate_texel_centres_top_row_first() {
        let map = HeightMap { size: [2, 2], heights: vec![0.0, 1.0, 0.25, 0.5], amplitude: 1.0, middle: 0.0 };
        assert_eq!(map.sample(DVec2::new(0.25, 0.75)).0, 0.0);
        assert_eq!(map.sample(DVec2::new(0.75, 0.25)).0, 0.5);
        assert_eq!(map.sample(DVec2::new(0.5, 0.75)).0, 0.5);
        assert_eq!(map.sample(DVec2::new(9.0, 9.0)).0, 1.0);
    }
}
