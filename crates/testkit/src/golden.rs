//! Named cases, run for every method in every kernel that its tests compile: both precisions and
//! forms, every width and instruction set.
//!
//! The cases stand in `data/golden`. What a method fails is recorded in its README, and asserted.

mod cases;
mod scenes;
mod table;

use std::io::{self, Write as _};
use std::path::Path;
use std::thread;

use trisect_core::{FloatFormat, InstructionSet};
use trisect_method::{Form, ReciprocalKind};

use crate::kernels::{Found, Kernels, Lists, Results};
use crate::readme::{Part, is_blessing};
use crate::subject::Subject;
use cases::{CASES, Case, Holds};
use scenes::Scene;

const PART: Part = Part {
    begin: "<!-- golden cases, observed: TRISECT_BLESS=1 cargo test rewrites them -->\n",
    end: "<!-- end of golden cases -->",
};

/// What decides the bits of an answer: neither width nor instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Way {
    precision: FloatFormat,
    form: Form,
    fused: bool,
}

/// What came of a case in one way.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Outcome {
    Holds,
    /// The method does not take such a mesh.
    Refused,
    Fails(String),
}

/// A method that the cases are run for, with its kernels in both precisions.
struct Player<'a> {
    subject: &'a Subject,
    kernels: [Kernels; 2],
}

impl<'a> Player<'a> {
    fn of(subject: &'a Subject) -> Self {
        Self { subject, kernels: subject.lists.each_ref().map(Lists::all) }
    }

    fn ways(&self) -> Vec<Way> {
        let mut ways = Vec::new();
        for kernels in &self.kernels {
            for kind in kernels.list.iter().map(|kernel| kernel.kind) {
                let way = Way { precision: kernels.precision, form: kind.form, fused: kind.fused };
                if !ways.contains(&way) {
                    ways.push(way);
                }
            }
        }
        ways
    }

    /// What comes of a case in each way.
    ///
    /// # Panics
    /// When two kernels that must have the same bits have not.
    fn outcomes(&self, case: &Case) -> Vec<(Way, Outcome)> {
        let mut outcomes: Vec<_> =
            self.ways().into_iter().map(|way| (way, Outcome::Holds)).collect();
        for kernels in &self.kernels {
            for scene in case.scenes(kernels.precision) {
                self.run(kernels, case, scene, &mut outcomes);
            }
        }
        outcomes
    }

    fn run(&self, kernels: &Kernels, case: &Case, scene: &Scene, outcomes: &mut [(Way, Outcome)]) {
        let precision = kernels.precision;
        let of_precision = |(way, _): &&mut (Way, Outcome)| way.precision == precision;
        let Ok(mesh) = kernels.prepare(&scene.triangles) else {
            for (_, outcome) in outcomes.iter_mut().filter(of_precision) {
                outcome.worsen(Outcome::Refused);
            }
            return;
        };
        let turned = case.reversed.then(|| {
            let turned: Vec<_> = scene.triangles.iter().rev().copied().collect();
            kernels.prepare(&turned).unwrap_or_else(|_| panic!("{}: refused in one order", case.id))
        });
        let mut firsts: Vec<(Way, Results)> = Vec::new();
        for kernel in &kernels.list {
            let kind = kernel.kind;
            let way = Way { precision, form: kind.form, fused: kind.fused };
            let results = kernel.run(&scene.rays, &mesh, scene.culling);
            let first = firsts.iter().find(|(other, _)| *other == way);
            // An estimate has the bits that the processor gives it; deferred, it does not decide.
            let same = match (kind.reciprocal, kind.form) {
                (ReciprocalKind::True, _) => Found::is_same,
                (ReciprocalKind::Newton, Form::Deferred) => Found::is_same_pair,
                (ReciprocalKind::Newton, Form::Early) => continue,
            };
            if let Some((_, first)) = first {
                let difference = results.difference(first, same);
                assert!(
                    difference.is_none(),
                    "{}, {}, {precision}, {kind:?} differs from others: {difference:?}",
                    self.subject.info.name,
                    case.id
                );
                continue;
            }
            let mut judged = scene.judge(&results, precision, self.subject.weighs());
            if let Some(turned) = &turned {
                let other = kernel.run(&scene.rays, turned, scene.culling);
                let other = other.reversed(scene.triangles.len());
                if let Some(difference) = results.difference(&other, Found::is_same) {
                    judged = Err(format!("the order of triangles matters: {difference:?}"));
                }
            }
            if let Err(why) = judged {
                for (_, outcome) in outcomes.iter_mut().filter(|(other, _)| *other == way) {
                    outcome.worsen(Outcome::Fails(why.clone()));
                }
            }
            firsts.push((way, results));
        }
    }

