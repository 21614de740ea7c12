//! Every control of the panel by a click where it is painted: grid, swatches, pickers, buttons, questions.

use super::colour::{from_hex, to_hex};
use super::dialog::{Dialog, Then};
use super::editor::{Editor, Tool};
use super::habits::Seat;
use super::overlay::colour32;
use super::script::{Action, Button};
use crate::edit::drag::size_of;
use crate::edit::handle::{Id, Kind, Stage};
use egui::epaint::Shape;
use egui::{Color32, Pos2, Rect};
use glam::{DVec2, DVec4};

fn leaves<'a>(shape: &'a Shape, found: &mut Vec<&'a Shape>) {
    match shape {
        Shape::Vec(all) => all.iter().for_each(|s| leaves(s, found)),
        one => found.push(one),
    }
}

impl Seat {
    /// Places of what the last frame painted and `of` accepts, in the order of painting.
    fn places(&self, of: impl Fn(&Shape) -> Option<Rect>) -> Vec<Rect> {
        let mut all = Vec::new();
        self.painted.iter().for_each(|s| leaves(&s.shape, &mut all));
        all.into_iter().filter_map(of).collect()
    }

    /// Places of a text.
    pub fn texts(&self, wanted: &str) -> Vec<Rect> {
        self.places(|s| match s {
            Shape::Text(t) if t.galley.text() == wanted => Some(Rect::from_min_size(t.pos, t.galley.size())),
            _ => None,
        })
    }

    /// The one place of a text.
    pub fn text(&self, wanted: &str) -> Pos2 {
        let all = self.texts(wanted);
        assert_eq!(all.len(), 1, "{wanted}");
        all[0].center()
    }

    /// Texts that are numbers, painted right of `left` in the row of a place.
    pub fn numbers(&self, row: Pos2) -> Vec<(f64, Pos2)> {
        let mut found = Vec::new();
        let mut all = Vec::new();
        self.painted.iter().for_each(|s| leaves(&s.shape, &mut all));
        for s in all {
            if let Shape::Text(t) = s {
                let rect = Rect::from_min_size(t.pos, t.galley.size());
                if let (Ok(x), true) = (t.galley.text().parse(), (rect.center().y - row.y).abs() < 4.0) {
                    found.push((x, rect.center()));
                }
            }
        }
        found
    }

    /// Squares of a colour and of this many points.
    pub fn squares(&self, colour: Color32, side: f32) -> Vec<Rect> {
        self.places(|s| match s {
            Shape::Rect(r) if r.fill == colour && (r.rect.size() - egui::Vec2::splat(side)).length() < 0.1 => {
                Some(r.rect)
            }
            _ => None,
        })
    }

    pub fn point(&mut self, at: Pos2) {
        self.act(Action::Move([at.x, at.y]));
    }

    pub fn press(&mut self, at: Pos2, button: Button) {
        self.point(at);
        self.act(Action::Down(button));
        self.act(Action::Up(button));
        // What follows is painted.
        self.frame(vec![], vec![]);
    }

    pub fn press_text(&mut self, text: &str) {
        self.press(self.text(text), Button::Left);
    }

    /// Presses, moves in steps and lets go.
    pub fn slide(&mut self, from: Pos2, by: f32) {
        self.point(from);
        self.act(Action::Down(Button::Left));
        (1..=4).for_each(|k| self.point(from + egui::vec2(by * k as f32 / 4.0, 0.0)));
        self.act(Action::Up(Button::Left));
        self.frame(vec![], vec![]);
    }

    /// Types into the field at a place, in place of what is there.
    pub fn type_into(&mut self, at: Pos2, text: &str) {
        self.press(at, Button::Left);
        self.key("Ctrl+A");
        self.act(Action::Text(text.to_owned()));
        self.key("Enter");
        self.frame(vec![], vec![]);
    }

    /// Selects the first colour handle.
    fn select_colour(&mut self) -> Id {
        let id = self.ids(Kind::Colour)[0];
        self.click(self.at(id));
        assert!(self.editor.selection.contains(&id));
        self.frame(vec![], vec![]);
        id
    }

    fn steps(&self) -> usize {
        self.editor.history.labels().0.len()
    }
}

