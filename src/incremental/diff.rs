//! From two scenes to what differs between them.

use super::ValueEdit;
use crate::scene::{ColourEdit, GeometryEdit, Handle, Scene};

/// A stretch of a list that is replaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Splice<T> {
    /// First entry that goes.
    pub at: usize,
    /// How many go.
    pub removed: usize,
    /// What comes in their place.
    pub added: Vec<T>,
}

impl<T> Splice<T> {
    /// Whether nothing goes and nothing comes.
    pub fn is_empty(&self) -> bool {
        self.removed == 0 && self.added.is_empty()
    }
}

impl<T: Clone> Splice<T> {
    /// Makes the change.
    ///
    /// # Panics
    /// If the list is shorter.
    pub fn write(&self, list: &mut Vec<T>) {
        list.splice(self.at..self.at + self.removed, self.added.iter().cloned());
    }

    /// From one list to another, by what entries are `alike`, whatever their values.
    fn between(old: &[T], new: &[T], alike: impl Fn(&T, &T) -> bool) -> Splice<T> {
        let same = old.iter().zip(new).take_while(|(a, b)| alike(a, b)).count();
        let rest = |list: &[T]| list.len() - same;
        let back = old[same..].iter().rev().zip(new[same..].iter().rev()).take_while(|(a, b)| alike(a, b)).count();
        Splice { at: same, removed: rest(old) - back, added: new[same..new.len() - back].to_vec() }
    }

    /// Entries of both lists, before and after, that stay.
    fn staying<'a>(&self, old: &'a [T], new: &'a [T]) -> impl Iterator<Item = (usize, &'a T, &'a T)> {
        let (old_end, new_end) = (self.at + self.removed, self.at + self.added.len());
        let front = old[..self.at].iter().zip(&new[..self.at]).enumerate();
        let back = old[old_end..].iter().zip(&new[new_end..]).enumerate().map(move |(i, pair)| (new_end + i, pair));
        front.chain(back).map(|(i, (a, b))| (i, a, b))
    }
}

/// Edits that come and go, and values that change.
#[derive(Clone, Debug, PartialEq)]
pub struct Delta {
    /// Entries of [`Scene::geometry`] that go and come.
    pub geometry: Splice<GeometryEdit>,
    /// The same of [`Scene::colours`].
    pub colours: Splice<ColourEdit>,
    /// The same of [`Scene::sharp`].
    pub sharp: Splice<u32>,
    /// The same of [`Scene::handles`].
    pub handles: Splice<Handle>,
    /// The same of [`Scene::face_points`].
    pub face_points: Splice<Handle>,
    /// Values that change after that.
    pub values: Vec<ValueEdit>,
}

impl Delta {
    /// Changes of values only.
    pub fn of(values: Vec<ValueEdit>) -> Delta {
        fn none<T>() -> Splice<T> {
            Splice { at: 0, removed: 0, added: Vec::new() }
        }
        Delta { geometry: none(), colours: none(), sharp: none(), handles: none(), face_points: none(), values }
    }

    /// Whether only values change.
    pub fn is_values(&self) -> bool {
        self.geometry.is_empty()
            && self.colours.is_empty()
            && self.sharp.is_empty()
            && self.handles.is_empty()
            && self.face_points.is_empty()
    }

    /// Makes all changes in the scene, and nothing that follows from them.
    ///
    /// # Panics
    /// If a place is out of range.
    pub fn write(&self, scene: &mut Scene) {
        self.geometry.write(&mut scene.geometry);
        self.colours.write(&mut scene.colours);
        self.sharp.write(&mut scene.sharp);
        self.handles.write(&mut scene.handles);
        self.face_points.write(&mut scene.face_points);
        self.values.iter().for_each(|e| e.write(scene));
    }
}

/// The value edits that turn `old` into `new`, or `None` where more than values differs: polygons, rules, or which edges
/// and places are edited. Names and reference pictures are not looked at. Time linear in the scenes.
pub fn between(old: &Scene, new: &Scene) -> Option<Vec<ValueEdit>> {
    delta(old, new).filter(Delta::is_values).map(|d| d.values)
}

/// What turns `old` into `new`, or `None` where polygons or rules differ. Names and reference pictures are not looked at. Time linear in the scenes.
pub fn delta(old: &Scene, new: &Scene) -> Option<Delta> {
    let same = old.mesh.corners == new.mesh.corners
        && old.mesh.face_start == new.mesh.face_start
        && old.mesh.positions.len() == new.mesh.positions.len()
        && old.corners == new.corners
        && old.corner_colours.len() == new.corner_colours.len();
    if !same {
        return None;
    }
    let mut values = Vec::new();
    for (i, (a, b)) in old.mesh.positions.iter().zip(&new.mesh.positions).enumerate() {
        if a != b {
            values.push(ValueEdit::Position(i as u32, *b));
        }
    }
    for (i, (a, b)) in old.corner_colours.iter().zip(&new.corner_colours).enumerate() {
        if a != b {
            values.push(ValueEdit::CornerColour(i as u32, *b));
        }
    }
    let alike = |a: &Handle, b: &Handle| a.half_edge == b.half_edge;
    let handles = Splice::between(&old.handles, &new.handles, alike);
    let face_points = Splice::between(&old.face_points, &new.face_points, alike);
    for (splice, lists, make) in [
        (&handles, [&old.handles, &new.handles], ValueEdit::Handle as fn(u32, glam::DVec2) -> ValueEdit),
        (&face_points, [&old.face_points, &new.face_points], ValueEdit::FacePoint),
    ] {
        let staying = splice.staying(lists[0], lists[1]);
        values.extend(staying.filter(|(_, a, b)| a.at != b.at).map(|(i, _, b)| make(i as u32, b.at)));
    }
    let geometry = Splice::between(&old.geometry, &new.geometry, |a, b| {
        (a.level, a.half_edge, a.frame) == (b.level, b.half_edge, b.frame)
    });
    let moved = geometry.staying(&old.geometry, &new.geometry).filter(|(_, a, b)| (a.a, a.b) != (b.a, b.b));
    values.extend(moved.map(|(i, _, b)| ValueEdit::Geometry(i as u32, [b.a, b.b])));
    let colours = Splice::between(&old.colours, &new.colours, |a, b| (a.level, a.half_edge) == (b.level, b.half_edge));
    let painted = colours.staying(&old.colours, &new.colours).filter(|(_, a, b)| a.colour != b.colour);
    values.extend(painted.map(|(i, _, b)| ValueEdit::Colour(i as u32, b.colour)));
    let sharp = Splice::between(&old.sharp, &new.sharp, |a, b| a == b);
    Some(Delta { geometry, colours, sharp, handles, face_points, values })
}
