//! The scene's edits, resolved once: from numbers in a file to slots and anchors.

use super::EDIT_FACES;
use crate::scene::{ColourEdit, Frame, GeometryEdit, Scene};
use crate::subdiv::edit::Anchor;
use crate::subdiv::index_map::{IndexMap, Slot};
use crate::threads;
use glam::DVec4;
use std::ops::Range;
use thiserror::Error;

/// Deepest edit level: 4^12 times the half-edges of M^0 still fit in 64 bits with room to spare.
pub const MAX_LEVEL: u32 = 12;

/// An edit that names something M^level does not have. `index` counts from 0 in the scene's list.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum EditError {
    /// Half-edge number too great.
    #[error("{what} edit {}: level {level} has no half-edge {half_edge} (it has {count} interior and {boundary} boundary ones); correct the number", index + 1)]
    NoSuchHalfEdge {
        /// "geometry" or "colour".
        what: &'static str,
        /// Position in the scene's list.
        index: usize,
        /// Level of the edit.
        level: u32,
        /// What it asked for.
        half_edge: u64,
        /// Interior half-edges there are.
        count: u64,
        /// Boundary half-edges there are.
        boundary: u64,
    },
    /// Boundary form on an edge that is not on the boundary.
    #[error("geometry edit {}: half-edge {half_edge} of level {level} is not on the boundary; use the sector form", index + 1)]
    NotOnBoundary {
        /// Position in the scene's list.
        index: usize,
        /// Level of the edit.
        level: u32,
        /// Half-edge it named.
        half_edge: u64,
    },
    /// A colour edit of a vertex whose colour is not editable.
    #[error("colour edit {}: half-edge {half_edge} of level {level} does not leave a colour vertex (those lie three edges apart); use one that does", index + 1)]
    NotAColourVertex {
        /// Position in the scene's list.
        index: usize,
        /// Level of the edit.
        level: u32,
        /// Half-edge it named.
        half_edge: u64,
    },
    /// Level beyond what numbers hold.
    #[error("{what} edit {}: level {level} is too deep; the deepest is {MAX_LEVEL}", index + 1)]
    TooDeep {
        /// "geometry" or "colour".
        what: &'static str,
        /// Position in the scene's list.
        index: usize,
        /// Level of the edit.
        level: u32,
    },
}

/// A geometry edit, resolved.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// Level of the edit.
    pub level: u32,
    /// Slot that `anchor` refers to.
    pub slot: Slot,
    /// Slot that leaves the moved vertex.
    pub vertex: Slot,
    /// What the slot stands for.
    pub anchor: Anchor,
    /// First coordinate.
    pub a: f64,
    /// Second coordinate.
    pub b: f64,
}

/// A colour edit, resolved.
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    /// Level of the edit.
    pub level: u32,
    /// Slot that leaves the vertex within the sector.
    pub slot: Slot,
    /// First level of the vertex and its least slot there: the same for all edits of one vertex.
    pub vertex: (u32, Slot),
    /// New colour.
    pub colour: DVec4,
}

/// All edits of a scene.
#[derive(Clone, Debug, Default)]
pub struct Edits {
    /// Geometry edits by level.
    pub moves: Vec<Move>,
    /// Colour edits by vertex, then level.
    pub paints: Vec<Paint>,
}

impl Edits {
    /// Deepest level that has an edit, 0 without any.
    pub fn deepest(&self) -> u32 {
        let moves = self.moves.iter().map(|m| m.level);
        moves.chain(self.paints.iter().map(|p| p.level)).max().unwrap_or(0)
    }
}

