//! The figures of the tracer's study.

use trisect_harness::record::Contest;

use super::summary::{StudyRow, gains, of_view};
use super::{classes, faster, middle, scenes, speed, traced, trees};
use crate::chart::{
    Axis, Drawing, Entry, Group, Join, Look, Mark, Panel, Plane, Row, Rows, Sample, Scale, Series,
    Shape,
};
use crate::figures::{Figure, look};
use crate::format::{number, ratio, tick};
use crate::stats::geometric_mean;
use crate::theme::Ink;
use crate::view::{BASELINE, View};

/// All figures, in the order of the page.
pub(super) fn all(view: &View) -> Vec<Figure> {
    vec![gain(view), methods(view), builders(view), threads(view)]
}

fn nothing_traced() -> String {
    "Left out: the record holds no study of the tracer; make one with `trisect study`.".into()
}

/// How many methods are told apart in a figure of all.
const MARKED: usize = 6;

/// The fastest methods, and the one that all are compared with.
fn marked(rows: &[StudyRow]) -> Vec<&str> {
    let mut order: Vec<(&str, f64)> =
        rows.iter().filter_map(|row| Some((row.method.as_str(), row.single_gain?))).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut methods: Vec<&str> = order.into_iter().map(|(method, _)| method).take(MARKED).collect();
    if !methods.contains(&BASELINE) {
        methods.push(BASELINE);
    }
    methods
}

fn point(look: Look, filled: bool, points: Vec<(f64, f64)>) -> Series {
    Series { look, filled, join: Join::No, marked: true, points }
}

fn gain(view: &View) -> Figure {
    let rows = of_view(view).rows;
    let marked = marked(&rows);
    let panels: Vec<Panel> = [("Single rays", "single"), ("Packets", "packets")]
        .into_iter()
        .filter_map(|(title, tracing)| {
            let all: Vec<(&str, bool, (f64, f64))> = [false, true]
                .into_iter()
                .flat_map(|any| {
                    gains(view, tracing, any).into_iter().map(move |(name, at)| (name, any, at))
                })
                .collect();
            if all.is_empty() {
                return None;
            }
            let look_of = |method: &str| {
                if marked.contains(&method) {
                    look(view, method)
                } else {
                    Look { ink: Ink::Grid, shape: Shape::Circle }
                }
            };
            let ends = |of: fn(&(f64, f64)) -> f64| {
                let values = || all.iter().map(|(.., at)| of(at));
                (values().fold(1.0, f64::min), values().fold(1.0, f64::max))
            };
            let (across, up) = (ends(|at| at.0), ends(|at| at.1));
            // As far as the points go in both directions.
            let line = [across.0.max(up.0), across.1.min(up.1)];
            let mut series = vec![Series {
                look: Look { ink: Ink::Muted, shape: Shape::Circle },
                filled: false,
                join: Join::Straight,
                marked: false,
                points: line.map(|x| (x, x)).into(),
            }];
            let (told, others): (Vec<_>, Vec<_>) =
                all.iter().partition(|(method, ..)| marked.contains(method));
            series.extend(
                others
                    .into_iter()
                    .chain(told)
                    .map(|&(method, any, at)| point(look_of(method), !any, vec![at])),
            );
            Some(Panel::Plane(Plane {
                title: title.into(),
                x: Axis::over("kernel", Scale::Log, [across.0, across.1], ratio),
                y: Axis::over("tracer", Scale::Log, [up.0, up.1], ratio),
                height: 300,
                series,
                rules: Vec::new(),
                labels: Vec::new(),
            }))
        })
        .collect();
    let mut legend: Vec<Entry> = view
        .methods()
        .iter()
        .filter(|method| marked.contains(*method))
        .map(|&method| Entry {
            sample: Sample::Point(look(view, method), true),
            text: view.title(method),
        })
        .collect();
    let other = |ink| Look { ink, shape: Shape::Circle };
    for (ink, filled, text) in [
        (Ink::Grid, true, "other methods"),
        (Ink::Muted, true, "closest hit"),
        (Ink::Muted, false, "any hit"),
    ] {
        legend.push(Entry { sample: Sample::Point(other(ink), filled), text: text.into() });
    }
    let text = "as much as the kernel".into();
    legend.push(Entry { sample: Sample::Line(Ink::Muted), text });
    Figure {
        name: "study-gain",
        title: "What is left of a kernel's gain",
        caption: "Speed over that of Möller–Trumbore: across, of the test alone, one ray against \
                  lanes of triangles on random rays; up, of rays through a tree on one thread, \
                  geometric mean over scenes and classes, both methods in turn. On the line the \
                  tracer would gain as much as its kernel."
            .into(),
        drawing: if panels.is_empty() {
            Err(nothing_traced())
        } else {
            Ok(Drawing { panels, legend, key: Vec::new() })
        },
    }
}

