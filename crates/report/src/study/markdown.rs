//! Tables of the tracer's study, for pages and documents alike.

use std::fmt::Write as _;

use trisect_harness::record::{Contest, Traced, TreeBuilt};

use super::summary::of_view;
use super::{classes, middle, scenes, speed, traced};
use crate::format::{grouped, number, or_dash};
use crate::markdown::{Table, measured};
use crate::stats::geometric_mean;
use crate::view::View;

/// What was found, in words.
pub(crate) fn findings(view: &View) -> String {
    let mut text = String::new();
    for finding in super::findings::findings(view) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "- **{}:** {}; {}.", finding.about, finding.says, finding.how);
    }
    let _ = writeln!(text, "\n{}", measured(view));
    text
}

fn times(x: Option<f64>) -> String {
    or_dash(x, |x| format!("{x:.2}"))
}

/// A row per method.
pub(crate) fn methods(view: &View) -> Table {
    let classes = classes(view);
    let mut head =
        vec!["method".to_owned(), "kernel".to_owned(), "single".into(), "packets".into()];
    head.extend(classes.iter().map(|class| format!("{class}, single")));
    head.extend(classes.iter().map(|class| format!("{class}, packets")));
    head.extend(["build ms", "bytes", "differ"].map(ToOwned::to_owned));
    let mut table = Table { head, rows: Vec::new() };
    for row in of_view(view).rows {
        let mut cells = vec![
            row.method.clone(),
            times(row.kernel_gain),
            times(row.single_gain),
            times(row.packet_gain),
        ];
        for speeds in [&row.single, &row.packets] {
            cells.extend(classes.iter().map(|class| or_dash(speeds.get(*class).copied(), number)));
        }
        cells.push(or_dash(row.build_ms, number));
        cells.push(or_dash(row.bytes_per_triangle, number));
        cells.push(number(row.differ_per_million));
        table.rows.push(cells);
    }
    table
}

/// What the columns of [`methods`] mean.
pub(crate) const METHODS: &str = "kernel, single, packets: speed over that of Möller–Trumbore, of \
    the tests alone when asked for the fullest hit, of rays one by one and of rays in packets, \
    geometric mean over scenes and classes. Then million rays per second by class, on one thread, \
    geometric mean over scenes. build: of all scenes' trees; bytes: of the trees, per triangle. \
    differ: rays per million whose decision is not the same in plain arithmetic.";

/// The lines of the trees' contest about one tree and way of tracing, by class.
fn by_class(view: &View, keep: impl Fn(&Traced) -> bool) -> Vec<String> {
    let of = |class: &&str| {
        let mine = traced(view, Contest::Trees).find(|t| t.class == **class && keep(t));
        or_dash(mine.and_then(speed), number)
    };
    classes(view).iter().map(of).collect()
}

/// A row per scene and tree, of one method; then the other ways to trace the tree that is the default.
pub(crate) fn trees(view: &View) -> Table {
    let mut head: Vec<String> =
        ["tree", "leaves", "rays", "build ms", "bytes", "cost", "references", "nodes", "depth"]
            .map(ToOwned::to_owned)
            .into();
    head.extend(classes(view).iter().map(|class| (*class).to_owned()));
    let mut table = Table { head, rows: Vec::new() };
    for tree in super::trees(view, Contest::Trees) {
        let TreeBuilt { scene, builder, leaves, .. } = tree;
        let mut ways = vec![("single", "batch", "single")];
        if builder == "spatial" && leaves == "cheapest" {
            ways.extend([("plain", "batch", "plain lanes"), ("single", "ray", "a call each")]);
        }
        for (tracing, calls, says) in ways {
            let mut row = vec![format!("{scene}, {builder}"), leaves.clone(), says.to_owned()];
            row.extend([
                or_dash(middle(&tree.samples_ns).map(|ns| ns / 1e6), number),
                grouped(tree.bytes as u64),
                number(tree.cost),
                grouped(tree.references as u64),
                grouped(tree.nodes as u64),
                tree.depth.to_string(),
            ]);
            row.extend(by_class(view, |t| {
                t.scene == *scene
                    && t.builder == *builder
                    && t.leaves == *leaves
                    && t.tracing == tracing
                    && t.calls == calls
            }));
            table.rows.push(row);
        }
    }
    table
}

/// What the columns of [`trees`] mean.
pub(crate) const TREES: &str = "Trees of Möller–Trumbore. leaves: when triangles that are \
    together become a leaf: where that is the cheapest, up to sixteen, or always up to so many. \
    rays: single ones, one call of the tree for 16,384 of them; on plain lanes, four of SSE4.2 without \
    fused multiply-add, where the processor has those; one call each, so that what is prepared per call is done for \
    every ray. Building is on all threads. cost: expected tests of a node or a block of eight \
    triangles for a ray that meets the root. By class million rays per second, on one thread.";

/// A row per scene and number of threads: building and tracing.
pub(crate) fn threads(view: &View) -> Table {
    let mut table = Table::new(&[
        "threads",
        "linear ms",
        "binned ms",
        "spatial ms",
        "M rays/s",
        "over one thread",
    ]);
    for scene in scenes(view) {
        let speed_of = |threads: usize| {
            let mine =
                traced(view, Contest::Threads).filter(|t| t.scene == scene && t.threads == threads);
            geometric_mean(mine.filter_map(speed))
        };
        let mut counts: Vec<usize> = super::trees(view, Contest::Threads)
            .filter(|tree| tree.scene == scene)
            .map(|tree| tree.threads)
            .collect();
        counts.sort_unstable();
        counts.dedup();
        for threads in counts {
            let build = |builder: &str| {
                let tree = super::trees(view, Contest::Threads).find(|tree| {
                    tree.scene == scene && tree.builder == builder && tree.threads == threads
                });
                or_dash(tree.and_then(|t| middle(&t.samples_ns)).map(|ns| ns / 1e6), number)
            };
            let mut row = vec![format!("{scene}, {threads}")];
            row.extend(["linear", "binned", "spatial"].map(build));
            row.push(or_dash(speed_of(threads), number));
            row.push(times(speed_of(threads).zip(speed_of(1)).map(|(many, one)| many / one)));
            table.rows.push(row);
        }
    }
    table
}

/// What the columns of [`threads`] mean.
pub(crate) const THREADS: &str = "Milliseconds to build by each builder, and million single rays \
    per second through the tree of the last, geometric mean over classes; Möller–Trumbore.";
