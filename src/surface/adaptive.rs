//! Feature-adaptive subdivision (NLMD12), with subdivided normals and blend weights as further
//! channels: a level has only the faces that a patch cannot draw one level before, and those around them.
//!
//! A vertex is *near* trouble, and its faces are refined, where a fan is not regular, where a finite sharpness is left, or
//! where a blend weight starts. It is *wide*, and the faces around those are refined too, where later levels set weights
//! that the patches around would not know of: before the first level of weights, where an extraordinary crease will decay
//! or a crease ends, and where the ring of an extraordinary vertex meets a sharp edge or the boundary. Both sets shrink by half from level
//! to level, so neighbours differ by one level at most.
//!
//! Channels are linear from the first level on that patches may draw; until then N_S is normalised in every step, as on
//! uniform levels. Otherwise the field of a coarse patch would not be that of the finer one beside it. Creases count as
//! smooth as soon as their sharpness is used up.

use super::level::{Level, Scheme};
use super::limit::{shape, Shape};
use super::normal::{given_normals, merged, mesh_normals, ControlNormals};
use super::part::{around, step, touching, vertices_of};
use super::region::Wedges;
use super::shade::Settings;
use super::stencil::{refine_values, refine_wedge_values, region_ends};
use super::weight::{roles, set, Initial, Role, Variant};
use crate::mesh::NONE;
use glam::DVec3;

/// What becomes of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Not part of the surface on this level: it holds what its neighbours need.
    Padding,
    /// A patch.
    Drawn,
    /// The next level has its children.
    Refined,
}

/// What there is of a level.
#[derive(Clone, Debug)]
pub struct Part {
    /// The level, its borders being the edges that are still sharp. Vertices of padding alone may be anything.
    pub level: Level,
    /// Of each face.
    pub fate: Vec<Fate>,
    /// Each face's number in the whole level; that of its parent, where both have as many sides, is a fourth of it.
    pub name: Vec<u64>,
    /// Regions between edges that are still sharp.
    pub live: Wedges,
    /// N_S, one a wedge of `live`; not unit from the first level drawn on.
    pub normal: Vec<DVec3>,
    /// Control weight, one a vertex.
    pub weight: Vec<f64>,
    /// Of each half-edge of a refined face, the face of the next part at its corner; else [`NONE`].
    pub child: Vec<u32>,
    /// Vertices that were computed for this level.
    pub computed: usize,
}

/// How deep to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Depth {
    /// First level that may be drawn, at least 1; all before is refined.
    pub first: u32,
    /// Last level, at least `first`. Patches there are of all kinds; before, regular ones only.
    pub last: u32,
}

impl Depth {
    /// As few patches as can be, refined near trouble down to level `last`.
    pub fn adaptive(last: u32, settings: &Settings) -> Depth {
        Depth { first: settings.normals_from.saturating_sub(1).clamp(1, last.max(1)), last: last.max(1) }
    }

    /// Level `last` alone.
    pub fn uniform(last: u32) -> Depth {
        Depth { first: last.max(1), last: last.max(1) }
    }
}

/// Levels of `control` from 0 on, each as far as it is needed. `given` as in [`super::shade::shade`].
pub fn subdivide(control: &Level, given: &[DVec3], settings: &Settings, depth: Depth) -> Vec<Part> {
    let normals_start = settings.normals_from.max(1).min(depth.last) - 1;
    let weights_start = settings.weights_from.min(depth.last);
    let mut level = control.clone();
    let mut drawn = Wedges::drawn(&level);
    let mut normal = vec![DVec3::ZERO; drawn.len()];
    let mut weight = vec![0.0; level.vertices()];
    let mut owned = vec![true; level.faces()];
    let mut name: Vec<u64> = (0..level.faces() as u64).collect();
    // Of the vertices that were there before.
    let mut was_sharp: Vec<bool> = Vec::new();
    let mut computed = 0;
    let mut parts = Vec::new();
    loop {
        let k = level.depth;
        if k == normals_start {
            normal = mesh_normals(&level, &drawn);
            if k == 0 && settings.control == ControlNormals::Given && !given.is_empty() {
                normal = given_normals(&level, &drawn, given, normal);
            }
        }
        let live = Wedges::live(&level);
        normal = if k < normals_start { vec![DVec3::ZERO; live.len()] } else { merged(&drawn, &live, &normal) };
        level.border = level.sharpness.iter().map(|&s| s > 0.0).collect();
        level.border_edges = level.sharp_edges.clone();
        let now = roles(&level, settings.rules.darts);
        if k >= weights_start {
            let fresh = |v: usize| k == weights_start || was_sharp.get(v).is_some_and(|&was| was && !now[v].sharp);
            set(&level, settings.rules, &now, fresh, &mut weight);
        }
        let refined = match k {
            k if k >= depth.last => vec![false; level.faces()],
            k if k < depth.first => owned.clone(),
            _ => in_trouble(&level, &owned, &now, settings, k < weights_start),
        };
        let fate = owned.iter().zip(&refined).map(|(&owned, &refined)| match (owned, refined) {
            (_, true) => Fate::Refined,
            (true, false) => Fate::Drawn,
            (false, false) => Fate::Padding,
        });
        let mut part = Part {
            fate: fate.collect(),
            name,
            live,
            normal,
            weight,
            child: vec![NONE; level.half_edges()],
            computed,
            level,
        };
        if !refined.contains(&true) {
            parts.push(part);
            return parts;
        }
        let done = step(&part.level, &refined);
        let from = &done.from;
        let on: &Level = &from.level;
        // By half-edge: a vertex at the edge of the part may not have all its regions there.
        let at_corner: Vec<DVec3> =
            from.half_edge.iter().map(|&h| part.normal[part.live.of[h as usize] as usize]).collect();
        let at_vertex: Vec<f64> = from.vertex.iter().map(|&v| part.weight[v as usize]).collect();
        let next_drawn = Wedges::drawn(&done.next);
        let next_normal = if k < normals_start {
            vec![DVec3::ZERO; next_drawn.len()]
        } else {
            let mut n = refine_wedge_values(on, &next_drawn, |h| at_corner[h as usize], Some(&done.wanted));
            if k < depth.first {
                for n in &mut n {
                    *n = n.normalize_or_zero();
                }
            }
            n
        };
        let next_weight = if k < weights_start {
            vec![0.0; done.next.vertices()]
        } else {
            refine_values(on, &at_vertex, Some(&done.wanted))
        };
        was_sharp = from.vertex.iter().map(|&v| now[v as usize].sharp).collect();
        name = match part.level.scheme {
            Scheme::CatmullClark => from
                .half_edge
                .iter()
                .map(|&h| {
                    let f = part.level.face_of(h);
                    match part.level.sides {
                        4 => 4 * part.name[f] + u64::from(h - part.level.of_face(f).start),
                        _ => u64::from(h),
                    }
                })
                .collect(),
            Scheme::Loop => {
                from.half_edge.chunks(3).flat_map(|h| (0..4).map(|k| 4 * part.name[h[0] as usize / 3] + k)).collect()
            }
        };
        for &whole in &from.half_edge {
            if refined[part.level.face_of(whole)] {
                part.child[whole as usize] = done.child(whole);
            }
        }
        computed = done.wanted.iter().filter(|&&w| w).count();
        (level, drawn, normal, weight, owned) = (done.next, next_drawn, next_normal, next_weight, done.owned);
        parts.push(part);
    }
}

