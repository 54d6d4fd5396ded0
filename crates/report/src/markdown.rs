//! Parts of documents as Markdown, spliced into texts between markers.

use crate::document::{Content, Document, Section};
use crate::table::{Kind, Table};

/// Why a text could not be spliced.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpliceError {
    /// No marker.
    #[error(
        "there is no marker that this record fills; write `<!-- trisect:NAME -->` and \
         `<!-- end of trisect:NAME -->` on lines of their own, NAME being one of: {0}"
    )]
    NoMarker(String),
    /// A marker that opens and does not close.
    #[error("`<!-- trisect:{0} -->` has no `<!-- end of trisect:{0} -->` behind it")]
    Open(&'static str),
}

/// `text` with what stands between its markers made anew from a document. Parts of other documents stay as
/// they are.
///
/// # Errors
/// When the text has no marker of the document's, or one that does not close.
pub fn splice(text: &str, document: &Document) -> Result<String, SpliceError> {
    let mut parts: Vec<(&'static str, Vec<&Section>)> = Vec::new();
    for section in document.sections.iter().filter(|section| !section.part.is_empty()) {
        match parts.iter_mut().find(|(name, _)| *name == section.part) {
            Some((_, sections)) => sections.push(section),
            None => parts.push((section.part, vec![section])),
        }
    }
    let mut text = text.to_owned();
    let mut found = false;
    for (name, sections) in &parts {
        let (begin, end) =
            (format!("<!-- trisect:{name} -->"), format!("<!-- end of trisect:{name} -->"));
        let Some((head, rest)) = text.split_once(&begin) else { continue };
        let (_, tail) = rest.split_once(&end).ok_or(SpliceError::Open(name))?;
        found = true;
        let written = draw(sections, &document.source.measured);
        text = format!("{head}{begin}\n\n{written}\n{end}{tail}");
    }
    let names = || parts.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    if found { Ok(text) } else { Err(SpliceError::NoMarker(names())) }
}

/// The sections of one part, with headings where there are several.
fn draw(sections: &[&Section], measured: &str) -> String {
    let mut paragraphs = Vec::new();
    for section in sections.iter().filter(|section| !section.is_empty()) {
        if sections.len() > 1 && !section.title.is_empty() {
            paragraphs.push(format!("### {}", section.title));
        }
        let content = match &section.content {
            Content::Prose | Content::Figure(_) | Content::Pictures(_) => String::new(),
            Content::Table(table) => draw_table(table),
            Content::Findings(findings) => {
                let item = |f: &crate::document::Finding| {
                    format!("- **{}:** {}; {}.", f.about, f.says, f.how)
                };
                findings.iter().map(item).collect::<Vec<_>>().join("\n")
            }
            Content::List(items) => {
                let item = |(head, text): &(String, String)| format!("- {head} {text}");
                items.iter().map(item).collect::<Vec<_>>().join("\n")
            }
        };
        let mut both = [content, section.says.clone()];
        // What a table means stands below it.
        if !matches!(section.content, Content::Table(_)) {
            both.reverse();
        }
        paragraphs.extend(both.into_iter().filter(|paragraph| !paragraph.is_empty()));
    }
    if paragraphs.is_empty() {
        paragraphs.push("The record holds nothing of this.".to_owned());
    }
    let is_said = sections
        .last()
        .is_some_and(|last| matches!(last.content, Content::Table(_)) && !last.says.is_empty());
    match paragraphs.last_mut() {
        Some(last) if is_said => *last = format!("{last} {measured}"),
        _ => paragraphs.push(measured.to_owned()),
    }
    paragraphs.join("\n\n") + "\n"
}

/// A table, names as code.
fn draw_table(table: &Table) -> String {
    let heads: Vec<&str> = table.columns.iter().map(|column| column.head.as_str()).collect();
    let rules = table.columns.iter().map(|c| if c.kind == Kind::Number { "--:" } else { "---" });
    let rows = table.rows.iter().map(|row| {
        let cells = row.iter().zip(&table.columns).map(|(cell, column)| match column.kind {
            Kind::Name => format!("`{}`", cell.text()),
            _ => cell.text(),
        });
        cells.collect::<Vec<_>>().join(" | ")
    });
    let lines = [heads.join(" | "), rules.collect::<Vec<_>>().join(" | ")].into_iter().chain(rows);
    lines.map(|line| format!("| {line} |")).collect::<Vec<_>>().join("\n")
}
