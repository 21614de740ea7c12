//! Recorded input: one JSON object a line, each with the time it happened and what it was.
//!
//! ```text
//! {"at":0,"resize":[1280,800]}
//! {"at":0.5,"move":[640,400]}          points of the window; "aim" takes model coordinates instead
//! {"at":0.6,"down":"left"}             "up" likewise; left, middle or right
//! {"at":0.8,"key":"Ctrl+Z"}            pressed and released
//! {"at":1.0,"screenshot":"a"}          writes a.png
//! ```
//!
//! The events of one time go into one frame, as they came. A replay hands them to the very input queue that a mouse and
//! a keyboard fill, with these times as its clock, so that one script makes one scene, byte for byte.

use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Vec2};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Something that happens at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timed {
    /// Seconds since the beginning.
    pub at: f64,
    /// What.
    #[serde(flatten)]
    pub action: Action,
}

/// What can happen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// The pointer goes to a place of the window, points from the top left.
    Move([f32; 2]),
    /// The pointer goes over a place of the model.
    Aim([f64; 2]),
    /// The pointer goes over a place of a surface in space.
    AimAt([f64; 3]),
    /// The pointer leaves the window.
    Leave(bool),
    /// A button goes down.
    Down(Button),
    /// A button comes up.
    Up(Button),
    /// Steps of the wheel, across and up.
    Wheel([f32; 2]),
    /// A key with its modifiers goes down and up: `Ctrl+Shift+Z`.
    Key(String),
    /// A key goes down and stays.
    Hold(String),
    /// A key comes up.
    Release(String),
    /// Modifiers that are held from now on: `Shift`, `Ctrl+Alt`, or nothing.
    Modifiers(String),
    /// Text is typed.
    Text(String),
    /// Text is pasted.
    Paste(String),
    /// Copy.
    Copy(bool),
    /// A file is dropped on the window.
    Drop(String),
    /// The window gets another size, points.
    Resize([f32; 2]),
    /// The window is minimised, or comes back.
    Minimise(bool),
    /// The system takes the window's pixels away, or gives them back.
    Suspend(bool),
    /// The window's close button.
    Close(bool),
    /// The window is written to NAME.png once this frame is drawn.
    Screenshot(String),
    /// Real seconds go by.
    Wait(f64),
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Button {
    /// The main one.
    Left,
    /// The wheel.
    Middle,
    /// The other one.
    Right,
}

impl From<Button> for PointerButton {
    fn from(button: Button) -> PointerButton {
        match button {
            Button::Left => PointerButton::Primary,
            Button::Middle => PointerButton::Middle,
            Button::Right => PointerButton::Secondary,
        }
    }
}

/// Reads a script.
///
/// # Errors
/// One line that names file, line and column.
pub fn load(path: &Path) -> Result<Vec<Timed>, String> {
    let bytes = crate::scene::read_bounded(path).map_err(|e| e.to_string())?;
    let text = String::from_utf8(bytes)
        .map_err(|_| format!("{}:1:1: this is not UTF-8; write the script as text", path.display()))?;
    parse(&text).map_err(|(line, column, what)| {
        format!("{}:{line}:{column}: {what}; see `gradtess edit --help` for what a script holds", path.display())
    })
}

/// Reads the lines of a script; empty ones and those that begin with `#` are left out.
///
/// # Errors
/// Line, column and what is wrong.
pub fn parse(text: &str) -> Result<Vec<Timed>, (usize, usize, String)> {
    let mut all: Vec<Timed> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let fault = |column, what: String| (number + 1, column, what);
        let timed: Timed = serde_json::from_str(line).map_err(|e| {
            let what = e.to_string();
            fault(e.column().max(1), what.split(" at line").next().unwrap_or(&what).to_owned())
        })?;
        let late = all.last().is_none_or(|before| timed.at >= before.at);
        if !timed.at.is_finite() || timed.at < 0.0 || !late {
            return Err(fault(1, format!("the time {} comes before the one above", timed.at)));
        }
        if let Action::Key(name) | Action::Hold(name) | Action::Release(name) = &timed.action {
            key(name).map_err(|what| fault(1, what))?;
        }
        if let Action::Modifiers(name) = &timed.action {
            modifiers(name).map_err(|what| fault(1, what))?;
        }
        let numbers: &[f64] = match &timed.action {
            Action::Move(p) | Action::Wheel(p) | Action::Resize(p) => &[f64::from(p[0]), f64::from(p[1])],
            Action::Aim(p) => p,
            Action::AimAt(p) => p,
            Action::Wait(s) => &[*s],
            _ => &[],
        };
        if numbers.iter().any(|x| !x.is_finite() || x.abs() > 1e9) {
            return Err(fault(1, "a number is out of range".to_owned()));
        }
        all.push(timed);
    }
    Ok(all)
}