/// Resolves all edits of `scene`; constant time an edit and level.
///
/// The scene's initial colours become level-0 paints of the sectors that have no edit there.
///
/// # Errors
/// The first edit that names something its level does not have.
pub fn resolve(scene: &Scene, map: &IndexMap) -> Result<Edits, EditError> {
    let mut edits = Edits::default();
    let of_run =
        |run: Range<usize>| run.map(|i| resolve_move(i, &scene.geometry[i], map)).collect::<Result<Vec<_>, _>>();
    for moves in threads::each(threads::pieces_worth(scene.geometry.len(), EDIT_FACES), of_run) {
        edits.moves.extend_from_slice(&moves?);
    }
    let of_run =
        |run: Range<usize>| run.map(|i| resolve_paint(i, &scene.colours[i], map)).collect::<Result<Vec<_>, _>>();
    for paints in threads::each(threads::pieces_worth(scene.colours.len(), EDIT_FACES), of_run) {
        edits.paints.extend_from_slice(&paints?);
    }
    if !scene.corner_colours.is_empty() {
        let mut painted = vec![false; scene.corner_colours.len()];
        for p in edits.paints.iter().filter(|p| p.level == 0) {
            painted[(p.slot >> 3) as usize] = true;
        }
        for (h, &colour) in scene.corner_colours.iter().enumerate() {
            if !painted[h] {
                let slot = 8 * h as u64;
                edits.paints.push(Paint { level: 0, slot, vertex: map.birth(0, slot), colour });
            }
        }
    }
    edits.moves.sort_by_key(|m| m.level);
    // One number to compare: slots of level 12 take 58 bits, levels four.
    edits.paints.sort_by_key(|p| u128::from(p.vertex.0) << 96 | u128::from(p.vertex.1) << 8 | u128::from(p.level));
    Ok(edits)
}

/// Resolves one geometry edit.
pub(crate) fn resolve_move(index: usize, e: &GeometryEdit, map: &IndexMap) -> Result<Move, EditError> {
    let missing = || no_such("geometry", index, e.level, e.half_edge, map);
    if e.level > MAX_LEVEL {
        return Err(EditError::TooDeep { what: "geometry", index, level: e.level });
    }
    let (slot, anchor) = match (map.from_app_a(e.level, e.half_edge), e.frame) {
        (Some(d), Frame::Sector) => (d, Anchor::Sector),
        (Some(d), Frame::Boundary) if map.twin(e.level, d).is_none() => (d, Anchor::Boundary),
        (Some(_), Frame::Boundary) => {
            return Err(EditError::NotOnBoundary { index, level: e.level, half_edge: e.half_edge })
        }
        (None, Frame::Sector) => {
            let twin = map.boundary_twin_app_a(e.level, e.half_edge).ok_or_else(missing)?;
            (map.from_app_a(e.level, twin).ok_or_else(missing)?, Anchor::SectorBeyond)
        }
        (None, Frame::Boundary) => return Err(missing()),
    };
    let vertex = if anchor == Anchor::Sector { slot } else { map.next(e.level, slot) };
    Ok(Move { level: e.level, slot, vertex, anchor, a: e.a, b: e.b })
}

/// Resolves one colour edit.
pub(crate) fn resolve_paint(index: usize, e: &ColourEdit, map: &IndexMap) -> Result<Paint, EditError> {
    if e.level > MAX_LEVEL {
        return Err(EditError::TooDeep { what: "colour", index, level: e.level });
    }
    let slot =
        map.from_app_a(e.level, e.half_edge).ok_or_else(|| no_such("colour", index, e.level, e.half_edge, map))?;
    if !map.is_colour_vertex(e.level, slot) {
        return Err(EditError::NotAColourVertex { index, level: e.level, half_edge: e.half_edge });
    }
    Ok(Paint { level: e.level, slot, vertex: map.birth(e.level, slot), colour: e.colour })
}

fn no_such(what: &'static str, index: usize, level: u32, half_edge: u64, map: &IndexMap) -> EditError {
    EditError::NoSuchHalfEdge {
        what,
        index,
        level,
        half_edge,
        count: map.half_edges(level),
        boundary: map.boundary_half_edges(level),
    }
}
