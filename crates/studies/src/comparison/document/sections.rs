//! What the comparison says.

use crate::comparison::record::{Agreement, MethodFacts, PartCost, Refusal, Workload};
use crate::record::{Records, Variant};
use trisect_core::FloatFormat::{self, F32};
use trisect_method::Output;

use super::answers::Answers;
use super::view::{BASELINE, View, finish_label, lanes_label};
use super::{figures, havel};
use crate::lines::source;
use trisect_report::document::{Content, Document, Section, Shown};
use trisect_report::format::{fixed, grouped, mtests, number, scientific};
use trisect_report::stats::{median, quartiles};
use trisect_report::table::{Cell, Kind, Table, count};

pub(crate) fn document(records: &Records) -> Document {
    let view = &View::new(records);
    let mut sections = Answers::of(view).sections(view);
    if sections.is_empty() {
        let missing = "Nothing was timed, so nothing is the fastest.";
        sections.push(Section::prose("").shown(Shown::Everywhere).missing(missing));
    }
    sections.extend(figures::all(view));
    sections.extend([
        preparation(view),
        variants(view),
        agreement(view),
        workloads(view),
        methods(view),
    ]);
    sections.push(costs(view));
    sections.extend(havel::sections(view));
    Document {
        title: "Ray–triangle intersection, measured",
        heading: "Ray–triangle intersection, measured",
        source: source(&records.header),
        sections,
    }
}

/// Preparation time and bytes of each method and precision: a table is their best figure.
fn preparation(view: &View) -> Section {
    let pairs =
        view.methods().iter().flat_map(|m| view.precisions().into_iter().map(move |p| (*m, p)));
    let rows: Vec<(&str, FloatFormat, f64)> =
        pairs.filter_map(|(m, p)| Some((m, p, view.preparation(m, p)?))).collect();
    let table = Table::of(&rows)
        .text("method", |(method, ..)| view.title(method))
        .text("precision", |(_, precision, _)| precision.name())
        .number("ns per triangle", number, |(.., ns)| *ns)
        .number("bytes per triangle", count, |(m, p, _)| view.bytes(m, *p).map(|b| b as f64))
        .done();
    let says = "What a triangle costs before it is tested: the median time to prepare it, and the bytes it \
                then takes.";
    Section::table("preparation", "Preparation", says, table)
        .missing("Left out: the record holds no preparation times.")
}

/// A variant as the table of all shows it.
struct Shape<'a> {
    variant: &'a Variant,
    ns: f64,
    /// Quartiles of the samples, each over its workload's median.
    spread: Option<(f64, f64)>,
    bytes: Option<usize>,
}