/// A line of a script.
pub fn line(at: f64, action: &Action) -> String {
    serde_json::to_string(&Timed { at, action: action.clone() }).unwrap_or_default() + "\n"
}

/// Modifiers by name: `Ctrl+Shift`.
fn modifiers(name: &str) -> Result<Modifiers, String> {
    let mut out = Modifiers::NONE;
    for part in name.split('+').map(str::trim).filter(|p| !p.is_empty()) {
        match part {
            "Ctrl" => (out.ctrl, out.command) = (true, true),
            "Shift" => out.shift = true,
            "Alt" => out.alt = true,
            _ => return Err(format!("there is no modifier {part:?}; use Ctrl, Shift and Alt")),
        }
    }
    Ok(out)
}

fn modifier_names(m: Modifiers) -> String {
    let names = [(m.ctrl || m.command, "Ctrl"), (m.shift, "Shift"), (m.alt, "Alt")];
    names.iter().filter(|n| n.0).map(|n| n.1).collect::<Vec<_>>().join("+")
}

/// A key by name with its modifiers: `Ctrl+Z`.
fn key(name: &str) -> Result<(Modifiers, Key), String> {
    let (before, last) = match name.rsplit_once('+') {
        Some((before, last)) if !last.is_empty() => (before, last),
        _ => ("", name),
    };
    let key = Key::from_name(last).ok_or_else(|| format!("there is no key {last:?}"))?;
    Ok((modifiers(before)?, key))
}

/// Turns actions into the window system's events and keeps what lies between them: the pointer and the modifiers.
#[derive(Clone, Debug, Default)]
pub struct Keyboard {
    pointer: Pos2,
    held: Modifiers,
}

impl Keyboard {
    /// Modifiers held at the moment.
    pub fn held(&self) -> Modifiers {
        self.held
    }

    /// Adds the events of an action; `aim` turns model coordinates into points of the window.
    pub fn events(&mut self, action: &Action, aim: impl Fn([f64; 2]) -> Pos2, out: &mut Vec<Event>) {
        let button = |button: Button, pressed, pos, modifiers| Event::PointerButton {
            pos,
            button: button.into(),
            pressed,
            modifiers,
        };
        match action {
            Action::Move(p) => {
                self.pointer = Pos2::new(p[0], p[1]);
                out.push(Event::PointerMoved(self.pointer));
            }
            Action::Aim(p) => {
                self.pointer = aim(*p);
                out.push(Event::PointerMoved(self.pointer));
            }
            Action::Leave(_) => out.push(Event::PointerGone),
            Action::Down(b) => out.push(button(*b, true, self.pointer, self.held)),
            Action::Up(b) => out.push(button(*b, false, self.pointer, self.held)),
            Action::Wheel(d) => out.push(Event::MouseWheel {
                unit: MouseWheelUnit::Line,
                delta: Vec2::new(d[0], d[1]),
                modifiers: self.held,
            }),
            Action::Key(name) => {
                self.press(name, true, out);
                self.press(name, false, out);
            }
            Action::Hold(name) => self.press(name, true, out),
            Action::Release(name) => self.press(name, false, out),
            Action::Modifiers(name) => self.held = modifiers(name).unwrap_or_default(),
            Action::Text(text) => out.push(Event::Text(text.clone())),
            Action::Paste(text) => out.push(Event::Paste(text.clone())),
            Action::Copy(_) => out.push(Event::Copy),
            _ => {}
        }
    }

    fn press(&self, name: &str, pressed: bool, out: &mut Vec<Event>) {
        if let Ok((modifiers, key)) = key(name) {
            let modifiers = modifiers | self.held;
            out.push(Event::Key { key, physical_key: None, pressed, repeat: false, modifiers });
        }
    }
}

