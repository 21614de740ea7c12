//! Surfaces in space by the editor's own widgets, without a window: every option, sharpness, crashes.

use super::dialog::Dialog;
use super::editor::Editor;
use super::habits::{Folder, Seat};
use super::script::Button;
use super::surface::{Options, Shown, Solid};
use crate::edit::journal_file::left_behind;
use crate::gpu::{SolidNormals, SolidShow};
use crate::surface::level::Scheme;
use crate::surface::shade::Geometric;
use crate::surface::weight::{Darts, Initial, Variant};
use egui::Pos2;
use std::path::Path;

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

impl Seat {
    fn with_cube(file: &Path, state: &Path) -> Seat {
        let mut seat = Seat::new(Editor::fresh("quad"), Some(state.to_path_buf()));
        seat.editor.open(file);
        (0..3).for_each(|_| seat.frame(vec![], vec![]));
        seat
    }

    fn solid(&self) -> &Solid {
        self.editor.solid.as_ref().expect("a surface is open")
    }

    fn options(&self) -> Options {
        self.solid().options
    }

    /// Clicks where an edge shows.
    fn pick_edge(&mut self, h: u32) {
        let (solid, rect) = (self.solid(), self.editor.view.rect);
        let eye = solid.eye(rect);
        let [a, b] = solid.ends(h).map(|p| eye.place(p).unwrap().0);
        self.press(Pos2::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y)), Button::Left);
        assert!(self.solid().selected.contains(&h));
    }

    /// An edge that nothing hides at the start.
    fn front_edge(&self) -> u32 {
        let solid = self.solid();
        let in_front = |h: &u32| solid.ends(*h).iter().all(|p| p.z == 1.0 && p.y == 1.0);
        solid.edges().find(in_front).unwrap()
    }

    /// Chooses by the box that has a name to its right.
    fn choose(&mut self, name: &str, now: &str, wanted: &str) {
        let row = self.text(name);
        let boxes: Vec<Pos2> = self.texts(now).into_iter().map(|r| r.center()).collect();
        let at = boxes.iter().find(|at| (at.y - row.y).abs() < 8.0);
        self.press(*at.unwrap_or_else(|| panic!("{name} at {row:?}, {now} at {boxes:?}")), Button::Left);
        self.frame(vec![], vec![]);
        let wanted = self.texts(wanted).last().expect("the list is open").center();
        self.press(wanted, Button::Left);
        (0..2).for_each(|_| self.frame(vec![], vec![]));
    }

    /// Types into the number of a slider.
    fn number(&mut self, name: &str, value: &str) {
        let row = self.text(name);
        let (_, at) = self.numbers(row)[0];
        self.type_into(at, value);
    }
}

#[test]
fn every_option_of_the_panel_does_what_it_says() {
    let folder = Folder::new("surface-options");
    let file = folder.0.join("cube.obj");
    std::fs::write(&file, CUBE).unwrap();
    let mut seat = Seat::with_cube(&file, &folder.0.join("state"));
    assert_eq!(seat.options(), Options::default());
    let mut wanted = Options::default();
    let shown = [
        ("highlight lines", Shown::Surface(SolidShow::Highlight)),
        ("reflection lines", Shown::Surface(SolidShow::Reflection)),
        ("normals", Shown::Surface(SolidShow::Normals)),
        ("blend weights", Shown::Surface(SolidShow::Weights)),
        ("sides", Shown::Surface(SolidShow::Sides)),
        ("mesh of the level", Shown::Mesh),
        ("shaded", Shown::Surface(SolidShow::Shaded)),
    ];
    let mut now = "shaded";
    for (name, what) in shown {
        seat.choose("shown", now, name);
        (now, wanted.shown) = (name, what);
        assert_eq!(seat.options(), wanted, "{name}");
    }
    seat.choose("normals", "blended N_B", "geometric N_L");
    wanted.normals = SolidNormals::Geometric;
    assert_eq!(seat.options(), wanted);
    seat.choose("normals", "geometric N_L", "subdivided N_S");
    wanted.normals = SolidNormals::Subdivided;
    seat.number("stripes", "50");
    wanted.stripes = 50.0;
    seat.press_text("patches of the limit");
    wanted.patches = true;
    seat.press_text("Loop");
    wanted.scheme = Scheme::Loop;
    seat.number("level (0 to 6)", "5");
    wanted.level = 5;
    assert_eq!(seat.options(), wanted);
    seat.number("normals from", "2");
    seat.number("weights from", "3");
    seat.number("p", "2.5");
    (wanted.settings.normals_from, wanted.settings.weights_from, wanted.settings.power) = (2, 3, 2.5);
    assert_eq!(seat.options(), wanted);
    seat.choose("variant", "B", "A");
    seat.choose("darts", "smooth", "sharp");
    seat.choose("weights", "ring", "inverse limit");
    seat.choose("N_L", "of the limit", "of the mesh");
    wanted.settings.rules.variant = Variant::A;
    wanted.settings.rules.darts = Darts::Sharp;
    wanted.settings.rules.initial = Initial::Inverse;
    wanted.settings.geometric = Geometric::Mesh;
    assert_eq!(seat.options(), wanted);
    // None of it is of the file.
    assert!(!seat.editor.unsaved() && seat.solid().journal().is_none());
}

