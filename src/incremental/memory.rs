//! How much memory things hold, and how it grows: by a sixteenth, where a vector would double.

use crate::mesh::HalfEdgeMesh;
use crate::patch::PatchTable;
use crate::refine::Refinement;
use crate::scene::Scene;
use crate::subdiv::level::Level;
use std::collections::HashMap;

/// Bytes that a vector holds.
pub(super) fn of<T>(list: &Vec<T>) -> usize {
    size_of::<T>() * list.capacity()
}

/// Makes room for a few entries more, so that what follows does not double the vector.
pub(super) fn make_room<T>(list: &mut Vec<T>, more: usize) {
    if list.len() + more > list.capacity() {
        list.reserve_exact(more + room(list.len()) - list.len());
    }
}

/// Entries that a vector of `length` has room for, itself included.
fn room(length: usize) -> usize {
    length + 64 + length / 16
}

/// An empty vector for `length` entries and a few more.
pub(super) fn with_room<T>(length: usize) -> Vec<T> {
    Vec::with_capacity(room(length))
}

/// A vector with room for a few entries more.
pub(super) fn roomy<T>(entries: impl ExactSizeIterator<Item = T>) -> Vec<T> {
    let mut list = with_room(entries.len());
    list.extend(entries);
    list
}

/// Zeros with room for a few more. From the system they come page by page where something is written.
pub(super) fn zeros(length: usize) -> Vec<u32> {
    let mut list = vec![0; room(length)];
    list.truncate(length);
    list
}

/// Gives back what a vector holds beyond that.
fn fit<T>(list: &mut Vec<T>) {
    list.shrink_to(room(list.len()));
}

/// Gives back what a build has left over. Lists that double, and those that expect more than comes, hold up to twice as
/// much as there is.
pub(super) fn fit_all(refinement: &mut Refinement, table: &mut PatchTable) {
    for level in &mut refinement.levels {
        fit(&mut level.value);
        for list in [&mut level.origin, &mut level.twin, &mut level.tint, &mut level.child] {
            fit(list);
        }
        fit(&mut level.face);
        fit(&mut level.bits);
        [&mut level.inside, &mut level.sharp].into_iter().for_each(fit);
    }
    refinement.fates.iter_mut().for_each(fit);
    fit(&mut table.control);
    fit(&mut table.indices);
    fit(&mut table.faces);
}

/// [`Vec::push`] with room for a few more.
pub(super) fn push<T>(list: &mut Vec<T>, entry: T) {
    make_room(list, 1);
    list.push(entry);
}

/// Makes the list longer, up to `length`, likewise.
pub(super) fn extend_to<T: Clone>(list: &mut Vec<T>, length: usize, entry: T) {
    if length > list.len() {
        make_room(list, length - list.len());
        list.resize(length, entry);
    }
}

/// Bytes that a map holds: its entries and a byte for each.
pub(super) fn of_map<K, V>(map: &HashMap<K, V>) -> usize {
    (size_of::<(K, V)>() + 1) * map.capacity() * 8 / 7
}

pub(super) fn of_scene(scene: &Scene) -> usize {
    of(&scene.mesh.positions)
        + of(&scene.mesh.corners)
        + of(&scene.mesh.face_start)
        + of(&scene.corner_colours)
        + of(&scene.sharp)
        + of(&scene.handles)
        + of(&scene.face_points)
        + of(&scene.geometry)
        + of(&scene.colours)
}

pub(super) fn of_mesh(mesh: &HalfEdgeMesh) -> usize {
    let numbers = [&mesh.origin, &mesh.twin, &mesh.face, &mesh.face_start, &mesh.boundary_before, &mesh.edges_before];
    of(&mesh.positions) + numbers.into_iter().map(of).sum::<usize>()
}

pub(super) fn of_level(level: &Level) -> usize {
    let numbers = [&level.polygon_start, &level.polygon_face, &level.origin, &level.twin, &level.tint, &level.child];
    let flags = [&level.inside, &level.sharp];
    numbers.into_iter().map(of).sum::<usize>()
        + flags.into_iter().map(of).sum::<usize>()
        + of(&level.face)
        + of(&level.value)
        + of(&level.bits)
}

pub(super) fn of_table(table: &PatchTable) -> usize {
    of(&table.control) + of(&table.indices) + of(&table.faces) + of(&table.ranges)
}