fn methods(view: &View) -> Figure {
    let rows = of_view(view).rows;
    let both = |row: &StudyRow, class: &str| {
        [(row.single.get(class), true), (row.packets.get(class), false)]
            .into_iter()
            .filter_map(|(at, filled)| Some((*at?, filled)))
            .collect::<Vec<_>>()
    };
    let panels: Vec<Panel> = classes(view)
        .into_iter()
        .filter_map(|class| {
            let mut shown: Vec<(&StudyRow, Vec<(f64, bool)>)> =
                rows.iter().map(|row| (row, both(row, class))).collect();
            shown.retain(|(_, marks)| !marks.is_empty());
            let best = |marks: &[(f64, bool)]| marks.iter().map(|m| m.0).fold(0.0, f64::max);
            shown.sort_by(|a, b| best(&b.1).total_cmp(&best(&a.1)));
            let values = shown.iter().flat_map(|(_, marks)| marks).map(|m| m.0).chain([0.0]);
            let axis = Axis::over("million rays per second", Scale::Linear, values, tick);
            let as_row = |(row, marks): &(&StudyRow, Vec<(f64, bool)>)| Row {
                label: row.method.clone(),
                ink: look(view, &row.method).ink,
                marks: marks
                    .iter()
                    .map(|&(at, filled)| Mark::Point { at, shape: Shape::Circle, filled })
                    .collect(),
                note: marks.first().map_or_else(String::new, |m| number(m.0)),
            };
            let group = Group {
                heading: if class == "occlusion" { "any hit" } else { "closest hit" }.into(),
                rows: shown.iter().map(as_row).collect(),
            };
            (!shown.is_empty()).then(|| Panel::Rows(Rows::new(class, axis, None, vec![group])))
        })
        .collect();
    Figure {
        name: "study-methods",
        title: "Speed of every method by class of rays",
        caption: "Million rays per second on one thread, geometric mean over scenes of the median \
                  over rounds. Filled, with its number: single rays; hollow: packets. The faster \
                  of the two decides the order."
            .into(),
        drawing: if panels.is_empty() {
            Err(nothing_traced())
        } else {
            Ok(Drawing { panels, ..Drawing::default() })
        },
    }
}

fn builders(view: &View) -> Figure {
    let of_scene = |scene: &&str| {
        let mut series = Vec::new();
        let mut labels = Vec::new();
        let mine = trees(view, Contest::Trees).filter(|tree| tree.scene == *scene);
        for (number, tree) in mine.enumerate() {
            let lines = traced(view, Contest::Trees).filter(|t| {
                t.scene == *scene
                    && t.builder == tree.builder
                    && t.leaves == tree.leaves
                    && t.tracing == "single"
                    && t.calls == "batch"
            });
            let (Some(ns), Some(mrays)) =
                (middle(&tree.samples_ns), geometric_mean(lines.filter_map(speed)))
            else {
                continue;
            };
            let at = (ns / 1e6, mrays);
            series.push(point(Look::of(number), true, vec![at]));
            let leaves = if tree.leaves == "cheapest" {
                tree.builder.clone()
            } else {
                format!("{} always", tree.leaves)
            };
            labels.push((at.0, at.1, leaves));
        }
        let points = || series.iter().flat_map(|s: &Series| &s.points);
        if series.is_empty() {
            return None;
        }
        Some(Panel::Plane(Plane {
            title: (*scene).to_owned(),
            x: Axis::over("ms to build", Scale::Log, points().map(|p| p.0), tick),
            y: Axis::over("million rays per second", Scale::Linear, points().map(|p| p.1), tick)
                .with_margin(),
            height: 240,
            series,
            rules: Vec::new(),
            labels,
        }))
    };
    let panels: Vec<Panel> = scenes(view).iter().filter_map(of_scene).collect();
    Figure {
        name: "study-builders",
        title: "Builders: time to build against speed",
        caption:
            "Trees of Möller–Trumbore, built on all threads, and traced by single rays on one: \
                  geometric mean over classes, all trees in turn. Up and left is better. The \
                  spatial builder's tree also with leaves of up to 16 and 32 triangles always, \
                  whether cheaper or not."
                .into(),
        drawing: if panels.is_empty() {
            Err(nothing_traced())
        } else {
            Ok(Drawing { panels, ..Drawing::default() })
        },
    }
}

