//! What leaves and calls cost, beside A. S. Morozov's tables (2011).

use trisect_machine::forms::{CallTime, Called, LeafTime};
use trisect_report::document::Section;
use trisect_report::format::{grouped, number, ratio};
use trisect_report::stats::ns_per_test;
use trisect_report::table::Table;

use crate::lines::distinct;
use crate::pictures::FrameSeries;
use crate::pictures::morozov::rows;
use crate::record::Records;

pub(super) fn sections(records: &Records) -> [Section; 2] {
    [leaves(records), calls(records)]
}

/// A row per size of leaves.
fn leaves(records: &Records) -> Section {
    let all: Vec<&LeafTime> = records.all().collect();
    let ns = |leaf: &LeafTime| ns_per_test(&leaf.samples_ns, leaf.rays);
    let best = all.iter().filter_map(|leaf| ns(leaf)).fold(f64::INFINITY, f64::min);
    // His speed at the low level over his best.
    let his: Vec<(usize, f64)> = rows()
        .filter(|row| row.series == FrameSeries::Leaves)
        .map(|row| (row.x as usize, row.frames_per_second[0]))
        .collect();
    let his_best = his.iter().map(|(_, speed)| *speed).fold(0.0, f64::max);
    let table = Table::of(&all)
        .name("triangles of a leaf, at most", |leaf| match leaf.leaf {
            0 => "no tree".to_owned(),
            most if most >= leaf.triangles => format!("{most}: one boxed leaf"),
            most => most.to_string(),
        })
        .count("leaves", |leaf| leaf.leaves as u64)
        .number("tests per ray", number, |leaf| {
            (leaf.rays > 0).then(|| leaf.tests as f64 / leaf.rays as f64)
        })
        .number("ns per ray", number, |leaf| ns(leaf))
        .number("of the fastest", number, |leaf| Some(best / ns(leaf)?))
        .number("Morozov", number, |leaf| {
            let (_, speed) = his.iter().find(|(size, _)| *size == leaf.leaf)?;
            Some(speed / his_best)
        })
        .done();
    let triangles = all.first().map_or(0, |leaf| leaf.triangles);
    let says = format!(
        "Camera rays at a chair of {} triangles, in a plain binary tree that is cut at medians, not the tracer's; \
         tests of eight lanes in a leaf, in blocks of sixteen, so that leaves of four and eight gain nothing. of the \
         fastest: speed over that of the fastest row; Morozov: the same of his frames per second at his low level.",
        grouped(triangles as u64)
    );
    Section::table("leaves", "Leaves of any size", says, table).part("forms-morozov")
}

/// A row per size of arrays.
fn calls(records: &Records) -> Section {
    let all: Vec<&CallTime> = records.all().collect();
    let sizes = distinct(all.iter().map(|call| call.triangles));
    let kinds = distinct(all.iter().map(|call| (call.width, call.called)));
    let ns = |triangles: usize, (width, called): (usize, Called)| {
        let is_it = |call: &&&CallTime| {
            (call.triangles, call.width, call.called) == (triangles, width, called)
        };
        let call = all.iter().find(is_it)?;
        ns_per_test(&call.samples_ns, call.tests)
    };
    let mut table = Table::of(&sizes).count("triangles", |size| *size as u64);
    for (width, called) in kinds {
        let lanes = if width == 1 { "scalar".to_owned() } else { format!("{width} lanes") };
        let head =
            format!("{lanes}, {}", if called == Called::Nothing { "none" } else { called.name() });
        table = table.number(head, number, move |size| ns(*size, (width, called)));
        if called != Called::Nothing {
            table = table.number("over none", ratio, move |size| {
                Some(ns(*size, (width, called))? / ns(*size, (width, Called::Nothing))?)
            });
        }
    }
    let says = "Nanoseconds per test of Möller–Trumbore in a loop over an array of triangles, whether there is a hit, by \
                what is called through a pointer that the compiler cannot see through: none, the loop over the array (as \
                the tracer's leaves behind a call are), each block of eight, or each test (as a virtual function of a \
                triangle is). over none: times the time without the call.";
    Section::table("calls", "What virtual calls cost", says, table.done()).part("forms-morozov")
}
