//! The habits of a drawing program, by the widgets themselves but without a window: pointer and keys in, scene out.

use super::dialog::{Dialog, Wanted};
use super::editor::Editor;
use super::script::{Action, Button, Keyboard};
use crate::edit::drag::size_of;
use crate::edit::handle::{Id, Kind};
use crate::edit::place::exact_limit;
use crate::image::Picture;
use crate::scene::Scene;
use egui::epaint::ClippedShape;
use egui::{Context, DroppedFile, Event, Pos2, RawInput, Rect, Vec2};
use glam::{DVec2, DVec4};
use std::path::{Path, PathBuf};

/// Somebody at the editor.
pub(super) struct Seat {
    pub editor: Editor,
    ctx: Context,
    keyboard: Keyboard,
    time: f64,
    /// What the last frame painted.
    pub painted: Vec<ClippedShape>,
}

impl Seat {
    pub fn new(scene: Scene, state: Option<PathBuf>) -> Seat {
        let mut editor = Editor::new(state);
        assert!(editor.take(scene, None));
        editor.prevent_folds = false;
        let ctx = Context::default();
        ctx.style_mut(|s| s.animation_time = 0.0);
        let mut seat = Seat { editor, ctx, keyboard: Keyboard::default(), time: 0.0, painted: Vec::new() };
        (0..3).for_each(|_| seat.frame(vec![], vec![]));
        seat
    }

    pub fn frame(&mut self, events: Vec<Event>, dropped_files: Vec<DroppedFile>) {
        self.time += 0.4;
        let raw = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, Vec2::new(900.0, 640.0))),
            time: Some(self.time),
            modifiers: self.keyboard.held(),
            events,
            dropped_files,
            focused: true,
            ..RawInput::default()
        };
        let editor = &mut self.editor;
        self.painted = self.ctx.run(raw, |ctx| editor.ui(ctx)).shapes;
    }

    pub fn act(&mut self, action: Action) {
        let (view, mut events) = (self.editor.view, Vec::new());
        self.keyboard.events(&action, |[x, y]| view.to_window(DVec2::new(x, y)), &mut events);
        self.frame(events, vec![]);
    }

    pub fn key(&mut self, name: &str) {
        self.act(Action::Key(name.to_owned()));
    }

    pub fn click(&mut self, at: DVec2) {
        self.drag(at, at);
    }

    pub fn drag(&mut self, from: DVec2, to: DVec2) {
        self.act(Action::Aim(from.into()));
        self.act(Action::Down(Button::Left));
        if from != to {
            self.act(Action::Aim(from.midpoint(to).into()));
            self.act(Action::Aim(to.into()));
        }
        self.act(Action::Up(Button::Left));
    }

    pub fn at(&self, id: Id) -> DVec2 {
        exact_limit(&self.editor.model.scene, &self.editor.model.mesh, id.level, id.slot).unwrap()
    }

    pub fn ids(&mut self, kind: Kind) -> Vec<Id> {
        self.editor.overlay().handles.iter().map(|h| h.id).filter(|id| id.kind == kind).collect()
    }

    pub fn colour(&mut self, id: Id) -> DVec4 {
        self.editor.overlay().handles.iter().find(|h| h.id == id).unwrap().colour
    }
}

pub(super) struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("gradtess-habits-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn moves_that_come_in_one_frame_with_the_release_count_up_to_it() {
    let mut seat = Seat::new(Editor::fresh("grid:3x2"), None);
    let id = seat.ids(Kind::Input)[5];
    let (from, way) = (seat.at(id), DVec2::splat(20.0 * seat.editor.view.unit));
    seat.click(from);
    seat.click(from);
    assert!(seat.editor.selection.contains(&id));
    seat.act(Action::Aim(from.into()));
    seat.act(Action::Down(Button::Left));
    let (view, mut events) = (seat.editor.view, Vec::new());
    for action in [Action::Aim((from + way).into()), Action::Up(Button::Left), Action::Aim((from - way).into())] {
        seat.keyboard.events(&action, |[x, y]| view.to_window(DVec2::new(x, y)), &mut events);
    }
    seat.frame(events, vec![]);
    let size = size_of(&seat.editor.model.scene);
    // Where a pointer stands is single precision.
    assert!(seat.at(id).distance(from + way) < 1e-4 * size, "{} not {}", seat.at(id), from + way);
}