fn variants(view: &View) -> Section {
    let mut rows = Vec::new();
    for &need in view.needs() {
        let comparable = view.comparable(|v| v.needs == need);
        let mut seen = Vec::new();
        for (variant, ns) in comparable.scores() {
            let of = (variant.method.as_ref(), variant.lane());
            if seen.contains(&of) {
                continue;
            }
            seen.push(of);
            let mut relative = Vec::new();
            let mut bytes = None;
            for t in comparable.workloads.iter().filter_map(|w| view.throughput[variant].get(w)) {
                bytes = Some(t.bytes_per_triangle);
                let samples: Vec<f64> = t.samples_ns.iter().map(|&ns| ns as f64).collect();
                if let Some(middle) = median(&samples) {
                    relative.extend(samples.iter().map(|ns| middle / ns.max(1.0)));
                }
            }
            rows.push(Shape { variant, ns, spread: quartiles(&relative), bytes });
        }
    }
    let ghz = view.records.header.machine.core_ghz;
    let error = |row: &Shape, quantity| view.error(row.variant, quantity);
    let table = Table::of(&rows)
        .text("method", |row| row.variant.method.as_ref())
        .text("lanes", |row| lanes_label(row.variant))
        .text("variant", |row| finish_label(row.variant))
        .text("asked for", |row| row.variant.needs.name())
        .number("M tests/s", number, |row| mtests(row.ns))
        .note("million tests per second, geometric mean over the workloads that all ran")
        .cells("quartiles", Kind::Number, |row| {
            let (low, high) = row.spread?;
            Some(Cell::Range([low, high].map(|share| mtests(row.ns) * share), number))
        })
        .note("first and third quartile of the samples, each over its workload's median")
        .number("cycles", number, |row| row.ns * ghz)
        .note("cycles per test: nanoseconds times the measured frequency")
        .number("err t", scientific, |row| error(row, "t").map(|q| q.median))
        .note("median relative error of t against exact arithmetic")
        .number("p99 t", scientific, |row| error(row, "t").map(|q| q.p99))
        .note("99th percentile of the relative error of t")
        .number("max t", scientific, |row| error(row, "t").map(|q| q.max))
        .note("largest relative error of t")
        .number("err β", scientific, |row| error(row, "beta").map(|q| q.median))
        .note("median relative error of beta")
        .number("err γ", scientific, |row| error(row, "gamma").map(|q| q.median))
        .note("median relative error of gamma")
        .number("bytes", count, |row| row.bytes.map(|b| b as f64))
        .note("bytes of prepared data per triangle")
        .number("wrong/M", number, |row| wrong(view, row.variant))
        .note("false hits and false misses per million pairs")
        .filtered("f32 avx2 deferred");
    let says = format!(
        "{} variants: of each method on each kind of lanes the fastest for what is asked; `trisect rank` lists \
         all. A button in the head sorts by its column, a second press reverses the order. Errors are \
         relative, against exact arithmetic.",
        rows.len()
    );
    Section::table("variants", "Variants", says, table)
        .missing("Left out: the record holds no throughput.")
}

/// Wrong decisions of a variant; needs, arrangement and width do not change them.
fn wrong(view: &View, variant: &Variant) -> Option<f64> {
    view.wrong_per_million((&variant.method, variant.precision), |v| v.rounds_like(variant))
}

/// A share in per cent, to three digits.
fn share(x: f64) -> String {
    format!("{} %", number(x * 100.0))
}

fn agreement(view: &View) -> Section {
    let rows: Vec<&Agreement> = view.all().collect();
    let differs = |a: &&Agreement| {
        let some = a.differs_from_oracle.iter().filter(|m| m.count > 0);
        let some = some.map(|m| format!("{} {}", m.method, grouped(m.count as u64)));
        let some = some.collect::<Vec<_>>().join(", ");
        if some.is_empty() { "none".to_owned() } else { some }
    };
    let table = Table::of(&rows)
        .text("workload", |a| &a.workload)
        .text("precision", |a| a.precision.name())
        .count("rays", |a| a.rays as u64)
        .count("unanimous", |a| a.unanimous as u64)
        .number("share", share, |a| (a.rays > 0).then(|| a.unanimous as f64 / a.rays as f64))
        .text("differ from the oracle", differs)
        .done();
    let says = "Whether all methods pick the same closest triangle for each ray, and how many rays of each \
                method end elsewhere than the oracle says.";
    Section::table("agreement", "Agreement", says, table)
        .missing("Left out: the record does not say which triangle each method picks.")
}

fn workloads(view: &View) -> Section {
    let rows: Vec<&Workload> = view.workloads.values().copied().collect();
    let table = Table::of(&rows)
        .text("workload", |w| &w.name)
        .count("rays", |w| w.rays as u64)
        .count("triangles", |w| w.triangles as u64)
        .number("hits", share, |w| w.hit_rate)
        .number("exact", share, |w| {
            (w.oracle_tests > 0).then(|| w.oracle_exact as f64 / w.oracle_tests as f64)
        })
        .prose("what it is", |w| &w.description)
        .done();
    let says = "exact: the share of the oracle's answers that needed exact arithmetic; the others were \
                certain in floating point.";
    Section::table("workloads", "Workloads", says, table)
        .missing("Left out: the record describes no workloads.")
}

