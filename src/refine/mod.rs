//! Feature-adaptive, hierarchical refinement (ZHHK22 4): which faces live at which level, and their meshes.
//!
//! [`refine`] plans the affected faces on names alone ([`forest`]), then builds the levels from M^0 down, each
//! holding only the children of affected faces and one ring around them, applies the level's edits, and says of
//! every face whether it is refined, drawn or padding. What comes out is plain arrays; [`crate::patch`] turns
//! them into patches.

pub mod edits;
pub mod forest;
pub mod isolation;
pub mod meetings;
pub mod region;

use crate::mesh::HalfEdgeMesh;
use crate::scene::{CornerRule, Scene};
use crate::subdiv::edit::{self, LocalMove};
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::subdiv::level::{vertex_bits, Level, CUT};
use crate::subdiv::{catmull_clark, ternary};
use crate::threads;
use edits::{EditError, Edits};
use forest::{Forest, Node};
use thiserror::Error;

/// Which faces are refined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rules {
    /// The authors' tool to the letter: no grading, whole 3-rings, cascade also around colour corners.
    Authors,
    /// Graded 2:1, colour edits only in the sectors they can change, cascade around extraordinary vertices, one
    /// level more where sharp edges meet.
    #[default]
    Gradtess,
}

/// Adaptive, or every face to one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Only affected faces are refined (`isolate` 0: as the paper).
    Adaptive {
        /// How many levels more the irregular faces around extraordinary vertices and meeting sharp edges are refined,
        /// counted from the level at which they would be drawn; [`Rules::Gradtess`] only. Where five and more edges meet, as
        /// many as make the error so many times less ([`isolation`]).
        isolate: u32,
    },
    /// Uniform subdivision to a level: the paper's rival, and the way to whole meshes.
    Global(u32),
}

/// What to refine and how.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Rule set.
    pub rules: Rules,
    /// Adaptive or global.
    pub mode: Mode,
}

impl Default for Options {
    fn default() -> Self {
        Options { rules: Rules::default(), mode: Mode::Adaptive { isolate: 0 } }
    }
}

/// Why refinement could not be done.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum RefineError {
    /// An edit does not fit the mesh.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A global level beyond what numbers hold.
    #[error("level {level} is too deep; the deepest is {}", edits::MAX_LEVEL)]
    TooDeep {
        /// Level that was asked for.
        level: u32,
    },
    /// More faces than memory is meant for.
    #[error("level {level} has {faces} faces; at most {limit} can be refined, choose a lower level")]
    TooLarge {
        /// Level that was asked for.
        level: u32,
        /// Faces it has.
        faces: u64,
        /// The limit.
        limit: u64,
    },
}

/// Most faces one level may have; a face takes about 300 bytes while it is refined.
pub const MAX_FACES: u64 = 1 << 24;

/// What becomes of a face, as bits.
pub mod fate {
    /// Refined: its children stand in the next level.
    pub const AFFECTED: u8 = 1;
    /// Drawn at this level.
    pub const DRAWN: u8 = 2;
    /// A corner is extraordinary or its colours follow no bicubic: a Gregory patch.
    pub const IRREGULAR: u8 = 4;
    /// Bit 4 + i: the neighbour across the face's edge i is refined.
    pub const TRANSITION: u32 = 4;
}

/// Levels of a refined scene.
#[derive(Debug)]
pub struct Refinement {
    /// M^0 and the refined parts of M^1, M^2, ...
    pub levels: Vec<Level>,
    /// [`fate`] bits of every face of every level.
    pub fates: Vec<Vec<u8>>,
    /// Corner rule the scene asked for.
    pub corners: CornerRule,
    /// Rule set used.
    pub rules: Rules,
    /// Deepest edit level of the scene.
    pub edit_level: u32,
}

