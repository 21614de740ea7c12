//! `gradtess edit`: the editor's window, by hand or by a script.

use super::{picture::size, Failure, Global};
use crate::app::{self, AppError, Launch};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `edit`.
#[derive(Args)]
#[command(
    after_help = "A script is one JSON object a line: {\"at\": SECONDS, \"ACTION\": VALUE}. Actions: move [x, y] (points \
    of the window), aim [x, y] (model coordinates), aim_at [x, y, z] (the same in space), down, up (\"left\", \"middle\", \"right\"), wheel [x, y], key, hold, \
    release (\"Ctrl+Z\"), modifiers (\"Shift\"), text, paste, copy, drop (a file), resize [w, h], minimise, suspend, close, \
    screenshot (a name), wait (real seconds). Actions of one time go into one frame; lines that begin with # are remarks."
)]
pub struct Edit {
    /// Scene file; a new scene unless given
    scene: Option<PathBuf>,
    /// Replay recorded input, then close the window
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// Real seconds that a second of the script takes; 0: as fast as it goes
    #[arg(long, value_name = "S", default_value_t = 0.0, requires = "script")]
    pace: f64,
    /// Keep the window open when the script ends
    #[arg(long, requires = "script")]
    stay: bool,
    /// Folder for the script's screenshots
    #[arg(long, value_name = "DIR", default_value = ".", requires = "script")]
    screenshots: PathBuf,
    /// Record input to a script
    #[arg(long, value_name = "FILE", conflicts_with = "script")]
    record: Option<PathBuf>,
    /// Width and height of the window, points
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x800")]
    size: [u32; 2],
    /// Show the window through a surface format that converts to sRGB, as on devices that have no other
    #[arg(long, hide = true)]
    srgb_surface: bool,
}

impl Edit {
    /// Opens the window and waits until it closes.
    pub fn run(&self, global: &Global) -> Result<(), Failure> {
        if !(self.pace >= 0.0 && self.pace <= 1000.0) {
            return Err(Failure::input("--pace is a number from 0"));
        }
        if self.script.is_some() && !self.screenshots.is_dir() {
            let folder = self.screenshots.display();
            return Err(Failure::input(format_args!("{folder}: this folder does not exist; make it first")));
        }
        let launch = Launch {
            scene: self.scene.clone(),
            script: self.script.clone(),
            pace: self.pace,
            stay: self.stay,
            screenshots: self.screenshots.clone(),
            record: self.record.clone(),
            size: self.size.map(|x| x as f32),
            gpu: global.gpu(),
            converting: self.srgb_surface,
        };
        let ended = app::run(launch).map_err(|e| match e {
            AppError::Script(what) => Failure::input(what),
            AppError::Gpu(e) => e.into(),
            AppError::Window(what) => Failure::machine(what),
            e @ AppError::Validation(_) => Failure::machine(e),
        })?;
        if let (true, Some(report)) = (global.json, &ended.report) {
            super::print_json(report)?;
        }
        match ended.journal {
            // The window system took the window away before anybody could be asked. A script has its end.
            Some(journal) if self.script.is_none() || self.stay => Err(Failure::machine(format_args!(
                "{}: the unsaved work is in this journal; open the scene to restore it",
                journal.display()
            ))),
            _ => Ok(()),
        }
    }
}
