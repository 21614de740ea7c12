//! Gradient meshes by the editor's own widgets, without a window: files, questions, colours, keys, folds, crashes.

use super::dialog::{Dialog, Wanted};
use super::editor::Editor;
use super::habits::{Folder, Seat};
use super::script::{Action, Button};
use crate::edit::gradient::pick::Pick;
use crate::edit::gradient::Gradient;
use crate::edit::journal_file::left_behind;
use crate::ferguson::inherit::Continuity;
use crate::ferguson::mesh::HalfEdge;
use crate::ferguson::Mesh;
use crate::scene::ferguson::{parse, write};
use crate::timing::random::Random;
use egui::{DroppedFile, Pos2};
use glam::{DVec2, DVec4};
use std::path::Path;

const DRAWING: &str = "<svg xmlns='http://www.w3.org/2000/svg'><meshgradient gradientUnits='userSpaceOnUse'><meshrow>\
<meshpatch><stop path='l 100,0' stop-color='#f00'/><stop path='l 0,100' stop-color='#ff0'/>\
<stop path='l -100,0' stop-color='#0a0'/><stop path='l 0,-100' stop-color='#00f'/></meshpatch>\
<meshpatch><stop path='l 80,0'/><stop path='l 0,100' stop-color='#0ff'/>\
<stop path='l -80,0' stop-color='#333'/></meshpatch></meshrow></meshgradient></svg>";

impl Seat {
    fn with_patches(n: u32) -> Seat {
        let colour = |i: u32, j: u32| DVec4::new(f64::from(i % 2), f64::from(j % 2), 0.5, 1.0);
        let mesh = Mesh::grid(n, n, [0.0, 0.0, f64::from(n), f64::from(n)], colour).unwrap();
        let mut seat = Seat::new(Editor::fresh("quad"), None);
        assert!(seat.editor.take_gradient(Gradient::new(mesh), None));
        seat.settle();
        seat
    }

    fn settle(&mut self) {
        (0..3).for_each(|_| self.frame(vec![], vec![]));
    }

    fn gradient(&self) -> &Gradient {
        self.editor.gradient.as_ref().expect("a gradient mesh is open")
    }

    fn said(&self) -> &str {
        self.editor.message.as_ref().map_or("", |m| &m.text)
    }

    fn drop_file(&mut self, path: &Path) {
        self.frame(vec![], vec![DroppedFile { path: Some(path.to_path_buf()), ..DroppedFile::default() }]);
        self.settle();
    }

    /// The point at a place.
    fn point_at(&self, at: DVec2) -> u32 {
        match self.gradient().at(at, 1e-9) {
            Some(Pick::Point(p)) => p,
            other => panic!("{other:?} at {at}"),
        }
    }

    fn select_point(&mut self, at: DVec2) -> u32 {
        let point = self.point_at(at);
        self.click(at);
        self.frame(vec![], vec![]);
        assert_eq!(self.gradient().selected, Some(Pick::Point(point)));
        point
    }
}

