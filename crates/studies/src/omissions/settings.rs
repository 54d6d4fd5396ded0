//! What the study of what is left out can be asked for.

use clap::Args;
use trisect_catalog::Entry;

use crate::input::methods;
use crate::study::StudyError;

/// Study what it would take to keep what nobody asks for: values in kernels; values and guarantees in the
/// tracer; in pictures, what their scenes do not need. The same work goes in turn with it and without.
///
/// Prints a table, and adds the page omissions.html and the record omissions.jsonl to a report.
#[derive(Debug, Args)]
pub struct Settings {
    /// Methods whose kernels are timed, separated by commas; all if left out
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Seed of every random choice
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Fewer rays, pixels and samples: seconds instead of half a minute
    #[arg(long)]
    pub quick: bool,
    /// Divide the sides of all pictures, and the number of tests, for a trial
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub shrink: u32,
}

/// What is studied, and how long.
pub struct Omissions {
    /// Seed of rays, triangles and the order of samples.
    pub seed: u64,
    /// The methods whose kernels are timed.
    pub methods: Vec<&'static Entry>,
    /// Samples of each kind.
    pub rounds: usize,
    /// Rays, and triangles, that kernels are timed on.
    pub tests: usize,
    /// Side, in pixels, of the picture whose rays meet a mesh.
    pub pixels: usize,
    /// Pixels across and down of the pictures of scenes.
    pub picture: [u32; 2],
}

impl Settings {
    pub(super) fn plan(&self) -> Result<Omissions, StudyError> {
        let (rounds, tests, pixels, picture) =
            if self.quick { (11, 256, 128, [160, 120]) } else { (51, 512, 256, [320, 240]) };
        Ok(Omissions {
            seed: self.seed,
            methods: methods(&self.methods)?,
            rounds,
            // Divided by no more than 100, each is left with some.
            tests: tests / self.shrink as usize,
            pixels: pixels / self.shrink as usize,
            picture: picture.map(|side: u32| side / self.shrink),
        })
    }
}
