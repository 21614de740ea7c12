//! Value edits, followed through the levels: only what depends on a changed vertex is computed again, and what comes out
//! the same is followed no further.

use super::colour::{Above, Todo};
use super::index::Index;
use super::ValueEdit;
use crate::mesh::HalfEdgeMesh;
use crate::refine::Refinement;
use crate::scene::Scene;
use crate::subdiv::edit::{step, LocalMove};
use crate::subdiv::gather::{self, Around};
use crate::subdiv::level::{Level, CUT};
use glam::DVec2;

/// What changed beside values.
#[derive(Default)]
pub struct News {
    /// Vertices that are new, of each level.
    pub vertices: Vec<Vec<u32>>,
    /// Level and vertex of geometry edits that came or went.
    pub moves: Vec<(u32, u32)>,
    /// Level and group of colour edits that came.
    pub groups: Vec<(u32, u32)>,
    /// Vertices of each level whose sectors may be others: where colour edits or tags went or came, and faces.
    pub sectors: Vec<Vec<u32>>,
    /// Points of M^0 of handles that came or went.
    pub points: Vec<u32>,
}

/// What of a level is not what it was.
#[derive(Default)]
pub struct Spread {
    /// Vertices with other values, ascending.
    pub changed: Vec<u32>,
    /// Vertices with other sharp edges or colour sectors.
    pub parted: Vec<u32>,
}

/// Writes what follows from `edits` and `news`, which `scene` and `mesh` have already, into the levels, and returns what
/// changed in each.
///
/// # Panics
/// If an edit's index is out of range, or the index belongs to another refinement.
pub fn spread(
    index: &mut Index,
    scene: &Scene,
    mesh: &HalfEdgeMesh,
    refinement: &mut Refinement,
    edits: &[ValueEdit],
    news: &News,
) -> Vec<Spread> {
    let mut seeds = Seeds::of(index, mesh, edits);
    seeds.points.extend_from_slice(&news.points);
    seeds.groups.extend_from_slice(&news.groups);
    let mut all: Vec<Spread> = Vec::with_capacity(refinement.levels.len());
    let (mut moved, mut painted) = (Vec::new(), Vec::new());
    for l in 0..refinement.levels.len() {
        let (coarser, rest) = refinement.levels.split_at_mut(l);
        let level = &mut rest[0];
        let below = |coarse: &[u32], level: &Level| match coarser.last() {
            Some(above) => dependents(above, &index.levels[l - 1].around, coarse, level),
            None => Vec::new(),
        };
        let mut to_move = if l == 0 { seeds.points.clone() } else { below(&moved, level) };
        let mut todo = Todo { colours: below(&painted, level), ..Todo::default() };
        todo.sectors = all.last().map_or(Vec::new(), |above| below(&above.parted, level));
        to_move.extend(news.moves.iter().filter(|m| m.0 == l as u32).map(|m| m.1));
        if let Some(new) = news.vertices.get(l) {
            to_move.extend_from_slice(new);
            todo.sectors.extend_from_slice(new);
        }
        todo.sectors.extend(news.sectors.get(l).into_iter().flatten());
        todo.groups = seeds.groups.iter().filter(|g| g.0 == l as u32).map(|g| g.1).collect();
        let epoch = index.next_epoch();

        let own = &mut index.levels[l];
        if !own.moves.is_empty() {
            // A frame's ends carry the vertex along.
            let frames = to_move.iter().filter_map(|v| own.read.get(v)).flatten().copied();
            let edited = seeds.moves.iter().filter(|m| m.0 == l as u32).map(|m| m.1);
            let vertices = frames.chain(edited).map(|m| own.moves[m as usize].vertices[0]);
            to_move.extend(vertices.collect::<Vec<_>>());
        }
        to_move.retain(|&v| std::mem::replace(&mut own.vertex_mark[v as usize], epoch) != epoch);

        {
            let index = &*index;
            let own = &index.levels[l];
            let above =
                coarser.last().map(|level| Above { level, around: &index.levels[l - 1].around, parent: &own.parent });
            let plain = |v: u32| match &above {
                Some(above) => above.position(own.around.of(v)[0], refinement.corners),
                None => match index.placed.get(&v) {
                    Some(&(false, i)) => scene.handles[i as usize].at,
                    Some(&(true, i)) => scene.face_points[i as usize].at,
                    None => gather::ternary_point(mesh, v),
                },
            };
            moved.clear();
            for v in to_move {
                let mut p = plain(v);
                for &m in own.moved.get(&v).map_or(&[][..], |m| m) {
                    let m = &own.moves[m as usize];
                    let e = &scene.geometry[m.entry as usize];
                    let [v, end1, end2] = m.vertices.map(plain);
                    p += step(&LocalMove { a: e.a, b: e.b, ..m.local }, end1 - v, end2 - v);
                }
                if set_position(level, &own.around, v, p) {
                    moved.push(v);
                }
            }
        }
        let done = index.recolour(scene, mesh, coarser, level, todo);
        painted = done.changed;
        let mut changed = moved.clone();
        changed.extend_from_slice(&painted);
        changed.sort_unstable();
        changed.dedup();
        all.push(Spread { changed, parted: done.parted });
    }
    all
}

