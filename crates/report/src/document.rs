//! What a study says, however it is drawn: prose, findings, tables, figures and pictures.
//!
//! Four renderers draw a [`Document`], and know nothing of what it is about: `terminal`, `markdown`, `html`
//! and, for figures, `svg`. Prose may hold `` `code` `` and `**strong**` text.

use serde::{Serialize, Serializer};

use crate::figure::Drawing;
use crate::table::Table;
use crate::terminal;

/// What a study says.
pub struct Document {
    /// The title of the page's window.
    pub title: &'static str,
    /// The heading of the page.
    pub heading: &'static str,
    /// Where the numbers come from.
    pub source: Source,
    /// In order. Those without a title that come first stand in the head of the page.
    pub sections: Vec<Section>,
}

/// Where the numbers of a document come from.
#[derive(Clone, Default, Serialize)]
pub struct Source {
    /// The program and the machine in one line, for a terminal.
    pub line: String,
    /// One sentence that stands below every table and figure.
    pub measured: String,
    /// The program and its version, for the page's metadata.
    pub generator: String,
    /// How steady the machine was, which says what differences are worth: one sentence below the heading of a page.
    pub steadiness: Option<String>,
    /// Terms and what they are, for the end of the page.
    pub facts: Vec<(&'static str, String)>,
}

/// What a section consists of, beside its prose.
#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Content {
    /// Nothing but prose.
    Prose,
    /// Answers.
    Findings(Vec<Finding>),
    /// Items, each with a text that stands out before it.
    List(Vec<(String, String)>),
    /// A table.
    Table(Table),
    /// A figure; the section's prose is its caption.
    #[serde(serialize_with = "as_drawn")]
    Figure(Drawing),
    /// Pictures to look at.
    Pictures(Vec<Picture>),
}

/// A page is given its figures already drawn.
fn as_drawn<S: Serializer>(_: &Drawing, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_bool(true)
}

/// Where a section is drawn, beside the documents that it is spliced into.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// On the page.
    Page,
    /// On a terminal.
    Terminal,
    /// On both.
    Everywhere,
    /// In the documents that it is spliced into alone.
    Part,
}

/// A part of a document.
#[derive(Serialize)]
pub struct Section {
    /// Its anchor on the page, and the name of a figure's files.
    pub id: &'static str,
    /// Its heading, or nothing.
    pub title: String,
    /// Its prose, or what its columns mean.
    pub says: String,
    /// What it consists of.
    pub content: Content,
    /// What the page says where there is nothing of it; without a sentence the section is left out.
    pub missing: String,
    /// The name of the part that it is spliced as, or nothing.
    #[serde(skip)]
    pub part: &'static str,
    /// Where it is drawn.
    #[serde(skip)]
    pub shown: Shown,
    /// Of a list, the line that opens it on the page; it is open without one.
    pub fold: String,
    /// Of a figure, another one that the page shows in its place when a switch is pressed.
    pub other: Option<Box<Section>>,
}

/// An answer: what it is about, what it is, and how that was found.
#[derive(Serialize)]
pub struct Finding {
    /// What it is about.
    pub about: String,
    /// The answer.
    pub says: String,
    /// How it was found.
    pub how: String,
}

/// A picture to look at.
#[derive(Serialize)]
pub struct Picture {
    /// Its name.
    pub name: String,
    /// What is to be seen.
    pub says: String,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// A PNG, in base64.
    pub png: String,
}

impl Finding {
    /// An answer.
    pub fn new(about: impl Into<String>, says: impl Into<String>, how: impl Into<String>) -> Self {
        Self { about: about.into(), says: says.into(), how: how.into() }
    }
}

impl Section {
    /// A section of the page, without prose.
    pub fn new(id: &'static str, title: impl Into<String>, content: Content) -> Self {
        Self {
            id,
            title: title.into(),
            says: String::new(),
            content,
            missing: String::new(),
            part: "",
            shown: Shown::Page,
            fold: String::new(),
            other: None,
        }
    }

    /// Answers for the head of the page, spliced as a part.
    pub fn findings(part: &'static str, findings: Vec<Finding>) -> Self {
        Self::new("says", "", Content::Findings(findings)).part(part)
    }

    /// A table, and what its columns mean.
    pub fn table(
        id: &'static str,
        title: impl Into<String>,
        says: impl Into<String>,
        table: Table,
    ) -> Self {
        Self::new(id, title, Content::Table(table)).says(says)
    }

    /// A figure with its caption.
    pub fn figure(
        id: &'static str,
        title: &str,
        caption: impl Into<String>,
        drawing: Drawing,
    ) -> Self {
        Self::new(id, title, Content::Figure(drawing)).says(caption)
    }

    /// A table for a terminal, and what its columns mean.
    pub fn brief(table: Table, says: impl Into<String>) -> Self {
        Self::table("", "", says, table).shown(Shown::Terminal)
    }

    /// A paragraph.
    pub fn prose(says: impl Into<String>) -> Self {
        Self::new("", "", Content::Prose).says(says)
    }

    /// A list for documents alone.
    pub fn list(part: &'static str, title: &str, items: Vec<(String, String)>) -> Self {
        Self::new("", title, Content::List(items)).part(part).shown(Shown::Part)
    }

    /// The same with this prose.
    pub fn says(self, says: impl Into<String>) -> Self {
        Self { says: says.into(), ..self }
    }

    /// The same, which says this where there is nothing of it.
    pub fn missing(self, missing: impl Into<String>) -> Self {
        Self { missing: missing.into(), ..self }
    }

    /// The same, spliced into documents under this name.
    pub fn part(self, part: &'static str) -> Self {
        Self { part, ..self }
    }

    /// The same, drawn elsewhere.
    pub fn shown(self, shown: Shown) -> Self {
        Self { shown, ..self }
    }

    /// The same list, opened on the page by this line.
    pub fn folded(self, fold: impl Into<String>) -> Self {
        Self { fold: fold.into(), ..self }
    }

    /// The same figure, which a switch of the page changes for another one; for that alone where there is nothing of
    /// the other.
    pub fn or(self, other: Self) -> Self {
        Self { other: (!other.is_empty()).then(|| Box::new(other)), ..self }
    }

    /// Whether there is nothing of it.
    pub fn is_empty(&self) -> bool {
        match &self.content {
            Content::Prose => self.says.is_empty(),
            Content::Findings(findings) => findings.is_empty(),
            Content::List(items) => items.is_empty(),
            Content::Table(table) => table.rows.is_empty(),
            Content::Figure(drawing) => drawing.panels.is_empty(),
            Content::Pictures(pictures) => pictures.is_empty(),
        }
    }
}

impl Document {
    /// The document as text of at most `width` columns, for 40 columns or more.
    pub fn to_text(&self, width: usize) -> String {
        terminal::draw(self, width)
    }

    /// Sections of no study as text of at most `width` columns, for 40 columns or more.
    pub fn text(sections: impl Into<Vec<Section>>, width: usize) -> String {
        let in_terminal = |section: Section| section.shown(Shown::Terminal);
        let sections = sections.into().into_iter().map(in_terminal).collect();
        Self { title: "", heading: "", source: Source::default(), sections }.to_text(width)
    }
}