impl Refinement {
    /// Number of a face of a level by its name, `None` where it is not there. Time linear in the level.
    pub fn find(&self, level: u32, name: u64) -> Option<u32> {
        if level == 0 {
            return u32::try_from(name).ok().filter(|&f| (f as usize) < self.levels[0].faces());
        }
        let mut h = (name >> (2 * (level - 1))) as u32;
        for l in 0..level {
            let child = *self.levels.get(l as usize)?.child.get(h as usize)?;
            if child >= CUT {
                return None;
            }
            if l + 1 == level {
                return Some(child);
            }
            h = 4 * child + (name >> (2 * (level - 2 - l)) & 3) as u32;
        }
        None
    }
}

/// Refines `scene`, whose mesh is `mesh`. Time and memory linear in the faces made, which are at most a constant
/// times the faces drawn.
///
/// # Errors
/// An edit that does not fit the mesh, or a global level that is too large.
pub fn refine(scene: &Scene, mesh: &HalfEdgeMesh, options: Options) -> Result<Refinement, RefineError> {
    by(scene, mesh, options, true)
}

/// As [`refine`] by [`Rules::Authors`], but without the cascade around extraordinary vertices: what ZHHK22 Fig. 8 has on
/// its left, for comparison only.
///
/// # Errors
/// As [`refine`].
pub fn refine_uncascaded(scene: &Scene, mesh: &HalfEdgeMesh) -> Result<Refinement, RefineError> {
    by(scene, mesh, Options { rules: Rules::Authors, ..Options::default() }, false)
}

fn by(scene: &Scene, mesh: &HalfEdgeMesh, options: Options, cascading: bool) -> Result<Refinement, RefineError> {
    // Faces of M^0, and what an edit makes of them.
    let faces = 2 * mesh.half_edges() as usize + EDIT_FACES * (scene.geometry.len() + scene.colours.len());
    threads::crew(faces, || by_levels(scene, mesh, options, cascading))
}

/// About as many faces does an edit refine.
pub(crate) const EDIT_FACES: usize = 16;

fn by_levels(scene: &Scene, mesh: &HalfEdgeMesh, options: Options, cascading: bool) -> Result<Refinement, RefineError> {
    let map = IndexMap::new(mesh);
    let edits = edits::resolve(scene, &map)?;
    let edit_level = edits.deepest();
    if let Mode::Global(level) = options.mode {
        if level > edits::MAX_LEVEL {
            return Err(RefineError::TooDeep { level });
        }
        let faces = map.faces(level);
        if faces > MAX_FACES {
            return Err(RefineError::TooLarge { level, faces, limit: MAX_FACES });
        }
    }
    let plan = match options.mode {
        Mode::Adaptive { isolate } => {
            Some(forest::plan(&map, &edits, &scene.sharp, options.rules, scene.corners, isolate))
        }
        Mode::Global(_) => None,
    };

    let mut level = ternary::ternary(mesh, scene.corners, &scene.handles, &scene.face_points);
    let mut cursors = Cursors::new(&edits);
    let mut nodes = Vec::new();
    let mut levels = Vec::new();
    let mut fates = Vec::new();
    loop {
        cursors.apply(&mut level);
        if level.level == 0 {
            for &h in &scene.sharp {
                edit::tag_sharp(&mut level, h);
            }
        }
        let around_polygons = around_polygons(&level);
        let mut affected = match (&plan, options.mode) {
            (_, Mode::Global(to)) => vec![level.level < to; level.faces()],
            (Some(forest), _) => wanted(&level, forest, &nodes),
            (None, Mode::Adaptive { .. }) => unreachable!("adaptive refinement has a plan"),
        };
        if cascading && options.rules == Rules::Authors && plan.is_some() {
            cascade(&level, &mut affected, &around_polygons, scene.corners, options.rules);
        }
        fates.push(decide(&level, &affected, &around_polygons, scene.corners, options.rules));
        if !affected.iter().any(|&a| a) {
            levels.push(level);
            break;
        }
        let next = catmull_clark::refine(&mut level, &affected, scene.corners);
        if let Some(forest) = &plan {
            nodes = descend(&level, forest, &nodes, next.faces());
        }
        cursors.descend(&level);
        levels.push(level);
        level = next;
    }
    Ok(Refinement { levels, fates, corners: scene.corners, rules: options.rules, edit_level })
}

