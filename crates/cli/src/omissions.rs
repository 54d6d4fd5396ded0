//! `trisect omissions`: the study of what is left out.

use anyhow::Result;
use trisect_harness::OmissionSettings;
use trisect_report::Chapter;

use crate::arguments::Omissions;
use crate::progress::Bar;
use crate::{records, tasks};

/// How much is studied.
struct Size {
    /// Samples of each kind.
    rounds: usize,
    /// Rays, and triangles, that kernels are timed on.
    tests: usize,
    /// Side, in pixels, of the picture whose rays meet a mesh.
    pixels: usize,
    /// Pixels across and down of pictures of scenes.
    picture: [u32; 2],
}

const QUICK: Size = Size { rounds: 11, tests: 256, pixels: 128, picture: [160, 120] };
const FULL: Size = Size { rounds: 51, tests: 512, pixels: 256, picture: [320, 240] };

/// Studies, prints the summary, and adds page and record to the report.
pub(crate) fn run(arguments: &Omissions) -> Result<()> {
    let Omissions { seed, quick, shrink, output, json, .. } = arguments;
    let methods = tasks::methods(&arguments.methods)?;
    records::check(Chapter::Omissions, output)?;
    let Size { rounds, tests, pixels, picture } = if *quick { QUICK } else { FULL };
    let mut bar = Bar::new();
    let mut taken = records::of_machine(*seed, rounds, &mut bar)?;
    let settings = OmissionSettings {
        seed: *seed,
        methods,
        rounds,
        // Divided by no more than 100, each is left with some.
        tests: tests / *shrink as usize,
        pixels: pixels / *shrink as usize,
        picture: picture.map(|side| side / shrink),
    };
    taken.lines.extend(trisect_harness::omissions(&settings, &mut bar)?);
    drop(bar);
    records::keep(Chapter::Omissions, &taken, output, *json)
}
