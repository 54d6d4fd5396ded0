//! The list of studies.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use crate::comparison::settings::Comparison;
use crate::forms;
use crate::record::{Parser, ReadError, Records};
use crate::shard::Part;
use crate::study::{Chapter, Study};

/// Something to do with a study of whatever type.
pub trait StudyVisitor {
    /// What comes of it.
    type Output;

    /// Does it.
    fn visit<S: Study>(self, settings: &S::Settings) -> Self::Output;
}

macro_rules! studies {
    ($($(#[doc = $says:literal])+ $verb:ident($study:ty),)+) => {
        /// A study on the command line, with its settings and those of whoever asks for it, `More`.
        #[derive(Debug, clap::Subcommand)]
        pub enum Choice<More: clap::Args> {
            $($(#[doc = $says])+ $verb(Asked<<$study as Study>::Settings, More>),)+
        }

        impl<More: clap::Args> Choice<More> {
            /// Hands the study and its settings to a visitor that is made from what is asked beside them.
            pub fn visit<'a, V: StudyVisitor>(&'a self, visitor: impl FnOnce(&'a More) -> V) -> V::Output {
                match self {
                    $(Self::$verb(asked) => visitor(&asked.more).visit::<$study>(&asked.settings),)+
                }
            }
        }

        /// All studies as chapters of a report, the comparison first and what a program beside trisect writes last:
        /// in the order in which pages lead to each other.
        pub fn chapters() -> &'static [Chapter] {
            static CHAPTERS: &[Chapter] =
                &[Chapter::of::<Comparison>(), $(Chapter::of::<$study>(),)+ forms::CHAPTER];
            CHAPTERS
        }
    };
}

/// The settings of a study, and what is asked beside them.
#[derive(Debug, clap::Args)]
pub struct Asked<Settings: clap::Args, More: clap::Args> {
    #[command(flatten)]
    #[allow(missing_docs, reason = "a comment here would become the command's")]
    pub settings: Settings,
    #[command(flatten)]
    #[allow(missing_docs, reason = "a comment here would become the command's")]
    pub more: More,
}

// Each with what it does, as the help of the command lists it.
studies! {
    /// Study what every method does in stiff and extreme cases
    Stress(crate::stress::Stability),
    /// Study what every method is worth in a ray tracer
    Study(crate::tracer::Tracer),
    /// Study how fast pictures of the mirror scene are, and draw one of every feature
    Pictures(crate::pictures::Pictures),
    /// Study what it would take to keep what nobody asks for
    Omissions(crate::omissions::Omissions),
    /// Study when rasterising beats casting, and count pixels at which they differ
    Raster(crate::raster::Raster),
}

/// The study that took a record. One that is older than its header's field has lines of that study alone,
/// or else is a comparison.
pub fn chapter_of(records: &Records) -> &'static Chapter {
    let says = |chapter: &&Chapter| records.header.study.as_deref() == Some(chapter.about.name);
    let is_of = |chapter: &&Chapter| {
        let is_own = |kind| chapter.about.lines.iter().any(|parser| parser.kind == kind);
        records.lines.iter().any(|line| is_own(line.kind()))
    };
    let [comparison, studies @ ..] = chapters() else { unreachable!("the comparison is listed") };
    chapters().iter().find(says).or_else(|| studies.iter().find(is_of)).unwrap_or(comparison)
}

/// The first bytes of a file that gzip has compressed.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Reads a record of any study, plain or compressed by gzip.
///
/// # Errors
/// When the stream fails, or a line is not a record.
pub fn read(mut from: impl BufRead) -> Result<Records, ReadError> {
    let of_studies = chapters().iter().flat_map(|chapter| chapter.about.lines).copied();
    let parsers: Vec<Parser> = of_studies.chain([Parser::of::<Part>()]).collect();
    if from.fill_buf()?.starts_with(&GZIP) {
        Records::read(BufReader::new(MultiGzDecoder::new(from)), &parsers)
    } else {
        Records::read(from, &parsers)
    }
}

/// Reads a record of any study by its path; a pipe will do.
///
/// # Errors
/// As [`read`].
pub fn load(path: &Path) -> Result<Records, ReadError> {
    read(BufReader::new(File::open(path).map_err(ReadError::NotOpened)?))
}
