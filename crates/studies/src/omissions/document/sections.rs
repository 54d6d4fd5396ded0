//! What the study of omissions says.

use crate::omissions::record::{Code, Layer, Omission};
use crate::record::Records;

use super::select::{LAYERS, kind, names, of_layer, ratios};
use super::summary::{OmissionKind, omission_summary};
use crate::lines::{distinct, source};
use trisect_report::document::{Document, Finding, Section, Shown};
use trisect_report::figure::{Axis, Drawing, Group, Look, Mark, Panel, Row, Scale, Shape};
use trisect_report::format::{bytes, ratio};
use trisect_report::table::{Cell, Kind, Table};

/// Double precision, as records name it.
const PRECISION: &str = "f64";

const KERNELS: &str = "Time of the fullest hit over that of whether there is one, one ray at a time on the \
    widest fused lanes of f32, without early-out: median and quartiles over rounds in which both were timed \
    one after the other. numerators: the deferred form, which decides a hit without a division; quotients: \
    the early one, which divides first; a dash where the method does not have that form. f64: the fullest \
    hit in double precision over that in single, in the first of these forms.";

const TRACER: &str = "Time with it over time without, on one thread, single rays: median and quartiles over \
    rounds in which both were timed. values: the closest hit with all its values, against whether there is \
    any. same-bits: plain lanes, which give the same bits on every processor. culling: back faces not seen, \
    in leaves behind a call. robust-boxes: the watertight formula in boxes that allow for their rounding, \
    against boxes that do not. watertight, exact: trees of these methods, against those of Möller–Trumbore, \
    which the other columns are of.";

const PICTURES: &str = "Time of a picture with what its scene does not need over that without, on one \
    thread, by Möller–Trumbore: median and quartiles over rounds in which both were made. everything: all \
    that the scene does not need, together; where that is one part alone it stands there. The picture is the \
    same to the bit.";

pub(crate) fn document(records: &Records) -> Document {
    let tracer = cross(records, Layer::Tracer, "scene, rays", || Cell::Missing);
    let pictures = cross(records, Layer::Picture, "scene", || Cell::Text("needed".into()));
    let mut sections = vec![
        Section::findings("omissions-findings", findings(records)),
        costs(records),
        Section::brief(kinds(&omission_summary(records).kinds), ""),
        Section::table("kernels", "Kernels", KERNELS, kernels(records)).part("omissions-kernels"),
        Section::table("tracer", "Tracer", TRACER, tracer).part("omissions-tracer"),
        Section::table("pictures", "Pictures", PICTURES, pictures).part("omissions-pictures"),
    ];
    sections.extend(records.all::<Code>().map(|code| {
        let says = format!("Instances of the {}: {}, {}", code.of, code.instances, code_says(code));
        Section::prose(says).shown(Shown::Terminal)
    }));
    Document {
        title: "What is gained by leaving out what nobody asks for",
        heading: "What is left out",
        source: source(&records.header),
        sections,
    }
}

/// All findings that the record has the numbers for.
fn findings(records: &Records) -> Vec<Finding> {
    let of_layer = |layer| {
        ratios(records, layer).into_iter().map(move |(name, ratios, mean)| {
            let count = ratios.len();
            let faster = ratios.iter().filter(|ratio| **ratio > 1.0).count();
            let (about, how) = told(layer, name);
            let says = match (layer, name) {
                (Layer::Kernel, form) if form != PRECISION => {
                    format!("{} without values", ratio(mean))
                }
                _ => format!("{} the time", ratio(mean)),
            };
            let over = match (layer, name) {
                (Layer::Kernel, PRECISION) => format!(" over {count} methods"),
                (Layer::Kernel, _) => {
                    format!(" over {count} methods; {faster} of them are faster without")
                }
                (Layer::Tracer, _) => String::new(),
                (Layer::Picture, _) => " over the scenes that do without".to_owned(),
            };
            let how = format!("{how}geometric mean{over}; {}", ends(records, layer, name));
            Finding::new(about, says, how)
        })
    };
    let code = |code: &Code| {
        let says = format!("{} of the {}", code.instances, code.of);
        Finding::new("Instances", says, format!("{}, read from itself", code_says(code)))
    };
    let layers = LAYERS.into_iter().flat_map(|(layer, _)| of_layer(layer));
    layers.chain(records.all().map(code)).collect()
}

/// What something that is left out is, and what it is compared with.
fn told(layer: Layer, part: &str) -> (String, &'static str) {
    let (about, how) = match (layer, part) {
        (Layer::Kernel, PRECISION) => ("Kernels in f64", "against f32, as many tests, "),
        (Layer::Kernel, "deferred") => {
            ("Kernels that decide by numerators", "as fast as with them, in the same form, ")
        }
        (Layer::Kernel, _) => {
            ("Kernels that divide first", "as fast as with them, in the same form, ")
        }
        (Layer::Picture, part) => return (format!("Pictures with {part}"), ""),
        (Layer::Tracer, "values") => {
            ("The closest hit with its values", "against whether there is one, for the same rays, ")
        }
        (Layer::Tracer, "same-bits") => (
            "The same bits on every processor",
            "plain lanes and boxes that allow for rounding, against lanes as the processor has them, ",
        ),
        (Layer::Tracer, "culling") => {
            ("Back faces culled", "through leaves behind a call, against both faces seen, ")
        }
        (Layer::Tracer, "robust-boxes") => (
            "Boxes without cracks",
            "the same watertight formula, with tests of boxes that allow for their rounding and without, ",
        ),
        (Layer::Tracer, "watertight") => ("The watertight method", "against Möller–Trumbore, "),
        (Layer::Tracer, "exact") => ("The exact method", "against Möller–Trumbore, "),
        (Layer::Tracer, other) => (other, "against the same without, "),
    };
    (about.to_owned(), how)
}

