//! Tables and findings of the study of omissions, for pages and documents alike.

use std::fmt::Write as _;

use trisect_harness::record::{Code, Layer, Omission};

use super::{distinct, kind, of_layer, ratios};
use crate::format::{bytes, or_dash, ratio};
use crate::markdown::{Table, measured, part};
use crate::page::Finding;
use crate::view::View;

/// What was found, in words; nothing where nothing was studied.
pub(crate) fn findings(view: &View) -> String {
    let mut text = String::new();
    for finding in all_findings(view) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "- **{}:** {}; {}.", finding.about, finding.says, finding.how);
    }
    if !text.is_empty() {
        let _ = writeln!(text, "\n{}", measured(view));
    }
    text
}

/// Double precision, as records name it.
const PRECISION: &str = "f64";

/// All findings that the record has the numbers for.
pub(super) fn all_findings(view: &View) -> Vec<Finding> {
    let finding = |about: &str, says, how| Finding { about: about.into(), says, how };
    let mut all = Vec::new();
    for (form, ratios, mean) in ratios(view, Layer::Kernel) {
        let count = ratios.len();
        if form == PRECISION {
            let how = format!(
                "against f32, as many tests, geometric mean over {count} methods; {}",
                ends(view, Layer::Kernel, form)
            );
            all.push(finding("Kernels in f64", format!("{} the time", ratio(mean)), how));
            continue;
        }
        let faster = ratios.iter().filter(|ratio| **ratio > 1.0).count();
        let about = match form {
            "deferred" => "Kernels that decide by numerators",
            _ => "Kernels that divide first",
        };
        all.push(finding(
            about,
            format!("{} without values", ratio(mean)),
            format!(
                "as fast as with them, in the same form, geometric mean over {count} methods; {faster} of \
                 them are faster without; {}",
                ends(view, Layer::Kernel, form)
            ),
        ));
    }
    for (name, _, mean) in ratios(view, Layer::Tracer) {
        let (about, how) = told(name);
        let how = format!("{how}, geometric mean; {}", ends(view, Layer::Tracer, name));
        all.push(finding(about, format!("{} the time", ratio(mean)), how));
    }
    for (name, _, mean) in ratios(view, Layer::Picture) {
        let how = format!(
            "geometric mean over the scenes that do without; {}",
            ends(view, Layer::Picture, name)
        );
        let about = format!("Pictures with {name}");
        all.push(finding(&about, format!("{} the time", ratio(mean)), how));
    }
    for code in &view.code {
        let says = format!("{} of the {}", code.instances, code.of);
        all.push(finding("Instances", says, format!("{}, read from itself", code_says(code))));
    }
    all
}

/// What something that the tracer leaves out is, and what it is compared with.
fn told(part: &str) -> (&str, &'static str) {
    match part {
        "values" => {
            ("The closest hit with its values", "against whether there is one, for the same rays")
        }
        "same-bits" => (
            "The same bits on every processor",
            "plain lanes and boxes that allow for rounding, against lanes as the processor has them",
        ),
        "culling" => ("Back faces culled", "through leaves behind a call, against both faces seen"),
        "robust-boxes" => (
            "Boxes without cracks",
            "the same watertight formula, with tests of boxes that allow for their rounding and without",
        ),
        "watertight" => ("The watertight method", "against Möller–Trumbore"),
        "exact" => ("The exact method", "against Möller–Trumbore"),
        other => (other, "against the same without"),
    }
}

/// Where something costs the least, and the most.
fn ends(view: &View, layer: Layer, name: &str) -> String {
    let mine = of_layer(view, layer).filter(|omission| kind(omission) == name);
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
pub(super) fn code_says(code: &Code) -> String {
    let Code { bytes: own, of_bytes, .. } = code;
    let (own, all) = (bytes(*own as f64), bytes(*of_bytes as f64));
    format!("{own} of machine code, of the program's {all}")
}

fn row_name(omission: &Omission) -> String {
    format!("{}, {}", omission.scene, omission.of)
}

/// The median with its quartiles.
fn cell(omission: &Omission) -> Option<String> {
    let (middle, [low, high]) = omission.ratio()?;
    Some(format!("{} ({low:.2}–{high:.2})", ratio(middle)))
}

/// A row per method, a column per form.
pub(crate) fn kernels(view: &View) -> Table {
    let mut table = Table::new(&["method", "numerators", "quotients", "f64"]);
    for method in distinct(of_layer(view, Layer::Kernel), |omission| &omission.method) {
        let of = |name: &str| {
            let mut mine = of_layer(view, Layer::Kernel);
            let mine = mine.find(|omission| omission.method == method && kind(omission) == name);
            mine.and_then(cell).unwrap_or_else(|| or_dash(None, ratio))
        };
        let cells = ["deferred", "early", PRECISION].map(of);
        table.rows.push([vec![method.to_owned()], cells.into()].concat());
    }
    table
}

/// What the columns of [`kernels`] mean.
pub(crate) const KERNELS: &str = "Time of the fullest hit over that of whether there is one, one ray at a \
    time on the widest fused lanes of f32, without early-out: median and quartiles over rounds in which \
    both were timed one after the other. numerators: the deferred form, which decides a hit without a \
    division; quotients: the early one, which divides first; a dash where the method has not that form. \
    f64: the fullest hit in double precision over that in single, in the first of these forms.";

/// A row per scene and what is done with it, a column per part.
fn cross(view: &View, layer: Layer, first: &str, needed: &str) -> Table {
    let parts = distinct(of_layer(view, layer), |omission| &omission.part);
    let mut table = Table::new(&[&[first], &parts[..]].concat());
    let mut names: Vec<String> = Vec::new();
    for name in of_layer(view, layer).map(row_name) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    for name in names {
        let of = |part: &&str| {
            let mut mine = of_layer(view, layer);
            let mine = mine.find(|other| row_name(other) == name && other.part == **part);
            mine.and_then(cell).unwrap_or_else(|| needed.to_owned())
        };
        let cells: Vec<String> = parts.iter().map(of).collect();
        table.rows.push([vec![name], cells].concat());
    }
    table
}

/// A row per scene and class of rays, a column per part.
pub(crate) fn tracer(view: &View) -> Table {
    cross(view, Layer::Tracer, "scene, rays", "–")
}

/// What the columns of [`tracer`] mean.
pub(crate) const TRACER: &str = "Time with it over time without, on one thread, single rays: median and \
    quartiles over rounds in which both were timed. values: the closest hit with all its values, against \
    whether there is any. same-bits: plain lanes, which give the same bits on every processor. culling: \
    back faces not seen, in leaves behind a call. robust-boxes: the watertight formula in boxes that \
    allow for their rounding, against boxes that do not. watertight, exact: trees of these methods, against \
    those of Möller–Trumbore, which the other columns are of.";

/// A row per scene and settings, a column per part.
pub(crate) fn pictures(view: &View) -> Table {
    cross(view, Layer::Picture, "scene", "needed")
}

/// What the columns of [`pictures`] mean.
pub(crate) const PICTURES: &str = "Time of a picture with what its scene does not need over that without, \
    on one thread, by Möller–Trumbore: median and quartiles over rounds in which both were made. \
    everything: all that the scene does not need, together; where that is one part alone it stands there. \
    The picture is the same to the bit.";

/// A part of a document; nothing where the record says nothing about it.
pub(crate) fn unless_empty(view: &View, table: &Table, says: &str) -> String {
    if table.rows.is_empty() { String::new() } else { part(view, table, says) }
}
