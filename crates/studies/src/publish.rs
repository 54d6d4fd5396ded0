//! Reports: a page for each study, in one folder, which lead to each other.

use std::path::{Path, PathBuf};

use trisect_report::document::Document;
use trisect_report::html::{self, Link, PageError};
use trisect_report::markdown::{self, SpliceError};

use crate::file::{Files, WriteError};
use crate::record::{ReadError, Records};
use crate::registry::{chapter_of, chapters, load};
use crate::study::{About, Chapter};

/// Why a page could not be published. The folder is as it was before.
#[derive(Debug, thiserror::Error)]
pub enum PublishError {
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
    /// The page could not be drawn.
    #[error(transparent)]
    Draw(#[from] PageError),
}

/// What was published.
pub struct Page {
    /// What it says.
    pub document: Document,
    /// The page.
    pub index: PathBuf,
    /// The figures, in the order of the page; each twice, wide and narrow.
    pub figures: Vec<PathBuf>,
}

/// A text with what stands between its markers made anew from a record; what the record says nothing
/// about stays as it is.
///
/// # Errors
/// When the text has no marker that the record fills, or one that does not close.
pub fn splice(text: &str, records: &Records) -> Result<String, SpliceError> {
    markdown::splice(text, &chapter_of(records).document(records))
}

impl Chapter {
    fn link(&self) -> Link {
        let About { page, title, says, .. } = self.about;
        Link { page, name: title, says }
    }

    fn is(&self, other: &Self) -> bool {
        self.about.name == other.about.name
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
    pub fn publish(&self, records: &Records, folder: &Path) -> Result<Page, PublishError> {
        self.publish_with(records, folder, Files::default())
    }

    /// The same, and the record beside the page.
    ///
    /// # Errors
    /// As [`publish`](Chapter::publish).
    pub fn keep(&self, records: &Records, folder: &Path) -> Result<Page, PublishError> {
        let mut files = Files::default();
        files.add(&folder.join(self.about.record), |out| records.write(out))?;
        self.publish_with(records, folder, files)
    }

    fn publish_with(
        &self,
        records: &Records,
        folder: &Path,
        mut files: Files,
    ) -> Result<Page, PublishError> {
        let is_there =
            |chapter: &&Self| chapter.is(self) || folder.join(chapter.about.page).exists();
        let there: Vec<&Self> = chapters().iter().filter(is_there).collect();
        let mut add = |chapter: &Self, records: &Records| -> Result<Page, PublishError> {
            let others = there.iter().filter(|other| !other.is(chapter));
            let links: Vec<Link> = others.map(|other| other.link()).collect();
            let document = chapter.document(records);
            let page = html::draw(&document, &links)?;
            let mut figures = Vec::new();
            for (name, svg) in &page.figures {
                let path = folder.join("figures").join(name);
                files.add(&path, |out| out.write_all(svg.as_bytes()))?;
                figures.push(path);
            }
            let index = folder.join(chapter.about.page);
            files.add(&index, |out| out.write_all(page.html.as_bytes()))?;
            Ok(Page { document, index, figures })
        };
        for (other, records) in self.led_here(folder)? {
            add(other, &records)?;
        }
        let page = add(self, records)?;
        files.commit()?;
        Ok(page)
    }

    /// Reads what [`publish`](Chapter::publish) would read beside the page: for those who work long before.
    ///
    /// # Errors
    /// When a record beside the page cannot be read.
    pub fn check(&self, folder: &Path) -> Result<(), PublishError> {
        self.led_here(folder).map(drop)
    }

    /// The chapters in a folder, with their records, whose pages do not lead to this one yet.
    fn led_here(&self, folder: &Path) -> Result<Vec<(&'static Self, Records)>, PublishError> {
        if folder.join(self.about.page).exists() {
            return Ok(Vec::new());
        }
        let others = chapters().iter().filter(|chapter| {
            folder.join(chapter.about.page).exists() && folder.join(chapter.about.record).exists()
        });
        let read = |chapter: &'static Self| {
            let path = folder.join(chapter.about.record);
            let records = load(&path);
            Ok((chapter, records.map_err(|problem| PublishError::Read { path, problem })?))
        };
        others.map(read).collect()
    }
}
