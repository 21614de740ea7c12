//! Patches of surfaces in space at a parameter, on the CPU. GLSL twins: `glsl/solid.tese`, `glsl/solid_quartic.tese`.

use super::patches::{Form, Patches, Place};
use crate::patch::eval::{face_sample, Sample};
use crate::patch::{quartic, ControlPoint, Kind};
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
    /// What it is.
    pub form: Form,
    /// Control points, as many as the form has; those of a transition patch's halves after them.
    pub control: Vec<ControlPoint>,
    /// Where.
    pub place: Place,
    /// Bit i: the neighbour across side i is finer.
    pub sides: u8,
}

impl Patches {
    /// Number of all patches.
    pub fn len(&self) -> usize {
        let quads = self.bicubic.len() + self.transition.len() + self.gregory.len();
        quads + self.quartic.len() + self.quartic_transition.len() + self.quartic_gregory.len()
    }

    /// Number of those with finer neighbours.
    pub fn transitions(&self) -> usize {
        self.transition.len() + self.quartic_transition.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of control points.
    pub fn points(&self) -> usize {
        self.stencils.points.len()
    }

    /// Control point `i`, as in [`crate::patch`]: x, y, z, weight; normal, 0.
    pub fn control(&self, i: u32) -> ControlPoint {
        self.stencils.point(&self.sources, i)
    }

    /// The box of all control points, without a size where there are none, and how many of them had to be made for it.
    pub fn bounds(&self) -> ([DVec3; 2], usize) {
        let (found, made) = self.stencils.bounds(&self.sources);
        (found.unwrap_or_default(), made)
    }

    /// All patches with their own control points.
    pub fn iter(&self) -> impl Iterator<Item = Patch> + '_ {
        let gather = |ids: &[u32]| ids.iter().map(|&i| self.control(i)).collect();
        let whole = move |form, ids: &[u32], place| Patch { form, control: gather(ids), place, sides: 0 };
        let bicubic = self.bicubic.iter().map(move |(ids, place)| whole(Form::Bicubic, ids, *place));
        let transition = self.transition.iter().map(move |t| Patch {
            sides: t.sides,
            ..whole(Form::Bicubic, &[&t.points[..], &t.halves[..]].concat(), t.place)
        });
        let gregory = self.gregory.iter().map(move |(ids, place)| whole(Form::Gregory, ids, *place));
        let quartic = self.quartic.iter().map(move |(ids, place)| whole(Form::Quartic, ids, *place));
        let quartic_transition = self.quartic_transition.iter().map(move |t| Patch {
            sides: t.sides,
            ..whole(Form::Quartic, &[&t.points[..], &t.halves[..]].concat(), t.place)
        });
        let quartic_gregory =
            self.quartic_gregory.iter().map(move |(ids, place)| whole(Form::QuarticGregory, ids, *place));
        bicubic.chain(transition).chain(gregory).chain(quartic).chain(quartic_transition).chain(quartic_gregory)
    }
}

fn vector(c: &ControlPoint) -> DVec3 {
    DVec3::new(c[0], c[1], c[2])
}

fn sample(form: Form, control: &[ControlPoint], u: f64, v: f64) -> Sample {
    match form {
        Form::Bicubic => face_sample(Kind::Bicubic, control, u, v),
        Form::Gregory => face_sample(Kind::Gregory, control, u, v),
        Form::Quartic => quartic::sample(&control[..15], u, v),
        Form::QuarticGregory => quartic::sample(&control[..18], u, v),
    }
}

/// The patch at (u, v), in a triangle the weights of its second and third corner; blended with exponent `power`.
pub fn point(form: Form, control: &[ControlPoint], u: f64, v: f64, power: f64) -> Point {
    let cross = |s: &Sample| vector(&s.du).cross(vector(&s.dv));
    let sample_at = |u, v| sample(form, control, u, v);
    let sample = sample_at(u, v);
    let mut across = cross(&sample);
    if across.length_squared() <= 1e-10 * vector(&sample.du).length_squared() * vector(&sample.dv).length_squared() {
        // The boundary turns round the corner of its only face, or the corner is a spike: both derivatives are along it.
        let middle = if form.sides() == 3 { 1.0 / 3.0 } else { 0.5 };
        let near = |x: f64| x + (middle - x) / 256.0;
        across = cross(&sample_at(near(u), near(v)));
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
