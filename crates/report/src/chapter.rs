//! The chapters of a report: one page each, in one folder, which lead to each other.

use std::path::{Path, PathBuf};

use serde::Serialize;
use trisect_harness::file::{Files, WriteError};
use trisect_harness::record::{ReadError, Record, Records};

use crate::chart::DrawError;
use crate::page::{Drawn, draw_comparison};
use crate::view::View;
use crate::{omissions, pictures, stress, study};

/// Why a page could not be published. The folder is as it was before.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A record beside the page could not be read, whose own page would have to lead to the new one.
    #[error("{}: {problem}", path.display())]
    Read {
        /// The record.
        path: PathBuf,
        /// Why. Not a `source`: the message holds it already.
        problem: ReadError,
    },
    /// A figure could not be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// The page could not be filled in.
    #[error("cannot fill in the page: {0}")]
    Fill(#[from] minijinja::Error),
}

/// What was published.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page {
    /// The page.
    pub index: PathBuf,
    /// The figures, in the order of the page; each twice, wide and narrow.
    pub figures: Vec<PathBuf>,
}

/// A chapter of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chapter {
    /// The comparison of methods.
    Comparison,
    /// The stability study.
    Stress,
    /// The study of the tracer.
    Tracer,
    /// The study of pictures.
    Pictures,
    /// The study of what is left out.
    Omissions,
}

/// Where a page leads.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Link {
    page: &'static str,
    name: &'static str,
    says: &'static str,
}

impl Chapter {
    /// All chapters, in the order in which pages lead to them.
    pub const ALL: [Self; 5] =
        [Self::Comparison, Self::Stress, Self::Tracer, Self::Pictures, Self::Omissions];

    /// The chapter that a record belongs to: that of the study that any of its lines is a part of, or
    /// else the comparison. Studies hold lines of a comparison as well.
    pub fn of(records: &Records) -> Self {
        let of_study =
            |chapter: &Self| records.lines.iter().any(|line| Self::of_line(line) == *chapter);
        let studies = [Self::Stress, Self::Pictures, Self::Omissions, Self::Tracer];
        studies.into_iter().find(of_study).unwrap_or(Self::Comparison)
    }

    /// The chapter that asks for such a line, where only one does; the comparison for all others.
    fn of_line(line: &Record) -> Self {
        match line {
            Record::SurfaceCracks(_)
            | Record::Stress(_)
            | Record::ByCondition(_)
            | Record::FusedDifference(_)
            | Record::Limits(_)
            | Record::Contract(_)
            | Record::SpecialValues(_)
            | Record::Exactness(_)
            | Record::Stages(_) => Self::Stress,
            Record::Tree(_) | Record::Traced(_) => Self::Tracer,
            Record::Frames(_) | Record::Picture(_) => Self::Pictures,
            Record::Omission(_) | Record::Code(_) => Self::Omissions,
            Record::Header(_)
            | Record::Method(_)
            | Record::Workload(_)
            | Record::Throughput(_)
            | Record::Error(_)
            | Record::Decisions(_)
            | Record::Preparation(_)
            | Record::Agreement(_)
            | Record::Refusal(_)
            | Record::Cracks(_) => Self::Comparison,
        }
    }

