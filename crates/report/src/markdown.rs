//! Tables and findings as Markdown, spliced into documents between markers.

use std::fmt::Write as _;

use serde::Serialize;
use trisect_core::{FloatFormat, Output};
use trisect_harness::record::{Records, Variant};

use crate::format::{number, or_dash, scientific};
use crate::havel;
use crate::omissions;
use crate::pictures;
use crate::stress::exact;
use crate::stress::findings;
use crate::stress::markdown as stress;
use crate::study::markdown as study;
use crate::view::{BASELINE, View};

/// Why a document could not be spliced.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpliceError {
    /// No marker.
    #[error(
        "there is no marker; write `<!-- trisect:NAME -->` and `<!-- end of trisect:NAME -->` on \
         lines of their own, NAME being one of: {}",
        PARTS.map(|(name, _)| name).join(", ")
    )]
    NoMarker,
    /// A marker that opens and does not close.
    #[error("`<!-- trisect:{0} -->` has no `<!-- end of trisect:{0} -->` behind it")]
    Open(&'static str),
}

/// Writes a part from a record; nothing where the record says nothing about it.
type Write = fn(&View) -> String;

/// What can be spliced: its name, and what writes it.
const PARTS: [(&str, Write); 23] = [
    ("methods", methods),
    ("omissions", omissions::kernels::page),
    ("omissions-findings", omissions::markdown::findings),
    ("omissions-kernels", |view| {
        let table = omissions::markdown::kernels(view);
        omissions::markdown::unless_empty(view, &table, omissions::markdown::KERNELS)
    }),
    ("omissions-tracer", |view| {
        let table = omissions::markdown::tracer(view);
        omissions::markdown::unless_empty(view, &table, omissions::markdown::TRACER)
    }),
    ("omissions-pictures", |view| {
        let table = omissions::markdown::pictures(view);
        omissions::markdown::unless_empty(view, &table, omissions::markdown::PICTURES)
    }),
    ("havel", havel::page),
    ("stress-findings", findings::page),
    ("stress-f32", |view| part(view, &stress::methods(view, FloatFormat::F32), stress::METHODS)),
    ("stress-f64", |view| part(view, &stress::methods(view, FloatFormat::F64), stress::METHODS)),
    ("stress-watertight", |view| part(view, &stress::watertight(view), "")),
    ("stress-contract", |view| part(view, &stress::contract(view), "")),
    ("stress-special", |view| part(view, &stress::special_values(view), stress::SPECIAL)),
    ("stress-arithmetic", |view| part(view, &stress::arithmetic(view), stress::ARITHMETIC)),
    ("stress-exact", |view| part(view, &exact::exactness(view), exact::EXACTNESS)),
    ("stress-stages", |view| part(view, &exact::stages(view), exact::STAGES)),
    ("study-findings", study::findings),
    ("study-methods", |view| part(view, &study::methods(view), study::METHODS)),
    ("study-trees", |view| part(view, &study::trees(view), study::TREES)),
    ("study-threads", |view| part(view, &study::threads(view), study::THREADS)),
    ("pictures-findings", pictures::markdown::findings),
    ("pictures-sizes", |view| {
        part(view, &pictures::markdown::sizes(view), pictures::markdown::SIZES)
    }),
    ("pictures-techniques", |view| {
        part(view, &pictures::markdown::techniques(view), &pictures::markdown::techniques_say(view))
    }),
];

/// `document` with what stands between its markers made anew from a record; what the record says nothing
/// about stays as it is.
///
/// # Errors
/// When the document has no markers, or one that does not close.
pub fn splice(document: &str, records: &Records) -> Result<String, SpliceError> {
    let view = View::new(records);
    let mut text = document.to_owned();
    let mut found = false;
    for (name, write) in PARTS {
        let (begin, end) =
            (format!("<!-- trisect:{name} -->"), format!("<!-- end of trisect:{name} -->"));
        let Some((head, rest)) = text.split_once(&begin) else { continue };
        let (_, tail) = rest.split_once(&end).ok_or(SpliceError::Open(name))?;
        found = true;
        let written = write(&view);
        // A document may be made of several records.
        if !written.is_empty() {
            text = format!("{head}{begin}\n\n{written}\n{end}{tail}");
        }
    }
    if found { Ok(text) } else { Err(SpliceError::NoMarker) }
}

