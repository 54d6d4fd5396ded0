//! `trisect list`

use anyhow::Result;
use serde::Serialize;
use trisect_catalog::{Entry, entries};
use trisect_core::InstructionSet;
use trisect_harness::machine;

use crate::arguments::List;
use crate::output;

#[derive(Serialize)]
struct Listing {
    methods: Vec<Method>,
    /// Of f32.
    widths: Vec<usize>,
    widths_f64: Vec<usize>,
    instruction_sets: Vec<&'static str>,
}

#[derive(Serialize)]
struct Method {
    name: &'static str,
    title: &'static str,
    year: u16,
    input: &'static str,
    outputs: Vec<&'static str>,
    divisions: Vec<&'static str>,
    watertight: bool,
    exact: bool,
    stored_numbers: usize,
    source: &'static str,
}

impl Method {
    /// What a hit can be asked for, but for what every method gives, and what is claimed.
    fn gives(&self) -> String {
        let mut words = vec!["t"];
        let more = ["barycentrics", "normal"].into_iter().filter(|w| self.outputs.contains(w));
        words.extend(more);
        if self.watertight {
            words.push("watertight");
        }
        if self.exact {
            words.push("exact");
        }
        words.join(" ")
    }
}

pub(crate) fn run(arguments: &List) -> Result<()> {
    let listing = Listing {
        methods: entries().iter().map(Method::from).collect(),
        widths: entries().first().map_or_else(Vec::new, |entry| widths(&entry.f32.finders)),
        widths_f64: entries().first().map_or_else(Vec::new, |entry| widths(&entry.f64.finders)),
        instruction_sets: machine::instruction_sets().map(InstructionSet::name).collect(),
    };
    output::print_as(arguments.json, &listing, |out| {
        for method in &listing.methods {
            writeln!(
                out,
                "{:<29} {} {:>2} numbers  {}",
                method.name,
                method.year,
                method.stored_numbers,
                method.gives(),
            )?;
        }
        let numbers =
            |widths: &[usize]| widths.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
        writeln!(out)?;
        writeln!(out, "f32 widths        {}", numbers(&listing.widths))?;
        writeln!(out, "f64 widths        {}", numbers(&listing.widths_f64))?;
        writeln!(out, "instruction sets  {}", listing.instruction_sets.join(" "))
    })
}

/// The widths that this processor can run, narrowest first.
pub(crate) fn widths(finders: &[trisect_catalog::Finder]) -> Vec<usize> {
    let mut widths: Vec<usize> = finders
        .iter()
        .map(|finder| finder.variant.lane)
        .filter(|lane| lane.instruction_set.is_available())
        .map(|lane| lane.width)
        .collect();
    widths.sort_unstable();
    widths.dedup();
    widths
}

impl From<&Entry> for Method {
    fn from(entry: &Entry) -> Self {
        Self {
            name: entry.info.name,
            title: entry.info.title,
            year: entry.info.year,
            input: entry.info.input.name(),
            outputs: entry.info.outputs.iter().map(|output| output.name()).collect(),
            divisions: entry.f32.divisions().collect(),
            watertight: entry.info.claims.watertight,
            exact: entry.info.claims.exact,
            stored_numbers: entry.cost.stored_numbers,
            source: entry.info.source,
        }
    }
}
