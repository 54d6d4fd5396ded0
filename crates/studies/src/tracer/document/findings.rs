//! What the study of the tracer says, its figures taken from the record.

use trisect_report::document::Finding;
use trisect_report::format::{fixed, grouped, number, or_dash};
use trisect_report::stats::geometric_mean;

use super::select::{against_default, classes, faster, is_single, middle, speed, traced, trees};
use super::summary::{StudyRow, StudySummary, survival};
use crate::comparison::document::view::{BASELINE, View};
use crate::tracer::record::{Contest, Traced, TreeBuilt};

/// All findings that the record has the numbers for.
pub(super) fn all<'a>(view: &'a View<'a>, summary: &'a StudySummary) -> Vec<Finding> {
    let study = Study { view, summary };
    let findings = [
        study.fastest(),
        study.survives(),
        study.fastest_kernel(),
        study.packets(),
        study.builders(),
        study.leaves(),
        study.lanes(),
        study.calls(),
        study.inline(),
        study.threads(),
        study.chance(),
        study.rounding(),
    ];
    findings.into_iter().flatten().collect()
}

struct Study<'a> {
    view: &'a View<'a>,
    summary: &'a StudySummary,
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
        let how = format!(
            "single rays are {} as fast as with Möller–Trumbore, geometric mean over scenes and classes; in \
             packets the fastest is {}, {} as fast",
            times(gain),
            self.view.title(&of_packets.method),
            times(packet_gain)
        );
        Some(Finding::new("The fastest in the tracer", self.view.title(&row.method), how))
    }

    fn survives(&self) -> Option<Finding> {
        let (slope, correlation) = survival(self.view, "single", false)?;
        let write = |tracing, any| {
            let slope = survival(self.view, tracing, any).map(|(slope, _)| slope);
            or_dash(slope.map(|slope| 2_f64.powf(slope)), fixed)
        };
        let how = format!(
            "what a kernel twice as fast gains for closest hits of single rays (correlation of the logarithms \
             {correlation:.2}); for any hit {}, in packets {} and {}",
            write("single", true),
            write("packets", false),
            write("packets", true)
        );
        let says = format!("{} from a kernel twice as fast", times(2_f64.powf(slope)));
        Some(Finding::new("How much of a kernel's gain remains", says, how))
    }

    fn fastest_kernel(&self) -> Option<Finding> {
        let (row, gain) = self.best(|row| row.kernel_gain)?;
        let how = format!(
            "{} as fast as Möller–Trumbore's on its own; in the tracer {} in single rays and {} in packets",
            times(gain),
            or_dash(row.single_gain, times),
            or_dash(row.packet_gain, times)
        );
        Some(Finding::new("The fastest kernel", self.view.title(&row.method), how))
    }

    /// The speed of packets over that of single rays, by class, over methods and scenes.
    fn packets(&self) -> Option<Finding> {
        let gain = |class: &str| {
            let both = |row: &StudyRow| Some(row.packets.get(class)? / row.single.get(class)?);
            geometric_mean(self.summary.rows.iter().filter_map(both))
        };
        let classes = classes(self.view).into_iter();
        let all: Vec<_> = classes.filter_map(|class| Some((class, gain(class)?))).collect();
        let best = all.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let list: Vec<_> = all.iter().map(|(class, gain)| format!("{class} {gain:.2}")).collect();
        let list = list.join(", ");
        let how = format!("speed in packets over that of single rays, over methods: {list}");
        Some(Finding::new("Packets", format!("{} on {} rays", times(best.1), best.0), how))
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
            let speed = against_default(self.view, |t| {
                t.builder == builder && t.leaves == "cheapest" && is_single(t)
            })?;
            let is_of = |tree: &TreeBuilt| tree.builder == builder && tree.leaves == "cheapest";
            let time = self.tree_against_default(is_of, |tree| middle(&tree.samples_ns))?;
            Some(format!("{speed:.2} of the speed for {time:.2} of the time"))
        };
        let how = format!("compared with the builder that splits space; binned: {}", of("binned")?);
        Some(Finding::new("Builders", format!("linear, {}", of("linear")?), how))
    }

    fn leaves(&self) -> Option<Finding> {
        let of = |leaves: &str| {
            let speed = against_default(self.view, |t| t.leaves == leaves)?;
            let bytes = |tree: &TreeBuilt| Some(tree.bytes as f64);
            Some((speed, self.tree_against_default(|tree| tree.leaves == leaves, bytes)?))
        };
        let (sixteen, thirty_two) = (of("16")?, of("32")?);
        let how = format!(
            "where up to sixteen triangles always become a leaf, not only where that is cheapest: {:.2} of the \
             memory; with thirty-two {:.2} of the speed in {:.2} of the memory",
            sixteen.1, thirty_two.0, thirty_two.1
        );
        let says = format!("{:.2} of the speed with sixteen", sixteen.0);
        Some(Finding::new("Triangles per leaf", says, how))
    }

    fn lanes(&self) -> Option<Finding> {
        let slower = against_default(self.view, |t| t.tracing == "plain")?;
        let how = "single rays on the fast lanes, eight and fused where the processor has those, against \
                   plain ones, four without fused multiply-add, whose tests of boxes allow for rounding as \
                   well";
        Some(Finding::new("Lanes", times(1.0 / slower), how))
    }

    fn calls(&self) -> Option<Finding> {
        let slower = against_default(self.view, |t| t.calls == "ray")?;
        let ns = |calls: &str| {
            let mine = traced(self.view, Contest::Trees).filter(|t| {
                t.tracing == "single"
                    && t.calls == calls
                    && t.builder == "spatial"
                    && t.leaves == "cheapest"
            });
            geometric_mean(mine.filter_map(speed)).map(|mrays| 1e3 / mrays)
        };
        let how = format!(
            "compared with one call per ray, which takes {} ns more per ray: dynamic dispatch, the choice of \
             lanes, room for the traversal stack, and no other ray whose work hides its latency",
            number(ns("ray")? - ns("batch")?)
        );
        Some(Finding::new("One call for all rays", times(1.0 / slower), how))
    }

    /// What the test inside the traversal loop gains over a call for each leaf.
    fn inline(&self) -> Option<Finding> {
        let gain = |of: fn(&StudyRow) -> Option<f64>| {
            geometric_mean(self.summary.rows.iter().filter_map(of))
        };
        let (single, packets) = (gain(|row| row.inline_single)?, gain(|row| row.inline_packets)?);
        let by_class = classes(self.view).into_iter().filter_map(|class| {
            let mine = traced(self.view, Contest::Inline)
                .filter(|t| t.class == class && t.tracing == "single");
            let gain = geometric_mean(mine.filter_map(|t| faster(&t.samples_ns, &t.baseline_ns)))?;
            Some(format!("{class} {gain:.2}"))
        });
        Some(Finding::new(
            "The test inside the loop",
            times(single),
            format!(
                "single rays against a call for each leaf, which is how all methods are compared; \
                 geometric mean over the methods that are compiled both ways; in packets {}; single \
                 rays by class: {}",
                times(packets),
                by_class.collect::<Vec<_>>().join(", ")
            ),
        ))
    }

    fn threads(&self) -> Option<Finding> {
        let all = || traced(self.view, Contest::Threads);
        let most = all().map(|t| t.threads).max().filter(|&most| most > 1)?;
        let ratios = all().filter(|t| t.threads == most).filter_map(|mine| {
            let is_one =
                |t: &&Traced| t.threads == 1 && t.scene == mine.scene && t.class == mine.class;
            faster(&mine.samples_ns, &all().find(is_one)?.samples_ns)
        });
        let tracing = geometric_mean(ratios)?;
        let built = |builder: &str| {
            let trees = || trees(self.view, Contest::Threads).filter(|t| t.builder == builder);
            let ratios = trees().filter(|t| t.threads == most).filter_map(|mine| {
                let one = trees().find(|t| t.threads == 1 && t.scene == mine.scene)?;
                faster(&mine.samples_ns, &one.samples_ns)
            });
            or_dash(geometric_mean(ratios), fixed)
        };
        let how = format!(
            "single rays against one thread; building: linear {}, binned {}, splitting space {}",
            built("linear"),
            built("binned"),
            built("spatial")
        );
        Some(Finding::new("Threads", format!("{} with {most}", times(tracing)), how))
    }

    /// How much the method that all are compared with differs from itself.
    fn chance(&self) -> Option<Finding> {
        let itself = traced(self.view, Contest::Methods).filter(|t| t.method == BASELINE);
        let off = itself.filter_map(|t| faster(&t.samples_ns, &t.baseline_ns));
        let worst = off.map(|ratio| (ratio - 1.0).abs()).max_by(f64::total_cmp)?;
        let how = "the largest deviation from 1 when Möller–Trumbore is timed against itself, as every method \
                   was against it";
        Some(Finding::new("Measurement noise", format!("{} %", number(worst * 100.0)), how))
    }

    fn rounding(&self) -> Option<Finding> {
        let rows = self.summary.rows.iter();
        let worst = rows.max_by(|a, b| a.differ_per_million.total_cmp(&b.differ_per_million))?;
        let (rays, differ) = traced(self.view, Contest::Methods)
            .fold((0, 0), |sum, t| (sum.0 + t.rays, sum.1 + t.differ));
        let how = format!(
            "decided differently than by the same method in plain arithmetic, over methods; most by {}, {} per \
             million",
            self.view.title(&worst.method),
            number(worst.differ_per_million)
        );
        let says = format!("{} of {} rays", grouped(differ), grouped(rays));
        Some(Finding::new("Hits that rounding decides", says, how))
    }
}
