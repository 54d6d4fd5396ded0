//! The tables of A. S. Morozov's thesis on a parallel Whitted ray tracer (2011), and what to ask of this one to
//! measure the same.

use super::measure::{LEVELS, SIZES};
use super::record::{FrameSeries, Frames};

/// The scene that he timed, as far as he describes it.
pub(super) const SCENE: &str = "morozov";

/// A row of one of his tables.
pub(crate) struct Row {
    /// Which of his tables.
    pub table: u32,
    /// What changes from row to row.
    pub series: FrameSeries,
    /// Its value.
    pub x: u32,
    /// His frames per second, from low to very hard.
    pub frames_per_second: [f64; 4],
}

/// A picture of his scene at one of his levels.
#[derive(Clone, Copy)]
pub(super) struct Asked {
    pub size: [u32; 2],
    pub samples: u32,
    pub depth: u32,
    pub lights: usize,
}

/// The settings that he sums his tracer up by (section 5.7), with his frames per second.
pub(super) const GOALS: [(Asked, f64); 3] = [
    (Asked { size: [640, 480], samples: 1, depth: 16, lights: 1 }, 36.0),
    (Asked { size: [1024, 768], samples: 6, depth: 16, lights: 1 }, 2.5),
    (Asked { size: [1920, 1080], samples: 12, depth: 16, lights: 8 }, 0.198),
];

impl Asked {
    /// What the picture is called in a record.
    pub(super) fn name(&self) -> String {
        let Self { size: [width, height], samples, depth, lights } = self;
        format!("{width}×{height} {samples}/{depth}/{lights}")
    }

    /// Whether these are pictures of it.
    pub(super) fn is_of(&self, frames: &Frames) -> bool {
        frames.scene == SCENE && frames.series == FrameSeries::Goal && frames.name == self.name()
    }
}

/// All rows, in the order of his tables.
pub(crate) fn rows() -> impl Iterator<Item = Row> {
    let lines = include_str!("morozov.tsv").lines().filter(|line| !line.starts_with('#'));
    lines.skip(1).filter_map(row)
}

fn row(line: &str) -> Option<Row> {
    let cells: Vec<&str> = line.split('\t').collect();
    let [table, series, x, low, middle, hard, very_hard] = cells[..] else { return None };
    let series = match series {
        "threads" => FrameSeries::Threads,
        "samples" => FrameSeries::Samples,
        "lights" => FrameSeries::Lights,
        "depth" => FrameSeries::Depth,
        "leaves" => FrameSeries::Leaves,
        "tiles" => FrameSeries::Tiles,
        _ => return None,
    };
    let [low, middle, hard, very_hard] = [low, middle, hard, very_hard].map(str::parse);
    let frames_per_second = [low.ok()?, middle.ok()?, hard.ok()?, very_hard.ok()?];
    Some(Row { table: table.parse().ok()?, series, x: x.parse().ok()?, frames_per_second })
}

impl Row {
    /// What changes, in words.
    pub(super) fn says(&self) -> &'static str {
        match (self.table, self.series) {
            (3, _) => "threads, OpenMP",
            (4, _) => "threads, TBB",
            (_, FrameSeries::Samples) => "subpixels",
            (_, FrameSeries::Lights) => "lights",
            (_, FrameSeries::Depth) => "depth",
            (_, FrameSeries::Leaves) => "objects of a leaf, at most",
            _ => "portions for each thread",
        }
    }

    /// What the picture of this row asks at a level.
    pub(super) fn at(&self, level: usize) -> Asked {
        let (_, samples, depth, lights) = LEVELS[level];
        let asked = Asked { size: SIZES[level], samples, depth, lights };
        match self.series {
            FrameSeries::Samples => Asked { samples: self.x, ..asked },
            FrameSeries::Lights => Asked { lights: self.x as usize, ..asked },
            FrameSeries::Depth => Asked { depth: self.x, ..asked },
            _ => asked,
        }
    }

    /// What the picture is called in a record.
    pub(super) fn name(&self, level: usize) -> String {
        format!("{} {}", LEVELS[level].0, self.x)
    }

    /// Whether these are pictures of this row at a level.
    pub(super) fn is_of(&self, level: usize, frames: &Frames) -> bool {
        frames.scene == SCENE && frames.series == self.series && frames.name == self.name(level)
    }
}

/// The side of tiles of which each thread gets so many: his portions are of equal size as well.
pub(super) fn tile_of(portions: u32, threads: usize, [width, height]: [u32; 2]) -> u32 {
    let pixels = f64::from(width) * f64::from(height) / (f64::from(portions) * threads as f64);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most a picture's side"
    )]
    let side = pixels.sqrt().ceil() as u32;
    side.max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_his_tables_is_there() {
        let counts =
            [3, 4, 5, 6, 7, 8, 9].map(|table| rows().filter(|row| row.table == table).count());
        assert_eq!(counts, [24, 24, 18, 18, 12, 39, 12]);
        // Speeds fall from level to level.
        assert!(rows().all(|row| row.frames_per_second.is_sorted_by(|a, b| a > b)));
    }

    #[test]
    fn a_row_changes_one_thing() {
        let row = rows().find(|row| row.table == 7 && row.x == 1024).expect("his deepest");
        let Asked { size, samples, depth, lights } = row.at(3);
        assert_eq!((size, samples, depth, lights), ([1920, 1080], 3, 1024, 2));
        assert_eq!(row.name(3), "very hard 1024");
    }

    #[test]
    fn tiles_are_as_many_as_portions() {
        assert_eq!(tile_of(1, 4, [512, 512]), 256);
        assert_eq!(tile_of(12, 2, [8, 1]), 1);
    }
}