/// Whether all regions at the origin of `h`, a half-edge whose vertex has all its faces, can be drawn by regular patches.
fn regular(level: &Level, h: u32) -> bool {
    let v = level.origin[h as usize];
    let sharp = level.sharp_edges[v as usize];
    let (inside, side) = match level.scheme {
        Scheme::CatmullClark => (4, 2),
        Scheme::Loop => (6, 3),
    };
    let wanted = match shape(sharp, level.corner_sharpness(v) > 0.0) {
        Shape::Smooth => return sharp == 0 && !level.on_boundary(v) && level.fan(v).count() == inside,
        Shape::Crease => side,
        Shape::Corner => 1,
    };
    level.fan(v).all(|h| {
        let Some([first, last]) = region_ends(level, h, |g| level.is_sharp(g)) else { return false };
        let faces = std::iter::successors(Some(first), |&g| if g == last { None } else { level.spoke_after(g) });
        faces.count() == wanted
    })
}

/// Whether `v`, where sharpness will run out, lies inside a crease that decays in the same step on both sides.
fn decays_at_once(level: &Level, v: u32) -> bool {
    let sharp = level.fan(v).map(|h| level.sharpness[level.edge[h as usize] as usize]).filter(|&s| s > 0.0);
    let both: Vec<f64> = sharp.collect();
    level.corner_sharpness(v) == 0.0 && !level.on_boundary(v) && both.len() == 2 && both[0] == both[1]
}

/// Which of the `owned` faces have to be refined. `before_weights`: the level is one before the first of weights.
fn in_trouble(level: &Level, owned: &[bool], roles: &[Role], settings: &Settings, before_weights: bool) -> Vec<bool> {
    let mut finite = vec![false; level.vertices()];
    for h in 0..level.half_edges() as u32 {
        let s = level.sharpness[level.edge[h as usize] as usize];
        if s > 0.0 && s.is_finite() {
            finite[level.origin[h as usize] as usize] = true;
            finite[level.target(h) as usize] = true;
        }
    }
    for (finite, &s) in finite.iter_mut().zip(&level.corner) {
        *finite |= s > 0.0 && s.is_finite();
    }
    let mut near = vec![false; level.vertices()];
    let mut wide = vec![false; level.vertices()];
    for (v, here) in vertices_of(level, owned).into_iter().enumerate() {
        if !here {
            continue;
        }
        let role = roles[v];
        let weighs = role.extraordinary && !(settings.rules.variant == Variant::B && role.sharp);
        near[v] = finite[v] || weighs || !regular(level, level.spoke[v]);
        let ring_is_set = weighs && !role.boundary && settings.rules.initial == Initial::Ring;
        let dart = !role.sharp && level.sharp_edges[v] > 0 && !role.boundary;
        wide[v] = role.extraordinary && before_weights
            || finite[v] && (role.extraordinary || !decays_at_once(level, v as u32))
            || settings.rules.variant == Variant::B && dart
            || ring_is_set
                && level.fan(v as u32).any(|h| {
                    level.of_face(level.face_of(h)).any(|g| {
                        let u = level.origin[g as usize] as usize;
                        u != v && (roles[u].sharp || roles[u].boundary)
                    })
                });
    }
    let near = touching(level, &near);
    let wide = around(level, &touching(level, &wide));
    let mut refined: Vec<bool> = (0..level.faces()).map(|f| owned[f] && (near[f] || wide[f])).collect();
    // A patch with finer ones on all sides would have more control points than patches may have.
    loop {
        let surrounded = |f: usize| {
            level.of_face(f).all(|h| {
                let t = level.twin[h as usize];
                t != NONE && refined[level.face_of(t)]
            })
        };
        let more: Vec<usize> = (0..level.faces()).filter(|&f| owned[f] && !refined[f] && surrounded(f)).collect();
        if more.is_empty() {
            return refined;
        }
        for f in more {
            refined[f] = true;
        }
    }
}