/// Where something costs the least, and the most.
fn ends(records: &Records, layer: Layer, name: &str) -> String {
    let mine = of_layer(records, layer).filter(|omission| kind(omission) == name);
    let mut all: Vec<(f64, &Omission)> =
        mine.filter_map(|omission| Some((omission.ratio()?.0, omission))).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(least), Some(most)) = (all.first(), all.last()) else { return String::new() };
    let place = |omission: &Omission| match layer {
        Layer::Kernel => omission.method.clone(),
        Layer::Tracer | Layer::Picture => row_name(omission),
    };
    format!("from {} ({}) to {} ({})", ratio(least.0), place(least.1), ratio(most.0), place(most.1))
}

/// How much code there is of what is compiled several times.
fn code_says(code: &Code) -> String {
    let [own, all] = [code.bytes, code.of_bytes].map(|size| bytes(size as f64));
    format!("{own} of machine code, of the program's {all}")
}

fn row_name(omission: &Omission) -> String {
    format!("{}, {}", omission.scene, omission.of)
}

/// A row for each kind of what is left out, a point for each method, or scene and what is done with it.
fn costs(records: &Records) -> Section {
    let panel = |(place, (layer, name)): (usize, (Layer, &str))| {
        let mut kinds = ratios(records, layer);
        kinds.sort_by(|a, b| b.2.total_cmp(&a.2));
        let values = kinds.iter().flat_map(|(_, all, _)| all).copied().chain([1.0]);
        let axis = Axis::over("times as long with it", Scale::Log, values, ratio);
        let row = |(kind, all, mean): &(&str, Vec<f64>, f64)| {
            let ink = Look::of(place).ink;
            let point = |at: f64| (ink, Mark::Point { at, shape: Shape::Circle, filled: false });
            let mean_at = (ink, Mark::Point { at: *mean, shape: Shape::Diamond, filled: true });
            Row {
                label: (*kind).to_owned(),
                method: String::new(),
                marks: all.iter().copied().map(point).chain([mean_at]).collect(),
                note: ratio(*mean),
            }
        };
        let group = Group { heading: String::new(), rows: kinds.iter().map(row).collect() };
        (!kinds.is_empty()).then(|| Panel::rows(name, axis, Some(1.0), vec![group]))
    };
    let caption = "Time with it over time without, each the median over rounds in which both were timed. \
                   Hollow: of kernels a method each, in the tracer a class of rays through a scene, of \
                   pictures a scene. Filled, with its number: their geometric mean. On the line it costs \
                   nothing.";
    let drawing = Drawing::of(LAYERS.into_iter().enumerate().filter_map(panel).collect());
    Section::figure(
        "omissions-costs",
        "What it takes to keep what nobody asks for",
        caption,
        drawing,
    )
    .missing("Left out: the record holds no omissions; make one with `trisect omissions`.")
}

/// A row per kind, for a terminal.
fn kinds(kinds: &[OmissionKind]) -> Table {
    Table::of(kinds)
        .name("with what is left out", |of| format!("{}: {}", of.layer, of.kind))
        .number("times", ratio, |of| of.mean)
        .number("least", ratio, |of| of.least)
        .number("most", ratio, |of| of.most)
        .done()
}

/// The median with its quartiles.
fn cell(omission: &Omission) -> Option<Cell> {
    let (middle, quartiles) = omission.ratio()?;
    Some(Cell::Ratio(middle, quartiles))
}

/// A row per method, a column per form.
fn kernels(records: &Records) -> Table {
    let mine = || of_layer(records, Layer::Kernel);
    let methods = distinct(mine().map(|omission| omission.method.as_str()));
    let mut table = Table::of(&methods).name("method", |method| *method);
    for (head, name) in [("numerators", "deferred"), ("quotients", "early"), ("f64", PRECISION)] {
        table = table.cells(head, Kind::Number, |method| {
            let found =
                mine().find(|omission| omission.method == *method && kind(omission) == name);
            found.and_then(cell)
        });
    }
    table.done()
}

/// A row per scene and what is done with it, a column per part; `needed` where nothing is left out.
fn cross(records: &Records, layer: Layer, first: &str, needed: fn() -> Cell) -> Table {
    let mine = || of_layer(records, layer);
    let rows = distinct(mine().map(row_name));
    let mut table = Table::of(&rows).name(first, |name| name);
    for part in names(mine().map(|omission| omission.part.as_str())) {
        table = table.cells(part, Kind::Number, |name| {
            let found = mine().find(|other| row_name(other) == *name && other.part == part);
            found.and_then(cell).unwrap_or_else(needed)
        });
    }
    table.done()
}
