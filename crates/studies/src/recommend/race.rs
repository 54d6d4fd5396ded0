//! Races: which of many kernels are the fastest, and which of all is.

use rand_pcg::Pcg64;
use trisect_catalog::Kernel;

use super::{Candidate, Exhaustive, RecommendSettings};
use crate::kernels::Group;
use crate::study::Progress;
use crate::timing::middle;
use crate::timing::{self, Contender, WrongAnswer};

/// So many kernels share the last, and longest, part of a race.
const FINALISTS: usize = 16;

/// A kernel in the race, with its group.
pub(super) type Racer<'a> = (&'a Group, Contender<'a>);

/// Races kernels until a few are left, sorted by their median: in each part of the time, which are of
/// one length, all that are left are timed in turn, and the slower half drops out; so those that are
/// hard to tell apart are timed longest.
///
/// Karnin, Koren, Somekh: Almost Optimal Exploration in Multi-Armed Bandits. ICML 2013: sequential
/// halving.
pub(super) fn race(
    racing: &mut Vec<Racer<'_>>,
    settings: &RecommendSettings,
    random: &mut Pcg64,
    progress: &mut dyn Progress,
) -> Result<(), WrongAnswer> {
    /// Samples that even the slowest is worth: one alone may have been interrupted.
    const FEWEST: usize = 3;
    let halvings = (racing.len() as f64 / FINALISTS as f64).log2().ceil().max(0.0);
    let part = settings.time.as_nanos() as f64 / (halvings + 1.0);
    loop {
        let is_last = racing.len() <= FINALISTS;
        progress.phase(&format!("timing {} kernels", racing.len()), 1);
        timing::rounds(racing, FEWEST, random, |(_, contender), timed| contender.sample(timed))?;
        let round: f64 = racing.iter().map(|(_, contender)| middle(&contender.samples_ns)).sum();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small count"
        )]
        let more = (part / round.max(1.0)) as usize;
        if let Some(more) = more.checked_sub(FEWEST) {
            timing::rounds(racing, more, random, |(_, contender), timed| contender.sample(timed))?;
        }
        racing.sort_by(|(_, a), (_, b)| middle(&a.samples_ns).total_cmp(&middle(&b.samples_ns)));
        progress.step();
        if is_last {
            return Ok(());
        }
        let stay = (racing.len() / 2).max(FINALISTS);
        let beside = racing.iter().position(|(group, _)| Some(group.method) == settings.beside);
        if let Some(place) = beside.filter(|&place| place >= stay) {
            racing.swap(place, stay - 1);
        }
        racing.truncate(stay);
    }
}

/// Measures every kernel, then the fastest of them and the one chosen for longer, all in turn.
pub(super) fn measure_all<'a>(
    all: &mut Vec<Racer<'a>>,
    (group, kernel): (&Group, &Kernel),
    random: &mut Pcg64,
    progress: &mut dyn Progress,
    candidate: impl Fn(&Racer<'a>) -> Candidate,
) -> Result<Exhaustive, WrongAnswer> {
    const OF_ALL: usize = 15;
    const OF_FASTEST: usize = 301;
    progress.phase(&format!("timing all {} kernels", all.len()), (OF_ALL + OF_FASTEST) as u64);
    let is_chosen =
        |racer: &Racer<'_>| std::ptr::eq(racer.0, group) && std::ptr::eq(racer.1.kernel, kernel);
    let by_median = |(_, a): &Racer<'_>, (_, b): &Racer<'_>| {
        middle(&a.samples_ns).total_cmp(&middle(&b.samples_ns))
    };
    timing::rounds(all, OF_ALL, random, |(_, contender), timed| contender.sample(timed))?;
    all.sort_by(by_median);
    let mut place = 0;
    all.retain(|racer| {
        place += 1;
        place <= 2 * FINALISTS || is_chosen(racer)
    });
    // What was fastest by luck is not so again.
    for (_, contender) in &mut *all {
        contender.samples_ns.clear();
    }
    timing::rounds(all, OF_FASTEST, random, |(_, contender), timed| contender.sample(timed))?;
    all.sort_by(by_median);
    let chosen = all.iter().find(|racer| is_chosen(racer)).expect("it was kept");
    let (best, chosen) = (candidate(&all[0]), candidate(chosen));
    Ok(Exhaustive {
        samples_of_all: OF_ALL,
        samples_of_fastest: OF_FASTEST,
        behind: chosen.ns_per_test / best.ns_per_test - 1.0,
        chosen_ns_per_test: chosen.ns_per_test,
        best,
    })
}
