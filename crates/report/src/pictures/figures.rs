//! The figures of the study of pictures.

use trisect_harness::record::FrameSeries;

use super::markdown::scene_of;
use super::summary::{TimedFrame, of_view};
use super::{series, speed};
use crate::chart::{Axis, Drawing, Entry, Join, Look, Panel, Plane, Sample, Scale, Series};
use crate::figures::Figure;
use crate::format::tick;
use crate::view::View;

/// What is varied one at a time, and how it is called.
pub(super) const SERIES: [(FrameSeries, &str); 6] = [
    (FrameSeries::Threads, "threads"),
    (FrameSeries::Samples, "samples of a pixel"),
    (FrameSeries::Lights, "lights"),
    (FrameSeries::Depth, "depth"),
    (FrameSeries::Leaves, "triangles of a leaf, at most"),
    (FrameSeries::Tiles, "side of a tile, in pixels"),
];

/// All figures, in the order of the page.
pub(super) fn all(view: &View) -> Vec<Figure> {
    vec![sizes(view), one_at_a_time(view)]
}

fn nothing() -> String {
    "Left out: the record holds no pictures; make one with `trisect pictures`.".into()
}

fn line(number: usize, points: Vec<(f64, f64)>) -> Series {
    Series { look: Look::of(number), filled: true, join: Join::Straight, marked: true, points }
}

/// Frames per second against millions of pixels, a line for each level.
fn sizes(view: &View) -> Figure {
    let summary = of_view(view);
    let (frames, levels) = (&summary.sizes, summary.levels());
    let of_level = |(number, level): (usize, &&TimedFrame)| {
        let mine = frames.iter().filter(|frame| frame.name == level.name);
        let pixels = |width: u32, height: u32| f64::from(width) * f64::from(height) / 1e6;
        line(number, mine.map(|f| (pixels(f.width, f.height), f.frames_per_second)).collect())
    };
    let series: Vec<Series> = levels.iter().enumerate().map(of_level).collect();
    let points = || series.iter().flat_map(|series| &series.points);
    let panel = Plane {
        title: "Sizes".into(),
        x: Axis::over("million pixels", Scale::Log, points().map(|p| p.0), tick),
        y: Axis::over("frames per second", Scale::Log, points().map(|p| p.1), tick),
        height: 280,
        rules: Vec::new(),
        labels: Vec::new(),
        series,
    };
    let legend = levels.iter().enumerate().map(|(number, level)| Entry {
        sample: Sample::Point(Look::of(number), true),
        text: level.name.clone(),
    });
    Figure {
        name: "pictures-sizes",
        title: "Frames per second",
        caption: "The mirror scene, on all threads, from low to very hard: the table below says \
                  what each level is."
            .into(),
        drawing: if frames.is_empty() {
            Err(nothing())
        } else {
            Ok(Drawing { panels: vec![Panel::Plane(panel)], legend: legend.collect(), key: vec![] })
        },
    }
}

/// Frames per second against one thing after another.
fn one_at_a_time(view: &View) -> Figure {
    let panels: Vec<Panel> = SERIES
        .into_iter()
        .filter_map(|(which, title)| {
            let points: Vec<(f64, f64)> = series(view, which)
                .filter_map(|frames| {
                    // The cheapest leaves have up to sixteen, and are drawn below those that always do.
                    let at = if frames.name == "cheapest" { Ok(8.0) } else { frames.name.parse() };
                    Some((at.ok()?, speed(frames)?))
                })
                .collect();
            if points.len() < 2 {
                return None;
            }
            let scale = match which {
                FrameSeries::Lights | FrameSeries::Depth => Scale::Linear,
                _ => Scale::Binary,
            };
            Some(Panel::Plane(Plane {
                title: String::new(),
                x: Axis::over(title, scale, points.iter().map(|p| p.0), tick),
                y: Axis::over(
                    "frames per second",
                    Scale::Linear,
                    points.iter().map(|p| 1.05 * p.1).chain([0.0]),
                    tick,
                ),
                height: 200,
                series: vec![line(0, points)],
                rules: Vec::new(),
                labels: Vec::new(),
            }))
        })
        .collect();
    Figure {
        name: "pictures-series",
        title: "One thing at a time",
        caption: format!(
            "{}, all threads, tiles of 64; each panel changes one of these. Leaves at 8 are the cheapest \
             ones, of up to 16.",
            scene_of(view, FrameSeries::Threads)
        ),
        drawing: if panels.is_empty() {
            Err(nothing())
        } else {
            Ok(Drawing { panels, ..Drawing::default() })
        },
    }
}
