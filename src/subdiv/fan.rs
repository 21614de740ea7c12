//! The neighbourhood of one vertex, gathered once for limits, tangents and Gregory points.

use super::level::{vertex_bits, Level};
use glam::{DVec2, DVec4};
use std::ops::{Add, Mul, Sub};

/// What the rules need of a value: positions (two channels) and colours (four) alike.
pub trait Linear: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> + Default {}
impl Linear for DVec2 {}
impl Linear for DVec4 {}
impl Linear for super::level::Value {}

/// Spokes and faces around a vertex, or around it within one colour sector, in the order of
/// [`Level::spoke_after`]. Buffers are kept between vertices.
#[derive(Clone, Debug, Default)]
pub struct Fan<V> {
    /// Value at the vertex.
    pub centre: V,
    /// Far ends of the spokes: as many as faces if closed, one more if open.
    pub spoke: Vec<V>,
    /// Mean of each face's corners; face i lies between spokes i and i + 1.
    pub face: Vec<V>,
    /// Corner opposite the vertex in each face; in other than quads `v + 3 (mean - v)` in a triangle and
    /// `v + 2 (mean - v)` otherwise.
    pub opposite: Vec<V>,
    /// Whether the last face meets the first spoke.
    pub closed: bool,
    /// Half-edges of the spokes that leave the vertex, one a face.
    pub half_edge: Vec<u32>,
    /// Around a dart, the spoke that is sharp: its far end stays apart from the faces beside it.
    pub dart: Option<usize>,
}

impl<V: Linear> Fan<V> {
    /// Number of faces.
    pub fn faces(&self) -> usize {
        self.face.len()
    }

    /// Index of the spoke that `h` runs along.
    ///
    /// # Panics
    /// If `h` does not leave the vertex within the fan.
    pub fn spoke_of(&self, h: u32) -> usize {
        self.half_edge.iter().position(|&s| s == h).expect("the half-edge leaves the fan's vertex")
    }

    fn clear(&mut self) {
        self.spoke.clear();
        self.face.clear();
        self.opposite.clear();
        self.half_edge.clear();
        self.dart = None;
    }

    fn push_face(&mut self, level: &Level, h: u32, value: impl Fn(u32) -> V) {
        let f = level.face_of(h);
        let n = level.valence(f);
        let mut sum = V::default();
        for g in level.of_face(f) {
            sum = sum + value(g);
        }
        let mean = sum * (1.0 / f64::from(n));
        self.half_edge.push(h);
        self.face.push(mean);
        self.opposite.push(match n {
            4 => value(level.next(level.next(h))),
            3 => self.centre + (mean - self.centre) * 3.0,
            _ => self.centre + (mean - self.centre) * 2.0,
        });
    }
}

/// Positions around the origin of `h`. Closed fans start at the least half-edge, so that the sums come out the
/// same whoever asks.
pub fn position_fan(level: &Level, h: u32, fan: &mut Fan<DVec2>) {
    fan.clear();
    let at = |g: u32| level.position(g);
    let boundary = level.bits[level.origin[h as usize] as usize] & vertex_bits::BOUNDARY != 0;
    let start = if boundary { level.fan_start(h, |_| false) } else { least(level, h) };
    fan.centre = at(h);
    fan.closed = !boundary;
    let mut spoke = start;
    loop {
        fan.spoke.push(at(level.next(spoke)));
        fan.push_face(level, spoke, at);
        match level.spoke_after(spoke) {
            Some(s) if s == start => return,
            Some(s) => spoke = s,
            None => break,
        }
    }
    fan.spoke.push(at(level.prev(spoke)));
}

/// Colours around the origin of `h`, in its sector where sharp edges or the boundary part the faces. Around a
/// dart the fan is closed and the far end of the sharp spoke counts with the mean of its two sides.
pub fn colour_fan(level: &Level, h: u32, fan: &mut Fan<DVec4>) {
    use vertex_bits::{BOUNDARY, DART, SECTORS};
    fan.clear();
    let at = |g: u32| level.corner_colour(g);
    let bits = level.bits[level.origin[h as usize] as usize];
    fan.centre = at(h);
    fan.closed = bits & (BOUNDARY | SECTORS) == 0;
    let start = if fan.closed { least(level, h) } else { level.fan_start(h, |s| level.colour_border(s)) };
    let mut spoke = start;
    loop {
        let mut far = at(level.next(spoke));
        if bits & DART != 0 {
            if let Some(t) = level.across(spoke) {
                far = (far + at(t)) * 0.5;
            }
            if level.colour_border(spoke) {
                fan.dart = Some(fan.spoke.len());
            }
        }
        fan.spoke.push(far);
        fan.push_face(level, spoke, at);
        match level.spoke_after(spoke) {
            Some(s) if s == start || (!fan.closed && level.colour_border(s)) => break,
            Some(s) => spoke = s,
            None => break,
        }
    }
    if !fan.closed {
        fan.spoke.push(at(level.prev(spoke)));
    }
}

fn least(level: &Level, h: u32) -> u32 {
    let mut least = h;
    level.around(h, |s| least = least.min(s));
    least
}
