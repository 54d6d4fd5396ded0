//! The page: one file that asks the network for nothing.

use std::borrow::Cow;

use minijinja::Environment;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use serde::Serialize;
use trisect_core::{FloatFormat, Output};
use trisect_harness::record::{Header, Picture};

use crate::chapter::{Link, PageError};
use crate::chart::{Layout, draw};
use crate::figures;
use crate::format::{grouped, mtests, number, or_dash, ratio, scientific};
use crate::markdown::Table;
use crate::stats::{median, quartiles};
use crate::summary::{Summary, of_view};
use crate::theme::{css, inline_svg};
use crate::view::{View, finish_label, lanes_label, need_in_prose};

/// A page of a study: what it says, its figures and its tables.
pub(crate) struct Study {
    pub(crate) title: &'static str,
    pub(crate) heading: &'static str,
    pub(crate) findings: Vec<Finding>,
    pub(crate) tables: Vec<Titled>,
    pub(crate) pictures: Vec<Picture>,
}

/// One of the answers at the head of a page.
#[derive(Serialize)]
pub(crate) struct Finding {
    pub(crate) about: String,
    pub(crate) says: String,
    pub(crate) how: String,
}

/// A table with what stands above it.
#[derive(Serialize)]
pub(crate) struct Titled {
    pub(crate) id: &'static str,
    pub(crate) title: &'static str,
    pub(crate) says: Cow<'static, str>,
    pub(crate) table: Table,
}

impl Titled {
    pub(crate) fn new(
        id: &'static str,
        title: &'static str,
        says: impl Into<Cow<'static, str>>,
        table: Table,
    ) -> Self {
        Self { id, title, says: says.into(), table }
    }
}

#[derive(Serialize)]
struct StudyContext<'a> {
    style: String,
    header: &'a Header,
    ghz: String,
    title: &'static str,
    heading: &'static str,
    links: Vec<Link>,
    findings: Vec<Finding>,
    figures: Vec<FigureOnPage>,
    tables: Vec<Titled>,
    pictures: Vec<Picture>,
}

/// Draws the page of a study and its figures.
pub(crate) fn draw_study(
    view: &View,
    links: Vec<Link>,
    drawings: Vec<figures::Figure>,
    study: Study,
) -> Result<Drawn, PageError> {
    let Study { title, heading, findings, tables, pictures } = study;
    let fill_in = |figures| {
        render(
            "study.html",
            StudyContext {
                style: style(),
                header: view.header,
                ghz: number(view.header.machine.core_ghz),
                title,
                heading,
                links,
                findings,
                figures,
                tables,
                pictures,
            },
        )
    };
    Drawn::of(view, drawings, fill_in)
}

/// Draws the page of a comparison and its figures.
pub(crate) fn draw_comparison(view: &View, links: Vec<Link>) -> Result<Drawn, PageError> {
    Drawn::of(view, figures::all(view), |on_page| fill_in(view, on_page, links))
}

/// The page and its files in memory.
pub(crate) struct Drawn {
    pub(crate) html: String,
    /// Name and text of each figure's file.
    pub(crate) files: Vec<(String, String)>,
}

/// A figure as a page shows it.
#[derive(Serialize)]
struct FigureOnPage {
    name: &'static str,
    title: &'static str,
    caption: String,
    wide: String,
    narrow: String,
    missing: Option<String>,
}

/// A cell of the table of variants: what is shown and what is sorted by.
#[derive(Serialize)]
struct Cell {
    text: String,
    /// `None` sorts last.
    value: Option<f64>,
}

#[derive(Serialize)]
struct VariantRow {
    method: String,
    lanes: String,
    needs: Output,
    finish: String,
    cells: Vec<Cell>,
}

#[derive(Serialize)]
struct WinnerText {
    need: &'static str,
    method: String,
    variant: String,
    speed: String,
    ratios: Vec<String>,
}

#[derive(Serialize)]
struct FrontText {
    method: String,
    variant: String,
    ns: String,
    error: String,
}

#[derive(Serialize)]
struct AgreementRow {
    workload: String,
    precision: FloatFormat,
    rays: String,
    unanimous: String,
    share: String,
    differs: String,
}

#[derive(Serialize)]
struct WorkloadRow {
    name: String,
    description: String,
    rays: String,
    triangles: String,
    hit_rate: String,
    exact: String,
}

#[derive(Serialize)]
struct MethodText {
    title: String,
    name: String,
    year: u16,
    source: String,
    numbers: usize,
    /// What a triangle is given as.
    input: String,
    /// What a hit cannot be asked for.
    lacks: String,
    claims: String,
    /// Rays per million that pass through a closed surface at its edges.
    cracks: Option<String>,
    /// Workloads that the method cannot take, with its reason.
    refusals: Vec<String>,
}

