//! How often, how long and in what order frames are measured.

use super::random::Random;
use serde::{Deserialize, Serialize};

/// The protocol of a run, as `run.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Protocol {
    /// Least number of frames before the timed ones, in every repeat.
    pub warmup_frames: u32,
    /// Least time they take, s. Both have to be reached.
    pub warmup_s: f64,
    /// Timed frames of a repeat; they carry no statistics queries.
    pub measure_frames: u32,
    /// Frames of the statistics pass of a repeat; they are not timed.
    pub stats_frames: u32,
    /// Repeats of every configuration.
    pub repeats: u32,
    /// Repeats that were finished when this was written.
    pub repeats_done: u32,
    /// How configurations follow each other.
    pub order: String,
    /// Seed of the order and of the bootstrap.
    pub seed: u64,
}

impl Default for Protocol {
    fn default() -> Self {
        Protocol {
            warmup_frames: 64,
            warmup_s: 1.0,
            measure_frames: 512,
            stats_frames: 8,
            repeats: 5,
            repeats_done: 0,
            order: ORDER.to_owned(),
            seed: 1,
        }
    }
}

/// What `Protocol::order` says.
pub const ORDER: &str = "repeats of all scenes in one shuffled list; the configurations of a scene take turns frame by frame, who begins is drawn for each pair";

impl Protocol {
    /// For smoke tests: runs everything, measures nothing.
    pub fn short() -> Self {
        Protocol { warmup_frames: 2, warmup_s: 0.0, measure_frames: 6, stats_frames: 2, repeats: 2, ..Self::default() }
    }

    /// (scene, repeat) in the order they are measured. Repeats of one scene stay in order; which scene comes next is
    /// drawn, so that no scene always has the warm machine.
    pub fn schedule(&self, scenes: usize, random: &mut Random) -> Vec<(usize, u32)> {
        let mut turns: Vec<usize> = (0..scenes).flat_map(|scene| vec![scene; self.repeats as usize]).collect();
        random.shuffle(&mut turns);
        let mut next = vec![0; scenes];
        turns
            .into_iter()
            .map(|scene| {
                next[scene] += 1;
                (scene, next[scene] - 1)
            })
            .collect()
    }
}

/// A protocol that cannot be followed.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum ProtocolError {
    /// Nothing would be measured.
    #[error("no frames or no repeats; give at least 1 of each")]
    Nothing,
    /// The warm-up is no time.
    #[error("the warm-up has to last 0 seconds or more")]
    Warmup,
}

impl Protocol {
    /// Checks the numbers.
    ///
    /// # Errors
    /// No frames or repeats, or a warm-up time that is negative or no number.
    pub fn check(&self) -> Result<(), ProtocolError> {
        if self.measure_frames == 0 || self.repeats == 0 {
            return Err(ProtocolError::Nothing);
        }
        if !(self.warmup_s.is_finite() && self.warmup_s >= 0.0) {
            return Err(ProtocolError::Warmup);
        }
        Ok(())
    }
}
