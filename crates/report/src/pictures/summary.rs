//! What a terminal prints after the study of pictures.

use serde::Serialize;
use trisect_harness::record::{FrameSeries, Frames, Header, Records};

use super::{series, speed};
use crate::format::{number, or_dash};
use crate::text::{Table, wrap};
use crate::view::View;

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
    of_view(&View::new(records))
}

fn timed(frames: &Frames) -> Option<TimedFrame> {
    let Frames { name, width, height, samples, depth, lights, threads, .. } = frames.clone();
    let frames_per_second = speed(frames)?;
    Some(TimedFrame { name, width, height, samples, depth, lights, threads, frames_per_second })
}

pub(super) fn of_view(view: &View) -> PictureSummary {
    let mut techniques: Vec<Technique> = Vec::new();
    for frames in series(view, FrameSeries::Techniques) {
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
        header: view.header.clone(),
        goal: series(view, FrameSeries::Goal).find_map(timed),
        sizes: series(view, FrameSeries::Sizes).filter_map(timed).collect(),
        techniques,
    }
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

    /// A row per size: its pixels with a sign between, and the frames per second of each level.
    pub(super) fn by_size(&self, levels: &[&TimedFrame], times: &str) -> Vec<Vec<String>> {
        let rows = self.sizes.chunk_by(|a, b| (a.width, a.height) == (b.width, b.height));
        let row = |frames: &[TimedFrame]| {
            let of_level = |level: &&TimedFrame| {
                let frame = frames.iter().find(|frame| frame.name == level.name);
                or_dash(frame.map(|frame| frame.frames_per_second), number)
            };
            let size = format!("{}{times}{}", frames[0].width, frames[0].height);
            std::iter::once(size).chain(levels.iter().map(of_level)).collect()
        };
        rows.map(row).collect()
    }

    /// The summary as text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        let h = &self.header;
        let machine = format!("trisect {} on {}, {}", h.trisect, h.machine.cpu, h.machine.compiler);
        let mut out = wrap(&machine, width, "  ");
        out.push('\n');
        if let Some(goal) = &self.goal {
            let says = format!(
                "The mirror scene at {} by {}, one sample, one light, depth {}: {} frames per second on \
                 {} thread(s).",
                goal.width,
                goal.height,
                goal.depth,
                number(goal.frames_per_second),
                goal.threads
            );
            out.push_str(&wrap(&says, width, ""));
            out.push('\n');
        }
        let levels = self.levels();
        let mut table = Table::new(&["frames/s"]);
        table.head.extend(levels.iter().map(|level| level.name.clone()));
        table.rows = self.by_size(&levels, "x");
        out.push_str(&table.render(width));
        out.push('\n');
        let mut table = Table::new(&["technique", "frames/s", "gain", "together"]);
        for technique in &self.techniques {
            table.rows.push(vec![
                technique.name.clone(),
                number(technique.frames_per_second),
                format!("{:.2}", technique.gain),
                number(technique.together),
            ]);
        }
        out.push_str(&table.render(width));
        out
    }
}