#[test]
fn arrows_move_by_pixels_and_everything_that_is_selected() {
    let mut seat = Seat::new(Editor::fresh("grid:3x2"), None);
    let all = seat.ids(Kind::Input);
    let (id, other) = (all[0], all[5]);
    // A colour lies over the point; the second click is for the point.
    seat.click(seat.at(id));
    seat.click(seat.at(id));
    assert_eq!(seat.editor.selection.iter().collect::<Vec<_>>(), [&id]);
    let (start, unit) = (seat.at(id), seat.editor.view.unit);
    seat.key("ArrowRight");
    seat.key("Shift+ArrowUp");
    let size = size_of(&seat.editor.model.scene);
    let moved = (seat.at(id) - start) / unit;
    assert!(moved.distance(DVec2::new(1.0, 10.0)) < 1e-9 * size / unit, "{moved}");
    // Shift and a click: the colour over another point is selected with it, and goes again.
    seat.act(Action::Modifiers("Shift".into()));
    let place = seat.at(other);
    seat.click(place);
    assert_eq!(seat.editor.selection.len(), 2);
    seat.click(place);
    seat.act(Action::Modifiers(String::new()));
    assert_eq!(seat.editor.selection.len(), 1);
    // Everything.
    seat.key("Ctrl+A");
    let before: Vec<DVec2> = all.iter().map(|&id| seat.at(id)).collect();
    seat.key("ArrowLeft");
    for (id, before) in all.iter().zip(before) {
        assert!((seat.at(*id) - before).distance(DVec2::new(-unit, 0.0)) < 1e-9 * size);
    }
    // A box around the first point and nothing else.
    seat.key("Escape");
    let (at, reach) = (seat.at(id), DVec2::splat(12.0 * unit));
    seat.drag(at - reach, at + reach);
    assert!(seat.editor.selection.contains(&id) && seat.editor.selection.iter().all(|s| seat.at(*s) == at));
}

#[test]
fn points_snap_to_the_grid_and_to_points() {
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    seat.key("1");
    let coloured: Vec<DVec2> = seat.ids(Kind::Colour).iter().map(|&id| seat.at(id)).collect();
    let free: Vec<Id> = seat.ids(Kind::Vertex).into_iter().filter(|&id| !coloured.contains(&seat.at(id))).collect();
    // So far away that it stays while the first one moves.
    let a = free[0];
    let far = |id: &&Id| seat.at(**id).distance(seat.at(a));
    let b = *free.iter().max_by(|x, y| far(x).total_cmp(&far(y))).unwrap();
    seat.editor.shown.grid = 0.25;
    seat.drag(seat.at(a), seat.at(a) + DVec2::new(0.11, 0.07));
    let cells = seat.at(a) / 0.25;
    assert!(cells.distance(cells.round()) < 1e-9, "{cells}");
    seat.editor.shown.grid = 0.0;
    seat.editor.shown.snap_points = true;
    let (place, near) = (seat.at(b), DVec2::new(3.0, 2.0) * seat.editor.view.unit);
    seat.drag(seat.at(a), place + near);
    assert!(seat.at(a).distance(place) < 1e-9, "{} {place}", seat.at(a));
}

