//! Publishing a record: its page, and what is printed of it.

use std::path::Path;

use anyhow::Result;
use trisect_studies::record::Records;
use trisect_studies::{Chapter, Page};

use crate::output::{self, COLUMNS};

/// Refuses a folder that a chapter could not be published in, before any work is done for it.
pub(crate) fn check(chapter: &Chapter, folder: &Path) -> Result<()> {
    output::check_folder(folder)?;
    Ok(chapter.check(folder)?)
}

/// Publishes a record that was taken for a report, with its page, and prints its summary.
pub(crate) fn keep(chapter: &Chapter, taken: &Records, folder: &Path, json: bool) -> Result<()> {
    let page = chapter.keep(taken, folder)?;
    tell(chapter, &page, taken, json)?;
    output::say(format_args!("record  {}", folder.join(chapter.about.record).display()));
    Ok(())
}

/// Prints a summary, and says where the page is.
pub(crate) fn tell(chapter: &Chapter, page: &Page, records: &Records, json: bool) -> Result<()> {
    output::print(|out| {
        if json {
            chapter.write_summary(records, &mut *out)?;
            writeln!(out)
        } else {
            writeln!(out, "{}", page.document.to_text(COLUMNS).trim_end())
        }
    })?;
    output::say(format_args!("\npage    {}", page.index.display()));
    Ok(())
}
