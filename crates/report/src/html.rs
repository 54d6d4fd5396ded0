//! Documents as pages: one file each, which asks the network for nothing.

use std::collections::BTreeMap;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, Value};
use serde::Serialize;

use crate::document::{Content, Document, Section, Shown, Source};
use crate::inline;
use crate::svg::{self, DrawError, Layout, css};

/// Why a page could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A figure could not be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// The page could not be filled in.
    #[error("cannot fill in the page: {0}")]
    Fill(#[from] minijinja::Error),
}

/// Where a page leads.
#[derive(Clone, Copy, Serialize)]
pub struct Link {
    /// The other page.
    pub page: &'static str,
    /// Its name.
    pub name: &'static str,
    /// What is to be read there.
    pub says: &'static str,
}

/// A page and its figures.
pub struct Page {
    /// The page.
    pub html: String,
    /// Name and text of each figure's file, wide and narrow, in the order of the page.
    pub figures: Vec<(String, String)>,
}

/// A section, and whether there is anything of it.
#[derive(Serialize)]
struct OnPage<'a> {
    #[serde(flatten)]
    section: &'a Section,
    is_empty: bool,
}

/// What the template fills in.
#[derive(Serialize)]
struct Context<'a> {
    style: String,
    title: &'static str,
    heading: &'static str,
    source: &'a Source,
    /// What its contents lead to.
    contents: Vec<&'a Section>,
    /// What stands in the head of the page.
    lead: &'a [OnPage<'a>],
    sections: &'a [OnPage<'a>],
    /// Wide and narrow, by their sections.
    figures: BTreeMap<&'static str, [String; 2]>,
    links: &'a [Link],
}

/// Draws a page and its figures.
///
/// # Errors
/// When a figure cannot be drawn or the page cannot be filled in.
pub fn draw(document: &Document, links: &[Link]) -> Result<Page, PageError> {
    let is_shown = |section: &&Section| {
        matches!(section.shown, Shown::Page | Shown::Everywhere)
            && !(section.is_empty() && section.missing.is_empty())
    };
    let shown: Vec<&Section> = document.sections.iter().filter(is_shown).collect();
    let mut files = Vec::new();
    let mut figures = BTreeMap::new();
    let others = shown.iter().flat_map(|section| [Some(*section), section.other.as_deref()]);
    for section in others.flatten() {
        let Content::Figure(drawing) = &section.content else { continue };
        if section.is_empty() {
            continue;
        }
        let says = format!("{} {}", section.says, document.source.measured);
        let mut draw = |layout, name: String| {
            let svg = svg::draw(drawing, layout, &name, &section.title, &says)?;
            files.push((format!("{name}.svg"), svg.file()));
            Ok::<_, DrawError>(svg.inline())
        };
        let wide = draw(Layout::Wide, section.id.to_owned())?;
        figures.insert(section.id, [wide, draw(Layout::Narrow, format!("{}-narrow", section.id))?]);
    }
    // What has no title and comes first stands in the head of the page.
    let lead = shown.iter().take_while(|section| section.title.is_empty()).count();
    let on_page: Vec<OnPage> =
        shown.into_iter().map(|section| OnPage { section, is_empty: section.is_empty() }).collect();
    let has_place =
        |s: &&OnPage| !(s.is_empty || s.section.title.is_empty() || s.section.id.is_empty());
    let html = fill_in(Context {
        style: format!("{}{}", css(), include_str!("../templates/page.css")),
        title: document.title,
        heading: document.heading,
        source: &document.source,
        contents: on_page.iter().filter(has_place).map(|s| s.section).collect(),
        lead: &on_page[..lead],
        sections: &on_page[lead..],
        figures,
        links,
    })?;
    Ok(Page { html, figures: files })
}

fn fill_in(context: Context) -> Result<String, minijinja::Error> {
    let mut env = Environment::new();
    env.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    env.add_filter("prose", |text: &str| Value::from_safe_string(inline::html(text)));
    env.add_template("page.html", include_str!("../templates/page.html"))?;
    env.add_template("page.js", include_str!("../templates/page.js"))?;
    env.get_template("page.html")?.render(Serde(context))
}