#[test]
fn a_drawing_is_opened_and_saved_beside_itself_after_a_question() {
    let folder = Folder::new("gradient-files");
    let (drawing, json) = (folder.0.join("two.svg"), folder.0.join("two.json"));
    std::fs::write(&drawing, DRAWING).unwrap();
    let mut seat = Seat::new(Editor::fresh("quad"), Some(folder.0.join("state")));
    seat.drop_file(&drawing);
    assert_eq!((seat.gradient().mesh.live().count(), seat.editor.unsaved()), (2, false), "{}", seat.said());
    assert_eq!(seat.editor.title(), "two.svg");
    let corner = seat.gradient().bounds().map(|b| DVec2::new(b[0], b[1])).unwrap();
    seat.drag(corner, corner - DVec2::new(10.0, 5.0));
    let middle = seat.gradient().bounds().map(|b| DVec2::new(0.6 * b[0] + 0.4 * b[2], 0.5 * (b[1] + b[3]))).unwrap();
    seat.act(Action::Aim(middle.into()));
    seat.key("U");
    assert_eq!((seat.gradient().mesh.live().count(), seat.gradient().steps()), (3, 2));
    // Closing asks; Esc keeps everything as it is.
    for keys in ["Ctrl+Q", "Ctrl+O", "Ctrl+N"] {
        seat.key(keys);
        assert!(matches!(seat.editor.dialog, Some(Dialog::Unsaved(_))), "{keys}");
        seat.key("Escape");
        assert!(seat.editor.dialog.is_none() && seat.editor.unsaved() && !seat.editor.quit);
    }
    // Saving first: a drawing is not written over, so there is a question for the name; then it quits.
    seat.key("Ctrl+Q");
    seat.frame(vec![], vec![]);
    seat.press_text("Save");
    match &seat.editor.dialog {
        Some(Dialog::Browse { wanted: Wanted::Save, name, then: Some(_), .. }) => assert_eq!(name, "two.json"),
        _ => panic!("no question for a name"),
    }
    seat.settle();
    seat.key("Enter");
    assert!(seat.editor.quit && !seat.editor.unsaved() && seat.editor.dialog.is_none(), "{}", seat.said());
    assert_eq!(std::fs::read_to_string(&drawing).unwrap(), DRAWING);
    let saved = parse(&std::fs::read(&json).unwrap(), "two").unwrap().0;
    assert_eq!(write(&saved), write(&seat.gradient().mesh));
    assert!(left_behind(Some(&drawing), None).is_empty() && left_behind(Some(&json), None).is_empty());
    // From here on it is saved to that file, without a question; save as asks before it replaces another.
    seat.editor.quit = false;
    seat.drag(corner - DVec2::new(10.0, 5.0), corner);
    seat.key("Ctrl+S");
    assert!(!seat.editor.unsaved() && seat.said().starts_with("saved"));
    seat.key("Ctrl+Shift+S");
    match &mut seat.editor.dialog {
        Some(Dialog::Browse { wanted: Wanted::Save, name, .. }) => *name = "two.svg".to_owned(),
        _ => panic!("no question for a name"),
    }
    seat.settle();
    seat.key("Enter");
    seat.settle();
    seat.press_text("Replace");
    assert!(seat.said().contains("convert"), "{}", seat.said());
    assert_eq!(std::fs::read_to_string(&drawing).unwrap(), DRAWING);
    // It opens again as what it was saved as.
    let mesh = write(&seat.gradient().mesh);
    seat.drop_file(&json);
    assert_eq!((write(&seat.gradient().mesh), seat.gradient().steps()), (mesh, 0));
}

#[test]
fn the_question_for_unsaved_changes_can_be_answered_by_discarding_them() {
    let folder = Folder::new("gradient-discard");
    let file = folder.0.join("a.json");
    std::fs::write(&file, write(&Seat::with_patches(2).gradient().mesh)).unwrap();
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    seat.drop_file(&file);
    let bytes = std::fs::read(&file).unwrap();
    seat.drag(DVec2::ONE, DVec2::new(1.2, 1.1));
    let journal = seat.gradient().journal().expect("a journal begins with the first step").to_path_buf();
    assert!(journal.exists());
    seat.key("Ctrl+Q");
    seat.frame(vec![], vec![]);
    seat.press_text("Discard");
    assert!(seat.editor.quit && !journal.exists() && std::fs::read(&file).unwrap() == bytes);
}

