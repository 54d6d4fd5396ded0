//! The figures of the stability study.

use crate::record::Variant;
use crate::stress::record::{Bin, ByCondition, Site, StressFamily, StressLevel, SurfaceCracks};
use trisect_core::FloatFormat::{self, F32, F64};

use super::select::{families, family_names, first_failure, level_text, pairs, stands_for};
use crate::comparison::document::figures::fastest_methods;
use crate::comparison::document::summary::{FrontPoint, plane};
use crate::comparison::document::view::{BASELINE, View};
use trisect_report::document::Section;
use trisect_report::figure::{
    Axis, Drawing, Entry, Ink, Look, Map, Panel, Plane, Sample, Scale, Series, Square, points,
};
use trisect_report::format::{percent, tick};
use trisect_report::stats::pareto_front;

/// All figures, in the order of the page.
pub(super) fn all(view: &View) -> [Section; 5] {
    let marked = marked(view);
    let shown = &Shown { view, marked };
    [shown.by_condition(), shown.decisions(), shown.cracks(), map(view), shown.pareto()]
}

const NO_STUDY: &str =
    "Left out: the record holds no stability study; make one with `trisect stress`.";

/// Methods that are told apart in figures of lines, the others being drawn as thin grey ones: the
/// fastest, the one that all are compared with, and those that claim to be watertight.
fn marked<'a>(view: &View<'a>) -> Vec<&'a str> {
    let mut methods = fastest_methods(view);
    let claims = |name: &str| {
        view.fact(name).is_some_and(|fact| fact.claims.iter().any(|claim| claim == "watertight"))
    };
    methods.extend(view.methods().iter().copied().filter(|name| claims(name)).take(1));
    methods.sort_unstable();
    methods.dedup();
    methods
}

/// A panel of lines, its axes over all its points.
fn panel(title: &str, x: &str, (y, scale): (&str, Scale), series: Vec<Series>) -> Panel {
    let (write, from_zero): (fn(f64) -> String, &[f64]) =
        if scale == Scale::Linear { (percent, &[0.0, 1.0]) } else { (tick, &[]) };
    let shown = points(&series).map(|p| p.1).chain(from_zero.iter().copied());
    let up = Axis::over(y, scale, shown, write);
    let across = Axis::over(x, Scale::Log, points(&series).map(|p| p.0), tick);
    Panel::plane(title, across, up, 240, series)
}

/// The line of a method in f32, and that of the reference in f64, on the numbers of f32.
fn conditions<'a>(
    view: &View<'a>,
    method: &str,
    precision: FloatFormat,
) -> Option<&'a ByCondition> {
    view.all::<ByCondition>().find(|b| {
        b.inputs == F32 && b.quantity == "t" && stands_for(view, &b.variant, method, precision)
    })
}

/// One of the numbers of a bin.
type OfBin = fn(&Bin) -> f64;

/// The family of the variant that stands for a method.
fn family<'a>(
    view: &View<'a>,
    method: &str,
    precision: FloatFormat,
    name: &str,
) -> Option<&'a StressFamily> {
    families(view, method, precision).find(|family| family.family == name)
}

fn wrong_share(level: &StressLevel) -> f64 {
    (level.false_hits + level.false_misses) as f64 * 100.0 / pairs(level).max(1) as f64
}

/// Points of a line, in the order of their places.
fn sorted(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut points: Vec<_> = points.collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// What figures of all methods show.
struct Shown<'a> {
    view: &'a View<'a>,
    marked: Vec<&'a str>,
}

