//! What the study of the tracer says.

use crate::record::Records;
use crate::tracer::record::{Contest, Traced, TreeBuilt};

use super::select::{classes, is_through, middle, scenes, speed, traced, trees};
use super::summary::{StudyRow, StudySummary, of_view};
use super::{figures, findings};
use crate::comparison::document::view::View;
use crate::lines::{distinct, source};
use trisect_report::document::{Document, Section, Shown};
use trisect_report::format::{fixed, number};
use trisect_report::stats::geometric_mean;
use trisect_report::table::{Columns, Table, count};

const METHODS: &str = "kernel, single, packets: speed over that of Möller–Trumbore, of the tests alone when \
    asked for the fullest hit, of rays one by one and of rays in packets, geometric mean over scenes and \
    classes. Then million rays per second by class, on one thread, geometric mean over scenes. build: of all \
    scenes' trees; bytes: of the trees, per triangle. differ: rays per million whose decision is not the \
    same in plain arithmetic.";

const INLINE: &str = "Every method is called for each leaf. inline: the speed with the method's test inside the \
    traversal loop over that with a call, where both are compiled.";

const BRIEF: &str = "primary to occl: million single rays per second on one thread, geometric mean over \
    scenes. single, packets: the speed of rays one by one and in packets over that of moller-trumbore's, \
    geometric mean over scenes and classes. kernel: the same ratio of the tests alone, asked for the fullest \
    hit.";

const TREES: &str = "Trees of Möller–Trumbore. leaves: when triangles that are together become a leaf: where \
    that is the cheapest, up to sixteen, or always up to so many. rays: single ones, one call of the tree \
    for 16,384 of them; on plain lanes, four of SSE4.2 without fused multiply-add, where the processor has \
    those; one call each, so that what is prepared per call is done for every ray. Building is on all \
    threads. cost: expected tests of a node or a block of eight triangles for a ray that meets the root. By \
    class million rays per second, on one thread.";

const THREADS: &str = "Milliseconds to build by each builder, and million single rays per second through the \
    tree of the last, geometric mean over classes; Möller–Trumbore.";

pub(crate) fn document(records: &Records) -> Document {
    let view = &View::new(records);
    let summary = &of_view(view);
    let methods = methods(view, summary);
    let says = if has_inline(summary) { format!("{METHODS} {INLINE}") } else { METHODS.to_owned() };
    let brief = methods.pick(&[
        ("method", "M rays/s"),
        ("primary, single", "primary"),
        ("random, single", "random"),
        ("diffuse, single", "diffuse"),
        ("occlusion, single", "occl"),
        ("single", "single"),
        ("packets", "packets"),
        ("kernel", "kernel"),
    ]);
    let survives = summary.survives.zip(summary.correlation).map(|(survives, correlation)| {
        format!(
            "A kernel that is twice as fast makes single rays {:.2} times as fast for their closest hits \
             (correlation of the logarithms over methods {correlation:.2}).",
            2_f64.powf(survives),
        )
    });
    let mut sections = vec![Section::findings("study-findings", findings::all(view, summary))];
    sections.extend(figures::all(view, summary));
    sections.extend([
        Section::brief(brief, BRIEF),
        Section::prose(survives.unwrap_or_default()).shown(Shown::Terminal),
        Section::table("methods", "All methods", says, methods).part("study-methods"),
        Section::table("trees", "Builders, leaves, lanes, calls", TREES, ways(view))
            .part("study-trees"),
        Section::table("threads", "Threads", THREADS, threads(view)).part("study-threads"),
    ]);
    Document {
        title: "Ray–triangle intersection in a ray tracer",
        heading: "In a ray tracer",
        source: source(&records.header),
        sections,
    }
}

/// Whether trees with the test inside the loop were timed; older records have no such lines.
fn has_inline(summary: &StudySummary) -> bool {
    summary.rows.iter().any(|row| row.inline_single.is_some())
}

