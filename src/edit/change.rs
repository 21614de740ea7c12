//! Differences between two scenes, small enough to keep hundreds of them and to write one to a file within a moment.

use crate::scene::{ColourEdit, CornerRule, GeometryEdit, Handle, InputMesh, Reference, Scene};
use glam::DVec4;
use serde::{Deserialize, Serialize};

/// A run of a list that was replaced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Splice<T> {
    /// First entry replaced.
    at: usize,
    /// Entries before.
    old: Vec<T>,
    /// Entries after.
    new: Vec<T>,
}

impl<T: Clone + PartialEq> Splice<T> {
    /// What turns `old` into `new`; `None` when they are equal. Linear in the lists, stores what differs.
    fn between(old: &[T], new: &[T]) -> Option<Splice<T>> {
        let shorter = old.len().min(new.len());
        let front = old.iter().zip(new).take_while(|(a, b)| a == b).count();
        if front == old.len() && front == new.len() {
            return None;
        }
        let room = shorter - front;
        let back = old.iter().rev().zip(new.iter().rev()).take(room).take_while(|(a, b)| a == b).count();
        Some(Splice {
            at: front,
            old: old[front..old.len() - back].to_vec(),
            new: new[front..new.len() - back].to_vec(),
        })
    }

    fn apply(&self, list: &mut Vec<T>, forward: bool) -> bool {
        let (from, to) = if forward { (&self.old, &self.new) } else { (&self.new, &self.old) };
        let end = self.at.saturating_add(from.len());
        if list.get(self.at..end) != Some(from) {
            return false;
        }
        list.splice(self.at..end, to.iter().cloned());
        true
    }
}

/// The step from one scene to another, either way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Change {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<(String, String)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<Box<(InputMesh, InputMesh)>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    positions: Option<Splice<glam::DVec2>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    corners: Option<(CornerRule, CornerRule)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    corner_colours: Option<Splice<DVec4>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sharp: Option<Splice<u32>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    handles: Option<Splice<Handle>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    face_points: Option<Splice<Handle>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    geometry: Option<Splice<GeometryEdit>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    colours: Option<Splice<ColourEdit>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reference: Option<Box<(Option<Reference>, Option<Reference>)>>,
}

impl Change {
    /// What turns `old` into `new`.
    pub fn between(old: &Scene, new: &Scene) -> Change {
        let differ = |a: &InputMesh, b: &InputMesh| {
            a.corners != b.corners || a.face_start != b.face_start || a.positions.len() != b.positions.len()
        };
        let mesh = differ(&old.mesh, &new.mesh);
        Change {
            name: (old.name != new.name).then(|| (old.name.clone(), new.name.clone())),
            mesh: mesh.then(|| Box::new((old.mesh.clone(), new.mesh.clone()))),
            positions: if mesh { None } else { Splice::between(&old.mesh.positions, &new.mesh.positions) },
            corners: (old.corners != new.corners).then_some((old.corners, new.corners)),
            corner_colours: Splice::between(&old.corner_colours, &new.corner_colours),
            sharp: Splice::between(&old.sharp, &new.sharp),
            handles: Splice::between(&old.handles, &new.handles),
            face_points: Splice::between(&old.face_points, &new.face_points),
            geometry: Splice::between(&old.geometry, &new.geometry),
            colours: Splice::between(&old.colours, &new.colours),
            reference: (old.reference != new.reference)
                .then(|| Box::new((old.reference.clone(), new.reference.clone()))),
        }
    }

    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        *self == Change::default()
    }

    /// Whether the polygons change, so that half-edges have other numbers.
    pub fn renumbers(&self) -> bool {
        self.mesh.is_some()
    }

    /// Makes the change, or with `forward` false takes it back. `false`: the scene is not the one that the change
    /// belongs to; it is then left as it was.
    #[must_use]
    pub fn apply(&self, scene: &mut Scene, forward: bool) -> bool {
        let mut next = scene.clone();
        fn swap<T: Clone + PartialEq>(pair: &(T, T), value: &mut T, forward: bool) -> bool {
            let (from, to) = if forward { (&pair.0, &pair.1) } else { (&pair.1, &pair.0) };
            let fits = value == from;
            value.clone_from(to);
            fits
        }
        let fits = self.name.as_ref().is_none_or(|p| swap(p, &mut next.name, forward))
            && self.mesh.as_ref().is_none_or(|p| {
                let (from, to) = if forward { (&p.0, &p.1) } else { (&p.1, &p.0) };
                let fits = next.mesh.corners == from.corners && next.mesh.positions == from.positions;
                next.mesh.clone_from(to);
                fits
            })
            && self.positions.as_ref().is_none_or(|s| s.apply(&mut next.mesh.positions, forward))
            && self.corners.as_ref().is_none_or(|p| swap(p, &mut next.corners, forward))
            && self.corner_colours.as_ref().is_none_or(|s| s.apply(&mut next.corner_colours, forward))
            && self.sharp.as_ref().is_none_or(|s| s.apply(&mut next.sharp, forward))
            && self.handles.as_ref().is_none_or(|s| s.apply(&mut next.handles, forward))
            && self.face_points.as_ref().is_none_or(|s| s.apply(&mut next.face_points, forward))
            && self.geometry.as_ref().is_none_or(|s| s.apply(&mut next.geometry, forward))
            && self.colours.as_ref().is_none_or(|s| s.apply(&mut next.colours, forward))
            && self.reference.as_ref().is_none_or(|p| swap(p, &mut next.reference, forward));
        if fits {
            *scene = next;
        }
        fits
    }
}
