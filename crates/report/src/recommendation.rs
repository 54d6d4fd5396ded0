//! A recommendation on a terminal.

use std::fmt::Write as _;

use trisect_harness::{Candidate, Decided, Exhaustive, Recommendation};

use crate::format::{grouped, mtests, number, scientific};
use crate::text::{Table, cut, hang, wrap};
use crate::view::{finish_label, lanes_label, need_in_prose};

/// Runners-up that are shown.
const RUNNERS_UP: usize = 6;

/// What is recommended for a mesh, and why, without the lines that use it.
pub fn recommendation_text(mesh: &str, found: &Recommendation, width: usize) -> String {
    let Recommendation { triangles, rays, hits, candidates, max_error, .. } = found;
    let count = |n: usize| grouped(n as u64);
    let mut out = wrap(
        &format!(
            "{}: asked for {}{}; {} kernels tried on {} of {} triangles and {} of {} rays, {} true \
             hits.",
            cut(mesh, width / 2),
            need_in_prose(found.needs),
            if found.watertight { ", watertight" } else { "" },
            count(*candidates),
            count(triangles[1]),
            count(triangles[0]),
            count(rays[1]),
            count(rays[0]),
            count(*hits),
        ),
        width,
        "",
    );
    match (found.open_edges, found.watertight) {
        (0, false) => {
            let says = "The mesh is closed: with --watertight no ray slips between its triangles.";
            out += &wrap(says, width, "");
        }
        (1.., true) => {
            let edges = grouped(found.open_edges as u64);
            let says =
                format!("The mesh is open along {edges} edges: rays pass there all the same.");
            out += &wrap(&says, width, "");
        }
        _ => {}
    }
    out += &wrap(
        &format!(
            "Decisions of the fastest checked on {} rays, {} pairs.",
            count(found.checked[0]),
            count(found.checked[1])
        ),
        width,
        "",
    );
    if let Some(wrong) = wrong_decisions(&found.decisions) {
        out += &hang("  ", &wrong, width, "    ");
    }
    for refused in &found.refused {
        out +=
            &hang("  ", &format!("without {}: {}", refused.method, refused.reason), width, "    ");
    }
    let Some((chosen, others)) = found.ranking.split_first() else { return out };
    let Candidate { variant, ns_per_test, bytes_per_triangle, error, wrong, .. } = chosen;
    let within = max_error.map_or_else(String::new, |allowed| {
        format!(", within the {} allowed", scientific(allowed))
    });
    let _ = write!(
        out,
        "\n{} {}\n  {}\n  {} million tests/s, {bytes_per_triangle} bytes per triangle\n  largest \
         error {}{within}; {} wrong decisions\n",
        variant.method,
        lanes_label(variant),
        finish_label(variant),
        number(mtests(*ns_per_test)),
        scientific(*error),
        wrong.total(),
    );
    if !others.is_empty() {
        let _ = write!(out, "\n{}", runners_up(others, width).render(width));
    }
    if let Some(exhaustive) = &found.exhaustive {
        let Exhaustive { samples_of_all, samples_of_fastest, best, behind, .. } = exhaustive;
        out.push('\n');
        out += &wrap(
            &format!(
                "All of them, {samples_of_all} samples each and {samples_of_fastest} of the fastest, in \
                 turn: {} {}, {}, at {} million tests/s; the one above is {:.1} % behind.",
                best.variant.method,
                lanes_label(&best.variant),
                finish_label(&best.variant),
                number(mtests(best.ns_per_test)),
                behind * 100.0,
            ),
            width,
            "",
        );
    }
    out
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
    let mut table = Table::new(&["runner-up", "M/s", "B", "error", "wrong"]);
    for other in others.iter().take(RUNNERS_UP) {
        let name = format!(
            "{} {}, {}",
            other.variant.method,
            lanes_label(&other.variant),
            finish_label(&other.variant)
        );
        table.rows.push(vec![
            // So that the numbers stand beside it.
            cut(&name, width.saturating_sub(35)),
            number(mtests(other.ns_per_test)),
            other.bytes_per_triangle.to_string(),
            scientific(other.error),
            other.wrong.total().to_string(),
        ]);
    }
    table
}
