//! What the study of the tracer says, its figures taken from the record.

use trisect_harness::record::{Contest, Traced, TreeBuilt};

use super::summary::{StudyRow, StudySummary, of_view, survival};
use super::{classes, faster, middle, speed, traced, trees};
use crate::format::{grouped, number};
use crate::page::Finding;
use crate::stats::geometric_mean;
use crate::view::{BASELINE, View};

/// All findings that the record has the numbers for.
pub(super) fn findings(view: &View) -> Vec<Finding> {
    let study = Study { view, summary: of_view(view) };
    [
        study.fastest(),
        study.survives(),
        study.fastest_kernel(),
        study.packets(),
        study.builders(),
        study.leaves(),
        study.lanes(),
        study.calls(),
        study.threads(),
        study.chance(),
        study.rounding(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

struct Study<'a> {
    view: &'a View<'a>,
    summary: StudySummary,
}

fn finding(about: &str, says: String, how: String) -> Finding {
    Finding { about: about.to_owned(), says, how }
}

fn times(x: f64) -> String {
    format!("{x:.2} times")
}

impl Study<'_> {
    /// The row that is best by some number.
    fn best(&self, of: impl Fn(&StudyRow) -> Option<f64>) -> Option<(&StudyRow, f64)> {
        let all = self.summary.rows.iter().filter_map(|row| Some((row, of(row)?)));
        all.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn fastest(&self) -> Option<Finding> {
        let (row, gain) = self.best(|row| row.single_gain)?;
        let (of_packets, packet_gain) = self.best(|row| row.packet_gain)?;
        Some(finding(
            "The fastest in the tracer",
            self.view.title(&row.method),
            format!(
                "single rays are {} as fast as with Möller–Trumbore, geometric mean over scenes \
                 and classes; in packets the fastest is {}, {} as fast",
                times(gain),
                self.view.title(&of_packets.method),
                times(packet_gain)
            ),
        ))
    }

    fn survives(&self) -> Option<Finding> {
        let (slope, correlation) = survival(self.view, "single", false)?;
        let others = [("single", true), ("packets", false), ("packets", true)]
            .map(|(tracing, any)| survival(self.view, tracing, any));
        let write = |both: Option<(f64, f64)>| {
            both.map_or_else(|| "–".to_owned(), |(slope, _)| format!("{:.2}", 2_f64.powf(slope)))
        };
        Some(finding(
            "What is left of a kernel's gain",
            format!("{:.2} times for twice", 2_f64.powf(slope)),
            format!(
                "a kernel that is twice as fast makes single rays that much faster for their \
                 closest hits (correlation of the logarithms {correlation:.2}); {} for any hit, in \
                 packets {} and {}",
                write(others[0]),
                write(others[1]),
                write(others[2])
            ),
        ))
    }

    fn fastest_kernel(&self) -> Option<Finding> {
        let (row, gain) = self.best(|row| row.kernel_gain)?;
        Some(finding(
            "The fastest kernel",
            self.view.title(&row.method),
            format!(
                "{} as fast as Möller–Trumbore's on its own; in the tracer {} in single rays and {} \
                 in packets",
                times(gain),
                row.single_gain.map_or_else(|| "–".to_owned(), times),
                row.packet_gain.map_or_else(|| "–".to_owned(), times)
            ),
        ))
    }

    /// The speed of packets over that of single rays, by class, over methods and scenes.
    fn packets(&self) -> Option<Finding> {
        let of = |class: &str| {
            let ratios = self
                .summary
                .rows
                .iter()
                .filter_map(|row| Some(row.packets.get(class)? / row.single.get(class)?));
            geometric_mean(ratios)
        };
        let all: Vec<(&str, f64)> =
            classes(self.view).into_iter().filter_map(|class| Some((class, of(class)?))).collect();
        let best = all.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let list: Vec<String> =
            all.iter().map(|(class, ratio)| format!("{class} {ratio:.2}")).collect();
        Some(finding(
            "Packets",
            format!("{} on {} rays", times(best.1), best.0),
            format!("speed in packets over that of single rays, over methods: {}", list.join(", ")),
        ))
    }

    /// Geometric mean, over scenes and classes of the trees' contest, of the speed of lines over that
    /// of the default tree's single rays in one call, round by round.
    fn against_default(&self, keep: impl Fn(&Traced) -> bool) -> Option<f64> {
        let is_default = |t: &Traced| {
            t.builder == "spatial"
                && t.leaves == "cheapest"
                && t.tracing == "single"
                && t.calls == "batch"
        };
        let all = || traced(self.view, Contest::Trees);
        let ratios = all().filter(|t| keep(t)).filter_map(|mine| {
            let alike = |t: &&Traced| t.scene == mine.scene && t.class == mine.class;
            let default = all().filter(alike).find(|t| is_default(t))?;
            faster(&mine.samples_ns, &default.samples_ns)
        });
        geometric_mean(ratios)
    }

    /// The mean over scenes of a number of a tree over the default tree's.
    fn tree_against_default(
        &self,
        keep: impl Fn(&TreeBuilt) -> bool,
        of: impl Fn(&TreeBuilt) -> Option<f64>,
    ) -> Option<f64> {
        let all = || trees(self.view, Contest::Trees);
        let ratios = all().filter(|tree| keep(tree)).filter_map(|tree| {
            let is_default = |t: &&TreeBuilt| {
                t.scene == tree.scene && t.builder == "spatial" && t.leaves == "cheapest"
            };
            Some(of(tree)? / of(all().find(is_default)?)?)
        });
        geometric_mean(ratios)
    }

    fn builders(&self) -> Option<Finding> {
        let of = |builder: &str| {
            let speed = self.against_default(|t| {
                t.builder == builder
                    && t.tracing == "single"
                    && t.calls == "batch"
                    && t.leaves == "cheapest"
            })?;
            let time = self.tree_against_default(
                |tree| tree.builder == builder && tree.leaves == "cheapest",
                |tree| middle(&tree.samples_ns),
            )?;
            Some((speed, time))
        };
        let (linear, binned) = (of("linear")?, of("binned")?);
        Some(finding(
            "Builders",
            format!("linear, {:.2} of the speed for {:.2} of the time", linear.0, linear.1),
            format!(
                "against the one that splits space; the binned one has {:.2} of the speed for {:.2} \
                 of the time",
                binned.0, binned.1
            ),
        ))
    }

    fn leaves(&self) -> Option<Finding> {
        let of = |leaves: &str| {
            let speed = self.against_default(|t| t.leaves == leaves)?;
            let bytes = |tree: &TreeBuilt| Some(tree.bytes as f64);
            Some((speed, self.tree_against_default(|tree| tree.leaves == leaves, bytes)?))
        };
        let (sixteen, thirty_two) = (of("16")?, of("32")?);
        Some(finding(
            "Triangles per leaf",
            format!("{:.2} of the speed with sixteen", sixteen.0),
            format!(
                "where up to sixteen triangles always become a leaf, instead of where that is the \
                 cheapest, in {:.2} of the memory; with thirty-two {:.2} of the speed in {:.2} of \
                 the memory",
                sixteen.1, thirty_two.0, thirty_two.1
            ),
        ))
    }

    fn lanes(&self) -> Option<Finding> {
        let slower = self.against_default(|t| t.tracing == "plain")?;
        Some(finding(
            "Lanes",
            times(1.0 / slower),
            "single rays on the fast lanes, eight and fused where the processor has those, against \
             plain ones, four without fused multiply-add, whose tests of boxes allow for rounding \
             as well"
                .into(),
        ))
    }

    fn calls(&self) -> Option<Finding> {
        let slower = self.against_default(|t| t.calls == "ray")?;
        let ns = |calls: &str| {
            let mine = traced(self.view, Contest::Trees).filter(|t| {
                t.tracing == "single"
                    && t.calls == calls
                    && t.builder == "spatial"
                    && t.leaves == "cheapest"
            });
            geometric_mean(mine.filter_map(speed)).map(|mrays| 1e3 / mrays)
        };
        let (each, batch) = (ns("ray")?, ns("batch")?);
        Some(finding(
            "One call for all rays",
            times(1.0 / slower),
            format!(
                "against one call for each: {} ns a ray more, of which the dynamic dispatch is a \
                 part, beside the choice of lanes, room for what waits, and a ray's walk having no \
                 other to hide behind",
                number(each - batch)
            ),
        ))
    }

    fn threads(&self) -> Option<Finding> {
        let all = || traced(self.view, Contest::Threads);
        let most = all().map(|t| t.threads).max().filter(|&most| most > 1)?;
        let ratios = all().filter(|t| t.threads == most).filter_map(|mine| {
            let one =
                all().find(|t| t.threads == 1 && t.scene == mine.scene && t.class == mine.class)?;
            faster(&mine.samples_ns, &one.samples_ns)
        });
        let tracing = geometric_mean(ratios)?;
        let built = |builder: &str| {
            let trees = || trees(self.view, Contest::Threads).filter(|t| t.builder == builder);
            let ratios = trees().filter(|t| t.threads == most).filter_map(|mine| {
                let one = trees().find(|t| t.threads == 1 && t.scene == mine.scene)?;
                faster(&mine.samples_ns, &one.samples_ns)
            });
            geometric_mean(ratios).map_or_else(|| "–".to_owned(), |x| format!("{x:.2}"))
        };
        Some(finding(
            "Threads",
            format!("{} with {most}", times(tracing)),
            format!(
                "single rays against one thread; building: linear {}, binned {}, splitting space {}",
                built("linear"),
                built("binned"),
                built("spatial")
            ),
        ))
    }

    /// How much the method that all are compared with differs from itself.
    fn chance(&self) -> Option<Finding> {
        let itself = traced(self.view, Contest::Methods).filter(|t| t.method == BASELINE);
        let off = itself.filter_map(|t| faster(&t.samples_ns, &t.baseline_ns));
        let worst = off.map(|ratio| (ratio - 1.0).abs()).max_by(f64::total_cmp)?;
        Some(finding(
            "What is chance",
            format!("{} %", number(worst * 100.0)),
            "the most by which a ratio of Möller–Trumbore to itself, in turn with it as every \
             method was, is off 1"
                .into(),
        ))
    }

    fn rounding(&self) -> Option<Finding> {
        let rows = self.summary.rows.iter();
        let worst = rows.max_by(|a, b| a.differ_per_million.total_cmp(&b.differ_per_million))?;
        let (rays, differ) = traced(self.view, Contest::Methods)
            .fold((0, 0), |sum, t| (sum.0 + t.rays, sum.1 + t.differ));
        Some(finding(
            "Hits that rounding decides",
            format!("{} of {} rays", grouped(differ), grouped(rays)),
            format!(
                "decided otherwise than by the same method in plain arithmetic, over methods; most by \
                 {}, {} per million",
                self.view.title(&worst.method),
                number(worst.differ_per_million)
            ),
        ))
    }
}
