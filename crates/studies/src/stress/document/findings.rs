//! What the stability study says to a reader who must choose, its figures taken from the record.

use crate::record::Variant;
use crate::stress::record::{ByCondition, FusedDifference, Site, StressFamily, SurfaceCracks};
use trisect_core::FloatFormat::{self, F32, F64};
use trisect_core::MultiplyAdd;

use super::select::{
    ENDLESS, division, families, first_failure, level_text, magnitude, stands_for,
};
use super::summary::{StressRow, StressSummary};
use crate::comparison::document::view::{BASELINE, View, lanes_label};
use trisect_report::document::{Section, Shown};
use trisect_report::format::{fixed, grouped, mtests, number, or_dash, scientific};
use trisect_report::stats::{geometric_mean, median};
use trisect_report::table::Table;

/// The part of documents that holds them.
const PART: &str = "stress-findings";

/// Which method for which need, and the findings behind it.
pub(super) fn sections<'a>(view: &'a View<'a>, summary: &'a StressSummary) -> [Section; 2] {
    let study = Study { view, summary };
    let findings = [
        study.cracks(),
        study.conditions(),
        study.far_from_the_world(),
        study.far_rays(),
        study.thin(),
        study.grazing(),
        study.range(),
        study.double(),
        study.fused(),
        study.flushing(),
        study.reference(),
    ];
    let items = findings.map(|(about, says)| (format!("**{about}**"), says));
    let choices = Section::table("", "", "", study.choices()).part(PART).shown(Shown::Part);
    [choices, Section::list(PART, "", items.into())]
}

/// What a finding is about, and what it says.
type Said = (&'static str, String);

/// An error over `κ·u` that a count of roundings explains.
const STABLE: f64 = 16.0;

impl StressRow {
    /// Whether no ray passed through anything.
    pub(super) fn is_tight(&self) -> bool {
        [self.edge_cracks, self.vertex_cracks, self.far_cracks].iter().all(|c| *c == Some(0.0))
    }
}

/// Whether a surface has the size that it was made in.
fn is_full_size(site: &Site) -> bool {
    site.scale == 1.0
}

/// Whether a method meets a need.
type Keep<'a> = &'a dyn Fn(&StressRow) -> bool;
/// What its fastest variant then promises.
type Promise<'a> = &'a dyn Fn(&StressRow, &Variant) -> String;

struct Study<'a> {
    view: &'a View<'a>,
    summary: &'a StressSummary,
}