#[test]
fn colours_are_copied_pasted_and_picked_under_all_handles() {
    let folder = Folder::new("colours");
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    let ids = seat.ids(Kind::Colour);
    let first = seat.colour(ids[0]);
    seat.click(seat.at(ids[0]));
    seat.act(Action::Copy(true));
    seat.click(seat.at(ids[2]));
    assert_ne!(seat.colour(ids[2]), first);
    seat.act(Action::Paste("no colour".into()));
    assert_eq!(seat.colour(ids[2]), first);
    seat.act(Action::Paste("#336699".into()));
    assert_eq!(super::colour::to_hex(seat.colour(ids[2])), "#336699");
    // A picture, dropped on the window: red on the left, blue on the right.
    let (mut rgba, picture) = (Vec::new(), folder.0.join("picture.png"));
    for k in 0..64 {
        rgba.extend(if k % 8 < 4 { [255, 0, 0, 255] } else { [0, 0, 255, 255] });
    }
    Picture { width: 8, height: 8, rgba }.write_png(&picture, &[]).unwrap();
    seat.frame(vec![], vec![DroppedFile { path: Some(picture), ..DroppedFile::default() }]);
    let reference = seat.editor.model.scene.reference.clone().unwrap();
    let middle = 0.5 * (reference.rect[0] + reference.rect[2]);
    seat.key("Escape");
    seat.editor.pick_under_all();
    let mut seen = [0, 0];
    for id in ids {
        let right = seat.at(id).x > middle;
        let [r, g, b] = if right { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        // Corners of the picture lie on its rim, where there may be none.
        if super::reference::sample(&seat.editor.model.scene, &seat.editor.reference, seat.at(id)).is_some() {
            assert_eq!(seat.colour(id), DVec4::new(r, g, b, 1.0));
            seen[usize::from(right)] += 1;
        }
    }
    assert!(seen[0] > 0, "{seen:?}");
    // The eyedropper takes one for the brush.
    seat.key("I");
    seat.click(DVec2::new(middle + 0.2, 0.5 * (reference.rect[1] + reference.rect[3])));
    assert_eq!(seat.editor.brush.colour, DVec4::new(0.0, 0.0, 1.0, 1.0));
}

#[test]
fn files_are_dropped_saved_as_and_remembered() {
    let folder = Folder::new("files");
    let state = folder.0.join("state");
    let scene = folder.0.join("pentagon.json");
    Editor::fresh("pentagon").save(&scene).unwrap();
    let drop = |seat: &mut Seat, path: &Path| {
        seat.frame(vec![], vec![DroppedFile { path: Some(path.to_path_buf()), ..DroppedFile::default() }]);
    };
    let mut seat = Seat::new(Editor::fresh("quad"), Some(state.clone()));
    drop(&mut seat, &scene);
    assert_eq!(seat.editor.file.as_deref(), Some(&*scene));
    // With a change there is a question first; Esc keeps everything.
    seat.key("Ctrl+A");
    seat.key("ArrowUp");
    assert!(seat.editor.unsaved());
    drop(&mut seat, &scene);
    assert!(matches!(seat.editor.dialog, Some(Dialog::Unsaved(_))));
    seat.key("Escape");
    assert!(seat.editor.dialog.is_none() && seat.editor.unsaved());
    // Save as, by a name and Enter.
    seat.key("Ctrl+Shift+S");
    match &mut seat.editor.dialog {
        Some(Dialog::Browse { wanted: Wanted::Save, name, .. }) => *name = "other".to_owned(),
        _ => panic!("no question for a name"),
    }
    (0..2).for_each(|_| seat.frame(vec![], vec![]));
    seat.key("Enter");
    let other = folder.0.join("other.json");
    assert!(other.exists() && !seat.editor.unsaved(), "{:?}", seat.editor.message);
    let again = Editor::new(Some(state));
    assert_eq!(again.recent, [other, scene]);
}

#[test]
fn five_hundred_steps_are_undone() {
    let mut seat = Seat::new(Editor::fresh("triangle"), None);
    let start = seat.editor.model.scene.clone();
    let id = seat.ids(Kind::Input)[0];
    seat.editor.selection = [id].into();
    (0..510).for_each(|_| seat.editor.nudge(DVec2::X));
    assert_ne!(seat.editor.model.scene.mesh.positions, start.mesh.positions);
    (0..510).for_each(|_| seat.key("Ctrl+Z"));
    assert_eq!(seat.editor.model.scene, start);
}

#[test]
fn every_panel_and_window_can_be_shown() {
    let mut seat = Seat::new(Editor::fresh("fan:5"), None);
    for key in ["T", "F1", "F1", "Ctrl+N", "Escape", "Ctrl+O", "Escape", "Ctrl+Shift+S", "Escape", "C", "G", "H"] {
        seat.key(key);
        seat.frame(vec![], vec![]);
    }
    assert!(seat.editor.timing_open && seat.editor.dialog.is_none() && seat.editor.shown.control);
    for stage in ["M", "0", "1", "2", "3", "4", "5", "6"] {
        seat.key(stage);
    }
    for (show, _) in Editor::shows() {
        seat.editor.look.show = show;
        seat.frame(vec![], vec![]);
    }
}