/// A row per method.
fn methods(view: &View, summary: &StudySummary) -> Table {
    let mut table = Table::of(&summary.rows)
        .name("method", |row| &row.method)
        .number("kernel", fixed, |row| row.kernel_gain)
        .number("single", fixed, |row| row.single_gain)
        .number("packets", fixed, |row| row.packet_gain);
    for class in classes(view) {
        let single = |row: &StudyRow| row.single.get(class).copied();
        table = table.number(format!("{class}, single"), number, single);
    }
    for class in classes(view) {
        let packets = |row: &StudyRow| row.packets.get(class).copied();
        table = table.number(format!("{class}, packets"), number, packets);
    }
    if has_inline(summary) {
        table = table.number("inline, single", fixed, |row| row.inline_single).number(
            "inline, packets",
            fixed,
            |row| row.inline_packets,
        );
    }
    table
        .number("build ms", number, |row| row.build_ms)
        .number("bytes", number, |row| row.bytes_per_triangle)
        .number("differ", number, |row| row.differ_per_million)
        .done()
}

/// A row per scene and tree, of one method; then the other ways to trace the tree that is the default.
fn ways(view: &View) -> Table {
    type Way<'a> = (&'a TreeBuilt, &'static str, &'static str, &'static str);
    let ways = |tree| {
        let mut ways: Vec<Way> = vec![(tree, "single", "batch", "single")];
        if tree.builder == "spatial" && tree.leaves == "cheapest" {
            ways.push((tree, "plain", "batch", "plain lanes"));
            ways.push((tree, "single", "ray", "a call each"));
        }
        ways
    };
    let rows: Vec<Way> = trees(view, Contest::Trees).flat_map(ways).collect();
    let mut table: Columns<Way> = Table::of(&rows)
        .name("tree", |(tree, ..)| format!("{}, {}", tree.scene, tree.builder))
        .text("leaves", |(tree, ..)| &tree.leaves)
        .text("rays", |(.., says)| *says)
        .number("build ms", number, |(tree, ..)| Some(middle(&tree.samples_ns)? / 1e6))
        .count("bytes", |(tree, ..)| tree.bytes as u64)
        .number("cost", number, |(tree, ..)| tree.cost)
        .count("references", |(tree, ..)| tree.references as u64)
        .count("nodes", |(tree, ..)| tree.nodes as u64)
        .number("depth", count, |(tree, ..)| tree.depth as f64);
    for class in classes(view) {
        table = table.number(class, number, |(tree, tracing, calls, _)| {
            let is_of = |t: &&Traced| {
                is_through(t, tree)
                    && t.class == class
                    && t.tracing == *tracing
                    && t.calls == *calls
            };
            traced(view, Contest::Trees).find(is_of).and_then(speed)
        });
    }
    table.done()
}

/// A row per scene and number of threads: building and tracing.
fn threads(view: &View) -> Table {
    let trees = || trees(view, Contest::Threads);
    let of_scene = |scene| {
        let mine = trees().filter(move |tree| tree.scene == scene).map(|tree| tree.threads);
        let mut counts = distinct(mine);
        counts.sort_unstable();
        counts.into_iter().map(move |threads| (scene, threads))
    };
    let rows: Vec<(&str, usize)> = scenes(view).into_iter().flat_map(of_scene).collect();
    let speed_of = |scene: &str, threads: usize| {
        let mine =
            traced(view, Contest::Threads).filter(|t| t.scene == scene && t.threads == threads);
        geometric_mean(mine.filter_map(speed))
    };
    let mut table =
        Table::of(&rows).name("threads", |(scene, threads)| format!("{scene}, {threads}"));
    for builder in ["linear", "binned", "spatial"] {
        table = table.number(format!("{builder} ms"), number, |(scene, threads)| {
            let is_of =
                |t: &&TreeBuilt| t.scene == *scene && t.builder == builder && t.threads == *threads;
            Some(middle(&trees().find(is_of)?.samples_ns)? / 1e6)
        });
    }
    table
        .number("M rays/s", number, |(scene, threads)| speed_of(scene, *threads))
        .number("over one thread", fixed, |(scene, threads)| {
            Some(speed_of(scene, *threads)? / speed_of(scene, 1)?)
        })
        .done()
}
