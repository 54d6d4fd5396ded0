//! Pictures of a record, by series.

use crate::pictures::morozov::SCENE;
use crate::pictures::record::{FrameSeries, Frames};
use crate::record::Records;

use trisect_report::stats::median;

/// What is varied one at a time, and how it is called.
pub(super) const SERIES: [(FrameSeries, &str); 6] = [
    (FrameSeries::Threads, "threads"),
    (FrameSeries::Samples, "samples of a pixel"),
    (FrameSeries::Lights, "lights"),
    (FrameSeries::Depth, "depth"),
    (FrameSeries::Leaves, "triangles of a leaf, at most"),
    (FrameSeries::Tiles, "side of a tile, in pixels"),
];

/// Pictures of a series of the mirror scene, in the record's order.
pub(super) fn series(records: &Records, series: FrameSeries) -> impl Iterator<Item = &Frames> {
    records.all::<Frames>().filter(move |frames| frames.series == series && frames.scene != SCENE)
}

/// Frames per second: of the median time.
pub(super) fn speed(frames: &Frames) -> Option<f64> {
    let samples: Vec<f64> = frames.samples_ns.iter().map(|&ns| ns as f64).collect();
    median(&samples).filter(|&ns| ns > 0.0).map(|ns| 1e9 / ns)
}

/// What the pictures of a series have in common.
pub(super) fn scene_of(records: &Records, which: FrameSeries) -> String {
    let (mut size, mut depth) = (String::new(), 0);
    if let Some(frames) = series(records, which).next() {
        size = format!(" at {} by {}", frames.width, frames.height);
        depth = frames.depth;
    }
    format!("The mirror scene{size}, one sample, one light, depth {depth}")
}