/// Where edits enter the levels.
#[derive(Default)]
struct Seeds {
    /// Vertices of M^0 that are placed anew.
    points: Vec<u32>,
    /// Level and number of geometry edits.
    moves: Vec<(u32, u32)>,
    /// Level and number of groups of colour edits.
    groups: Vec<(u32, u32)>,
}

impl Seeds {
    fn of(index: &Index, mesh: &HalfEdgeMesh, edits: &[ValueEdit]) -> Seeds {
        let mut seeds = Seeds::default();
        for e in edits {
            match *e {
                ValueEdit::Position(v, _) => {
                    gather::ternary_dependents(mesh, v, index.input.of(v), |p| seeds.points.push(p));
                }
                ValueEdit::Handle(i, _) => seeds.points.extend(index.point_of.get(&(false, i))),
                ValueEdit::FacePoint(i, _) => seeds.points.extend(index.point_of.get(&(true, i))),
                ValueEdit::Geometry(i, _) => seeds.moves.extend(index.move_of.get(&i)),
                ValueEdit::CornerColour(h, _) => {
                    // Input vertices have the same numbers in M^0.
                    let painted = index.levels[0].painted[mesh.origin[h as usize] as usize];
                    seeds.groups.push((0, painted));
                }
                ValueEdit::Colour(i, _) => seeds.groups.extend(index.group_of.get(&i)),
            }
        }
        seeds
    }
}

/// Vertices of `next` that depend on the vertices `changed` of the level above it, with repetitions.
fn dependents(level: &Level, around: &Around, changed: &[u32], next: &Level) -> Vec<u32> {
    let mut faces: Vec<u32> = changed.iter().flat_map(|&v| around.of(v)).map(|&h| level.face_of(h)).collect();
    faces.sort_unstable();
    faces.dedup();
    let mut found = Vec::with_capacity(16 * faces.len());
    // A face's vertex reaches its face point, the points of its edges and all of its corners: the corners of its children.
    for h in faces.into_iter().flat_map(|f| level.of_face(f)) {
        let child = level.child[h as usize];
        if child < CUT {
            found.extend(Level::quad(&next.origin, child));
        }
    }
    found
}

/// Whether that is another position.
fn set_position(level: &mut Level, around: &Around, v: u32, p: DVec2) -> bool {
    let old = level.value[v as usize].p;
    if old.to_array().map(f64::to_bits) == p.to_array().map(f64::to_bits) {
        return false;
    }
    level.value[v as usize].p = p;
    for &h in around.of(v) {
        level.value[level.tint[h as usize] as usize].p = p;
    }
    true
}
