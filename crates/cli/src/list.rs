//! `trisect list`

use anyhow::Result;
use serde::Serialize;
use trisect_catalog::{Entry, Kernels, Variant, entries};
use trisect_core::{InstructionSet, Precision};
use trisect_method::{Form, Input, Output};
use trisect_studies::machine;

use crate::arguments::List;
use crate::output;

#[derive(Serialize)]
struct Listing {
    methods: Vec<Method>,
    /// Of f32.
    widths: Vec<usize>,
    widths_f64: Vec<usize>,
    instruction_sets: Vec<InstructionSet>,
}

#[derive(Serialize)]
struct Method {
    name: &'static str,
    title: &'static str,
    year: u16,
    input: Input,
    outputs: &'static [Output],
    divisions: &'static [Form],
    watertight: bool,
    exact: bool,
    stored_numbers: usize,
    source: &'static str,
}

impl Method {
    /// What a hit can be asked for, but for what every method gives, and what is claimed.
    fn gives(&self) -> String {
        let mut words = vec!["t"];
        let more = [Output::Barycentrics, Output::Normal].into_iter();
        words.extend(more.filter(|output| self.outputs.contains(output)).map(Output::name));
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
        widths: entries().first().map_or_else(Vec::new, |entry| timed_widths(&entry.f32)),
        widths_f64: entries().first().map_or_else(Vec::new, |entry| timed_widths(&entry.f64)),
        instruction_sets: machine::instruction_sets().collect(),
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
        let sets: Vec<_> = listing.instruction_sets.iter().map(|set| set.name()).collect();
        writeln!(out, "instruction sets  {}", sets.join(" "))
    })
}

fn timed_widths<E: Precision>(kernels: &Kernels<E>) -> Vec<usize> {
    widths(kernels.timed.iter().map(|kernel| &kernel.variant))
}

/// The widths of variants that this processor can run, narrowest first.
pub(crate) fn widths<'a>(variants: impl Iterator<Item = &'a Variant>) -> Vec<usize> {
    let mut widths: Vec<usize> =
        variants.filter(|variant| variant.is_available()).map(|variant| variant.width).collect();
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
            input: entry.info.input,
            outputs: entry.info.outputs,
            divisions: entry.info.forms.list(),
            watertight: entry.info.claims.watertight,
            exact: entry.info.claims.exact,
            stored_numbers: entry.cost.stored_numbers,
            source: entry.info.source,
        }
    }
}