#[derive(Serialize)]
struct Context<'a> {
    style: String,
    header: &'a Header,
    ghz: String,
    winners: Vec<WinnerText>,
    front: Vec<FrontText>,
    figures: Vec<FigureOnPage>,
    preparation: Vec<[String; 4]>,
    variants: Vec<VariantRow>,
    columns: [(&'static str, &'static str); 10],
    agreement: Vec<AgreementRow>,
    workloads: Vec<WorkloadRow>,
    methods: Vec<MethodText>,
    links: Vec<Link>,
}

/// Columns of the table of variants after the names, with what they mean.
const COLUMNS: [(&str, &str); 10] = [
    ("M tests/s", "million tests per second, geometric mean over the workloads that all ran"),
    ("quartiles", "first and third quartile of the samples, each over its workload's median"),
    ("cycles", "cycles per test: nanoseconds times the measured frequency"),
    ("err t", "median relative error of t against exact arithmetic"),
    ("p99 t", "99th percentile of the relative error of t"),
    ("max t", "largest relative error of t"),
    ("err β", "median relative error of beta"),
    ("err γ", "median relative error of gamma"),
    ("bytes", "bytes of prepared data per triangle"),
    ("wrong/M", "false hits and false misses per million pairs"),
];

impl Drawn {
    /// Draws figures, and fills them into a page.
    fn of(
        view: &View,
        figures: Vec<figures::Figure>,
        fill_in: impl FnOnce(Vec<FigureOnPage>) -> Result<String, minijinja::Error>,
    ) -> Result<Self, PageError> {
        let mut files = Vec::new();
        let mut on_page = Vec::new();
        for figure in figures {
            let mut shown = FigureOnPage {
                name: figure.name,
                title: figure.title,
                caption: figure.caption,
                wide: String::new(),
                narrow: String::new(),
                missing: None,
            };
            match figure.drawing {
                Err(missing) => shown.missing = Some(missing),
                Ok(drawing) => {
                    let narrow_name = format!("{}-narrow", figure.name);
                    let says = format!("{} {}", shown.caption, measured_by(view));
                    let draw =
                        |layout, name: &str| draw(&drawing, layout, name, figure.title, &says);
                    let wide = draw(Layout::Wide, figure.name)?;
                    let narrow = draw(Layout::Narrow, &narrow_name)?;
                    shown.wide = inline_svg(&wide);
                    shown.narrow = inline_svg(&narrow);
                    files.push((format!("{}.svg", figure.name), wide));
                    files.push((format!("{narrow_name}.svg"), narrow));
                }
            }
            on_page.push(shown);
        }
        let html = fill_in(on_page)?;
        Ok(Self { html, files })
    }
}

/// How the numbers of a figure came about.
fn measured_by(view: &View) -> String {
    let (h, m) = (view.header, &view.header.machine);
    format!(
        "Measured on {} ({}) with {}, by the command: {}",
        m.cpu,
        m.instruction_sets.iter().map(|set| set.name()).collect::<Vec<_>>().join(", "),
        m.compiler,
        h.command
    )
}

fn fill_in(
    view: &View,
    figures: Vec<FigureOnPage>,
    links: Vec<Link>,
) -> Result<String, minijinja::Error> {
    let summary = of_view(view);
    let context = Context {
        style: style(),
        header: view.header,
        ghz: number(view.header.machine.core_ghz),
        winners: winners(view, &summary),
        front: front(view, &summary),
        figures,
        preparation: figures::preparation(view),
        variants: variants(view),
        columns: COLUMNS,
        agreement: agreement(view),
        workloads: workloads(view),
        methods: methods(view),
        links,
    };
    render("page.html", context)
}

/// Fills in one of the templates.
fn render(template: &str, context: impl Serialize) -> Result<String, minijinja::Error> {
    let mut env = Environment::new();
    env.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    for (name, text) in [
        ("parts.html", include_str!("../templates/parts.html")),
        ("page.html", include_str!("../templates/page.html")),
        ("page.js", include_str!("../templates/page.js")),
        ("study.html", include_str!("../templates/study.html")),
    ] {
        env.add_template(name, text)?;
    }
    env.get_template(template)?.render(Serde(context))
}

/// The style sheet of all pages.
fn style() -> String {
    format!("{}{}", css(), include_str!("../templates/page.css"))
}

fn winners(view: &View, summary: &Summary) -> Vec<WinnerText> {
    let said = |w: &crate::Winner| {
        let over = |x: Option<f64>, what: &str| x.map(|x| format!("{} {what}", ratio(x)));
        let ratios = [
            over(w.over_own_scalar, "its own scalar f32 form"),
            over(w.over_scalar_moller_trumbore, "scalar Möller–Trumbore"),
        ];
        WinnerText {
            need: need_in_prose(w.needs),
            method: view.title(&w.variant.method),
            variant: format!("{}, {}", lanes_label(&w.variant), finish_label(&w.variant)),
            speed: number(w.million_tests_per_second),
            ratios: ratios.into_iter().flatten().collect(),
        }
    };
    summary.winners.iter().map(said).collect()
}