impl Shown<'_> {
    /// Methods that are told apart, or the others.
    fn methods(&self, told: bool) -> impl Iterator<Item = &str> {
        let all = self.view.methods().iter().copied();
        all.filter(move |method| self.marked.contains(method) == told)
    }

    /// One line per method in f32: those that are told apart last, so that they lie on top; and that of
    /// the reference in f64.
    fn lines(&self, points_of: impl Fn(&str, FloatFormat) -> Vec<(f64, f64)>) -> Vec<Series> {
        let others = self.methods(false).map(|m| Series::bare(Ink::Grid, points_of(m, F32)).of(m));
        let told = self.methods(true);
        let told = told.map(|m| Series::line(self.view.look(m), points_of(m, F32)).of(m));
        let mut series: Vec<Series> = others.chain(told).collect();
        // Where the lines are, and not as far as a wider type goes.
        let shown = || points(&series).map(|p| p.0);
        let (low, high) =
            (shown().fold(f64::INFINITY, f64::min), shown().fold(f64::NEG_INFINITY, f64::max));
        let mut reference = points_of(BASELINE, F64);
        reference.retain(|p| (low..=high).contains(&p.0));
        series.push(Series::bare(Ink::Text, reference));
        series.retain(|series| !series.points.is_empty());
        series
    }

    fn legend(&self) -> Vec<Entry> {
        let told = self.methods(true);
        let entry = |method: &str| {
            Entry::of(self.view.look(method), self.view.title(method)).lit_with(method)
        };
        told.map(entry).collect()
    }

    /// A figure of panels of lines.
    fn figure(
        &self,
        id: &'static str,
        title: &str,
        caption: &'static str,
        panels: Vec<Panel>,
    ) -> Section {
        let mut legend = self.legend();
        legend.push(Entry::new(Sample::Line(Ink::Grid), "other methods"));
        legend.push(Entry::new(Sample::Line(Ink::Text), "Möller–Trumbore in f64"));
        let has_study = self.view.all::<StressFamily>().next().is_some();
        let missing = if has_study {
            format!(
                "Left out: the record has no `{BASELINE}`, whose difficulties are drawn; add it to \
                 `--methods`."
            )
        } else {
            NO_STUDY.to_owned()
        };
        let panels = if has_study { panels } else { Vec::new() };
        let drawing = Drawing { panels, legend, key: Vec::new() };
        Section::figure(id, title, caption, drawing).missing(missing)
    }

    fn by_condition(&self) -> Section {
        let drawn: [(&str, OfBin); 4] = [
            ("Median", |bin| f64::from(bin.error.0)),
            ("Largest", |bin| f64::from(bin.error.1)),
            ("Median over κ·u", |bin| f64::from(bin.over_condition.0)),
            ("Largest over κ·u", |bin| f64::from(bin.over_condition.1)),
        ];
        let panels = drawn.map(|(title, of)| {
            let series = self.lines(|method, precision| {
                let line = conditions(self.view, method, precision);
                let decades = line.map_or(&[][..], |line| &line.decades);
                // In the middle of the decade. What is 0 has no place on a logarithmic axis that others
                // fill.
                let points = decades.iter().map(|bin| (bin.from * 10_f64.sqrt(), of(bin)));
                points.filter(|p| p.1 > 0.0).collect()
            });
            let y =
                if title.contains('κ') { "error of t over κ·u" } else { "relative error of t" };
            panel(title, "condition number of t", (y, Scale::Log), series)
        });
        self.figure(
            "stress-condition",
            "Error against condition number",
            "Relative error of t in f32, plain arithmetic, against its relative condition number κ, per \
             decade, over all families but those about the range of numbers; below, the same errors over κ \
             times the unit roundoff of the line's own precision. A method whose line is level there is \
             backward stable; one whose line climbs is not.",
            panels.into(),
        )
    }

    fn decisions(&self) -> Section {
        let points = |method: &str, precision: FloatFormat, name: &str| {
            let family = family(self.view, method, precision, name);
            let levels = family.map_or(&[][..], |family| &family.levels);
            sorted(levels.iter().map(|level| (level.level, wrong_share(level))))
        };
        let drawn = family_names(self.view)
            .into_iter()
            .filter(|(name, _)| points(BASELINE, F32, name).len() > 3);
        let panels = drawn.map(|(name, knob)| {
            let series = self.lines(|method, precision| points(method, precision, name));
            panel(name, knob, ("wrong decisions", Scale::Linear), series)
        });
        self.figure(
            "stress-decisions",
            "Wrong decisions against difficulty",
            "The share of pairs whose decision, hit or miss, differs from the oracle's, in f32 and plain \
             arithmetic; deferred division where the method has it. The levels of the f64 line are its own, \
             as its pairs are: they go on where those of f32 have no digits left.",
            panels.collect(),
        )
    }

    fn cracks(&self) -> Section {
        let panels = [
            ("Aimed at edges, moved", "edges", true),
            ("Aimed at corners, moved", "vertices", true),
            ("Aimed at edges, scaled", "edges", false),
            ("Aimed at corners, scaled", "vertices", false),
        ]
        .map(|(title, aim, by_offset)| {
            let place = |site: &Site| {
                if by_offset {
                    (site.scale == 1.0).then_some(site.offset)
                } else {
                    (site.offset == 0.0).then_some(site.scale)
                }
            };
            let series = self.lines(|method, precision| {
                let sites = self
                    .view
                    .all::<SurfaceCracks>()
                    .filter(|c| stands_for(self.view, &c.variant, method, precision))
                    .flat_map(|c| &c.sites)
                    .filter(|site| site.surface == "sphere" && site.aim == aim);
                let share = |s: &Site| s.no_hit as f64 * 100.0 / s.rays.max(1) as f64;
                sorted(sites.filter_map(|site| Some((place(site)?, share(site)))))
            });
            let x = if by_offset { "offset" } else { "scale" };
            panel(title, x, ("rays that pass through", Scale::Linear), series)
        });
        self.figure(
            "stress-cracks",
            "Cracks",
            "Rays from inside a closed sphere of 1,280 triangles, radius 2 times the scale, that hit \
             nothing, in f32 and plain arithmetic. They are aimed in the precision of the method, f64's \
             line included: a wider type has cracks as well, finer ones. Far off, corners and origins lie on \
             a coarse grid, and differences are exact.",
            panels.into(),
        )
    }

    fn pareto(&self) -> Section {
        let (timed, ..) = plane(self.view);
        let strata =
            [("Easy: κ below 100", 0.0), ("Stiff: κ below a million", 1e2), ("Extreme", 1e6)];
        let error = |line: &ByCondition, from: f64| {
            let bin = line.strata.iter().find(|bin| bin.from == from)?;
            Some(f64::from(bin.error.0))
        };
        let line = |variant: &Variant| {
            let mut all = self.view.all::<ByCondition>();
            all.find(|b| b.inputs == F32 && b.quantity == "t" && variant.rounds_like(&b.variant))
        };
        let panels = strata.into_iter().filter_map(|(title, from)| {
            let point = |p: &'_ FrontPoint| {
                Some((p.variant.clone(), (p.ns_per_test, error(line(&p.variant)?, from)?)))
            };
            let points: Vec<(Variant, (f64, f64))> = timed.iter().filter_map(point).collect();
            let reference = conditions(self.view, BASELINE, F64).and_then(|line| error(line, from));
            (!points.is_empty()).then(|| Panel::Plane(self.pareto_panel(title, &points, reference)))
        });
        let mut legend = self.legend();
        for (ink, filled, text) in [
            (Ink::Grid, true, "other methods"),
            (Ink::Muted, true, "f32"),
            (Ink::Muted, false, "f64"),
        ] {
            legend.push(Entry::new(Sample::Point(Look::plain(ink), filled), text));
        }
        legend.push(Entry::new(Sample::Line(Ink::Muted), "Pareto front"));
        legend.push(Entry::new(Sample::Dashes, "error of f64 Möller–Trumbore"));
        let caption = "As on the page of the comparison, a point for each variant: across, nanoseconds per \
                       test on random rays; up, the median relative error of t over the pairs of the hard \
                       families, given in f32, by the condition number of t. What costs nothing on easy \
                       pairs may cost all digits on extreme ones; double precision keeps them at twice the \
                       time.";
        let drawing = Drawing { panels: panels.collect(), legend, key: Vec::new() };
        let title = "Error against run time, from easy to extreme";
        Section::figure("stress-pareto", title, caption, drawing)
            .missing("Left out: the record holds no times beside its errors.")
    }

    fn pareto_panel(
        &self,
        title: &str,
        points: &[(Variant, (f64, f64))],
        reference: Option<f64>,
    ) -> Plane {
        let at: Vec<(f64, f64)> = points.iter().map(|p| p.1).collect();
        let front = pareto_front(&at).into_iter().map(|i| at[i]).collect();
        let mut series = vec![Series::front(front)];
        // Those that are told apart last, so that they lie on top.
        for told in [false, true] {
            for method in self.methods(told) {
                let look = if told { self.view.look(method) } else { Look::plain(Ink::Grid) };
                for (precision, filled) in [(F64, false), (F32, true)] {
                    let mine = points
                        .iter()
                        .filter(|(v, _)| v.method == method && v.precision == precision);
                    series
                        .push(Series::points(look, filled, mine.map(|p| p.1).collect()).of(method));
                }
            }
        }
        let errors = || at.iter().map(|p| p.1).chain(reference);
        let across = Axis::over("ns per test", Scale::Log, at.iter().map(|p| p.0), tick);
        let up =
            Axis::over("median relative error of t", Scale::Log, errors(), tick).broken(errors());
        Plane {
            rules: reference.into_iter().collect(),
            ..Plane::new(title, across, up, 300, series)
        }
    }
}