/// The actions that stand for events of the window system, for a recording. What a replay cannot use (touch, input
/// methods, and the scrolling that the wheel's own event stands for) is left out.
pub fn actions(events: &[Event], held: &mut Modifiers) -> Vec<Action> {
    let mut out = Vec::new();
    let button = |button: &PointerButton| match button {
        PointerButton::Primary => Some(Button::Left),
        PointerButton::Middle => Some(Button::Middle),
        PointerButton::Secondary => Some(Button::Right),
        _ => None,
    };
    for event in events {
        let with = match event {
            Event::PointerButton { modifiers, .. } | Event::MouseWheel { modifiers, .. } => Some(*modifiers),
            _ => None,
        };
        if let Some(modifiers) = with.filter(|m| modifier_names(*m) != modifier_names(*held)) {
            *held = modifiers;
            out.push(Action::Modifiers(modifier_names(modifiers)));
        }
        out.extend(match event {
            Event::PointerMoved(p) => Some(Action::Move([p.x, p.y])),
            Event::PointerGone => Some(Action::Leave(true)),
            Event::PointerButton { pos: _, button: b, pressed: true, .. } => button(b).map(Action::Down),
            Event::PointerButton { button: b, pressed: false, .. } => button(b).map(Action::Up),
            Event::MouseWheel { unit, delta, .. } => {
                let lines = if *unit == MouseWheelUnit::Point { *delta / 50.0 } else { *delta };
                Some(Action::Wheel([lines.x, lines.y]))
            }
            Event::Key { key, pressed, modifiers, .. } => {
                let names = modifier_names(*modifiers);
                let name = if names.is_empty() { key.name().to_owned() } else { format!("{names}+{}", key.name()) };
                // Some keys have signs for names that only people read.
                let known = self::key(&name).is_ok();
                known.then_some(if *pressed { Action::Hold(name) } else { Action::Release(name) })
            }
            Event::Text(text) => Some(Action::Text(text.clone())),
            Event::Paste(text) => Some(Action::Paste(text.clone())),
            Event::Copy | Event::Cut => Some(Action::Copy(true)),
            _ => None,
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_recorded_replays_as_the_same_events() {
        let text = r#"
            {"at":0,"resize":[800,600]}
            {"at":0.1,"move":[10.5,20]}
            {"at":0.1,"modifiers":"Ctrl+Shift"}
            {"at":0.2,"down":"left"}
            {"at":0.3,"up":"left"}
            {"at":0.3,"modifiers":""}
            # a remark
            {"at":0.4,"hold":"Ctrl+Shift+Z"}
            {"at":0.4,"release":"Ctrl+Shift+Z"}
            {"at":0.5,"text":"a"}
        "#;
        let script = parse(text).unwrap();
        let mut keyboard = Keyboard::default();
        let mut events = Vec::new();
        for timed in &script {
            keyboard.events(&timed.action, |_| Pos2::ZERO, &mut events);
        }
        let mut held = Modifiers::NONE;
        let recorded = actions(&events, &mut held);
        let mut again = Vec::new();
        let mut keyboard = Keyboard::default();
        for action in &recorded {
            keyboard.events(action, |_| Pos2::ZERO, &mut again);
        }
        assert_eq!(events, again);
        assert!(events.len() == 6, "{events:?}");
        // And as text.
        let written: String = script.iter().map(|t| line(t.at, &t.action)).collect();
        assert_eq!(parse(&written).unwrap(), script);
    }

    #[test]
    fn faults_have_their_place() {
        for (text, place) in [
            ("{\"at\":0,\"jump\":1}", 1),
            ("{\"at\":1,\"wait\":1}\n{\"at\":0,\"wait\":1}", 2),
            ("{\"at\":0,\"key\":\"Ctrl+Nonsense\"}", 1),
            ("{\"at\":0,\"modifiers\":\"Hyper\"}", 1),
            ("\n\nnonsense", 3),
            ("{\"at\":-1,\"wait\":1}", 1),
            ("{\"at\":0,\"aim\":[1,1e300]}", 1),
            ("{\"wait\":1}", 1),
        ] {
            assert_eq!(parse(text).unwrap_err().0, place, "{text}");
        }
    }
}