#[test]
fn a_session_that_crashed_is_offered_restored_and_can_be_undone() {
    let folder = Folder::new("gradient-crash");
    let (drawing, state) = (folder.0.join("two.svg"), Some(folder.0.join("state")));
    std::fs::write(&drawing, DRAWING).unwrap();
    let mut seat = Seat::new(Editor::fresh("quad"), state.clone());
    seat.drop_file(&drawing);
    let start = write(&seat.gradient().mesh);
    let bounds = seat.gradient().bounds().unwrap();
    let corner = DVec2::new(bounds[0], bounds[1]);
    seat.drag(corner, corner - DVec2::new(9.0, 9.0));
    seat.act(Action::Aim([bounds[0] + 30.0, bounds[1] + 40.0]));
    seat.key("V");
    seat.key("U");
    seat.key("Ctrl+Z");
    let (mesh, steps) = (write(&seat.gradient().mesh), seat.gradient().steps());
    assert_eq!(steps, 2);
    let journal = seat.gradient().journal().unwrap().to_path_buf();
    // The process is gone: nothing is said goodbye to.
    drop(seat);
    assert_eq!(left_behind(Some(&drawing), None), vec![journal.as_path()]);

    let mut seat = Seat::new(Editor::fresh("quad"), state.clone());
    seat.drop_file(&drawing);
    assert!(
        matches!(seat.editor.dialog, Some(Dialog::Restore(_))),
        "{} {:?}",
        seat.said(),
        std::fs::read_to_string(&journal)
    );
    assert_eq!(write(&seat.gradient().mesh), start);
    seat.press_text("Later");
    assert!(journal.exists() && seat.editor.dialog.is_none());
    seat.drop_file(&drawing);
    seat.key("Enter");
    seat.settle();
    assert_eq!((write(&seat.gradient().mesh), seat.gradient().steps()), (mesh, 2), "{}", seat.said());
    assert!(seat.editor.unsaved() && !journal.exists() && seat.editor.file.as_deref() == Some(&*drawing));
    // What was undone before the crash can be done again, and the rest undone; a second crash loses nothing either.
    seat.key("Ctrl+Y");
    assert_eq!(seat.gradient().steps(), 3);
    (0..3).for_each(|_| seat.key("Ctrl+Z"));
    assert_eq!(write(&seat.gradient().mesh), start);
    let second = seat.gradient().journal().unwrap().to_path_buf();
    drop(seat);
    let mut seat = Seat::new(Editor::fresh("quad"), state);
    seat.drop_file(&drawing);
    assert!(second.exists());
    seat.press_text("Discard");
    assert!(!second.exists() && left_behind(Some(&drawing), None).is_empty());
}

#[test]
fn any_colour_goes_to_the_point_or_sector_that_is_selected_in_one_step() {
    let mut seat = Seat::with_patches(2);
    let point = seat.select_point(DVec2::ONE);
    let corners = seat.gradient().mesh.points[point as usize].corners.clone();
    let colour = |seat: &Seat, h: HalfEdge| seat.gradient().mesh.corner(h).colour.value;
    // As hex.
    let field = seat.text(&super::colour::to_hex(colour(&seat, corners[0])));
    seat.type_into(field, "#336699");
    assert!(corners.iter().all(|&h| super::colour::to_hex(colour(&seat, h)) == "#336699"));
    assert_eq!(seat.gradient().steps(), 1);
    // By a number that is dragged: one step again, taken back by one.
    let rgb = seat.text("RGB");
    let row = seat.numbers(rgb + egui::vec2(0.0, 22.0));
    assert_eq!(row.len(), 3, "{row:?}");
    seat.slide(row[0].1, 40.0);
    assert!(colour(&seat, corners[0]).x > 0.25, "{}", colour(&seat, corners[0]));
    assert_eq!(seat.gradient().steps(), 2);
    seat.key("Ctrl+Z");
    assert_eq!(super::colour::to_hex(colour(&seat, corners[0])), "#336699");
    // A swatch, for one sector alone: sharp.
    seat.select_point(DVec2::ONE);
    seat.press_text("sector 1");
    let sector = match seat.gradient().selected {
        Some(Pick::Sector(h)) => h,
        other => panic!("{other:?}"),
    };
    let white = seat.squares(egui::Color32::WHITE, 18.0);
    seat.press(white[0].center(), Button::Left);
    for &h in &corners {
        assert_eq!(colour(&seat, h) == DVec4::ONE, h == sector);
    }
    // Copied from there and pasted on another point.
    seat.act(Action::Copy(true));
    let other = seat.select_point(DVec2::new(2.0, 1.0));
    seat.act(Action::Paste("no colour".into()));
    let corners = &seat.gradient().mesh.points[other as usize].corners;
    assert!(corners.iter().all(|&h| colour(&seat, h) == DVec4::ONE));
}

