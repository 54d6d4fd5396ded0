//! The study of pictures in numbers, for a program to read.

use crate::pictures::record::{FrameSeries, Frames};
use crate::record::{Header, Records};
use serde::Serialize;

use super::select::{series, speed};

/// The study of pictures in a screenful.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureSummary {
    /// Who studied, where and how.
    pub header: Header,
    /// The picture that the speed is wanted of.
    pub goal: Option<TimedFrame>,
    /// Every size at every level.
    pub sizes: Vec<TimedFrame>,
    /// From the plain tracer on, what each technique gains.
    pub techniques: Vec<Technique>,
}

/// A picture and its speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimedFrame {
    /// The level.
    pub name: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples of a pixel.
    pub samples: u32,
    /// How often a ray may be reflected.
    pub depth: u32,
    /// Lights.
    pub lights: usize,
    /// Threads.
    pub threads: usize,
    /// Median frames per second.
    pub frames_per_second: f64,
}

/// A technique and what it gains.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Technique {
    /// Its name.
    pub name: String,
    /// The method then in use.
    pub method: String,
    /// Threads then in use.
    pub threads: usize,
    /// Frames per second with it and all before it.
    pub frames_per_second: f64,
    /// Speed over that without it.
    pub gain: f64,
    /// Speed over that of the plain tracer: the product of all gains so far.
    pub together: f64,
}

/// Sums up what was studied.
pub fn picture_summary(records: &Records) -> PictureSummary {
    let mut techniques: Vec<Technique> = Vec::new();
    for frames in series(records, FrameSeries::Techniques) {
        let Some(frames_per_second) = speed(frames) else { continue };
        let gain = techniques.last().map_or(1.0, |last| frames_per_second / last.frames_per_second);
        let together = techniques.last().map_or(1.0, |last| last.together) * gain;
        techniques.push(Technique {
            name: frames.name.clone(),
            method: frames.method.clone(),
            threads: frames.threads,
            frames_per_second,
            gain,
            together,
        });
    }
    PictureSummary {
        header: records.header.clone(),
        goal: series(records, FrameSeries::Goal).find_map(timed),
        sizes: series(records, FrameSeries::Sizes).filter_map(timed).collect(),
        techniques,
    }
}

fn timed(frames: &Frames) -> Option<TimedFrame> {
    let Frames { name, width, height, samples, depth, lights, threads, .. } = frames.clone();
    let frames_per_second = speed(frames)?;
    Some(TimedFrame { name, width, height, samples, depth, lights, threads, frames_per_second })
}

impl PictureSummary {
    /// The first picture of each level, in the record's order.
    pub(super) fn levels(&self) -> Vec<&TimedFrame> {
        let mut levels: Vec<&TimedFrame> = Vec::new();
        for frame in &self.sizes {
            if levels.iter().all(|level| level.name != frame.name) {
                levels.push(frame);
            }
        }
        levels
    }
}
