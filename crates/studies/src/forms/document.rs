//! What a record of forms says: of Havel's statements, of borders, of compilers, and beside Morozov.

use trisect_core::InstructionSet;
use trisect_kernels::Arrangement::{OneRay, OneTriangle};
use trisect_machine::forms::{Border, FormTime, FormVariant, TestForm};
use trisect_method::ReciprocalKind;
use trisect_report::document::{Content, Document, Section, Shown};
use trisect_report::format::{number, ratio};
use trisect_report::stats::{geometric_mean, ns_per_test};
use trisect_report::table::Table;

use super::morozov;
use super::pairs::{Change, Forms, WORKLOADS};
use crate::lines::{distinct, source};
use crate::record::Records;
use crate::statement::{Statement, found, said, unmeasured};

pub(super) fn document(records: &Records) -> Document {
    let forms = Forms::new(records);
    let statements =
        [first, moved, worst, signs, newton, packets, layout].map(|statement| statement(&forms));
    let paragraph = |(says, figures): &Statement| {
        Section::prose(format!("{says} {figures}")).shown(Shown::Terminal)
    };
    let mut sections: Vec<Section> = statements.iter().map(paragraph).collect();
    let statements =
        Section::new("havel", "Moving the division", Content::List(statements.to_vec()));
    sections.push(statements.part("havel-forms"));
    sections.extend(WORKLOADS.iter().enumerate().map(|(place, (workload, says))| {
        let part = if place == 0 { "havel-forms" } else { "" };
        times(&forms, workload, says).part(part)
    }));
    sections.push(borders(records));
    sections.push(compilers(records));
    sections.extend(morozov::sections(records));
    Document {
        title: "Forms of a ray–triangle test",
        heading: "Forms of a test",
        source: source(&records.header),
        sections,
    }
}

/// A change of form, one ray at a time.
fn change(from: TestForm, to: TestForm, early_out: bool) -> Change {
    Change { from, to, early_out, arrangement: OneRay }
}

/// A change on every workload, one number at a time: the first in full.
fn on_all(forms: &Forms<'_>, asked: &Change, first: &str) -> String {
    let full = forms.form(1, first, asked).each();
    let says = |name: &str| WORKLOADS.iter().find(|(n, _)| *n == name).map_or("", |(_, says)| says);
    let others = WORKLOADS.iter().filter(|(name, _)| *name != first);
    let others =
        others.map(|(name, says)| format!("{says}: {}", forms.form(1, name, asked).mean()));
    format!("Scalar, {}: {full}; {}.", says(first), others.collect::<Vec<_>>().join("; "))
}

/// A change on random pairs on all lanes, means alone.
fn on_lanes(forms: &Forms<'_>, asked: &Change) -> String {
    let wide = forms.lanes().into_iter().filter(|(width, _)| *width > 1);
    let each = wide.map(|(width, set)| {
        format!("{width} lanes ({set}) {}", forms.form(width, WORKLOADS[0].0, asked).mean())
    });
    each.collect::<Vec<_>>().join(", ")
}

fn first(forms: &Forms<'_>) -> Statement {
    let asked = change(TestForm::Deferred, TestForm::TFirst, true);
    found(
        "5.1.1: the winners win because they test t first.",
        forms.form(1, WORKLOADS[0].0, &asked).gains(),
        format!(
            "t first over the inside first, both deferred. {}",
            on_all(forms, &asked, WORKLOADS[0].0)
        ),
    )
}

fn moved(forms: &Forms<'_>) -> Statement {
    let asked = change(TestForm::Early, TestForm::TFirst, true);
    let few = WORKLOADS[1].0;
    let lanes = change(TestForm::Early, TestForm::Deferred, true);
    found(
        "5.2: where tests end early, moving the division behind them gains much.",
        forms.form(1, few, &asked).gains(),
        format!(
            "Deferred over early, both with t first. {} Lanes, which end in one place behind all tests: {}.",
            on_all(forms, &asked, few),
            on_lanes(forms, &lanes)
        ),
    )
}

fn worst(forms: &Forms<'_>) -> Statement {
    let asked = change(TestForm::Early, TestForm::Deferred, false);
    found(
        "5.2: in the worst case it costs nothing marked, though Wald pays five more products and the planes six.",
        forms.form(1, WORKLOADS[0].0, &asked).costs_nothing(),
        format!(
            "Exits disabled, deferred over early. {} {}. The planes deferred are `havel-herout` here, which has no \
             early form.",
            on_all(forms, &asked, WORKLOADS[0].0),
            on_lanes(forms, &asked)
        ),
    )
}

