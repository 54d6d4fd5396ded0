//! What the stability study says to a reader who must choose, its figures taken from the record.

use std::fmt::Write as _;

use trisect_core::{FloatFormat, MultiplyAdd};
use trisect_harness::record::{Site, Variant};

use super::figures::level_text;
use super::summary::{StressRow, StressSummary, magnitude, of_view};
use super::{division, families, first_failure, stands_for};
use crate::format::{grouped, mtests, number, scientific};
use crate::markdown::{fastest, measured};
use crate::stats::{geometric_mean, median};
use crate::view::{BASELINE, View, lanes_label};

/// Which method for which need, and the findings behind it.
pub(crate) fn page(view: &View) -> String {
    let study = Study { view, summary: of_view(view) };
    let mut text = study.choices();
    text.push('\n');
    for finding in [
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
    ] {
        let _ = writeln!(text, "- {finding}");
    }
    let _ = writeln!(text, "\n{}", measured(view));
    text
}

/// What a reader may need, as a test of a row.
struct Need {
    says: &'static str,
    keep: fn(&Study, &StressRow) -> bool,
    /// What the row promises.
    guarantee: fn(&Study, &StressRow, &Variant) -> String,
}

const NEEDS: [Need; 7] = [
    Need {
        says: "the most speed, on scenes of ordinary size near the world's origin",
        keep: |_, _| true,
        guarantee: |_, row, _| match row.edge_cracks {
            Some(cracks) => format!("none: {} cracks per million at edges", number(cracks)),
            None => "none, where it takes the mesh".to_owned(),
        },
    },
    Need {
        says: "no ray through a closed mesh, wherever that is",
        keep: |_, row| row.is_tight(),
        guarantee: |study, _, variant| {
            let (rays, through) = study.aimed(variant, is_full_size);
            format!("{} of {} aimed rays pass through", grouped(through), grouped(rays))
        },
    },
    Need {
        says: "errors that the condition number bounds",
        keep: |_, row| row.error_over_condition.is_some_and(|error| error <= STABLE),
        guarantee: |_, row, _| {
            format!("t within {}·κ·u", number(row.error_over_condition.unwrap_or_default()))
        },
    },
    Need {
        says: "meshes far from the world's origin",
        keep: |study, row| study.is_near(row.offset, |row| row.offset),
        guarantee: |_, row, _| match row.offset {
            Some(offset) if offset < ENDLESS => {
                format!("right up to an offset of {} sizes", magnitude(offset))
            }
            _ => "right at any offset".to_owned(),
        },
    },
    Need {
        says: "origins far from the triangle",
        keep: |study, row| study.is_near(row.distance, |row| row.distance),
        guarantee: |_, row, _| match row.distance.unwrap_or_default() {
            distance if distance < ENDLESS => {
                format!("right up to {} sizes away", magnitude(distance))
            }
            _ => "right at any distance".to_owned(),
        },
    },
    Need {
        says: "thin triangles, as of CAD",
        keep: |study, row| {
            let last = study.rows().filter_map(|row| study.thin_of(row)).fold(0.0, f64::max);
            study.thin_of(row).is_some_and(|level| level >= last)
        },
        guarantee: |study, row, _| {
            let level = study.thin_of(row).unwrap_or_default();
            if level.is_finite() {
                format!("right below a ratio of {}", level_text(level))
            } else {
                "right at any ratio".to_owned()
            }
        },
    },
    Need {
        says: "scenes of any size",
        keep: |study, row| {
            study.is_near(row.scale.map(|[low, high]| (high / low).sqrt()), |row| {
                row.scale.map(|[low, high]| (high / low).sqrt())
            })
        },
        guarantee: |_, row, _| {
            let [low, high] = row.scale.unwrap_or_default();
            format!("right from {} to {}", magnitude(low), magnitude(high))
        },
    },
];

/// Beyond this a distance or an offset has no end: triangles are points before.
pub(super) const ENDLESS: f64 = 1e30;

/// A distance or an offset.
pub(super) fn far(x: f64) -> String {
    if x < ENDLESS { magnitude(x) } else { "any".to_owned() }
}

/// An error over `κ·u` that a count of roundings explains.
const STABLE: f64 = 16.0;

impl StressRow {
    /// Whether no ray passed through anything.
    fn is_tight(&self) -> bool {
        [self.edge_cracks, self.vertex_cracks, self.far_cracks].iter().all(|c| *c == Some(0.0))
    }
}

/// Whether a surface has the size that it was made in.
fn is_full_size(site: &Site) -> bool {
    site.scale == 1.0
}

struct Study<'a, 'b> {
    view: &'b View<'a>,
    summary: StressSummary,
}

