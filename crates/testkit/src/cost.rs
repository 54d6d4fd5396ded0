//! Holds the cost tables of READMEs to what is counted.

use std::fmt::Write;
use std::path::Path;

use trisect_formula::{Cost, Ops, cost};
use trisect_method::Method;

use crate::readme::Part;

/// [`cost`] as the Markdown table that stands in a method's README.
pub fn cost_table<M: Method>() -> String {
    let cost = cost::<M>();
    let mut table = format!(
        "| `{}` | multiplies | adds | divisions | comparisons | sign flips |\n\
         | --- | --- | --- | --- | --- | --- |\n",
        M::INFO.name
    );
    for (part, Ops { multiplies, adds, divisions, comparisons, signs }) in cost.parts() {
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "| {part} | {multiplies} | {adds} | {divisions} | {comparisons} | {signs} |"
        );
    }
    let Cost { stored_numbers, ray_numbers, .. } = cost;
    let _ = writeln!(
        table,
        "\nPer triangle {stored_numbers} numbers, {} bytes in f32, {} in f64; per ray \
         {ray_numbers} numbers.",
        stored_numbers * size_of::<f32>(),
        stored_numbers * size_of::<f64>(),
    );
    table
}

const PART: Part = Part {
    begin: "<!-- cost table, counted: TRISECT_BLESS=1 cargo test rewrites it -->\n",
    end: "<!-- end of cost table -->",
};

/// Holds the cost tables in the README at `path` to `tables`, each from [`cost_table`]; with
/// `TRISECT_BLESS` set in the environment, rewrites them.
///
/// # Panics
/// When the README cannot be read or written, has no markers, or other tables.
pub fn readme_cost_tables(path: &Path, tables: &[String]) {
    PART.hold(path, &tables.join("\n"));
}