fn threads(view: &View) -> Figure {
    const LINES: [(&str, &str); 4] = [
        ("", "single rays"),
        ("linear", "linear builder"),
        ("binned", "binned builder"),
        ("spatial", "spatial builder"),
    ];
    let points = |scene: &str, builder: &str| {
        let mut points = Vec::new();
        if builder.is_empty() {
            let all = || traced(view, Contest::Threads).filter(|t| t.scene == scene);
            let mut counts: Vec<usize> = all().map(|t| t.threads).collect();
            counts.sort_unstable();
            counts.dedup();
            for threads in counts {
                let ratios = all().filter(|t| t.threads == threads).filter_map(|mine| {
                    let one = all().find(|t| t.threads == 1 && t.class == mine.class)?;
                    faster(&mine.samples_ns, &one.samples_ns)
                });
                points.extend(geometric_mean(ratios).map(|gain| (threads as f64, gain)));
            }
        } else {
            let all = || {
                trees(view, Contest::Threads).filter(|t| t.scene == scene && t.builder == builder)
            };
            let one = all().find(|t| t.threads == 1);
            points.extend(all().filter_map(|mine| {
                Some((mine.threads as f64, faster(&mine.samples_ns, &one?.samples_ns)?))
            }));
        }
        points
    };
    let of_scene = |scene: &&str| {
        let series: Vec<Series> = LINES
            .iter()
            .enumerate()
            .map(|(number, (builder, _))| Series {
                look: Look::of(number),
                filled: true,
                join: Join::Straight,
                marked: true,
                points: points(scene, builder),
            })
            .filter(|series| !series.points.is_empty())
            .collect();
        let shown: Vec<(f64, f64)> = series.iter().flat_map(|s| s.points.clone()).collect();
        if shown.iter().all(|p| p.0 <= 1.0) {
            return None;
        }
        // With air above the highest point.
        let y = shown.iter().map(|p| 1.05 * p.1).chain([0.0]);
        Some(Panel::Plane(Plane {
            title: (*scene).to_owned(),
            x: Axis::over("threads", Scale::Binary, shown.iter().map(|p| p.0), tick),
            y: Axis::over("over one thread", Scale::Linear, y, ratio),
            height: 240,
            series,
            rules: Vec::new(),
            labels: Vec::new(),
        }))
    };
    let panels: Vec<Panel> = scenes(view).iter().filter_map(of_scene).collect();
    let legend = LINES.iter().enumerate().map(|(number, (_, text))| Entry {
        sample: Sample::Point(Look::of(number), true),
        text: (*text).into(),
    });
    Figure {
        name: "study-threads",
        title: "Threads",
        caption: "Speed over that of one thread, round by round: building by each builder, and \
                  single rays, geometric mean over classes. Möller–Trumbore."
            .into(),
        drawing: if view.traced.is_empty() {
            Err(nothing_traced())
        } else if panels.is_empty() {
            Err("Left out: the record is of one thread.".into())
        } else {
            Ok(Drawing { panels, legend: legend.collect(), key: Vec::new() })
        },
    }
}