#[test]
fn the_grid_is_switched_on_changed_by_its_number_and_snapped_to() {
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    seat.key("1");
    seat.press_text("grid");
    let first = seat.editor.shown.grid;
    let size = size_of(&seat.editor.model.scene);
    assert!(first > size / 80.0 && first < size / 5.0, "{first} of {size}");
    let row = seat.text("grid");
    let place = seat.numbers(row)[0].1;
    seat.slide(place, 40.0);
    assert!(seat.editor.shown.grid > first, "{}", seat.editor.shown.grid);
    seat.type_into(seat.numbers(row)[0].1, "0.3");
    assert_eq!(seat.editor.shown.grid, 0.3);
    let coloured: Vec<DVec2> = seat.ids(Kind::Colour).iter().map(|&id| seat.at(id)).collect();
    let id = seat.ids(Kind::Vertex).into_iter().find(|&id| !coloured.contains(&seat.at(id))).unwrap();
    seat.drag(seat.at(id), seat.at(id) + DVec2::new(0.17, 0.13));
    let cells = seat.at(id) / 0.3;
    assert!(cells.distance(cells.round()) < 1e-9, "{cells}");
    seat.press_text("grid");
    assert_eq!(seat.editor.shown.grid, 0.0);
    seat.press_text("snap to points");
    assert!(seat.editor.shown.snap_points);
}

#[test]
fn swatches_paint_the_selection_and_are_kept_and_removed() {
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    let id = seat.select_colour();
    let before = seat.colour(id);
    let (count, wanted) = (seat.editor.swatches.len(), seat.editor.swatches[4]);
    let place = seat.squares(colour32(wanted), 18.0);
    assert_eq!(place.len(), 1);
    seat.press(place[0].center(), Button::Left);
    assert_eq!((seat.colour(id), seat.editor.brush.colour), (wanted, wanted));
    assert_eq!(seat.steps(), 1);
    seat.key("Ctrl+Z");
    assert_eq!(seat.colour(id), before);
    // A colour of one's own, kept, used, and removed again.
    seat.editor.brush.colour = from_hex("#123456").unwrap();
    seat.frame(vec![], vec![]);
    seat.press_text("+");
    assert_eq!((seat.editor.swatches.len(), seat.editor.swatches.last()), (count + 1, from_hex("#123456").as_ref()));
    seat.editor.brush.colour = DVec4::ONE;
    seat.frame(vec![], vec![]);
    let own = seat.squares(colour32(from_hex("#123456").unwrap()), 18.0)[0].center();
    seat.press(own, Button::Left);
    assert_eq!(to_hex(seat.colour(id)), "#123456");
    seat.press(own, Button::Right);
    assert_eq!(seat.editor.swatches.len(), count);
    assert!(seat.squares(colour32(from_hex("#123456").unwrap()), 18.0).is_empty());
}

#[test]
fn the_picker_paints_what_is_selected_in_one_step() {
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    let id = seat.select_colour();
    let before = seat.colour(id);
    let hex = seat.text(&to_hex(before));
    // The button stands left of the number.
    seat.press(hex - egui::vec2(50.0, 0.0), Button::Left);
    let squares = |seat: &Seat| {
        seat.places(|s| match s {
            Shape::Mesh(m) if m.calc_bounds().width() > 100.0 && m.calc_bounds().height() > 60.0 => {
                Some(m.calc_bounds())
            }
            _ => None,
        })
    };
    let square = *squares(&seat).last().expect("the picker is open");
    seat.slide(square.center(), 30.0);
    let after = seat.colour(id);
    assert_ne!(after, before);
    assert_eq!(seat.editor.brush.colour, after);
    // A click elsewhere closes it, and the gesture is whole.
    seat.press(seat.text("Colour and brush"), Button::Left);
    assert_eq!((seat.steps(), seat.editor.in_gesture()), (1, false));
    seat.key("Ctrl+Z");
    assert_eq!(seat.colour(id), before);
}

#[test]
fn colours_are_entered_as_hex_and_by_the_numbers_of_three_spaces() {
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    let id = seat.select_colour();
    let shown = to_hex(seat.colour(id));
    seat.type_into(seat.text(&shown), "#204080");
    assert_eq!(to_hex(seat.colour(id)), "#204080");
    let mut steps = seat.steps();
    for (space, numbers) in [
        ("HSV", super::colour::to_hsv as fn(glam::DVec3) -> glam::DVec3),
        ("Oklab", super::colour::to_oklab),
        ("RGB", |c| c),
    ] {
        seat.press_text(space);
        let row = seat.text(space) + egui::vec2(0.0, 21.0);
        let shown = seat.numbers(row);
        assert_eq!(shown.len(), 3, "{space}: {shown:?}");
        let now = numbers(seat.colour(id).truncate());
        for (i, (x, _)) in shown.iter().enumerate() {
            assert!((x - now[i]).abs() < 6e-4, "{space} {i}: {x} {now}");
        }
        // Dragged, and typed.
        let before = seat.colour(id);
        seat.slide(shown[0].1, 25.0);
        assert_ne!(seat.colour(id), before, "{space}");
        seat.type_into(seat.numbers(row)[0].1, "0.5");
        let now = numbers(seat.colour(id).truncate());
        assert!((now.x - 0.5).abs() < 2e-2, "{space}: {now}");
        assert!(seat.steps() > steps && !seat.editor.in_gesture(), "{space}");
        steps = seat.steps();
    }
    (0..steps).for_each(|_| seat.key("Ctrl+Z"));
    assert!(!seat.editor.unsaved());
}

