//! A recommendation on a terminal.

use crate::recommend::{Candidate, Decided, Exhaustive, Recommendation};

use crate::comparison::document::view::{finish_label, lanes_label, need_in_prose};
use trisect_report::document::{Content, Document, Section};
use trisect_report::format::{grouped, mtests, number, scientific};
use trisect_report::table::Table;
use trisect_report::terminal::cut;

/// Runners-up that are shown.
const RUNNERS_UP: usize = 6;

/// What is recommended for a mesh, and why, without the lines that use it.
pub fn recommendation_text(mesh: &str, found: &Recommendation, width: usize) -> String {
    let Recommendation { triangles, rays, hits, candidates, .. } = found;
    let count = |n: usize| grouped(n as u64);
    let mut says = vec![format!(
        "{}: asked for {}{}; {} kernels tried on {} of {} triangles and {} of {} rays, {} true hits.",
        cut(mesh, width / 2),
        need_in_prose(found.needs),
        if found.watertight { ", watertight" } else { "" },
        count(*candidates),
        count(triangles[1]),
        count(triangles[0]),
        count(rays[1]),
        count(rays[0]),
        count(*hits),
    )];
    match (found.open_edges, found.watertight) {
        (0, false) => says.push(
            "The mesh is closed: with --watertight no ray slips between its triangles.".to_owned(),
        ),
        (1.., true) => {
            let edges = count(found.open_edges);
            says.push(format!(
                "The mesh is open along {edges} edges: rays pass there all the same."
            ));
        }
        _ => {}
    }
    let [checked, pairs] = found.checked.map(count);
    says.push(format!("Decisions of the fastest checked on {checked} rays, {pairs} pairs."));
    let refused = found
        .refused
        .iter()
        .map(|refused| format!("without {}: {}", refused.method, refused.reason));
    let notes = wrong_decisions(&found.decisions).into_iter().chain(refused);
    let notes = notes.map(|note| ("  ".to_owned(), note)).collect();
    let mut sections =
        vec![Section::prose(says.join(" ")), Section::new("", "", Content::List(notes))];
    if let Some((chosen, others)) = found.ranking.split_first() {
        sections.push(recommended(chosen, found.max_error));
        sections.push(Section::brief(runners_up(others, width), ""));
        sections.extend(found.exhaustive.as_ref().map(of_all));
    }
    Document::text(sections, width)
}

/// The kernel that is recommended.
fn recommended(chosen: &Candidate, max_error: Option<f64>) -> Section {
    let Candidate { variant, ns_per_test, bytes_per_triangle, error, wrong, .. } = chosen;
    let within = max_error.map_or_else(String::new, |allowed| {
        format!(", within the {} allowed", scientific(allowed))
    });
    let speed = number(mtests(*ns_per_test));
    let about = [
        finish_label(variant),
        format!("{speed} million tests/s, {bytes_per_triangle} bytes per triangle"),
        format!("largest error {}{within}; {} wrong decisions", scientific(*error), wrong.total()),
    ];
    let head = (format!("{} ", variant.method), lanes_label(variant));
    let items = about.map(|about| ("  ".to_owned(), about));
    Section::new("", "", Content::List([head].into_iter().chain(items).collect()))
}

/// The race against a measurement of everything.
fn of_all(exhaustive: &Exhaustive) -> Section {
    let Exhaustive { samples_of_all, samples_of_fastest, best, behind, .. } = exhaustive;
    Section::prose(format!(
        "All of them, {samples_of_all} samples each and {samples_of_fastest} of the fastest, in turn: {} {}, \
         {}, at {} million tests/s; the one above is {:.1} % behind.",
        best.variant.method,
        lanes_label(&best.variant),
        finish_label(&best.variant),
        number(mtests(best.ns_per_test)),
        behind * 100.0,
    ))
}

/// How many decisions each method was wrong about in each precision, from its best form to its worst;
/// none where all were right.
fn wrong_decisions(decisions: &[Decided]) -> Option<String> {
    let is_alike = |a: &Decided, b: &Decided| (a.method, a.precision) == (b.method, b.precision);
    let mut wrong = Vec::new();
    for forms in decisions.chunk_by(is_alike) {
        let counts = || forms.iter().map(|decided| decided.wrong.total());
        let (least, most) = (counts().min()?, counts().max()?);
        if most > 0 {
            let Decided { method, precision, .. } = forms[0];
            let (from, to) = (grouped(least as u64), grouped(most as u64));
            let counts = if least == most { from } else { format!("{from} to {to}") };
            wrong.push(format!("{method} {precision} {counts}"));
        }
    }
    (!wrong.is_empty()).then(|| format!("wrong decisions, by method: {}", wrong.join(", ")))
}

fn runners_up(others: &[Candidate], width: usize) -> Table {
    let name = |other: &Candidate| {
        let v = &other.variant;
        format!("{} {}, {}", v.method, lanes_label(v), finish_label(v))
    };
    Table::of(&others[..others.len().min(RUNNERS_UP)])
        // So that the numbers stand beside it.
        .name("runner-up", |other| cut(&name(other), width.saturating_sub(35)))
        .number("M/s", number, |other| mtests(other.ns_per_test))
        .count("B", |other| other.bytes_per_triangle as u64)
        .number("error", scientific, |other| other.error)
        .count("wrong", |other| other.wrong.total() as u64)
        .done()
}