impl Study<'_, '_> {
    fn rows(&self) -> impl Iterator<Item = &StressRow> {
        self.summary.rows.iter().filter(|row| row.precision == FloatFormat::F32)
    }

    fn row(&self, method: &str, precision: FloatFormat) -> Option<&StressRow> {
        self.summary.rows.iter().find(|row| row.method == method && row.precision == precision)
    }

    /// The fastest variant of a method in f32 that decides as its row does.
    fn speed(&self, row: &StressRow) -> Option<(&Variant, f64)> {
        fastest(self.view, |v| {
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

    /// Whether a limit is within a factor of two of the best.
    fn is_near(&self, limit: Option<f64>, of: fn(&StressRow) -> Option<f64>) -> bool {
        // Of a method without weights fewer numbers can be wrong.
        let weighs = self.rows().filter(|row| self.speed(row).is_some());
        let best = weighs.filter_map(of).fold(0.0, f64::max);
        limit.is_some_and(|limit| limit >= 0.5 * best)
    }

    /// The first aspect of a sliver at which a method fails.
    fn thin_of(&self, row: &StressRow) -> Option<f64> {
        let mut families = families(self.view, &row.method, row.precision);
        let sliver = families.find(|family| family.family == "sliver")?;
        Some(first_failure(sliver).map_or(f64::INFINITY, |(_, level)| level.level))
    }

    /// The fastest method for each need.
    fn choices(&self) -> String {
        let mut text = String::from(
            "| need | fastest method | guarantee in f32 | million tests/s | of the fastest |\n\
             | --- | --- | --- | --: | --: |\n",
        );
        let fastest_of = |keep: &dyn Fn(&StressRow) -> bool| {
            self.rows()
                .filter(|row| keep(row))
                .filter_map(|row| Some((row, self.speed(row)?)))
                .min_by(|a, b| a.1.1.total_cmp(&b.1.1))
        };
        let Some((_, (_, best))) = fastest_of(&|_| true) else {
            return "The record holds no times.\n".to_owned();
        };
        for Need { says, keep, guarantee } in &NEEDS {
            let Some((row, (variant, ns))) = fastest_of(&|row| keep(self, row)) else { continue };
            let _ = writeln!(
                text,
                "| {says} | `{}` ({}, {}) | {} | {} | {:.2} |",
                row.method,
                lanes_label(variant),
                variant.division,
                guarantee(self, row, variant),
                number(mtests(ns)),
                best / ns,
            );
        }
        text
    }

    /// Rays aimed at edges and corners of the surfaces that `keep` lets pass, in the arithmetic and
    /// division of a variant, and those that pass through.
    fn aimed(&self, variant: &Variant, keep: impl Fn(&Site) -> bool) -> (u64, u64) {
        let alike = self.view.surface_cracks.iter().filter(|c| {
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

    fn cracks(&self) -> String {
        let tight = self.names(StressRow::is_tight);
        let at_edges = self.names(|row| {
            row.edge_cracks == Some(0.0) && row.vertex_cracks.is_some_and(|cracks| cracks > 0.0)
        });
        let mut leaky: Vec<(f64, &str)> = self
            .rows()
            .filter_map(|row| Some((row.edge_cracks.filter(|&c| c > 0.0)?, row.method.as_str())))
            .collect();
        leaky.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = leaky.first().zip(leaky.last()).map(|((low, first), (high, last))| {
            format!("from {} (`{first}`) to {} (`{last}`)", number(*low), number(*high))
        });
        format!(
            "**Cracks.** No ray aimed at an edge or a corner of a closed surface passes through \
             {tight}, at any offset. None at edges, but some at corners: {at_edges}. Through the \
             others pass, per million rays aimed at edges, {}. A wider type does not mend it: Möller–Trumbore in f64, \
             its rays aimed in f64, lets {} of a million through. (Figure *Cracks*.)",
            ends.unwrap_or_default(),
            self.row(BASELINE, FloatFormat::F64)
                .and_then(|row| row.edge_cracks)
                .map_or_else(|| "–".to_owned(), number),
        )
    }

    fn conditions(&self) -> String {
        let stable = |row: &StressRow| row.error_over_condition.is_some_and(|e| e <= STABLE);
        let (all, good) = (self.rows().count(), self.rows().filter(|row| stable(row)).count());
        format!(
            "**Errors and condition.** Of {all} methods {good} keep the error of t within {}·κ·u on \
             every pair for which κ·u is below a tenth: {}. The others lose more than the condition number says: \
             those that store planes in world space with the offset of the mesh, those that add \
             up volumes or shear the triangle with the distance of the origin. (Figure *Error \
             against condition number*, lower half.)",
            number(STABLE),
            self.names(stable)
        )
    }

    fn far_from_the_world(&self) -> String {
        let limited = |row: &StressRow| row.offset.is_some_and(|offset| offset < ENDLESS);
        let limits: Vec<f64> =
            self.rows().filter(|row| limited(row)).filter_map(|row| row.offset).collect();
        let twins: Vec<(bool, f64)> = self
            .rows()
            .filter_map(|row| {
                let near = self.row(row.method.strip_suffix("-relative")?, FloatFormat::F32)?;
                let speed = self.speed(near)?.1 / self.speed(row)?.1;
                Some((limited(near) && !limited(row), speed))
            })
            .collect();
        format!(
            "**Far from the world's origin.** {} methods are right up to offsets of {} to {} sizes of \
             the triangle alone: {}. The others take the numbers as they are given wherever they \
             lie, since differences of neighbours are exact. Of {} pairs of twins {} lose the \
             limit by subtracting a corner from the ray's origin first, at {} of the speed \
             (geometric mean). (Figure *Wrong decisions against difficulty*, far-mesh.)",
            limits.len(),
            magnitude(limits.iter().copied().fold(f64::INFINITY, f64::min)),
            magnitude(limits.iter().copied().fold(0.0, f64::max)),
            self.names(limited),
            twins.len(),
            twins.iter().filter(|twin| twin.0).count(),
            geometric_mean(twins.iter().map(|twin| twin.1))
                .map_or_else(|| "–".to_owned(), |x| format!("{x:.2}")),
        )
    }

    fn far_rays(&self) -> String {
        let short = |row: &StressRow| row.distance.is_some_and(|distance| distance < 1e3);
        let mut all: Vec<f64> = self.rows().filter_map(|row| row.distance).collect();
        all.sort_by(f64::total_cmp);
        format!(
            "**Rays from afar.** Most methods are right to a thousandth up to a distance of {} sizes \
             of the triangle (median), whichever formula: the weights are differences of the \
             distance. Below 1000 sizes fail already: {}. (Figure *Wrong decisions against \
             difficulty*, far-origin.)",
            median(&all).map_or_else(|| "–".to_owned(), magnitude),
            self.names(short)
        )
    }

    fn thin(&self) -> String {
        let levels = self.rows().filter_map(|row| self.thin_of(row));
        let mut levels: Vec<f64> = levels.filter(|level| level.is_finite()).collect();
        levels.sort_by(f64::total_cmp);
        let (Some(&first), Some(&last)) = (levels.first(), levels.last()) else {
            return "**Thin triangles.** The record does not tell.".to_owned();
        };
        let at = |level: f64| self.names(|row| self.thin_of(row) == Some(level));
        let is_endless = |row: &StressRow| self.thin_of(row) == Some(f64::INFINITY);
        let endless = if self.rows().any(is_endless) {
            format!(" At any ratio is right: {}.", self.names(is_endless))
        } else {
            String::new()
        };
        format!(
            "**Thin triangles.** Answers are off by more than a thousandth from a ratio of edge to \
             height of {} on ({}) to one of {} ({}).{endless} Stored planes lose their normal to the \
             cross product of long edges when they are prepared; methods that form volumes with \
             the ray's own direction do not. (Figure *Where each method first fails*.)",
            level_text(first),
            at(first),
            level_text(last),
            at(last)
        )
    }

    fn grazing(&self) -> String {
        let first = |row: &StressRow| {
            let mut families = families(self.view, &row.method, row.precision);
            let grazing = families.find(|family| family.family == "grazing")?;
            first_failure(grazing).map(|(_, level)| level.level)
        };
        let levels: Vec<f64> = self.rows().filter_map(first).collect();
        let (first, last) = (
            levels.iter().copied().fold(0.0, f64::max),
            levels.iter().copied().fold(f64::INFINITY, f64::min),
        );
        let until = if first == last { String::new() } else { format!(" to {}", level_text(last)) };
        format!(
            "**Grazing rays.** Of {} methods {} fail, all from a tangent of {}{until} of the angle to \
             the plane on: the condition number, not the method, is to blame.",
            self.rows().count(),
            levels.len(),
            level_text(first),
        )
    }

    fn range(&self) -> String {
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
        let span = |row: &StressRow| row.scale.map(|[low, high]| high.log10() - low.log10());
        let wider: Vec<f64> = self
            .rows()
            .filter_map(|row| Some(span(self.row(&row.method, FloatFormat::F64)?)? / span(row)?))
            .collect();
        let groups: Vec<String> = groups
            .into_iter()
            .map(|([low, high], _, names)| format!("{low} to {high}: {}", names.join(", ")))
            .collect();
        format!(
            "**Size of the scene.** With directions of length 1, products of coordinates under- and \
             overflow beyond: {}. In f64 the exponents are {} times as large (median).",
            groups.join("; "),
            median(&wider).map_or_else(|| "–".to_owned(), number)
        )
    }

    fn double(&self) -> String {
        let pairs: Vec<(f64, f64)> = self
            .rows()
            .filter_map(|row| {
                let wide = self.row(&row.method, FloatFormat::F64)?;
                Some((wide.distance? / row.distance?, self.speed(wide)?.1 / self.speed(row)?.1))
            })
            .collect();
        let gains: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
        format!(
            "**Double precision** moves every limit of distance, thinness and offset by the ratio of \
             the roundoffs (the limit of distance by {}, median over methods), and costs {} times \
             the time (geometric mean). It closes no crack.",
            median(&gains).map_or_else(|| "–".to_owned(), scientific),
            geometric_mean(pairs.iter().map(|p| p.1))
                .map_or_else(|| "–".to_owned(), |x| format!("{x:.2}")),
        )
    }

    fn fused(&self) -> String {
        let cracks = |arithmetic: MultiplyAdd, method: &str| {
            let alike = self.view.surface_cracks.iter().map(|c| &c.variant).find(|v| {
                v.method == method
                    && v.precision == FloatFormat::F32
                    && v.division == division(self.view, method)
                    && v.arithmetic == arithmetic
            })?;
            let here = |site: &Site| site.scale == 1.0 && site.offset == 0.0;
            let (rays, through) = self.aimed(alike, here);
            (rays > 0).then(|| number(through as f64 * 1e6 / rays as f64))
        };
        let both = |method: &str| {
            let dash = || "–".to_owned();
            format!(
                "`{method}` {} plain and {} fused",
                cracks(MultiplyAdd::Plain, method).unwrap_or_else(dash),
                cracks(MultiplyAdd::Fused, method).unwrap_or_else(dash)
            )
        };
        let shares: Vec<f64> = self
            .view
            .fused_differences
            .iter()
            .filter(|d| d.inputs == FloatFormat::F32 && d.variant.precision == FloatFormat::F32)
            .map(|d| d.decisions as f64 * 100.0 / d.pairs.max(1) as f64)
            .collect();
        format!(
            "**Fused multiply-add** decides {} % of the hard pairs differently (median over \
             variants) and is as accurate as plain arithmetic, but it breaks what only monotonous \
             rounding keeps. Cracks per million, edges and corners at the world's origin: {}, {}, \
             {}. The watertight kernels leave their edge functions plain.",
            median(&shares).map_or_else(|| "–".to_owned(), number),
            both(BASELINE),
            both("plucker-translated"),
            both("watertight"),
        )
    }

    fn flushing(&self) -> String {
        let first = |flushed: bool, method: &str| {
            let family = self.view.stress.iter().find(|s| {
                s.flush_to_zero == flushed
                    && s.family == "scale"
                    && s.variant.method == method
                    && s.variant.precision == FloatFormat::F32
                    && s.variant.arithmetic == MultiplyAdd::Plain
                    && s.variant.division == division(self.view, method)
            })?;
            let small = family.levels.iter().filter(|level| level.level < 1.0);
            small.filter(|level| level.wrong == 0).map(|level| level.level).min_by(f64::total_cmp)
        };
        let grows = |row: &StressRow| {
            first(true, &row.method).zip(first(false, &row.method)).is_some_and(|(a, b)| a > b)
        };
        let both = |method: &str| {
            let write = |level: Option<f64>| level.map_or_else(|| "–".to_owned(), level_text);
            format!(
                "from {} to {} for `{method}`",
                write(first(false, method)),
                write(first(true, method))
            )
        };
        format!(
            "**Flush-to-zero** changes no answer while nothing is subnormal. Of the levels of the \
             family scale, the smallest that is right grows for {} of {} methods, {} and {}; it \
             stays for {}.",
            self.rows().filter(|row| grows(row)).count(),
            self.rows().count(),
            both(BASELINE),
            both("wald"),
            self.names(|row| !grows(row)),
        )
    }

    fn reference(&self) -> String {
        let line = self.view.by_condition.iter().find(|b| {
            b.inputs == FloatFormat::F32
                && b.quantity == "t"
                && stands_for(self.view, &b.variant, BASELINE, FloatFormat::F64)
        });
        let worst = line.and_then(|line| line.decades.last());
        let says = worst.map_or_else(
            || "The record does not tell.".to_owned(),
            |bin| {
                format!(
                    "Its largest relative error of t is {} where κ is {} or more",
                    scientific(f64::from(bin.error.1)),
                    magnitude(bin.from)
                )
            },
        );
        format!(
            "**The reference.** Möller–Trumbore in f64, the usual reference, is drawn as a line of its \
             own in every figure. {says}: good enough to judge f32 by, whose own error there is \
             many times larger, and no oracle."
        )
    }
}