    fn observe(&self) -> Observed {
        let mut observed = Observed { name: self.subject.info.name, cases: Vec::new() };
        let mut wrong = Vec::new();
        for case in CASES.iter() {
            let outcomes = self.outcomes(case);
            for (way, outcome) in &outcomes {
                if let Outcome::Fails(why) = outcome
                    && !may_fail(case.holds, self.subject.info.claims.watertight, *way)
                {
                    let Case { id, what, .. } = case;
                    wrong.push(format!("{id} ({what}), {way:?}: {why}"));
                }
            }
            observed.cases.push(outcomes);
        }
        assert!(wrong.is_empty(), "{} must not fail: {}", self.subject.info.name, wrong.join("\n"));
        observed
    }
}

impl Outcome {
    fn worsen(&mut self, other: Self) {
        if !matches!(self, Self::Fails(_)) {
            *self = other;
        }
    }
}

/// Whether a failure may be recorded.
fn may_fail(holds: Holds, claims_watertight: bool, way: Way) -> bool {
    match holds {
        Holds::Contract => false,
        Holds::All => true,
        // What the claim covers.
        Holds::Watertight => !(claims_watertight && way.form == Form::Deferred && !way.fused),
    }
}

/// What came of the cases, in their order.
struct Observed {
    name: &'static str,
    cases: Vec<Vec<(Way, Outcome)>>,
}

/// Runs every case for the methods of a crate, and holds what fails to the table in the README at
/// `path`; with `TRISECT_BLESS` set in the environment, rewrites it. On a processor without fused
/// arithmetic what the table says of that is left open.
///
/// # Panics
/// When a case fails that no method may fail, kernels differ that must have the same bits, or the
/// table says something else.
pub fn golden_cases(path: &Path, subjects: &[Subject]) {
    say_skipped();
    let observed: Vec<Observed> = thread::scope(|scope| {
        let running: Vec<_> =
            subjects.iter().map(|subject| scope.spawn(|| Player::of(subject).observe())).collect();
        running
            .into_iter()
            .map(|running| running.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause)))
            .collect()
    });
    let wanted = table::of(&observed);
    let fuses = |way: &(Way, Outcome)| way.0.fused;
    if is_blessing() || observed.iter().any(|one| one.cases.iter().flatten().any(fuses)) {
        PART.hold(path, &wanted);
    } else {
        assert_eq!(table::plain(&PART.of(path)), table::plain(&wanted), "{}", path.display());
    }
}

/// Says which instruction sets of the target are not tested, as the processor lacks them: a line each, past the
/// test harness, which hides what a test prints.
fn say_skipped() {
    let of_target = |set| match set {
        InstructionSet::Scalar => true,
        InstructionSet::Neon => cfg!(target_arch = "aarch64"),
        _ => cfg!(any(target_arch = "x86", target_arch = "x86_64")),
    };
    for set in InstructionSet::ALL {
        if of_target(*set) && !set.is_available() {
            let _ =
                writeln!(io::stderr(), "skipped: kernels for {set}, which this processor lacks");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_contracts_nor_claims_are_recorded_as_failed() {
        let way = |form, fused| Way { precision: FloatFormat::F32, form, fused };
        for (form, fused) in [(Form::Early, false), (Form::Deferred, false), (Form::Deferred, true)]
        {
            let way = way(form, fused);
            assert!(!may_fail(Holds::Contract, false, way));
            assert!(may_fail(Holds::All, true, way));
            assert!(may_fail(Holds::Watertight, false, way));
            assert_eq!(may_fail(Holds::Watertight, true, way), form == Form::Early || fused);
        }
    }

    #[test]
    fn a_failure_hides_that_another_mesh_is_refused() {
        let mut outcome = Outcome::Holds;
        outcome.worsen(Outcome::Refused);
        assert_eq!(outcome, Outcome::Refused);
        outcome.worsen(Outcome::Fails("why".to_owned()));
        outcome.worsen(Outcome::Refused);
        assert_eq!(outcome, Outcome::Fails("why".to_owned()));
    }
}