fn signs(forms: &Forms<'_>) -> Statement {
    let scalar = change(TestForm::TFirst, TestForm::Signs, true);
    let wide = [true, false]
        .map(|exits| on_lanes(forms, &change(TestForm::Deferred, TestForm::Signs, exits)));
    said(
        "4.2.4: tests by sign bits, without turning numerators.",
        format!(
            "No claim about speed. Signs over comparisons, both deferred with t first. {} Lanes that end early: {}; \
             that do not: {}. What they do on borders stands below.",
            on_all(forms, &scalar, WORKLOADS[0].0),
            wide[0],
            wide[1]
        ),
    )
}

fn newton(forms: &Forms<'_>) -> Statement {
    let each = forms.lanes().into_iter().filter(|(width, _)| *width > 1).map(|(width, set)| {
        let keep = |v: &FormVariant| {
            v.form == TestForm::Early
                && !v.early_out
                && v.arrangement == OneRay
                && v.reciprocal == ReciprocalKind::True
        };
        let newton = |v: &mut FormVariant| v.reciprocal = ReciprocalKind::Newton;
        format!(
            "{width} lanes ({set}) {}",
            forms.changed(width, WORKLOADS[0].0, keep, newton).mean()
        )
    });
    said(
        "4.2.1: a reciprocal estimate with one Newton step.",
        format!(
            "No claim about speed. Over true division, the early form, exits disabled: {}.",
            each.collect::<Vec<_>>().join(", ")
        ),
    )
}

fn packets(forms: &Forms<'_>) -> Statement {
    let exits = |workload: &str, width: usize| {
        let keep = |v: &FormVariant| {
            v.form == TestForm::Early
                && !v.early_out
                && v.arrangement == OneTriangle
                && v.reciprocal == ReciprocalKind::True
        };
        forms.changed(width, workload, keep, |v| v.early_out = true)
    };
    let each = forms.lanes().into_iter().filter(|(width, _)| *width > 1).map(|(width, set)| {
        let each = WORKLOADS.map(|(name, says)| format!("{} ({says})", exits(name, width).mean()));
        format!("{width} lanes ({set}) {}", each.join(", "))
    });
    said(
        "4.2.2: packets of four that end early, and fall apart into single rays.",
        format!(
            "No claim about speed. Packets that end early over those that do not: {}. Rays that leave a packet are \
             not measured.",
            each.collect::<Vec<_>>().join("; ")
        ),
    )
}

fn layout(_: &Forms<'_>) -> Statement {
    unmeasured(
        "4.2.3: arrays of structures, structures of arrays, and blocks.",
        "Triangles lie in blocks of sixteen throughout.",
    )
}

/// A row per method and lanes, a column per form, with exits and without.
fn times(forms: &Forms<'_>, workload: &'static str, says: &str) -> Section {
    let methods = distinct(forms.times.iter().map(|time| time.variant.method.as_str()));
    let rows: Vec<(&str, (usize, InstructionSet))> = forms
        .lanes()
        .into_iter()
        .flat_map(|lanes| methods.iter().map(move |method| (*method, lanes)))
        .collect();
    let ns = |(method, (width, set)): &(&str, (usize, InstructionSet)), form, early_out| {
        let is_it = |time: &&&FormTime| {
            let v = &time.variant;
            v.method == *method
                && (v.width, v.instruction_set) == (*width, *set)
                && (v.form, v.early_out) == (form, early_out)
                && v.arrangement == OneRay
                && v.reciprocal == ReciprocalKind::True
                && time.workload == workload
        };
        let time = forms.times.iter().find(is_it)?;
        ns_per_test(&time.samples_ns, time.tests)
    };
    let mut table = Table::of(&rows).name("method", |(method, _)| *method).text(
        "lanes",
        |(_, (width, set))| {
            if *width == 1 { "scalar".to_owned() } else { format!("{width} {set}") }
        },
    );
    for (early_out, after) in [(true, ""), (false, ", no exits")] {
        for form in TestForm::ALL {
            if *form != TestForm::TFirst || early_out {
                let head = format!("{form}{after}");
                table = table.number(head, number, move |row| ns(row, *form, early_out));
            }
        }
    }
    let says = format!(
        "Nanoseconds per test in f32, one ray at a time, on pairs of which {says}, asked for t with barycentrics, medians over rounds. \
         Lanes end in one place, behind all tests, so that t cannot come first. Called directly, not through the catalogue."
    );
    let id = match workload {
        "random" => "times",
        "hit-rate/2" => "times-few",
        _ => "times-many",
    };
    Section::table(id, format!("Forms beside each other, {workload}"), says, table.done())
        .missing("Left out: the record times no forms.")
}