#[test]
fn every_switch_of_the_panel_does_what_it_says() {
    let mut seat = Seat::new(Editor::fresh("grid:2x2"), None);
    for (name, tool) in [
        ("Brush", Tool::Brush),
        ("Sharp", Tool::Sharp),
        ("Pick", Tool::Pick),
        ("Draw", Tool::Draw),
        ("Move", Tool::Move),
    ] {
        seat.press_text(name);
        assert_eq!(seat.editor.tool, tool);
    }
    for l in (0..=6).rev() {
        seat.press_text(&l.to_string());
        assert_eq!(seat.editor.stage, Stage::Level(l));
    }
    seat.press_text("M");
    assert_eq!(seat.editor.stage, Stage::Input);
    type Flag = fn(&Editor) -> bool;
    let flags: [(&str, Flag); 6] = [
        ("control mesh (G)", |e| e.shown.mesh),
        ("handles (H)", |e| e.shown.handles),
        ("control points, not limits (C)", |e| e.shown.control),
        ("region of influence", |e| e.shown.influence),
        ("smooth edges (4 samples)", |e| e.look.samples == 4),
        ("prevent folds (P)", |e| e.prevent_folds),
    ];
    for (name, flag) in flags {
        let before = flag(&seat.editor);
        seat.press_text(name);
        assert_ne!(flag(&seat.editor), before, "{name}");
        seat.press_text(name);
        assert_eq!(flag(&seat.editor), before, "{name}");
    }
    seat.press_text("moves");
    assert!(seat.editor.brush.moves);
    seat.press_text("paints");
    assert!(!seat.editor.brush.moves);
    let radius = seat.editor.brush.radius;
    seat.slide(seat.text("radius") - egui::vec2(110.0, 0.0), 20.0);
    assert_ne!(seat.editor.brush.radius, radius);
    // Menus.
    seat.key("Ctrl+A");
    seat.key("ArrowUp");
    assert_eq!(seat.steps(), 1);
    seat.press(seat.texts("Edit")[0].center(), Button::Left);
    seat.press_text("Undo");
    assert_eq!(seat.steps(), 0);
    seat.press(seat.texts("Edit")[0].center(), Button::Left);
    seat.press_text("Redo");
    assert_eq!(seat.steps(), 1);
    seat.press_text("View");
    seat.press_text("1:1");
    assert_eq!(seat.editor.view.unit, 1.0);
}

#[test]
fn unsaved_work_is_saved_discarded_or_kept_by_the_buttons_of_the_question() {
    let folder = std::env::temp_dir().join(format!("gradtess-clicks-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("quad.json");
    for (button, quits, saved) in [("Cancel", false, false), ("Discard", true, false), ("Save", true, true)] {
        Editor::fresh("quad").save(&file).unwrap();
        let bytes = std::fs::read(&file).unwrap();
        let mut seat = Seat::new(Editor::fresh("quad"), None);
        seat.editor.open(&file);
        (0..2).for_each(|_| seat.frame(vec![], vec![]));
        seat.key("Ctrl+A");
        seat.key("ArrowUp");
        // The close button of the window.
        seat.editor.ask_first(Then::Quit);
        (0..2).for_each(|_| seat.frame(vec![], vec![]));
        assert!(matches!(seat.editor.dialog, Some(Dialog::Unsaved(Then::Quit))) && !seat.editor.quit);
        seat.press_text(button);
        assert_eq!(seat.editor.quit, quits, "{button}");
        assert!(seat.editor.dialog.is_none(), "{button}");
        assert_eq!(std::fs::read(&file).unwrap() != bytes, saved, "{button}");
        seat.editor.close(true);
    }
    let _ = std::fs::remove_dir_all(&folder);
}