/// The first level at which a method fails, by family: as large as it comes early.
fn map(view: &View) -> Section {
    let names = family_names(view);
    let square = |family: &StressFamily| {
        let (place, level) = first_failure(family)?;
        let levels = family.levels.len();
        let weight = (levels - place) as f64 / levels as f64;
        Some(Square { weight, text: level_text(level.level) })
    };
    let panel = |precision: FloatFormat| {
        let row = |&method: &&'_ str| {
            let cell =
                |(name, _): &(&str, _)| family(view, method, precision, name).and_then(square);
            let empty = || Square { weight: 0.0, text: String::new() };
            let cells = names.iter().map(|name| cell(name).unwrap_or_else(empty)).collect();
            (method.to_owned(), cells)
        };
        let is_studied = |method: &&&str| families(view, method, precision).next().is_some();
        let mut rows: Vec<_> = view.methods().iter().filter(is_studied).map(row).collect();
        // What fails least comes first.
        let failure = |(_, cells): &(String, Vec<Square>)| cells.iter().map(|c| c.weight).sum();
        rows.sort_by(|a, b| f64::total_cmp(&failure(a), &failure(b)));
        let columns = (1..=names.len()).map(|i| i.to_string()).collect();
        (!rows.is_empty()).then(|| Panel::Map(Map { title: precision.to_string(), columns, rows }))
    };
    let key =
        names.iter().enumerate().map(|(i, (name, knob))| format!("{}  {name}: {knob}", i + 1));
    let drawing = Drawing {
        panels: [F32, F64].into_iter().filter_map(panel).collect(),
        key: key.collect(),
        ..Drawing::default()
    };
    let caption = "The first level, from easy to hard, at which an answer is wrong by more than a thousandth: \
                   the decision, t relative to itself, or a weight. The earlier in the family's levels, the \
                   larger the square; an empty cell never fails. Plain arithmetic, deferred division where \
                   the method has it. Decisions within a thousandth of an edge count for nothing here. Methods that fail least come \
                   first.";
    Section::figure("stress-map", "Where each method first fails", caption, drawing)
        .missing(NO_STUDY)
}
