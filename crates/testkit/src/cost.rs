//! Holds the cost tables of READMEs to what is counted.

use std::fmt::Write;
use std::path::Path;

use trisect_core::{Cost, Method, Ops, cost};

/// [`cost`] as the Markdown table that stands in a method's README.
///
/// # Panics
/// As [`cost`].
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

const BEGIN: &str = "<!-- cost table, counted: TRISECT_BLESS=1 cargo test rewrites it -->\n";
const END: &str = "<!-- end of cost table -->";

/// `readme` with the text between its markers replaced by `table`; `None` without markers.
fn spliced(readme: &str, table: &str) -> Option<String> {
    let (head, rest) = readme.split_once(BEGIN)?;
    let (_, tail) = rest.split_once(END)?;
    Some(format!("{head}{BEGIN}\n{table}\n{END}{tail}"))
}

/// Holds the cost tables in the README at `path` to `tables`, each from [`cost_table`]; with
/// `TRISECT_BLESS` set in the environment, rewrites them.
///
/// # Panics
/// When the README cannot be read or written, has no markers, or other tables.
pub fn readme_cost_tables(path: &Path, tables: &[String]) {
    let readme = std::fs::read_to_string(path).expect("a method has a README");
    let wanted = spliced(&readme, &tables.join("\n"))
        .unwrap_or_else(|| panic!("{} lacks {BEGIN}{END}", path.display()));
    if std::env::var_os("TRISECT_BLESS").is_some() {
        std::fs::write(path, wanted).expect("blessing needs a README that can be written");
    } else {
        assert_eq!(
            readme,
            wanted,
            "the cost table of {} is out of date: TRISECT_BLESS=1 cargo test rewrites it",
            path.display()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splicing_replaces_what_is_between_the_markers_alone() {
        let readme = format!("a\n{BEGIN}old\n{END}\nb");
        let once = spliced(&readme, "new\n").expect("there are markers");
        assert_eq!(once, format!("a\n{BEGIN}\nnew\n\n{END}\nb"));
        assert_eq!(spliced(&once, "new\n").expect("there are markers"), once);
    }

    #[test]
    fn without_markers_there_is_nothing_to_splice() {
        assert_eq!(spliced("a", "b"), None);
    }
}
