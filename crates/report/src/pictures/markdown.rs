//! Tables and findings of the study of pictures, for pages and documents alike.

use std::fmt::Write as _;

use trisect_harness::record::FrameSeries;

use super::summary::{TimedFrame, of_view};
use super::{series, speed};
use crate::format::{grouped, number, or_dash};
use crate::markdown::{Table, measured};
use crate::page::Finding;
use crate::view::View;

/// What was found, in words.
pub(crate) fn findings(view: &View) -> String {
    let mut text = String::new();
    for finding in all_findings(view) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "- **{}:** {}; {}.", finding.about, finding.says, finding.how);
    }
    let _ = writeln!(text, "\n{}", measured(view));
    text
}

/// All findings that the record has the numbers for.
pub(super) fn all_findings(view: &View) -> Vec<Finding> {
    let summary = of_view(view);
    let finding =
        |about: &str, says: String, how: String| Finding { about: about.into(), says, how };
    let goal = summary.goal.as_ref().map(|goal| {
        finding(
            "The mirror scene",
            format!("{} frames per second", number(goal.frames_per_second)),
            format!(
                "{} by {} pixels, {} sample, {} light, depth {}, on {} threads, by Möller–Trumbore",
                goal.width, goal.height, goal.samples, goal.lights, goal.depth, goal.threads
            ),
        )
    });
    let techniques = summary.techniques.last().map(|last| {
        let gains = summary.techniques.iter().skip(1);
        let gains: Vec<String> =
            gains.map(|technique| format!("{} {:.2}", technique.name, technique.gain)).collect();
        finding(
            "All techniques together",
            format!("{} times as fast as the plain tracer", number(last.together)),
            format!("multiplied up: {}; the kernel is that of {}", gains.join(", "), last.method),
        )
    });
    let ends = |which: FrameSeries| {
        let mut all = series(view, which).filter_map(speed);
        let first = all.next()?;
        Some((first, all.last()?))
    };
    let threads = ends(FrameSeries::Threads).map(|(one, all)| {
        finding(
            "Threads",
            format!("{:.2} times as fast as one", all / one),
            "on all of them".to_owned(),
        )
    });
    let depth = ends(FrameSeries::Depth).map(|(none, all)| {
        finding(
            "Reflections",
            format!("{:.2} times the time without", none / all),
            "of the mirror scene to depth 16".to_owned(),
        )
    });
    [goal, techniques, threads, depth].into_iter().flatten().collect()
}

/// A row per size, a column per level.
pub(crate) fn sizes(view: &View) -> Table {
    let summary = of_view(view);
    let levels = summary.levels();
    let mut table = Table::new(&["size"]);
    table.head.extend(levels.iter().map(|TimedFrame { name, samples, depth, lights, .. }| {
        format!("{name} {samples}/{depth}/{lights}")
    }));
    table.rows = summary.by_size(&levels, "×");
    table
}

/// What the columns of [`sizes`] mean.
pub(crate) const SIZES: &str = "Frames per second of the mirror scene, on all threads, by \
    Möller–Trumbore. After each level: samples of a pixel (on a circle), how often a ray may be \
    reflected, lights.";

/// A row per technique.
pub(crate) fn techniques(view: &View) -> Table {
    let mut table = Table::new(&["technique", "method", "threads", "frames/s", "gain", "together"]);
    for technique in of_view(view).techniques {
        table.rows.push(vec![
            technique.name,
            technique.method,
            technique.threads.to_string(),
            number(technique.frames_per_second),
            format!("{:.2}", technique.gain),
            number(technique.together),
        ]);
    }
    table
}

/// What the columns of [`techniques`] mean.
pub(crate) fn techniques_say(view: &View) -> String {
    format!(
        "{}, from a tracer that tests every triangle, one number at a time, on one thread. Each row adds \
         one technique to those above: a tree, lanes of SIMD, threads, and the fastest method of those \
         studied. gain: speed over the row above; together: the product of all gains so far.",
        scene_of(view, FrameSeries::Techniques)
    )
}

/// What the pictures of a series have in common.
pub(super) fn scene_of(view: &View, which: FrameSeries) -> String {
    let (mut size, mut depth) = (String::new(), 0);
    if let Some(frames) = series(view, which).next() {
        size = format!(" at {} by {}", frames.width, frames.height);
        depth = frames.depth;
    }
    format!("The mirror scene{size}, one sample, one light, depth {depth}")
}

/// A row per thing and value.
pub(crate) fn one_at_a_time(view: &View) -> Table {
    let mut table = Table::new(&["what", "frames/s", "rays", "million rays/s"]);
    for (which, says) in super::figures::SERIES {
        for frames in series(view, which) {
            let speed = speed(frames);
            table.rows.push(vec![
                format!("{says}: {}", frames.name),
                or_dash(speed, number),
                grouped(frames.rays),
                or_dash(speed.map(|speed| speed * frames.rays as f64 / 1e6), number),
            ]);
        }
    }
    table
}

/// What the columns of [`one_at_a_time`] mean.
pub(super) fn one_at_a_time_says(view: &View) -> String {
    format!(
        "{}, all threads, tiles of 64, leaves where they are the cheapest: each row changes one of these. \
         rays: of one picture, from the camera, reflected, and to lights.",
        scene_of(view, FrameSeries::Threads)
    )
}