fn front(view: &View, summary: &Summary) -> Vec<FrontText> {
    let said = |p: &crate::FrontPoint| FrontText {
        method: view.title(&p.variant.method),
        variant: format!("{}, {}", lanes_label(&p.variant), p.variant.division),
        ns: number(p.ns_per_test),
        error: scientific(p.error),
    };
    summary.front.iter().map(said).collect()
}

fn variants(view: &View) -> Vec<VariantRow> {
    let mut rows = Vec::new();
    for &need in view.needs() {
        let comparable = view.comparable(|v| v.needs == need);
        for (v, ns) in comparable.scores() {
            let mut relative = Vec::new();
            let mut bytes = None;
            for t in comparable.workloads.iter().filter_map(|w| view.throughput[v].get(w)) {
                bytes = Some(t.bytes_per_triangle as f64);
                let samples: Vec<f64> = t.samples_ns.iter().map(|&ns| ns as f64).collect();
                if let Some(middle) = median(&samples) {
                    relative.extend(samples.iter().map(|ns| middle / ns.max(1.0)));
                }
            }
            let spread = quartiles(&relative).map(|(a, b)| (mtests(ns) * a, mtests(ns) * b));
            let (t, beta, gamma) =
                (view.error(v, "t"), view.error(v, "beta"), view.error(v, "gamma"));
            let cell = |value: Option<f64>, write| Cell { text: or_dash(value, write), value };
            rows.push(VariantRow {
                method: v.method.to_string(),
                lanes: lanes_label(v),
                needs: v.needs,
                finish: finish_label(v),
                cells: vec![
                    cell(Some(mtests(ns)), number),
                    Cell {
                        text: spread.map_or_else(
                            || "–".into(),
                            |(a, b)| format!("{}–{}", number(a), number(b)),
                        ),
                        value: spread.map(|(a, b)| b - a),
                    },
                    cell(Some(ns * view.header.machine.core_ghz), number),
                    cell(t.map(|q| q.median), scientific),
                    cell(t.map(|q| q.p99), scientific),
                    cell(t.map(|q| q.max), scientific),
                    cell(beta.map(|q| q.median), scientific),
                    cell(gamma.map(|q| q.median), scientific),
                    cell(bytes, |b| format!("{b}")),
                    cell(wrong(view, v), number),
                ],
            });
        }
    }
    rows
}

/// Wrong decisions of a variant; needs, arrangement and width do not change them.
fn wrong(view: &View, variant: &trisect_harness::record::Variant) -> Option<f64> {
    view.wrong_per_million((&variant.method, variant.precision), |v| v.rounds_like(variant))
}

fn share(part: f64, whole: f64) -> String {
    if whole > 0.0 { format!("{} %", number(part / whole * 100.0)) } else { "–".into() }
}

fn agreement(view: &View) -> Vec<AgreementRow> {
    view.agreements
        .iter()
        .map(|a| {
            let differs: Vec<String> = a
                .differs_from_oracle
                .iter()
                .filter(|m| m.count > 0)
                .map(|m| format!("{} {}", m.method, grouped(m.count as u64)))
                .collect();
            AgreementRow {
                workload: a.workload.clone(),
                precision: a.precision,
                rays: grouped(a.rays as u64),
                unanimous: grouped(a.unanimous as u64),
                share: share(a.unanimous as f64, a.rays as f64),
                differs: if differs.is_empty() { "none".into() } else { differs.join(", ") },
            }
        })
        .collect()
}

fn workloads(view: &View) -> Vec<WorkloadRow> {
    view.workloads
        .values()
        .map(|w| WorkloadRow {
            name: w.name.clone(),
            description: w.description.clone(),
            rays: grouped(w.rays as u64),
            triangles: grouped(w.triangles as u64),
            hit_rate: share(w.hit_rate, 1.0),
            exact: share(w.oracle_exact as f64, w.oracle_tests as f64),
        })
        .collect()
}

fn methods(view: &View) -> Vec<MethodText> {
    view.facts
        .iter()
        .map(|m| MethodText {
            title: m.title.clone(),
            name: m.name.clone(),
            year: m.year,
            source: m.source.clone(),
            numbers: m.stored_numbers,
            input: m.input.map_or_else(String::new, |input| input.name().replace('-', " ")),
            lacks: Output::ALL
                .iter()
                .filter(|need| !m.outputs.is_empty() && !m.outputs.contains(need))
                .map(|need| need.name())
                .collect::<Vec<_>>()
                .join(", "),
            claims: m.claims.join(", "),
            cracks: view.cracks_per_million(&m.name).map(number),
            refusals: view
                .refusals
                .iter()
                .filter(|r| r.method == m.name && r.precision == FloatFormat::F32)
                .map(|r| format!("{} ({})", r.workload, r.reason))
                .collect(),
        })
        .collect()
}