/// Where each edit not yet applied stands in the level at hand.
struct Cursors {
    moves: Vec<(u32, Slot, LocalMove)>,
    paints: Vec<(u32, Slot, u32, glam::DVec4)>,
}

impl Cursors {
    fn new(edits: &Edits) -> Self {
        // Slots and local half-edges are the same numbers at level 0.
        Cursors {
            moves: edits
                .moves
                .iter()
                .map(|m| {
                    let half_edge = (m.slot >> (2 * m.level)) as u32;
                    (m.level, m.slot, LocalMove { half_edge, anchor: m.anchor, a: m.a, b: m.b })
                })
                .collect(),
            paints: edits
                .paints
                .iter()
                .map(|p| (p.level, p.slot, (p.slot >> (2 * p.level)) as u32, p.colour))
                .collect(),
        }
    }

    fn apply(&mut self, level: &mut Level) {
        let now = level.level;
        let moves: Vec<LocalMove> = self.moves.iter().filter(|m| m.0 == now).map(|m| m.2).collect();
        edit::move_vertices(level, &moves);
        let paints: Vec<(u32, glam::DVec4)> = self.paints.iter().filter(|p| p.0 == now).map(|p| (p.2, p.3)).collect();
        edit::paint(level, &paints);
        self.moves.retain(|m| m.0 > now);
        self.paints.retain(|p| p.0 > now);
    }

    /// One level down; the region of an edit is always refined, so its half-edge is there (ZHHK22 App. A).
    fn descend(&mut self, level: &Level) {
        let child = |h: u32, edit_level: u32, slot: Slot| {
            let digit = (slot >> (2 * (edit_level - level.level - 1))) & 3;
            4 * level.child[h as usize] + digit as u32
        };
        let refined = |h: u32| level.child[h as usize] < CUT;
        self.moves.retain(|m| refined(m.2.half_edge));
        self.paints.retain(|p| refined(p.2));
        for (l, slot, m) in &mut self.moves {
            m.half_edge = child(m.half_edge, *l, *slot);
        }
        for (l, slot, h, _) in &mut self.paints {
            *h = child(*h, *l, *slot);
        }
    }
}

fn wanted(level: &Level, forest: &Forest, nodes: &[Node]) -> Vec<bool> {
    if level.level == 0 {
        return threads::collect(level.faces(), |f| forest.wants0(level.face[f]));
    }
    threads::collect(nodes.len(), |f| nodes[f] != Node::NONE)
}

fn descend(level: &Level, forest: &Forest, nodes: &[Node], children: usize) -> Vec<Node> {
    // Children follow each other like the half-edges that they grow from.
    let of = |half_edges: std::ops::Range<usize>| {
        let grown = half_edges.filter(|&h| level.child[h] < CUT);
        let node = |h: usize| match level.level {
            0 => forest.root(h as u64),
            _ => forest.child(nodes[h >> 2], h as u32 & 3),
        };
        let mut below = Vec::with_capacity(children);
        below.extend(grown.map(node));
        below
    };
    let mut parts = threads::each(threads::pieces(level.half_edges()), of).into_iter();
    let mut below = parts.next().unwrap_or_default();
    parts.for_each(|part| below.extend_from_slice(&part));
    below
}

/// Level 0: vertices of faces that are no quads. Empty where there are none.
pub(crate) fn around_polygons(level: &Level) -> Vec<bool> {
    let mut around = Vec::new();
    for f in level.quads..level.faces() as u32 {
        if level.valence(f) != 4 {
            around.resize(level.vertices(), false);
            for h in level.of_face(f) {
                around[level.origin[h as usize] as usize] = true;
            }
        }
    }
    around
}