#[test]
fn keys_split_join_mirror_nudge_and_are_listed() {
    let mut seat = Seat::with_patches(2);
    seat.key("F1");
    seat.settle();
    for text in [
        "U, V",
        "split the patch under the pointer along u, v",
        "show twists",
        "remove the split whose curve is selected",
    ] {
        assert_eq!(seat.texts(text).len(), 1, "{text}");
    }
    assert!(seat.texts("brush").is_empty());
    seat.key("Escape");
    seat.act(Action::Aim([0.4, 0.3]));
    seat.key("U");
    seat.key("V");
    // The second split went through the half under the pointer.
    assert_eq!(seat.gradient().mesh.live().count(), 6);
    seat.key("C");
    assert_eq!(seat.gradient().continuity, Continuity::C0);
    seat.key("W");
    assert!(seat.gradient().twists);
    seat.key("W");
    seat.click(DVec2::new(0.7, 0.3));
    seat.key("Delete");
    assert_eq!((seat.gradient().mesh.live().count(), seat.gradient().steps()), (5, 3), "{}", seat.said());
    let point = seat.select_point(DVec2::new(2.0, 2.0));
    let unit = seat.editor.view.unit;
    seat.key("ArrowRight");
    seat.key("Shift+ArrowUp");
    assert!(seat.gradient().mesh.at(point).distance(DVec2::new(2.0 + unit, 2.0 + 10.0 * unit)) < 1e-9);
    // Keys of subdivision meshes do nothing here.
    let before = (write(&seat.gradient().mesh), seat.gradient().steps());
    ["B", "E", "D", "M", "3", "Tab", "Ctrl+A"].into_iter().for_each(|key| seat.key(key));
    assert_eq!((write(&seat.gradient().mesh), seat.gradient().steps()), before);
}

#[test]
fn drags_stop_at_folds_unless_that_is_switched_off() {
    for (prevented, key) in [(true, None), (false, Some("P"))] {
        let mut seat = Seat::with_patches(3);
        seat.editor.prevent_folds = true;
        let folder = Folder::new("gradient-folds");
        seat.editor.state = Some(folder.0.clone());
        key.into_iter().for_each(|key| seat.key(key));
        seat.drag(DVec2::ONE, DVec2::new(2.6, 2.5));
        let folded = (0..9).filter(|&p| !crate::edit::gradient::folds::sound(&seat.gradient().mesh, p, 1.0)).count();
        assert_eq!((folded == 0, seat.said().starts_with("stopped")), (prevented, prevented), "{folded}");
        assert_eq!(seat.gradient().steps(), 1);
    }
}

