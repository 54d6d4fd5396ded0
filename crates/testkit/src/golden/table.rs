//! The table of what fails, as it stands in a README.

use std::collections::BTreeSet;
use std::fmt::Write;

use trisect_core::FloatFormat;

use super::cases::CASES;
use super::{Observed, Outcome, Way};

const NOTHING: &str = "–";
const BETWEEN: &str = " … ";

/// A case, or several in a row, that fail in the same ways.
#[derive(Debug, PartialEq, Eq)]
struct Row {
    first: usize,
    last: usize,
    plain: String,
    fused: String,
}

/// The tables of the methods of a crate; methods that fail alike share one.
pub(super) fn of(observed: &[Observed]) -> String {
    let mut tables: Vec<(Vec<&str>, Vec<Row>)> = Vec::new();
    for one in observed {
        let rows = rows(one);
        match tables.iter_mut().find(|(_, others)| *others == rows) {
            Some((names, _)) => names.push(one.name),
            None => tables.push((vec![one.name], rows)),
        }
    }
    let mut text = String::new();
    for (names, rows) in tables {
        let names: Vec<_> = names.iter().map(|name| format!("`{name}`")).collect();
        let names = names.join(", ");
        // Writing to a string cannot fail.
        if rows.is_empty() {
            let _ = writeln!(text, "{names}: no case fails.\n");
            continue;
        }
        let _ = writeln!(text, "| {names} | what | fails, plain | fused |");
        let _ = writeln!(text, "| --- | --- | --- | --- |");
        for Row { first, last, plain, fused } in rows {
            let (from, to) = (&CASES[first], &CASES[last]);
            let [mut ids, mut what] = [from.id.clone(), from.what.clone()];
            if first != last {
                ids = ids + BETWEEN + &to.id;
                what = what + BETWEEN + &to.what;
            }
            let _ = writeln!(text, "| {ids} | {what} | {plain} | {fused} |");
        }
        text.push('\n');
    }
    text
}

fn rows(observed: &Observed) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for (place, outcomes) in observed.cases.iter().enumerate() {
        let cell = |fused| cell(outcomes, fused);
        let (plain, fused) = (cell(false), cell(true));
        match rows.last_mut() {
            Some(row) if row.last + 1 == place && row.plain == plain && row.fused == fused => {
                row.last = place;
            }
            _ if plain == NOTHING && fused == NOTHING => {}
            _ => rows.push(Row { first: place, last: place, plain, fused }),
        }
    }
    rows
}

/// In which precisions and forms a case fails: both forms where none is named.
fn cell(outcomes: &[(Way, Outcome)], fused: bool) -> String {
    let mut parts: Vec<(Vec<&str>, String)> = Vec::new();
    for &precision in FloatFormat::ALL {
        let ways: Vec<_> = outcomes
            .iter()
            .filter(|(way, _)| way.precision == precision && way.fused == fused)
            .collect();
        let bad: Vec<_> = ways.iter().filter(|(_, outcome)| *outcome != Outcome::Holds).collect();
        let Some((_, worst)) = bad.first() else { continue };
        let refused = *worst == Outcome::Refused;
        let mut how = String::new();
        if refused {
            how += " refused";
        } else if bad.len() < ways.len() {
            for (way, _) in &bad {
                how += " ";
                how += way.form.name();
            }
        }
        match parts.last_mut() {
            Some((precisions, other)) if *other == how => precisions.push(precision.name()),
            _ => parts.push((vec![precision.name()], how)),
        }
    }
    if parts.is_empty() {
        return NOTHING.to_owned();
    }
    let parts: Vec<_> = parts.iter().map(|(precisions, how)| precisions.join(" ") + how).collect();
    parts.join(", ")
}

/// What a table says of plain arithmetic, case by case: method, case, where it fails.
pub(super) fn plain(table: &str) -> BTreeSet<[String; 3]> {
    let mut said = BTreeSet::new();
    let mut names = Vec::new();
    for line in table.lines() {
        let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
        let &[ids, _, plain, _] = cells.as_slice() else { continue };
        if ids.starts_with('`') {
            names = ids.split(", ").collect();
        } else if plain != NOTHING && !ids.starts_with('-') {
            let (from, to) = ids.split_once(BETWEEN).unwrap_or((ids, ids));
            let place = |id: &str| CASES.iter().position(|case| case.id == id);
            let places = place(from).zip(place(to));
            let (from, to) = places.unwrap_or_else(|| panic!("no such cases: {ids}"));
            for case in &CASES[from..=to] {
                for name in &names {
                    said.insert([(*name).to_owned(), case.id.clone(), plain.to_owned()]);
                }
            }
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use trisect_method::Form;

    use super::*;

    fn observed(fails: impl Fn(usize, Way) -> bool) -> Observed {
        let mut ways = Vec::new();
        for &precision in FloatFormat::ALL {
            for (form, fused) in
                [(Form::Early, false), (Form::Deferred, false), (Form::Deferred, true)]
            {
                ways.push(Way { precision, form, fused });
            }
        }
        let outcome = |place, way| {
            if fails(place, way) { Outcome::Fails(String::new()) } else { Outcome::Holds }
        };
        let of_case =
            |place| ways.iter().map(|&way| (way, outcome(place, way))).collect::<Vec<_>>();
        let cases = (0..CASES.len()).map(of_case).collect();
        Observed { name: "some", cases }
    }

    #[test]
    fn cases_that_fail_alike_share_a_row() {
        let early = observed(|place, way| place < 3 && way.form == Form::Early);
        let table = of(&[early]);
        let [first, last] = [&CASES[0], &CASES[2]];
        let row = format!(
            "| {} … {} | {} … {} | f32 f64 early | – |",
            first.id, last.id, first.what, last.what
        );
        assert!(table.contains(&row), "{table}");
        assert_eq!(plain(&table).len(), 3);
    }

    #[test]
    fn what_fused_arithmetic_fails_is_not_said_of_plain() {
        let with = observed(|place, way| place == 1 || (place < 4 && way.fused));
        let without = observed(|place, way| place == 1 && !way.fused);
        assert_ne!(of(&[with]), of(&[without]));
        let with = observed(|place, way| place == 1 || (place < 4 && way.fused));
        let without = observed(|place, way| place == 1 && !way.fused);
        assert_eq!(plain(&of(&[with])), plain(&of(&[without])));
    }

    #[test]
    fn methods_that_fail_nothing_say_so() {
        assert_eq!(of(&[observed(|_, _| false)]).trim(), "`some`: no case fails.");
    }
}
