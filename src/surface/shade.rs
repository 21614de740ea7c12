//! Subdivision shading of a level: N_B = (1 - b^p) N_L + b^p N_S (ZBK23 eq. 1).

use super::level::{Level, Scheme};
use super::limit::{limit_value, shape};
use super::normal::{given_normals, limit_normals, mesh_normals, needed, refine_normals, ControlNormals};
use super::refine::{child_corner, refine};
use super::region::Wedges;
use super::weight::{control_weights, limit_weights, Rules};
use crate::threads;
use glam::DVec3;

/// Which geometric normals N_L are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Geometric {
    /// Those of the limit surface (the paper's text).
    #[default]
    Limit,
    /// Means of the level's face normals (the authors' tool).
    Mesh,
}

/// Choices of the shading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// First level whose normals are subdivided ones; those of the level before come from faces. At least 1.
    pub normals_from: u32,
    /// First level of weights; at most the level drawn.
    pub weights_from: u32,
    /// Control weights.
    pub rules: Rules,
    /// Exponent p, above 0.
    pub power: f64,
    /// N_L.
    pub geometric: Geometric,
    /// Where N_S starts.
    pub control: ControlNormals,
    /// Compute N_S at every vertex, needed or not.
    pub everywhere: bool,
}

impl Default for Settings {
    /// The paper's: both from level 1, ring, variant B, smooth darts, p = 1.
    fn default() -> Settings {
        Settings {
            normals_from: 1,
            weights_from: 1,
            rules: Rules::default(),
            power: 1.0,
            geometric: Geometric::default(),
            control: ControlNormals::default(),
            everywhere: false,
        }
    }
}

/// The last level with all that is drawn of it.
#[derive(Clone, Debug)]
pub struct Shaded {
    /// Vertex and region pairs; normals are one a wedge.
    pub wedges: Wedges,
    /// N_L.
    pub geometric: Vec<DVec3>,
    /// N_S; zero where the weight is 0, unless asked for everywhere.
    pub subdivided: Vec<DVec3>,
    /// N_B.
    pub blended: Vec<DVec3>,
    /// Subdivided weight, one a vertex.
    pub control_weight: Vec<f64>,
    /// Its limit b, one a vertex, 0 to 1.
    pub weight: Vec<f64>,
    /// Vertices whose subdivided normal was computed, summed over all steps; 0 where all were.
    pub normals_computed: usize,
}

impl Shaded {
    /// Vertices with a blend weight above 0: those that need N_S (ZBK23 section 5).
    pub fn blended_vertices(&self) -> usize {
        self.weight.iter().filter(|&&w| w > 0.0).count()
    }
}

/// Shades the last of `levels`, which begin with level 0. `given`: normals of the file, one a corner, or none.
///
/// # Panics
/// If `levels` is empty.
pub fn shade(levels: &[Level], given: &[DVec3], settings: &Settings) -> Shaded {
    let last = levels.last().expect("a surface has a level 0");
    threads::crew(last.vertices(), || shade_last(levels, last, given, settings))
}

fn shade_last(levels: &[Level], last: &Level, given: &[DVec3], settings: &Settings) -> Shaded {
    let wedges = Wedges::drawn(last);
    let geometric = match settings.geometric {
        Geometric::Mesh => mesh_normals(last, &wedges),
        Geometric::Limit if last.scheme == Scheme::CatmullClark && last.sides != 4 => {
            limit_normals(last, &wedges, Some(&refine(last)))
        }
        Geometric::Limit => limit_normals(last, &wedges, None),
    };
    let control_weight = control_weights(levels, settings.weights_from as usize, settings.rules);
    let weight = limit_weights(last, &control_weight);

    let wanted = (!settings.everywhere).then(|| weight.iter().map(|&w| w > 0.0).collect::<Vec<bool>>());
    let mut normals_computed = 0;
    let wanted = wanted.map(|w| (w, &mut normals_computed));
    let several = (wedges.len() > last.vertices()).then_some(&wedges);
    let subdivided = subdivided(levels, several, given, settings, wanted);
    let blend = |w: usize| {
        let b = weight[last.origin[wedges.first[w] as usize] as usize];
        let b = if settings.power == 1.0 { b } else { b.powf(settings.power) };
        if b == 0.0 {
            geometric[w]
        } else {
            (geometric[w] * (1.0 - b) + subdivided[w] * b).try_normalize().unwrap_or(geometric[w])
        }
    };
    let blended = threads::collect(wedges.len(), blend);
    Shaded { wedges, geometric, subdivided, blended, control_weight, weight, normals_computed }
}

/// N_S of the last of `levels`, one a wedge as drawn. `wanted`: which vertices need it, and what counts those computed on
/// all levels; none: all need it.
pub fn subdivided_normals(
    levels: &[Level],
    given: &[DVec3],
    settings: &Settings,
    wanted: Option<(Vec<bool>, &mut usize)>,
) -> Vec<DVec3> {
    let several = levels.last().and_then(Wedges::several);
    subdivided(levels, several.as_ref(), given, settings, wanted)
}

/// `several`: wedges of the last level, if some vertex has more than one.
fn subdivided(
    levels: &[Level],
    several: Option<&Wedges>,
    given: &[DVec3],
    settings: &Settings,
    wanted: Option<(Vec<bool>, &mut usize)>,
) -> Vec<DVec3> {
    let n = levels.len() - 1;
    let start = (settings.normals_from.max(1) as usize - 1).min(n);
    let (last, mut computed) = match wanted {
        Some((wanted, computed)) => (wanted, Some(computed)),
        None => (vec![true; levels[n].vertices()], None),
    };
    // From the last level to the one where subdivision starts.
    let mut wanted = vec![last];
    for level in levels[start..n].iter().rev() {
        wanted.push(needed(level, &wanted[wanted.len() - 1]));
    }
    wanted.reverse();
    let drawn = Wedges::drawn(&levels[start]);
    let mut normals = mesh_normals(&levels[start], &drawn);
    if start == 0 && settings.control == ControlNormals::Given && !given.is_empty() {
        normals = given_normals(&levels[0], &drawn, given, normals);
    }
    let mut drawn = (drawn.len() > levels[start].vertices()).then_some(drawn);
    for (k, wanted) in (start + 1..=n).zip(&wanted[1..]) {
        let made = if k < n { Wedges::several(&levels[k]) } else { None };
        let after = if k < n { made.as_ref() } else { several };
        normals = refine_normals(&levels[k - 1], drawn.as_ref(), &normals, after, Some(wanted));
        if let Some(computed) = &mut computed {
            **computed += wanted.iter().filter(|&&w| w).count();
        }
        drawn = made;
    }
    normals
}

/// Limit positions of the vertices of `level`, as if its remaining sharpness were endless.
pub fn limit_positions(level: &Level) -> Vec<DVec3> {
    let finer = (level.scheme == Scheme::CatmullClark && level.sides != 4).then(|| refine(level));
    let on = finer.as_ref().unwrap_or(level);
    let limit = |v: usize| {
        let h = match finer {
            Some(_) => child_corner(level, level.spoke[v]),
            None => level.spoke[v],
        };
        let shape = shape(on.sharp_edges[v], on.corner_sharpness(v as u32) > 0.0);
        limit_value(on, h, shape, |g| on.is_sharp(g), |g| on.position[on.origin[g as usize] as usize])
    };
    threads::collect(level.vertices(), limit)
}
