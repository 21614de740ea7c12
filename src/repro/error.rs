//! Why a figure was not made.

use crate::image::ImageError;
use crate::scene::SceneError;
use thiserror::Error;

/// What went wrong.
#[derive(Debug, Error)]
pub enum ReproError {
    /// A command of the figure failed.
    #[error("{command}: {message}")]
    Command {
        /// The command as it is printed.
        command: String,
        /// Its exit status: 1 the machine failed, 2 the input is wrong.
        status: u8,
        /// Its message.
        message: String,
    },
    /// A file or folder could not be read or written.
    #[error("{file}: {source}")]
    File {
        /// Its path.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// A scene could not be read, or a file not be written.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A picture could not be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The request makes no sense.
    #[error("{0}")]
    Request(String),
    /// A figure was made of something unexpected.
    #[error("{0}")]
    Figure(String),
}

impl ReproError {
    /// A file error of `path`.
    pub fn file(path: &std::path::Path, source: std::io::Error) -> ReproError {
        ReproError::File { file: path.display().to_string(), source }
    }

    /// True for errors in what the user gave.
    pub fn is_request(&self) -> bool {
        match self {
            ReproError::Command { status, .. } => *status == 2,
            ReproError::Request(_) => true,
            ReproError::Scene(e) => !e.is_machine_failure(),
            _ => false,
        }
    }
}
