//! The scene as a file: opened, restored, saved, closed.

use super::super::canvas::Hand;
use super::super::dialog::{Dialog, LeftBehind};
use super::super::surface_journal;
use super::Editor;
use crate::edit::history::History;
use crate::edit::model::Model;
use crate::edit::{gradient, journal};
use crate::scene::Scene;
use std::path::{Path, PathBuf};

impl Editor {
    /// Takes another scene in place of the one at hand.
    pub fn take(&mut self, scene: Scene, file: Option<PathBuf>) -> bool {
        match Model::new(scene, self.model.drawing) {
            Ok(mut model) => {
                model.revision = self.model.revision + 1;
                self.model = model;
            }
            Err(e) => {
                self.fail(format_args!("{}: {e}", file.as_deref().unwrap_or(Path::new("scene")).display()));
                return false;
            }
        }
        if let Some(journal) = self.journal.take() {
            journal.end();
        }
        if let Some(mut solid) = self.solid.take() {
            solid.end_journal();
        }
        if let Some(mut gradient) = self.gradient.take() {
            gradient.end_journal();
            self.forget_drawn();
        }
        self.file = file;
        self.history = History::default();
        self.saved_at = Some(0);
        self.gesture = None;
        self.selection.clear();
        self.hand = Hand::default();
        (self.overlay, self.influence) = (None, None);
        self.fit_next = true;
        let folder = self.folder();
        let lost = self.reference.follow(&self.model.scene, &folder);
        if let Some(lost) = lost {
            self.fail(lost);
        }
        true
    }

    /// Folder that relative names in the scene count from.
    pub fn folder(&self) -> PathBuf {
        self.file.as_deref().and_then(Path::parent).map(Path::to_path_buf).unwrap_or_default()
    }

    /// Opens a scene; offers what a crashed session of it has left.
    pub fn open(&mut self, file: &Path) {
        if self.open_gradient(file) {
            if self.gradient.is_some() && self.file.as_deref() == Some(file) {
                self.remember(file);
            }
            return self.offer_left_behind(Some(file));
        }
        if self.open_surface(file) {
            if self.solid.is_some() && self.file.as_deref() == Some(file) {
                self.remember(file);
            }
            return self.offer_left_behind(Some(file));
        }
        match Scene::load(file) {
            Ok(scene) => {
                self.message = None;
                if self.take(scene, Some(file.to_path_buf())) {
                    self.remember(file);
                    if self.message.is_none() {
                        self.say(format_args!("opened {}", file.display()));
                    }
                }
            }
            Err(e) => self.fail(e),
        }
        self.offer_left_behind(Some(file));
    }

    /// Offers the newest journal that a crashed session of `file` has left.
    pub fn offer_left_behind(&mut self, file: Option<&Path>) {
        if let Some(path) = journal::left_behind(file, self.state.as_deref()).into_iter().next() {
            match LeftBehind::read(&path) {
                Ok(left) if left.about().2 > 0 => self.dialog = Some(Dialog::Restore(Some(left))),
                // A session that ended before its first step was whole has left nothing to restore.
                Ok(_) => drop(std::fs::remove_file(&path)),
                Err(e) => self.fail(e),
            }
        }
    }

    /// Goes on where a crashed session stopped.
    pub fn resume(&mut self, left: LeftBehind) {
        // The restored scene begins a journal of its own before the old one goes.
        let (path, kept) = match left {
            LeftBehind::Scene(restored) => {
                let journal::Restored { path, file, scene, history, .. } = *restored;
                if !self.take(scene, file) {
                    return;
                }
                self.history = history;
                self.saved_at = None;
                self.start_journal(&self.model.scene.clone());
                (path, self.journal.is_some())
            }
            LeftBehind::Gradient(restored) => {
                let gradient::journal::Restored { path, file, gradient, .. } = *restored;
                if !self.take_gradient(gradient, file) {
                    return;
                }
                self.tick();
                (path, self.gradient.as_ref().is_some_and(|g| g.journal().is_some()))
            }
            LeftBehind::Surface(restored) => {
                let surface_journal::Restored { path, file, solid, .. } = *restored;
                if !self.take_surface(solid, file) {
                    return;
                }
                self.tick();
                (path, self.solid.as_ref().is_some_and(|s| s.journal().is_some()))
            }
        };
        match kept {
            true => drop(std::fs::remove_file(path)),
            false => self.fail("the restored scene has no journal; save it soon"),
        }
        if self.message.as_ref().is_none_or(|m| !m.error) {
            self.say("restored the last session");
        }
    }

    /// Writes the scene; `true`: it is on the disk.
    pub fn save(&mut self, file: &Path) -> bool {
        if self.gradient.is_some() {
            let done = self.save_gradient(file);
            if done {
                self.remember(file);
            }
            return done;
        }
        if self.solid.is_some() {
            let done = self.save_surface(file);
            if done {
                self.remember(file);
            }
            return done;
        }
        self.commit();
        self.carry_reference(file);
        let obj = file.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
        let done = if obj { self.model.scene.save_authors(file) } else { self.model.scene.save(file).map(|()| vec![]) };
        match done {
            Ok(losses) => {
                if let Some(journal) = self.journal.take() {
                    journal.end();
                }
                self.saved_at = Some(self.history.position());
                self.file = Some(file.to_path_buf());
                self.remember(file);
                match losses.first() {
                    Some(loss) => self.fail(format_args!("saved, but {loss}")),
                    None => self.say(format_args!("saved {}", file.display())),
                }
                true
            }
            Err(e) => {
                self.fail(e);
                false
            }
        }
    }

    /// Names the reference picture anew when the scene goes to another folder, from which its name would count.
    fn carry_reference(&mut self, file: &Path) {
        let whole = |p: &Path| std::path::absolute(p).unwrap_or_else(|_| p.to_path_buf());
        let (old, new) = (whole(&self.folder()), whole(file.parent().unwrap_or(Path::new(""))));
        let Some(r) = &self.model.scene.reference else { return };
        if old == new || Path::new(&r.file).is_absolute() {
            return;
        }
        let there = old.join(&r.file);
        let name = there.strip_prefix(&new).map_or_else(|_| there.clone(), Path::to_path_buf);
        let name = name.to_string_lossy().into_owned();
        self.change("name of the reference picture", |scene, _| {
            if let Some(r) = &mut scene.reference {
                r.file = name;
            }
            Ok(())
        });
    }

    fn remember(&mut self, file: &Path) {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        self.recent.retain(|f| *f != file);
        self.recent.insert(0, file);
        self.recent.truncate(12);
        super::super::files::write_recent(self.state.as_deref(), &self.recent);
    }

    /// The journal as it should be left when the window closes: none where everything is saved or given up.
    pub fn close(&mut self, give_up: bool) -> Option<PathBuf> {
        self.commit();
        let keep = self.unsaved() && !give_up;
        if self.gradient.is_some() {
            // What was done last is on the disk before the window goes.
            self.tick();
            let gradient = self.gradient.as_mut()?;
            let path = gradient.journal().map(Path::to_path_buf).filter(|_| keep);
            if !keep {
                gradient.end_journal();
            }
            return path;
        }
        if self.solid.is_some() {
            self.tick();
            let solid = self.solid.as_mut()?;
            let path = solid.journal().map(Path::to_path_buf).filter(|_| keep);
            if !keep {
                solid.end_journal();
            }
            return path;
        }
        match self.journal.take() {
            Some(journal) if keep => Some(journal.path().to_path_buf()),
            Some(journal) => {
                journal.end();
                None
            }
            None => None,
        }
    }
}