fn methods(view: &View) -> Section {
    let item = |m: &&MethodFacts| {
        let lacks = Output::ALL.iter().filter(|need| !m.outputs.contains(need));
        let lacks = lacks.map(|need| need.name()).collect::<Vec<_>>().join(", ");
        let input = m.input.map(|input| format!(", given {}", input.name().replace('-', " ")));
        let numbers = format!("{} numbers per triangle", m.stored_numbers);
        let mut said = vec![format!("`{}`, {numbers}{}", m.name, input.unwrap_or_default())];
        if !lacks.is_empty() && !m.outputs.is_empty() {
            said.push(format!("does not give {lacks}"));
        }
        if !m.claims.is_empty() {
            said.push(format!("claims: {}", m.claims.join(", ")));
        }
        if let Some(cracks) = view.cracks_per_million(&m.name) {
            said.push(format!("{} of a million rays aimed at edges pass through", number(cracks)));
        }
        let refusals = view.all::<Refusal>().filter(|r| r.method == m.name && r.precision == F32);
        said.extend(refusals.map(|r| format!("left out of {} ({})", r.workload, r.reason)));
        (format!("**{}** ({}),", m.title, m.year), format!("{}. {}", said.join("; "), m.source))
    };
    let items = view.facts.iter().map(item).collect();
    Section::new("methods", "Methods", Content::List(items))
        .missing("Left out: the record describes no methods.")
}

/// One table over all methods, for the documents.
fn costs(view: &View) -> Section {
    // Counted anew, as what a method costs is no measurement, and older versions left out products with a
    // stored 1; as recorded of a method that is no more.
    fn test(facts: &MethodFacts) -> Option<PartCost> {
        let counted = trisect_catalog::find(&facts.name).map(|entry| MethodFacts::of(entry).cost);
        let cost = counted.unwrap_or_else(|| facts.cost.clone());
        cost.into_iter().rfind(|part| part.part.starts_with("test"))
    }
    let fastest = |method: &str, need: Output| {
        let keep = |v: &Variant| v.method == method && v.precision == F32 && v.needs == need;
        view.fastest(keep).map(|(_, ns)| ns)
    };
    let error = |m: &&MethodFacts| view.pooled_error((&m.name, F32), "t", |_| true);
    let mut table = Table::of(&view.facts)
        .name("method", |m| &m.name)
        .number("year", |x| x.to_string(), |m| f64::from(m.year))
        .text("source", |m| m.source.split(':').next().unwrap_or_default())
        .number("×", count, |m| test(m).map(|c| f64::from(c.multiplies)))
        .number("+", count, |m| test(m).map(|c| f64::from(c.adds)))
        .number("÷", count, |m| test(m).map(|c| f64::from(c.divisions)))
        .number("≤", count, |m| test(m).map(|c| f64::from(c.comparisons)))
        .number("bytes", count, |m| (m.stored_numbers * size_of::<f32>()) as f64);
    for (&need, head) in Output::ALL.iter().zip(["hit", "t", "β γ", "point", "normal"]) {
        let base = fastest(BASELINE, need);
        table = table.number(head, fixed, |m| Some(base? / fastest(&m.name, need)?));
    }
    let table = table
        .number("err p50", scientific, |m| Some(error(m)?.median))
        .number("err max", scientific, |m| Some(error(m)?.max))
        .number("cracks", number, |m| view.cracks_per_million(&m.name))
        .done();
    let says = format!(
        "×, +, ÷, ≤: products, sums, divisions and comparisons of a test, in the deferred form where the \
         method has that. bytes: per triangle, in f32. hit to normal: speed in f32 relative to \
         `{BASELINE}`'s, each by its fastest variant, when asked for whether there is a hit, t, t with \
         barycentrics, the point, t with the normal; a dash where the method does not give it. err: median \
         and largest relative error of t in f32. cracks: rays per million aimed at the edges of a closed \
         sphere that pass through it, in plain arithmetic."
    );
    Section::table("", "", says, table).part("methods").shown(Shown::Part)
}
