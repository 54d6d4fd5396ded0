//! What the study of the rasteriser can be asked for.

use clap::Args;

use crate::study::threads;

/// Study when rasterising beats casting: milliseconds until it is known what is seen at each pixel, over meshes and
/// sizes of pictures, with and without building a tree; what exact agreement costs; and shaded frames.
///
/// Prints tables, and adds the page raster.html and the record raster.jsonl to a report. With --check it times
/// nothing, and counts the pixels at which the rasteriser and the exact caster differ.
#[derive(Debug, Args)]
pub struct Settings {
    /// Count pixels that differ from the exact caster, on every shipped scene and on hostile ones; ends with 1 if
    /// there are any
    #[arg(long, conflicts_with = "full")]
    pub check: bool,
    /// Up to 10 million triangles and 3840 by 2160 pixels: half an hour and 8 GB
    #[arg(long)]
    pub full: bool,
    /// Seed of the order of samples
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Divide the sides of all pictures, for a trial
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub shrink: u32,
    /// Threads, at most; all processors if left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// What is studied, and how long.
pub struct Raster {
    /// Seed of the order of samples.
    pub seed: u64,
    /// Pictures of each kind that are timed.
    pub rounds: usize,
    /// Threads, at most.
    pub threads: usize,
    /// Copies of the bunny in each mesh beyond it.
    pub copies: &'static [u16],
    /// Sizes of pictures.
    pub sizes: Vec<[u32; 2]>,
    /// The size of the frame of 2012.
    pub frame: [u32; 2],
}

/// Sizes of pictures.
const SIZES: [[u32; 2]; 5] = [[160, 120], [640, 480], [1024, 768], [1920, 1080], [3840, 2160]];

impl Settings {
    pub(super) fn plan(&self) -> Raster {
        let sizes: &[[u32; 2]] = if self.full { &SIZES } else { &[SIZES[0], SIZES[1], SIZES[3]] };
        Raster {
            seed: self.seed,
            rounds: if self.full { 15 } else { 5 },
            threads: threads(self.threads),
            copies: if self.full { &[4, 16, 144] } else { &[4] },
            sizes: sizes.iter().map(|&size| self.size(size)).collect(),
            frame: self.size([1366, 768]),
        }
    }

    /// A size as it is asked for.
    pub(super) fn size(&self, full: [u32; 2]) -> [u32; 2] {
        full.map(|side| (side / self.shrink).max(1))
    }
}