impl Study<'_> {
    fn rows(&self) -> impl Iterator<Item = &StressRow> {
        self.summary.rows.iter().filter(|row| row.precision == F32)
    }

    fn row(&self, method: &str, precision: FloatFormat) -> Option<&StressRow> {
        self.summary.rows.iter().find(|row| row.method == method && row.precision == precision)
    }

    /// The fastest variant of a method in f32 that decides as its row does.
    fn speed(&self, row: &StressRow) -> Option<(&Variant, f64)> {
        self.view.fastest(|v| {
            v.method == row.method
                && v.precision == row.precision
                && Some(v.needs) == self.view.main_need()
                && (!row.is_tight() || self.is_tight(v))
        })
    }

    /// Whether no ray passed through anything in the arithmetic and division of a variant.
    fn is_tight(&self, variant: &Variant) -> bool {
        let (rays, through) = self.aimed(variant, is_full_size);
        rays > 0 && through == 0
    }

    /// The first level of a family at which a method fails, infinite if it never does.
    fn first_failure_in(&self, row: &StressRow, name: &str) -> Option<f64> {
        let mut families = families(self.view, &row.method, row.precision);
        let family = families.find(|family| family.family == name)?;
        Some(first_failure(family).map_or(f64::INFINITY, |(_, level)| level.level))
    }

    /// The first aspect of a sliver at which a method fails.
    fn thin_of(&self, row: &StressRow) -> Option<f64> {
        self.first_failure_in(row, "sliver")
    }

    /// The fastest method for each need, and what it promises.
    fn choices(&self) -> Table {
        let timed: Vec<(&StressRow, (&Variant, f64))> =
            self.rows().filter_map(|row| Some((row, self.speed(row)?))).collect();
        let fastest_of = |keep: &dyn Fn(&StressRow) -> bool| {
            let kept = timed.iter().filter(|(row, _)| keep(row));
            kept.min_by(|a, b| a.1.1.total_cmp(&b.1.1)).copied()
        };
        // Within a factor of two of the best, of methods with weights: of others fewer numbers can be wrong.
        let is_near = |of: fn(&StressRow) -> Option<f64>| {
            let best = timed.iter().filter_map(|(row, _)| of(row)).fold(0.0, f64::max);
            move |row: &StressRow| of(row).is_some_and(|limit| limit >= 0.5 * best)
        };
        let thinnest = self.rows().filter_map(|row| self.thin_of(row)).fold(0.0, f64::max);
        let until = |limit: f64, says: &dyn Fn(f64) -> String, any: &str| {
            if limit < ENDLESS { says(limit) } else { any.to_owned() }
        };
        let needs: [(&str, Keep, Promise); 7] = [
            (
                "the most speed, on scenes of ordinary size near the world's origin",
                &|_| true,
                &|row, _| match row.edge_cracks {
                    Some(cracks) => format!("none: {} cracks per million at edges", number(cracks)),
                    None => "none, where it takes the mesh".to_owned(),
                },
            ),
            (
                "no ray through a closed mesh, wherever that is",
                &StressRow::is_tight,
                &|_, variant| {
                    let (rays, through) = self.aimed(variant, is_full_size);
                    format!("{} of {} aimed rays pass through", grouped(through), grouped(rays))
                },
            ),
            (
                "errors that the condition number bounds",
                &|row| row.error_over_condition.is_some_and(|error| error <= STABLE),
                &|row, _| format!("t within {}·κ·u", or_dash(row.error_over_condition, number)),
            ),
            ("meshes far from the world's origin", &is_near(|row| row.offset), &|row, _| {
                let says = |x| format!("right up to an offset of {} sizes", magnitude(x));
                until(row.offset.unwrap_or(ENDLESS), &says, "right at any offset")
            }),
            ("origins far from the triangle", &is_near(|row| row.distance), &|row, _| {
                let says = |x| format!("right up to {} sizes away", magnitude(x));
                until(row.distance.unwrap_or_default(), &says, "right at any distance")
            }),
            (
                "thin triangles, as of CAD",
                &|row| self.thin_of(row).is_some_and(|level| level >= thinnest),
                &|row, _| {
                    let says = |x| format!("right below a ratio of {}", level_text(x));
                    until(self.thin_of(row).unwrap_or_default(), &says, "right at any ratio")
                },
            ),
            (
                "scenes of any size",
                &is_near(|row| row.scale.map(|[low, high]| (high / low).sqrt())),
                &|row, _| {
                    let [low, high] = row.scale.unwrap_or_default().map(magnitude);
                    format!("right from {low} to {high}")
                },
            ),
        ];
        let chosen: Vec<_> = needs
            .into_iter()
            .filter_map(|(says, keep, promise)| Some((says, promise, fastest_of(keep)?)))
            .collect();
        let best = fastest_of(&|_| true).map_or(1.0, |(_, (_, ns))| ns);
        Table::of(&chosen)
            .text("need", |(says, ..)| *says)
            .text("fastest method", |(.., (row, (v, _)))| {
                format!("`{}` ({}, {})", row.method, lanes_label(v), v.division)
            })
            .text("guarantee in f32", |(_, promise, (row, (v, _)))| promise(row, v))
            .number("million tests/s", number, |(.., (_, (_, ns)))| mtests(*ns))
            .number("of the fastest", fixed, |(.., (_, (_, ns)))| best / ns)
            .done()
    }

    /// Rays aimed at edges and corners of the surfaces that `keep` lets pass, in the arithmetic and
    /// division of a variant, and those that pass through.
    fn aimed(&self, variant: &Variant, keep: impl Fn(&Site) -> bool) -> (u64, u64) {
        let alike = self.view.all::<SurfaceCracks>().filter(|c| {
            c.variant.method == variant.method
                && c.variant.precision == variant.precision
                && c.variant.arithmetic == variant.arithmetic
                && c.variant.division == variant.division
        });
        let sites = alike.flat_map(|c| &c.sites).filter(|site| keep(site));
        sites.fold((0, 0), |sum, site| (sum.0 + site.rays as u64, sum.1 + site.no_hit as u64))
    }

    fn names(&self, keep: impl Fn(&StressRow) -> bool) -> String {
        let names: Vec<String> =
            self.rows().filter(|row| keep(row)).map(|row| format!("`{}`", row.method)).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    }

    fn cracks(&self) -> Said {
        let at_edges = self.names(|row| {
            row.edge_cracks == Some(0.0) && row.vertex_cracks.is_some_and(|cracks| cracks > 0.0)
        });
        let leaks = |row: &'_ StressRow| row.edge_cracks.filter(|&cracks| cracks > 0.0);
        let mut leaky: Vec<_> =
            self.rows().filter_map(|row| Some((leaks(row)?, &row.method))).collect();
        leaky.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = leaky.first().zip(leaky.last()).map(|((low, first), (high, last))| {
            format!("from {} (`{first}`) to {} (`{last}`)", number(*low), number(*high))
        });
        let says = format!(
            "No ray aimed at an edge or a corner of a closed surface passes through {}, at any offset. None at \
             edges, but some at corners: {at_edges}. Through the others pass, per million rays aimed at edges, \
             {}. A wider type does not mend it: Möller–Trumbore in f64, its rays aimed in f64, lets {} of a \
             million through. (Figure *Cracks*.)",
            self.names(StressRow::is_tight),
            ends.unwrap_or_default(),
            or_dash(self.row(BASELINE, F64).and_then(|row| row.edge_cracks), number),
        );
        ("Cracks.", says)
    }

    fn conditions(&self) -> Said {
        let stable = |row: &StressRow| row.error_over_condition.is_some_and(|e| e <= STABLE);
        let (all, good) = (self.rows().count(), self.rows().filter(|row| stable(row)).count());
        let says = format!(
            "Of {all} methods {good} keep the error of t within {}·κ·u on every pair for which κ·u is below a \
             tenth: {}. The others lose more than the condition number says: those that store planes in world \
             space with the offset of the mesh, those that add up volumes or shear the triangle with the \
             distance of the origin. (Figure *Error against condition number*, lower half.)",
            number(STABLE),
            self.names(stable)
        );
        ("Errors and condition.", says)
    }

    fn far_from_the_world(&self) -> Said {
        let limit = |row: &StressRow| row.offset.filter(|&offset| offset < ENDLESS);
        let limits: Vec<f64> = self.rows().filter_map(limit).collect();
        let twin = |row: &'_ StressRow| {
            let near = self.row(row.method.strip_suffix("-relative")?, F32)?;
            let speed = self.speed(near)?.1 / self.speed(row)?.1;
            Some((limit(near).is_some() && limit(row).is_none(), speed))
        };
        let twins: Vec<(bool, f64)> = self.rows().filter_map(twin).collect();
        let says = format!(
            "{} methods are right up to offsets of {} to {} sizes of the triangle alone: {}. The others take \
             the numbers as they are given wherever they lie, since differences of neighbours are exact. Of {} \
             pairs of twins {} lose the limit by subtracting a corner from the ray's origin first, at {} of the \
             speed (geometric mean). (Figure *Wrong decisions against difficulty*, far-mesh.)",
            limits.len(),
            magnitude(limits.iter().copied().fold(f64::INFINITY, f64::min)),
            magnitude(limits.iter().copied().fold(0.0, f64::max)),
            self.names(|row| limit(row).is_some()),
            twins.len(),
            twins.iter().filter(|twin| twin.0).count(),
            or_dash(geometric_mean(twins.iter().map(|twin| twin.1)), fixed),
        );
        ("Far from the world's origin.", says)
    }

    fn far_rays(&self) -> Said {
        let all: Vec<f64> = self.rows().filter_map(|row| row.distance).collect();
        let says = format!(
            "Most methods are right to a thousandth up to a distance of {} sizes of the triangle (median), \
             whichever formula: the weights are differences of the distance. Below 1000 sizes fail already: \
             {}. (Figure *Wrong decisions against difficulty*, far-origin.)",
            or_dash(median(&all), magnitude),
            self.names(|row| row.distance.is_some_and(|distance| distance < 1e3))
        );
        ("Rays from afar.", says)
    }

    fn thin(&self) -> Said {
        let levels = self.rows().filter_map(|row| self.thin_of(row));
        let levels: Vec<f64> = levels.filter(|level| level.is_finite()).collect();
        if levels.is_empty() {
            return ("Thin triangles.", "This record has no such pairs.".to_owned());
        }
        let first = levels.iter().copied().fold(f64::INFINITY, f64::min);
        let last = levels.iter().copied().fold(0.0, f64::max);
        let at = |level: f64| self.names(|row| self.thin_of(row) == Some(level));
        let is_endless = |row: &StressRow| self.thin_of(row) == Some(f64::INFINITY);
        let endless = if self.rows().any(is_endless) {
            format!(" Right at any ratio: {}.", self.names(is_endless))
        } else {
            String::new()
        };
        let says = format!(
            "Answers are off by more than a thousandth once edge over height reaches {} ({}) to {} ({}).{endless} Stored planes lose their normal to the cross product of long edges when they are \
             prepared; methods that form volumes with the ray's own direction do not. (Figure *Where each \
             method first fails*.)",
            level_text(first),
            at(first),
            level_text(last),
            at(last)
        );
        ("Thin triangles.", says)
    }

    fn grazing(&self) -> Said {
        let first = |row| self.first_failure_in(row, "grazing").filter(|level| level.is_finite());
        let levels: Vec<f64> = self.rows().filter_map(first).collect();
        let first = levels.iter().copied().fold(0.0, f64::max);
        let last = levels.iter().copied().fold(f64::INFINITY, f64::min);
        let until = if first == last { String::new() } else { format!(" to {}", level_text(last)) };
        let says = format!(
            "Of {} methods {} fail, all from a tangent of {}{until} of the angle to the plane on: the condition \
             number, not the method, is to blame.",
            self.rows().count(),
            levels.len(),
            level_text(first),
        );
        ("Grazing rays.", says)
    }

    fn range(&self) -> Said {
        let mut groups: Vec<([String; 2], f64, Vec<String>)> = Vec::new();
        for row in self.rows() {
            let Some([low, high]) = row.scale else { continue };
            // Methods of the same degree end within a decade of each other.
            let key = [low, high].map(|x| format!("1e{}", x.log10().round()));
            let name = format!("`{}`", row.method);
            match groups.iter_mut().find(|group| group.0 == key) {
                Some(group) => group.2.push(name),
                None => groups.push((key, low, vec![name])),
            }
        }
        groups.sort_by(|a, b| b.1.total_cmp(&a.1));
        let groups = groups.into_iter();
        let groups: Vec<String> = groups
            .map(|([low, high], _, names)| format!("{low} to {high}: {}", names.join(", ")))
            .collect();
        let span = |row: &StressRow| row.scale.map(|[low, high]| high.log10() - low.log10());
        let wider = |row: &'_ StressRow| Some(span(self.row(&row.method, F64)?)? / span(row)?);
        let wider: Vec<f64> = self.rows().filter_map(wider).collect();
        let says = format!(
            "With directions of length 1, products of coordinates under- and overflow beyond: {}. In f64 the \
             exponents are {} times as large (median).",
            groups.join("; "),
            or_dash(median(&wider), number)
        );
        ("Size of the scene.", says)
    }

    fn double(&self) -> Said {
        let both = |row: &'_ StressRow| {
            let wide = self.row(&row.method, F64)?;
            Some((wide.distance? / row.distance?, self.speed(wide)?.1 / self.speed(row)?.1))
        };
        let (gains, costs): (Vec<f64>, Vec<f64>) = self.rows().filter_map(both).unzip();
        let says = format!(
            "moves every limit of distance, thinness and offset by the ratio of the roundoffs (the limit of \
             distance by {}, median over methods), and costs {} times the time (geometric mean). It closes no \
             crack.",
            or_dash(median(&gains), scientific),
            or_dash(geometric_mean(costs), fixed),
        );
        ("Double precision", says)
    }

    fn fused(&self) -> Said {
        let cracks = |arithmetic: MultiplyAdd, method: &str| {
            let alike = self.view.all::<SurfaceCracks>().map(|c| &c.variant).find(|v| {
                v.method == method
                    && v.precision == F32
                    && v.division == division(self.view, method)
                    && v.arithmetic == arithmetic
            })?;
            let here = |site: &Site| site.scale == 1.0 && site.offset == 0.0;
            let (rays, through) = self.aimed(alike, here);
            (rays > 0).then(|| through as f64 * 1e6 / rays as f64)
        };
        let both = |method: &str| {
            let [plain, fused] = [MultiplyAdd::Plain, MultiplyAdd::Fused]
                .map(|arithmetic| or_dash(cracks(arithmetic, method), number));
            format!("`{method}` {plain} plain and {fused} fused")
        };
        let shares: Vec<f64> = self
            .view
            .all::<FusedDifference>()
            .filter(|d| d.inputs == F32 && d.variant.precision == F32)
            .map(|d| d.decisions as f64 * 100.0 / d.pairs.max(1) as f64)
            .collect();
        let says = format!(
            "decides {} % of the hard pairs differently (median over variants) and is as accurate as plain \
             arithmetic, but it breaks what only monotonous rounding keeps. Cracks per million, edges and \
             corners at the world's origin: {}, {}, {}. The watertight kernels leave their edge functions \
             plain.",
            or_dash(median(&shares), number),
            both(BASELINE),
            both("plucker-translated"),
            both("watertight"),
        );
        ("Fused multiply-add", says)
    }

    fn flushing(&self) -> Said {
        let first = |flushed: bool, method: &str| {
            let family = self.view.all::<StressFamily>().find(|s| {
                s.flush_to_zero == flushed
                    && s.family == "scale"
                    && stands_for(self.view, &s.variant, method, F32)
            })?;
            let small = family.levels.iter().filter(|level| level.level < 1.0);
            small.filter(|level| level.wrong == 0).map(|level| level.level).min_by(f64::total_cmp)
        };
        let grows = |row: &StressRow| {
            first(true, &row.method).zip(first(false, &row.method)).is_some_and(|(a, b)| a > b)
        };
        let both = |method: &str| {
            let [kept, flushed] = [false, true].map(|flushed| first(flushed, method));
            let [kept, flushed] = [kept, flushed].map(|level| or_dash(level, level_text));
            format!("from {kept} to {flushed} for `{method}`")
        };
        let says = format!(
            "changes no answer while nothing is subnormal. Of the levels of the family scale, the smallest that \
             is right grows for {} of {} methods, {} and {}; it stays for {}.",
            self.rows().filter(|row| grows(row)).count(),
            self.rows().count(),
            both(BASELINE),
            both("wald"),
            self.names(|row| !grows(row)),
        );
        ("Flush-to-zero", says)
    }

    fn reference(&self) -> Said {
        let line = self.view.all::<ByCondition>().find(|b| {
            b.inputs == F32 && b.quantity == "t" && stands_for(self.view, &b.variant, BASELINE, F64)
        });
        let worst = line.and_then(|line| line.decades.last()).map(|bin| {
            let (error, from) = (scientific(f64::from(bin.error.1)), magnitude(bin.from));
            format!("Its largest relative error of t is {error} where κ is {from} or more")
        });
        let says = format!(
            "Möller–Trumbore in f64, the usual reference, is drawn as a line of its own in every figure. {}: \
             good enough to judge f32 by, whose own error there is many times larger, and no oracle.",
            worst.unwrap_or_else(|| "This record does not say how large its errors are".to_owned())
        );
        ("The reference.", says)
    }
}
