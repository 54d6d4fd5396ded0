//! The same work with a part and without, in turn, round by round, so that what happens to the machine
//! happens to both.

use std::time::Duration;

use rand::SeedableRng as _;
use rand_pcg::Pcg64;

use super::code;
use super::record::{Layer, Omission};
use super::settings::Omissions;
use crate::study::{Run, StudyError};
use crate::timing::{self, WrongAnswer, nanoseconds};

/// What is left out of kernels, of the tracer and of pictures; and how much code that is.
pub(super) fn measure(study: &Omissions, run: &mut Run<'_>) -> Result<(), StudyError> {
    let random = Pcg64::seed_from_u64(study.seed);
    let mut leaving = Leaving { study, random, run };
    leaving.kernels()?;
    leaving.tracer()?;
    leaving.pictures()?;
    leaving.run.lines.extend(code::of_renderer().map(Into::into));
    Ok(())
}

/// A study under way.
pub(super) struct Leaving<'a, 'r> {
    pub study: &'a Omissions,
    pub random: Pcg64,
    pub run: &'a mut Run<'r>,
}

impl Leaving<'_, '_> {
    /// Adds what was found.
    pub(super) fn found(&mut self, omissions: Vec<Omission>) {
        self.run.lines.extend(omissions.into_iter().map(Into::into));
    }
}

/// What is timed with parts and without, as records name it.
pub(super) struct Subject<'a> {
    pub layer: Layer,
    pub scene: &'a str,
    pub of: &'a str,
    pub method: &'a str,
}

/// What was timed in turn.
pub(super) struct Raced<C> {
    /// Nanoseconds of each sample without any of the parts.
    pub without_ns: Vec<u64>,
    /// Each of the parts.
    pub omissions: Vec<Omission>,
    /// The one without, then those with the parts.
    pub contenders: Vec<C>,
}

/// Times the same work without any of some parts, and with one or another of them, in turn; `sample` does
/// it once, verifies it, and says how long it took.
pub(super) fn in_turn<C>(
    subject: &Subject<'_>,
    without: C,
    with: Vec<(&str, C)>,
    rounds: usize,
    random: &mut Pcg64,
    mut sample: impl FnMut(&mut C) -> Result<Duration, WrongAnswer>,
) -> Result<Raced<C>, WrongAnswer> {
    let contenders = std::iter::once(("", without)).chain(with);
    let mut contenders: Vec<(&str, C, Vec<u64>)> =
        contenders.map(|(part, contender)| (part, contender, Vec::new())).collect();
    timing::rounds(&mut contenders, rounds, random, |(_, contender, samples_ns), timed| {
        let time = sample(contender)?;
        if timed {
            samples_ns.push(nanoseconds(time));
        }
        Ok(())
    })?;
    let mut raced = Raced { without_ns: Vec::new(), omissions: Vec::new(), contenders: Vec::new() };
    for (part, contender, samples_ns) in contenders {
        if raced.contenders.is_empty() {
            raced.without_ns = samples_ns;
        } else {
            raced.omissions.push(Omission {
                layer: subject.layer,
                part: part.to_owned(),
                scene: subject.scene.to_owned(),
                of: subject.of.to_owned(),
                method: subject.method.to_owned(),
                without_ns: raced.without_ns.clone(),
                with_ns: samples_ns,
            });
        }
        raced.contenders.push(contender);
    }
    Ok(raced)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_compared_with_the_same_round_without_it() {
        let subject =
            Subject { layer: Layer::Tracer, scene: "bunny", of: "primary", method: "wald" };
        // Everything slows down, but parts cost a half and the double of it all the time.
        let mut clock = 0;
        let with = vec![("half", 3), ("all", 4)];
        let mut random = Pcg64::seed_from_u64(5);
        let raced = in_turn(&subject, 2, with, 9, &mut random, |cost| {
            clock += 1;
            Ok(Duration::from_micros(500_000 * *cost * (10 + (clock - 1) / 3)))
        });
        let raced = raced.expect("nothing is wrong");
        assert_eq!(raced.contenders, [2, 3, 4]);
        assert_eq!(raced.without_ns.len(), 9);
        assert!(raced.without_ns[8] > raced.without_ns[0]);
        let ratios: Vec<_> = raced.omissions.iter().map(|o| (o.part.as_str(), o.ratio())).collect();
        assert_eq!(ratios, [("half", Some((1.5, [1.5; 2]))), ("all", Some((2.0, [2.0; 2])))]);
    }
}