    /// The name of its page.
    pub fn page(self) -> &'static str {
        self.link().page
    }

    /// The name of its record, where that lies beside the page.
    pub fn record(self) -> &'static str {
        match self {
            Self::Comparison => "record.jsonl",
            Self::Stress => "stress.jsonl",
            Self::Tracer => "study.jsonl",
            Self::Pictures => "pictures.jsonl",
            Self::Omissions => "omissions.jsonl",
        }
    }

    fn link(self) -> Link {
        let [page, name, says] = match self {
            Self::Comparison => {
                ["index.html", "The comparison", "error against run time on ordinary rays"]
            }
            Self::Stress => [
                "stress.html",
                "Stiff and extreme cases",
                "what every method does when it gets hard",
            ],
            Self::Tracer => [
                "study.html",
                "In a ray tracer",
                "what every method is worth where rays are traced",
            ],
            Self::Pictures => ["pictures.html", "Pictures", "scenes rendered, and what they cost"],
            Self::Omissions => [
                "omissions.html",
                "What is left out",
                "what it would take to keep what nobody asks for",
            ],
        };
        Link { page, name, says }
    }

    fn draw(self, records: &Records, links: Vec<Link>) -> Result<Drawn, PageError> {
        let view = View::new(records);
        match self {
            Self::Comparison => draw_comparison(&view, links),
            Self::Stress => stress::page::draw(&view, links),
            Self::Tracer => study::page::draw(&view, links),
            Self::Pictures => pictures::draw(&view, links),
            Self::Omissions => omissions::draw(&view, links),
        }
    }

    /// Draws the chapter's page and its figures into a folder, which is made if it does not exist. The
    /// page leads to those of other chapters there; where it is new, those whose records lie there are
    /// drawn again, to lead here.
    ///
    /// All files come into the folder together or not at all, and all others that are there stay.
    ///
    /// # Errors
    /// When a file cannot be written, a record beside the page cannot be read, or a figure or a page
    /// cannot be drawn.
    pub fn publish(self, records: &Records, folder: &Path) -> Result<Page, PageError> {
        self.publish_with(records, folder, Files::default())
    }

    /// The same, and the record beside the page.
    ///
    /// # Errors
    /// As [`publish`](Chapter::publish).
    pub fn keep(self, records: &Records, folder: &Path) -> Result<Page, PageError> {
        let mut files = Files::default();
        files.add(&folder.join(self.record()), |out| records.write(out))?;
        self.publish_with(records, folder, files)
    }

    fn publish_with(
        self,
        records: &Records,
        folder: &Path,
        mut files: Files,
    ) -> Result<Page, PageError> {
        let there = |chapter: &Self| *chapter == self || folder.join(chapter.page()).exists();
        let chapters: Vec<Self> = Self::ALL.into_iter().filter(there).collect();
        let drawn = |chapter: Self, records: &Records| {
            let others = chapters.iter().filter(|other| **other != chapter);
            chapter.draw(records, others.map(|other| other.link()).collect())
        };
        for (other, records) in self.led_here(folder)? {
            other.add(&drawn(other, &records)?, folder, &mut files)?;
        }
        let page = self.add(&drawn(self, records)?, folder, &mut files)?;
        files.commit()?;
        Ok(page)
    }

    /// Reads what [`publish`](Chapter::publish) would read beside the page: for who works long before.
    ///
    /// # Errors
    /// When a record beside the page cannot be read.
    pub fn check(self, folder: &Path) -> Result<(), PageError> {
        self.led_here(folder).map(drop)
    }

    /// The chapters in a folder, with their records, whose pages do not lead to this one yet.
    fn led_here(self, folder: &Path) -> Result<Vec<(Self, Records)>, PageError> {
        if folder.join(self.page()).exists() {
            return Ok(Vec::new());
        }
        let others = Self::ALL.into_iter().filter(|chapter| {
            folder.join(chapter.page()).exists() && folder.join(chapter.record()).exists()
        });
        others.map(|chapter| Ok((chapter, read(folder.join(chapter.record()))?))).collect()
    }

    /// The figures before the page that shows them.
    fn add(self, drawn: &Drawn, folder: &Path, files: &mut Files) -> Result<Page, WriteError> {
        let mut figures = Vec::new();
        for (name, svg) in &drawn.files {
            let path = folder.join("figures").join(name);
            files.add(&path, |out| out.write_all(svg.as_bytes()))?;
            figures.push(path);
        }
        let index = folder.join(self.page());
        files.add(&index, |out| out.write_all(drawn.html.as_bytes()))?;
        Ok(Page { index, figures })
    }
}

fn read(path: PathBuf) -> Result<Records, PageError> {
    Records::load(&path).map_err(|problem| PageError::Read { path, problem })
}