/// A scene with a chain of T-sections, through the pointer and the keyboard: everything comes back.
#[test]
fn edits_at_sections_are_refused_or_taken_back_and_done_again() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/ferguson/sections.json");
    let mut seat = Seat::new(Editor::fresh("quad"), None);
    // Without a file, so that no journal lies beside the scene.
    let (gradient, _) = Gradient::read(std::fs::read(scene).unwrap(), "sections".into()).unwrap();
    assert!(seat.editor.take_gradient(gradient, None));
    seat.settle();
    seat.editor.prevent_folds = true;
    let section = seat.gradient().mesh.points.iter().find(|p| p.on.is_some() && !p.corners.is_empty()).unwrap().at;
    seat.drag(section, section + DVec2::splat(20.0 * seat.editor.view.unit));
    assert!(seat.said().contains("is a T-section") && !seat.editor.unsaved(), "{}", seat.said());
    let mut states = vec![write(&seat.gradient().mesh)];
    let mut random = Random::new(3);
    let mut refused = 0;
    for k in 0..60 {
        let [x0, y0, x1, y1] = seat.gradient().bounds().unwrap();
        let mut between = |a: f64, b: f64| a + (b - a) * random.unit();
        let at = DVec2::new(between(x0, x1), between(y0, y1));
        match k % 5 {
            0 | 1 => {
                let picks: Vec<Pick> = seat.gradient().picks([x0, y0, x1, y1]);
                let from = seat.gradient().place(picks[(between(0.0, 1.0) * picks.len() as f64) as usize]);
                let way = DVec2::new(between(-1.0, 1.0), between(-1.0, 1.0)) * 30.0 * seat.editor.view.unit;
                seat.drag(from, from + way);
            }
            2 => {
                seat.act(Action::Aim(at.into()));
                seat.key(if between(0.0, 1.0) < 0.5 { "U" } else { "V" });
            }
            3 => {
                seat.click(at);
                seat.act(Action::Paste(["#ff0000", "#00ff0080"][k % 2].into()));
            }
            _ => seat.key("C"),
        }
        assert_eq!(seat.gradient().mesh.fault(), None, "after {k}");
        match seat.gradient().steps() + 1 - states.len() {
            0 => refused += 1,
            1 => states.push(write(&seat.gradient().mesh)),
            n => panic!("{n} steps at once"),
        }
    }
    assert!(states.len() > 15 && refused > 10, "{} {refused}", states.len());
    for state in states.iter().rev().skip(1) {
        seat.key("Ctrl+Z");
        assert!(write(&seat.gradient().mesh) == *state);
    }
    assert!(!seat.editor.unsaved());
    for state in &states[1..] {
        seat.key("Ctrl+Shift+Z");
        assert!(write(&seat.gradient().mesh) == *state);
    }
}

#[test]
fn ten_thousand_patches_show_their_handles_from_near() {
    let mut seat = Seat::with_patches(100);
    let notice = "zoom in to see the handles";
    assert!(!seat.texts(notice).is_empty());
    let vertices = |seat: &Seat| {
        let count = |s: &egui::Shape| if let egui::Shape::Mesh(m) = s { m.vertices.len() } else { 0 };
        seat.painted.iter().map(|s| count(&s.shape)).sum::<usize>()
    };
    assert!(vertices(&seat) < 120_000, "{}", vertices(&seat));
    seat.point(Pos2::new(600.0, 300.0));
    (0..8).for_each(|_| seat.act(Action::Wheel([0.0, 1.0])));
    seat.frame(vec![], vec![]);
    assert!(seat.texts(notice).is_empty() && vertices(&seat) < 150_000, "{}", vertices(&seat));
}

#[test]
fn a_new_gradient_mesh_is_made_and_saved_under_a_name() {
    let folder = Folder::new("gradient-new");
    let mut seat = Seat::new(Editor::fresh("quad"), Some(folder.0.clone()));
    seat.key("Ctrl+N");
    seat.settle();
    seat.press_text("patches");
    seat.settle();
    assert_eq!((seat.gradient().mesh.live().count(), seat.editor.unsaved()), (15, false));
    seat.drag(DVec2::ONE, DVec2::new(1.1, 1.1));
    // Its journal goes where those of unsaved scenes are.
    assert!(seat.gradient().journal().unwrap().starts_with(&folder.0));
    seat.key("Ctrl+S");
    match &mut seat.editor.dialog {
        Some(Dialog::Browse { wanted: Wanted::Save, name, folder: place, .. }) => {
            assert_eq!(name, "untitled.json");
            place.clone_from(&folder.0);
        }
        _ => panic!("no question for a name"),
    }
    seat.settle();
    seat.key("Enter");
    let saved = parse(&std::fs::read(folder.0.join("untitled.json")).unwrap(), "x").unwrap().0;
    assert_eq!(write(&saved), write(&seat.gradient().mesh));
    assert!(left_behind(None, Some(&folder.0)).is_empty());
}