/// Who measured, where and how, in a sentence.
pub(crate) fn measured(view: &View) -> String {
    let m = &view.header.machine;
    format!(
        "Measured on {} at {} GHz ({}), {}, by `{}`.",
        m.cpu,
        number(m.core_ghz),
        m.instruction_sets.last().map_or("scalar", |set| set.name()),
        m.compiler,
        view.header.command
    )
}

/// Nanoseconds per test of the fastest variant that `keep` lets pass, over the main workloads.
pub(crate) fn fastest<'a>(
    view: &View<'a>,
    keep: impl Fn(&Variant) -> bool,
) -> Option<(&'a Variant, f64)> {
    view.comparable(keep).scores().first().copied()
}

/// A table with names in its first column and numbers in the others.
#[derive(Serialize)]
pub(crate) struct Table {
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(head: &[&str]) -> Self {
        Self { head: head.iter().map(ToString::to_string).collect(), rows: Vec::new() }
    }

    /// As Markdown, names as code.
    fn markdown(&self) -> String {
        let mut text = format!("| {} |\n| ---", self.head.join(" | "));
        text.push_str(&" | --:".repeat(self.head.len() - 1));
        text.push_str(" |\n");
        for row in &self.rows {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "| `{}` | {} |", row[0], row[1..].join(" | "));
        }
        text
    }
}

/// A part of a document: its table, and the sentence below it.
pub(crate) fn part(view: &View, table: &Table, says: &str) -> String {
    let says = if says.is_empty() { String::new() } else { format!("{says} ") };
    format!("{}\n{says}{}\n", table.markdown(), measured(view))
}

/// One table over all methods.
fn methods(view: &View) -> String {
    let mut table = String::from(
        "| method | year | source | × | + | ÷ | ≤ | bytes | hit | t | β γ | point | normal | err p50 \
         | err max | cracks |\n\
         | --- | --: | --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: \
         | --: |\n",
    );
    let single = |v: &Variant, method: &str, need: Output| {
        v.method == method && v.precision == FloatFormat::F32 && v.needs == need
    };
    let baseline = Output::ALL.iter().map(|&need| fastest(view, |v| single(v, BASELINE, need)));
    let baseline: Vec<_> = baseline.collect();
    for facts in &view.facts {
        let name = facts.name.as_str();
        let cost = facts
            .cost
            .iter()
            .rfind(|part| part.part.starts_with("test"))
            .map(|c| [c.multiplies, c.adds, c.divisions, c.comparisons].map(|n| n.to_string()));
        let cost = cost.unwrap_or_else(|| [0; 4].map(|_| "–".to_owned())).join(" | ");
        let relative: Vec<String> = Output::ALL
            .iter()
            .zip(&baseline)
            .map(|(&need, base)| {
                let mine = fastest(view, |v| single(v, name, need)).map(|(_, ns)| ns);
                let ratio = base.and_then(|(_, base)| Some(base / mine?));
                or_dash(ratio, |x| format!("{x:.2}"))
            })
            .collect();
        let error = view.pooled_error((name, FloatFormat::F32), "t", |_| true);
        let authors = facts.source.split(':').next().unwrap_or_default();
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "| `{name}` | {} | {authors} | {cost} | {} | {} | {} | {} | {} |",
            facts.year,
            facts.stored_numbers * size_of::<f32>(),
            relative.join(" | "),
            or_dash(error.map(|q| q.median), scientific),
            or_dash(error.map(|q| q.max), scientific),
            or_dash(view.cracks_per_million(name), number),
        );
    }
    let _ = writeln!(
        table,
        "\n×, +, ÷, ≤: products, sums, divisions and comparisons of a test, in the deferred form where \
         the method has that. bytes: per triangle, in f32. hit to normal: speed in f32 relative to \
         `{BASELINE}`'s, each by its fastest variant, when asked for whether there is a hit, t, t with \
         barycentrics, the point, t with the normal; a dash where the method does not give it. err: \
         median and largest relative error of t in f32. cracks: rays per million aimed at the edges of \
         a closed sphere that pass through it, in plain arithmetic. {}",
        measured(view)
    );
    table
}
