//! Patches of surfaces in space at a parameter, on the CPU. GLSL twin: `glsl/solid.tese`.

use super::patches::{Patches, Place};
use crate::patch::eval::{face_sample, Sample};
use crate::patch::{ControlPoint, Kind};
use glam::DVec3;

/// A point of the surface with all that shading needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position.
    pub position: DVec3,
    /// N_L, unit, from the patch's derivatives.
    pub geometric: DVec3,
    /// N_S, unit.
    pub subdivided: DVec3,
    /// b, 0 to 1.
    pub weight: f64,
    /// N_B, unit.
    pub blended: DVec3,
}

/// A patch on its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Bicubic or Gregory.
    pub kind: Kind,
    /// Control points, 16 or 20; a transition patch's 15 further ones after them.
    pub control: Vec<ControlPoint>,
    /// Where.
    pub place: Place,
    /// Bit i: the neighbour across side i is finer.
    pub sides: u8,
}

impl Patches {
    /// Number of all patches.
    pub fn len(&self) -> usize {
        self.bicubic.len() + self.transition.len() + self.gregory.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All patches with their own control points.
    pub fn iter(&self) -> impl Iterator<Item = Patch> + '_ {
        let gather = |ids: &[u32]| ids.iter().map(|&i| self.control[i as usize]).collect();
        let whole = move |kind, ids: &[u32], place| Patch { kind, control: gather(ids), place, sides: 0 };
        let bicubic = self.bicubic.iter().map(move |(ids, place)| whole(Kind::Bicubic, ids, *place));
        let transition = self.transition.iter().map(move |t| Patch {
            sides: t.sides,
            ..whole(Kind::Bicubic, &[&t.points[..], &t.halves[..]].concat(), t.place)
        });
        let gregory = self.gregory.iter().map(move |(ids, place)| whole(Kind::Gregory, ids, *place));
        bicubic.chain(transition).chain(gregory)
    }
}

fn vector(c: &ControlPoint) -> DVec3 {
    DVec3::new(c[0], c[1], c[2])
}

/// The patch at (u, v), blended with exponent `power`.
pub fn point(kind: Kind, control: &[ControlPoint], u: f64, v: f64, power: f64) -> Point {
    let cross = |s: &Sample| vector(&s.du).cross(vector(&s.dv));
    let sample = face_sample(kind, control, u, v);
    let mut across = cross(&sample);
    if across.length_squared() <= 1e-10 * vector(&sample.du).length_squared() * vector(&sample.dv).length_squared() {
        // The boundary turns round the corner of its only face: both derivatives are along it.
        let near = |x: f64| x + (0.5 - x) / 256.0;
        across = cross(&face_sample(kind, control, near(u), near(v)));
    }
    let geometric = across.normalize_or_zero();
    let c = sample.value;
    let subdivided = DVec3::new(c[4], c[5], c[6]).try_normalize().unwrap_or(geometric);
    let weight = c[3].clamp(0.0, 1.0);
    let blend = if weight > 0.0 { weight.powf(power) } else { 0.0 };
    Point {
        position: vector(&c),
        geometric,
        subdivided,
        weight,
        blended: geometric.lerp(subdivided, blend).try_normalize().unwrap_or(geometric),
    }
}