/// Whether the surface at the corner of `h` in its face follows no bicubic.
fn irregular_corner(level: &Level, h: u32, around_polygons: &[bool], corners: CornerRule, rules: Rules) -> bool {
    use vertex_bits::{DART, EXTRAORDINARY, SECTORS};
    let v = level.origin[h as usize] as usize;
    let bits = level.bits[v];
    if bits & EXTRAORDINARY != 0 || (!around_polygons.is_empty() && around_polygons[v]) {
        return true;
    }
    // The authors' tool takes darts for regular; no bicubic runs into one.
    if bits & DART != 0 && rules == Rules::Gradtess {
        return true;
    }
    if bits & SECTORS == 0 {
        return false;
    }
    match sector_faces(level, h) {
        1 => corners == CornerRule::Smooth,
        n => n > 2,
    }
}

/// Whether the surface over a quad of level >= 1 follows no bicubic, in positions or colours.
pub(crate) fn irregular_face(level: &Level, f: u32, corners: CornerRule, rules: Rules) -> bool {
    let around = around_polygons(level);
    level.of_face(f).any(|h| irregular_corner(level, h, &around, corners, rules))
}

/// The [`fate`] of one face of a level that is edited in place, as [`refine`] has it; `around_polygons` are the vertices of
/// M^0 around faces that are no quads, and empty above.
pub(crate) fn fate_of(
    level: &Level,
    f: u32,
    affected: impl Fn(u32) -> bool,
    around_polygons: &[bool],
    corners: CornerRule,
    rules: Rules,
) -> u8 {
    if affected(f) {
        return fate::AFFECTED;
    }
    if !level.inside[f as usize] {
        return 0;
    }
    let mut bits = fate::DRAWN;
    let irregular = |h: u32| irregular_corner(level, h, around_polygons, corners, rules);
    if level.valence(f) != 4 || level.of_face(f).any(irregular) {
        bits |= fate::IRREGULAR;
    }
    for (i, h) in level.of_face(f).enumerate().take(4) {
        if level.across(h).is_some_and(|t| affected(level.face_of(t))) {
            bits |= 1 << (fate::TRANSITION + i as u32);
        }
    }
    bits
}

/// Faces of the colour sector that the corner of `h` lies in.
fn sector_faces(level: &Level, h: u32) -> u32 {
    let mut n = 1;
    let mut spoke = level.fan_start(h, |s| level.colour_border(s));
    while let Some(s) = level.spoke_after(spoke) {
        if level.colour_border(s) {
            break;
        }
        n += 1;
        spoke = s;
    }
    n
}

/// While an affected face has an irregular corner, all faces around it become affected (ZHHK22 4.2).
fn cascade(level: &Level, affected: &mut [bool], around_polygons: &[bool], corners: CornerRule, rules: Rules) {
    let mut queue: Vec<u32> = (0..level.faces() as u32).filter(|&f| affected[f as usize]).collect();
    while let Some(f) = queue.pop() {
        for h in level.of_face(f) {
            if irregular_corner(level, h, around_polygons, corners, rules) {
                level.around(h, |s| {
                    let g = level.face_of(s);
                    if !affected[g as usize] && level.inside[g as usize] {
                        affected[g as usize] = true;
                        queue.push(g);
                    }
                });
            }
        }
    }
}

fn decide(level: &Level, affected: &[bool], around_polygons: &[bool], corners: CornerRule, rules: Rules) -> Vec<u8> {
    let any = affected.iter().any(|&a| a);
    let fate_of = |f: usize| {
        let f = f as u32;
        if affected[f as usize] {
            return fate::AFFECTED;
        }
        if !level.inside[f as usize] {
            return 0;
        }
        let mut bits = fate::DRAWN;
        let special = |h: u32| level.bits[level.origin[h as usize] as usize] & !vertex_bits::BOUNDARY != 0;
        let irregular = |h: u32| {
            (special(h) || !around_polygons.is_empty()) && irregular_corner(level, h, around_polygons, corners, rules)
        };
        if level.valence(f) != 4 || level.of_face(f).any(irregular) {
            bits |= fate::IRREGULAR;
        }
        if any {
            for (i, h) in level.of_face(f).enumerate().take(4) {
                if level.across(h).is_some_and(|t| affected[level.face_of(t) as usize]) {
                    bits |= 1 << (fate::TRANSITION + i as u32);
                }
            }
        }
        bits
    };
    threads::collect(level.faces(), fate_of)
}
