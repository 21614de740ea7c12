//! A script in place of the window's own input.

use super::super::dialog::Then;
use super::super::script::{Action, Keyboard, Timed};
use super::super::surface::Eye;
use super::super::view::View;
use super::{Shell, SETTLING};
use egui::{Context, RawInput};
use glam::DVec3;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A script that is replayed.
pub struct Replay {
    /// What is left of it.
    pub waiting: VecDeque<Timed>,
    /// Real seconds a second of the script; 0: as fast as it goes.
    pub pace: f64,
    /// Where screenshots go.
    pub folder: PathBuf,
    /// Whether the window closes at the end.
    pub ends: bool,
    pub(super) keyboard: Keyboard,
    pub(super) begun: Option<Instant>,
    pub(super) now: f64,
    pub(super) settle: u32,
    pub(super) wait_until: Option<Instant>,
    pub(super) shot: Option<String>,
    pub(super) shooting: bool,
}

impl Replay {
    /// From the beginning.
    pub fn new(script: Vec<Timed>, pace: f64, folder: PathBuf, ends: bool) -> Replay {
        Replay {
            waiting: script.into(),
            pace,
            folder,
            ends,
            keyboard: Keyboard::default(),
            begun: None,
            now: 0.0,
            settle: SETTLING,
            wait_until: None,
            shot: None,
            shooting: false,
        }
    }
}

impl Replay {
    /// Adds an action to the input; `false`: it is none, but something that happens to the window.
    fn keyboard_takes(&mut self, action: &Action, view: View, eye: Option<Eye>, raw: &mut RawInput) -> bool {
        match action {
            Action::AimAt(p) => {
                if let Some((to, _)) = eye.and_then(|eye| eye.place(DVec3::from_array(*p))) {
                    let aim = |_| to;
                    self.keyboard.events(&Action::Aim([0.0; 2]), aim, &mut raw.events);
                }
            }
            Action::Screenshot(_)
            | Action::Wait(_)
            | Action::Resize(_)
            | Action::Minimise(_)
            | Action::Suspend(_)
            | Action::Close(_) => {
                return false;
            }
            Action::Drop(path) => raw
                .dropped_files
                .push(egui::DroppedFile { path: Some(PathBuf::from(path)), ..egui::DroppedFile::default() }),
            action => {
                let aim = |[x, y]: [f64; 2]| view.to_window(glam::DVec2::new(x, y));
                self.keyboard.events(action, aim, &mut raw.events);
            }
        }
        true
    }
}

impl Shell {
    /// Puts the script in place of the window's own input; `None`: nothing happens yet.
    pub(super) fn scripted(&mut self, outer: &Context, mut raw: RawInput) -> Option<RawInput> {
        let view = self.editor.view;
        let eye = self.editor.solid.as_ref().map(|solid| solid.eye(view.rect));
        let replay = self.replay.as_mut()?;
        raw.events.clear();
        raw.dropped_files.clear();
        raw.hovered_files.clear();
        raw.focused = true;
        let begun = *replay.begun.get_or_insert_with(Instant::now);
        if replay.wait_until.is_some_and(|t| Instant::now() < t) {
            return None;
        }
        replay.wait_until = None;
        if replay.shot.is_some() {
            // Until the picture is written.
            replay.shooting = replay.settle == 0;
            replay.settle = replay.settle.saturating_sub(1);
        } else if replay.settle > 0 {
            replay.settle -= 1;
        } else if let Some(next) = replay.waiting.front() {
            let at = next.at;
            if replay.pace > 0.0 && begun.elapsed().as_secs_f64() < at * replay.pace {
                return None;
            }
            replay.now = replay.now.max(at);
            while replay.waiting.front().is_some_and(|n| n.at == at) {
                let Some(Timed { action, .. }) = replay.waiting.pop_front() else { break };
                let alone = !replay.keyboard_takes(&action, view, eye, &mut raw);
                if alone {
                    self.do_alone(outer, action);
                    break;
                }
            }
        } else if replay.ends {
            self.finish(None);
            return None;
        } else {
            // From here on a person has the window.
            self.replay = None;
            self.inner.style_mut(|style| style.animation_time = egui::Style::default().animation_time);
            return None;
        }
        let replay = self.replay.as_ref()?;
        raw.modifiers = replay.keyboard.held();
        raw.time = Some(replay.now);
        raw.predicted_dt = 1.0 / 60.0;
        Some(raw)
    }

    /// Actions that are no input but happen to the window.
    fn do_alone(&mut self, outer: &Context, action: Action) {
        let Some(replay) = &mut self.replay else { return };
        replay.settle = SETTLING;
        match action {
            Action::Screenshot(name) => replay.shot = Some(name),
            Action::Wait(seconds) => {
                replay.wait_until = Some(Instant::now() + Duration::from_secs_f64(seconds.clamp(0.0, 3600.0)));
            }
            Action::Resize([w, h]) => {
                let size = egui::vec2(w.clamp(64.0, 16384.0), h.clamp(64.0, 16384.0));
                let scale = self.native_scale / outer.pixels_per_point();
                outer.send_viewport_cmd(egui::ViewportCommand::InnerSize(size * scale));
                // Until the window has it.
                replay.wait_until = Some(Instant::now() + Duration::from_millis(150));
            }
            Action::Minimise(on) => {
                outer.send_viewport_cmd(egui::ViewportCommand::Minimized(on));
                replay.wait_until = Some(Instant::now() + Duration::from_millis(100));
            }
            Action::Suspend(on) => self.suspend(on),
            Action::Close(_) => self.editor.ask_first(Then::Quit),
            _ => {}
        }
    }
}
