//! Undo and redo of everything, one step a gesture.

use super::change::Change;
use crate::scene::Scene;

/// Steps that are kept; the oldest go first.
pub const DEPTH: usize = 2000;

/// A change and what the user knows it by.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Such as "move vertex".
    pub label: String,
    /// What it did.
    pub change: Change,
}

/// Done and undone steps.
#[derive(Clone, Debug, Default)]
pub struct History {
    done: Vec<Step>,
    undone: Vec<Step>,
    /// Steps dropped at the old end, so that positions keep their meaning.
    dropped: usize,
}

impl History {
    /// Adds the step from `before` to `after`; what was undone is gone. `None` when nothing changed.
    pub fn push(&mut self, label: &str, before: &Scene, after: &Scene) -> Option<&Step> {
        let change = Change::between(before, after);
        if change.is_empty() {
            return None;
        }
        self.add(Step { label: label.to_owned(), change });
        self.done.last()
    }

    /// Adds a step that is done already.
    pub fn add(&mut self, step: Step) {
        self.undone.clear();
        self.done.push(step);
        if self.done.len() > DEPTH {
            self.done.remove(0);
            self.dropped += 1;
        }
    }

    /// Takes the last step back; its label, or `None` when there is none.
    pub fn undo(&mut self, scene: &mut Scene) -> Option<&str> {
        let step = self.done.pop()?;
        let fits = step.change.apply(scene, false);
        debug_assert!(fits, "the scene changed beside its history");
        self.undone.push(step);
        self.undone.last().map(|s| s.label.as_str())
    }

    /// Does the last step taken back again.
    pub fn redo(&mut self, scene: &mut Scene) -> Option<&str> {
        let step = self.undone.pop()?;
        let fits = step.change.apply(scene, true);
        debug_assert!(fits, "the scene changed beside its history");
        self.done.push(step);
        self.done.last().map(|s| s.label.as_str())
    }

    /// Steps since the beginning: a name for the state, as long as nothing is redone differently.
    pub fn position(&self) -> usize {
        self.dropped + self.done.len()
    }

    /// Labels of the steps that can be undone, the last first, and of those that can be redone, the next first.
    pub fn labels(&self) -> (Vec<&str>, Vec<&str>) {
        fn names(steps: &[Step]) -> Vec<&str> {
            steps.iter().rev().map(|s| s.label.as_str()).collect()
        }
        (names(&self.done), names(&self.undone))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes::builtin;
    use crate::scene::{ColourEdit, Frame, GeometryEdit, Handle};
    use glam::{DVec2, DVec4};

    #[test]
    fn six_hundred_steps_of_every_sort_come_back_one_by_one() {
        let mut scene = Scene { mesh: builtin("grid:2x2").unwrap(), ..Scene::default() };
        let mut history = History::default();
        let mut states = vec![scene.clone()];
        for i in 0..600u32 {
            let before = scene.clone();
            let x = f64::from(i) * 0.013;
            match i % 7 {
                0 => scene.mesh.positions[(i % 9) as usize].x += x + 1.0,
                1 => scene.colours.push(ColourEdit { level: 1, half_edge: u64::from(i), colour: DVec4::splat(x) }),
                2 => scene.geometry.insert(
                    scene.geometry.len() / 2,
                    GeometryEdit { level: 2, half_edge: 7, vertex: None, a: x, b: -x, frame: Frame::Boundary },
                ),
                3 => scene.handles.push(Handle { half_edge: i, at: DVec2::new(x, x) }),
                4 => scene.sharp.push(i),
                5 => {
                    scene.geometry.pop();
                }
                _ => scene.mesh = builtin(["ring:5", "fan:3", "quad"][(i % 3) as usize]).unwrap(),
            }
            // Changes that do nothing make no step.
            if history.push("step", &before, &scene).is_some() {
                states.push(scene.clone());
            }
            while scene.mesh.positions.len() < 9 {
                scene.mesh = builtin("grid:2x2").unwrap();
                let before = states.last().unwrap().clone();
                history.push("mesh", &before, &scene);
                states.push(scene.clone());
            }
        }
        assert!(history.position() >= 600 && history.position() + 1 == states.len());
        let last = states.len() - 1;
        for i in (0..last).rev() {
            history.undo(&mut scene).unwrap();
            assert_eq!(scene, states[i]);
        }
        assert_eq!(history.undo(&mut scene), None);
        for state in &states[1..] {
            history.redo(&mut scene).unwrap();
            assert_eq!(scene, *state);
        }
        assert_eq!(history.redo(&mut scene), None);
    }

    #[test]
    fn a_change_refuses_a_scene_that_it_does_not_belong_to() {
        let a = Scene { mesh: builtin("quad").unwrap(), ..Scene::default() };
        let mut b = a.clone();
        b.mesh.positions[1].x += 1.0;
        let change = Change::between(&a, &b);
        let mut other = a.clone();
        other.mesh.positions[1].x -= 1.0;
        let kept = other.clone();
        assert!(!change.apply(&mut other, true));
        assert_eq!(other, kept);
    }
}