/// What forms decide where numerators are zero, over the methods that have all forms.
fn borders(records: &Records) -> Section {
    let all: Vec<&Border> = records.all().collect();
    let has = |method: &str, form| all.iter().any(|b| b.method == method && b.form == form);
    let both = |b: &&&Border| has(&b.method, TestForm::Early) && has(&b.method, TestForm::Signs);
    let sets = distinct(all.iter().map(|b| b.set.as_str()));
    let forms = [TestForm::Early, TestForm::Deferred, TestForm::Signs];
    let rows: Vec<(&str, TestForm)> =
        sets.iter().flat_map(|set| forms.map(|form| (*set, form))).collect();
    let sum = |(set, form): &(&str, TestForm), of: fn(&Border) -> u64| {
        let mine = all.iter().filter(both).filter(|b| b.set == *set && b.form == *form);
        mine.map(|b| of(b)).sum::<u64>()
    };
    let table = Table::of(&rows)
        .name("pairs", |(set, _)| *set)
        .text("form", |(_, form)| form.name())
        .count("tested", |row| sum(row, |b| b.pairs))
        .count("false hits", |row| sum(row, |b| b.false_hits))
        .count("false misses", |row| sum(row, |b| b.false_misses))
        .count("rays", |row| sum(row, |b| b.rays))
        .count("escaped", |row| sum(row, |b| b.escaped))
        .done();
    let methods = distinct(all.iter().filter(both).map(|b| b.method.as_str()));
    let says = format!(
        "Decisions against the oracle, over {} methods in f32, one number at a time. Families are those of the \
         stability study at their hardest; surfaces are closed, and rays from inside are aimed at their edges and \
         corners. rays, escaped: of those the rays, and how many hit nothing. A comparison takes a zero numerator for a \
         hit; signs take it as its sign has it, so that they lose hits where coordinates are on a lattice.",
        methods.len()
    );
    Section::table("borders", "What forms decide on borders", says, table).part("havel-forms")
}

/// A row per setting of the compiler.
fn compilers(records: &Records) -> Section {
    let all: Vec<&FormTime> = records.all().collect();
    let settings = distinct(all.iter().map(|time| time.compiler.as_str()));
    let settings = if settings.len() > 1 { settings } else { Vec::new() };
    let widths = Forms::new(records).lanes();
    let is = |time: &&&FormTime, setting: &str, width: usize| {
        time.compiler == setting && time.variant.width == width && time.workload == WORKLOADS[0].0
    };
    let ns = |time: &FormTime| ns_per_test(&time.samples_ns, time.tests);
    // Of each form the speed over that of another: compiled otherwise, or changed.
    let mean = |setting: &str, width: usize, other: &dyn Fn(&FormTime) -> Option<FormTime>| {
        let ratios = all.iter().filter(|time| is(time, setting, width)).filter_map(|time| {
            let like = other(time)?;
            let is_like = |t: &&&FormTime| {
                t.variant == like.variant
                    && t.compiler == like.compiler
                    && t.workload == like.workload
            };
            Some(ns(all.iter().find(is_like)?)? / ns(time)?)
        });
        geometric_mean(ratios.collect::<Vec<_>>())
    };
    let mut table = Table::of(&settings).name("compiler", |setting| {
        if setting.is_empty() { "as the project has it".to_owned() } else { (*setting).to_owned() }
    });
    for &(width, _) in &widths {
        table = table.number(format!("speed ×{width}"), ratio, move |setting| {
            mean(setting, width, &|time| Some(FormTime { compiler: String::new(), ..time.clone() }))
        });
    }
    for &(width, _) in &widths {
        table = table.number(format!("deferred ×{width}"), ratio, move |setting| {
            mean(setting, width, &|time| {
                let v = &time.variant;
                let asked = v.form == TestForm::Deferred && !v.early_out && v.arrangement == OneRay;
                let variant = FormVariant { form: TestForm::Early, ..v.clone() };
                asked.then(|| FormTime { variant, ..time.clone() })
            })
        });
    }
    let says = "By settings of the compiler, on random pairs. speed: over the project's settings, geometric mean over all \
                methods and forms, on so many lanes. deferred: the deferred form over the early one, exits disabled. Runs \
                follow one another, so that these are no paired ratios.";
    Section::table("compilers", "Settings of the compiler", says, table.done()).part("havel-forms")
}