#[test]
fn the_slider_gives_the_selected_edges_their_sharpness_in_one_step() {
    let folder = Folder::new("surface-slider");
    let file = folder.0.join("cube.obj");
    std::fs::write(&file, CUBE).unwrap();
    let mut seat = Seat::with_cube(&file, &folder.0.join("state"));
    let edge = seat.front_edge();
    seat.pick_edge(edge);
    seat.number("sharpness", "2.25");
    assert_eq!((seat.solid().sharpness(edge), seat.solid().steps()), (2.25, 1));
    seat.press_text("For ever");
    seat.frame(vec![], vec![]);
    assert_eq!((seat.solid().sharpness(edge), seat.solid().steps()), (f64::INFINITY, 2));
    seat.press_text("Smooth");
    seat.frame(vec![], vec![]);
    assert_eq!((seat.solid().sharpness(edge), seat.solid().steps()), (0.0, 3));
}

#[test]
fn a_session_that_crashed_is_offered_restored_and_can_be_undone() {
    let folder = Folder::new("surface-crash");
    let (file, state) = (folder.0.join("cube.obj"), folder.0.join("state"));
    std::fs::write(&file, CUBE).unwrap();
    let mut seat = Seat::with_cube(&file, &state);
    let edge = seat.front_edge();
    seat.pick_edge(edge);
    seat.number("sharpness", "2.25");
    seat.key("E");
    seat.key("ArrowDown");
    seat.key("Ctrl+Z");
    let (sharpness, steps) = (seat.solid().scene.edge_sharpness.clone(), seat.solid().steps());
    assert!(steps == 2 && seat.solid().sharpness(edge) == f64::INFINITY);
    let journal = seat.solid().journal().expect("a journal begins with the first step").to_path_buf();
    // The process is gone: nothing is said goodbye to.
    drop(seat);
    assert_eq!(left_behind(Some(&file), None), vec![journal.as_path()]);

    let mut seat = Seat::with_cube(&file, &state);
    assert!(matches!(seat.editor.dialog, Some(Dialog::Restore(_))));
    assert_eq!(seat.solid().sharpness(edge), 0.0);
    seat.key("Enter");
    (0..3).for_each(|_| seat.frame(vec![], vec![]));
    assert_eq!((&seat.solid().scene.edge_sharpness, seat.solid().steps()), (&sharpness, 2));
    assert!(seat.editor.unsaved() && !journal.exists() && seat.editor.file.as_deref() == Some(&*file));
    // What was undone before the crash can be done again, and the rest undone; saving ends it.
    seat.key("Ctrl+Y");
    assert_eq!(seat.solid().steps(), 3);
    (0..3).for_each(|_| seat.key("Ctrl+Z"));
    assert_eq!(seat.solid().sharpness(edge), 0.0);
    seat.key("Ctrl+Y");
    assert!(seat.solid().journal().is_some());
    seat.key("Ctrl+S");
    assert!(!seat.editor.unsaved() && seat.solid().journal().is_none());
    assert!(left_behind(Some(&file), None).is_empty());
    // A second session that is given up leaves nothing.
    seat.key("E");
    let second = seat.solid().journal().unwrap().to_path_buf();
    seat.key("Ctrl+Q");
    seat.frame(vec![], vec![]);
    seat.press_text("Discard");
    assert!(seat.editor.quit && !second.exists());
}
