//! The figures of the study of pictures.

use crate::pictures::record::FrameSeries;
use crate::record::Records;

use super::select::{SERIES, scene_of, series, speed};
use super::summary::PictureSummary;
use trisect_report::document::Section;
use trisect_report::figure::{Axis, Drawing, Entry, Look, Panel, Scale, Series, points};
use trisect_report::format::tick;

const NOTHING: &str = "Left out: the record holds no pictures; make one with `trisect pictures`.";

/// Frames per second against millions of pixels, a line for each level.
pub(super) fn sizes(summary: &PictureSummary) -> Section {
    let (mut series, mut legend) = (Vec::new(), Vec::new());
    for (place, level) in summary.levels().into_iter().enumerate() {
        let mine = summary.sizes.iter().filter(|frame| frame.name == level.name);
        let points = mine.map(|frame| {
            let pixels = f64::from(frame.width) * f64::from(frame.height) / 1e6;
            (pixels, frame.frames_per_second)
        });
        series.push(Series::line(Look::of(place), points.collect()));
        legend.push(Entry::of(Look::of(place), &level.name));
    }
    let mut drawing = Drawing { legend, ..Drawing::default() };
    if !series.is_empty() {
        let x = Axis::over("million pixels", Scale::Log, points(&series).map(|p| p.0), tick);
        let y = Axis::over("frames per second", Scale::Log, points(&series).map(|p| p.1), tick);
        drawing.panels.push(Panel::plane("Sizes", x, y, 280, series));
    }
    let caption = "The mirror scene, on all threads, from low to very hard: the table below says what each \
                   level is.";
    Section::figure("pictures-sizes", "Frames per second", caption, drawing).missing(NOTHING)
}

/// Frames per second against one thing after another.
pub(super) fn one_at_a_time(records: &Records) -> Section {
    let panel = |(which, title): (FrameSeries, &str)| {
        let point = |frames: &crate::pictures::record::Frames| {
            // The cheapest leaves have up to sixteen, and are drawn below those that always do.
            let at = if frames.name == "cheapest" { 8.0 } else { frames.name.parse().ok()? };
            Some((at, speed(frames)?))
        };
        let points: Vec<(f64, f64)> = series(records, which).filter_map(point).collect();
        let scale = match which {
            FrameSeries::Lights | FrameSeries::Depth => Scale::Linear,
            _ => Scale::Binary,
        };
        let x = Axis::over(title, scale, points.iter().map(|p| p.0), tick);
        let speeds = points.iter().map(|p| 1.05 * p.1).chain([0.0]);
        let y = Axis::over("frames per second", Scale::Linear, speeds, tick);
        let is_line = points.len() > 1;
        let series = vec![Series::line(Look::of(0), points)];
        is_line.then(|| Panel::plane("", x, y, 200, series))
    };
    let caption = format!(
        "{}, all threads, tiles of 64; each panel changes one of these. Leaves at 8 are the cheapest ones, of \
         up to 16.",
        scene_of(records, FrameSeries::Threads)
    );
    let drawing = Drawing::of(SERIES.into_iter().filter_map(panel).collect());
    Section::figure("pictures-series", "One thing at a time", caption, drawing).missing(NOTHING)
}
