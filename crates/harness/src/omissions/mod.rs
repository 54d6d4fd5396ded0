//! What is gained by leaving out what nobody asks for: in kernels, in the tracer, and in pictures.
//!
//! It is one measurement everywhere: the same work with a part and without, in turn, round by round, so that
//! what happens to the machine happens to both.

mod kernels;
mod pictures;
mod tracer;

use std::time::Duration;

use rand::SeedableRng as _;
use rand_pcg::Pcg64;
use trisect_catalog::Entry;

use crate::Progress;
use crate::code;
use crate::record::{Layer, Omission, Record};
use crate::study::StudyError;
use crate::timing::{self, WrongAnswer, nanoseconds};

pub(crate) use pictures::{OfPictures, of_pictures};

/// What is studied, and how long.
pub struct OmissionSettings {
    /// Seed of rays, triangles and the order of samples.
    pub seed: u64,
    /// The methods whose kernels are timed.
    pub methods: Vec<&'static Entry>,
    /// Samples of each kind.
    pub rounds: usize,
    /// Rays, and triangles, that kernels are timed on.
    pub tests: usize,
    /// Side, in pixels, of the picture whose rays meet a mesh.
    pub pixels: usize,
    /// Pixels across and down of the pictures of scenes.
    pub picture: [u32; 2],
}

/// Studies what each omission gains, and says what was found as records.
///
/// # Errors
/// When a sample is not what it must be, or there are no threads.
///
/// # Panics
/// When the system has no place for temporary files.
pub fn omissions(
    settings: &OmissionSettings,
    progress: &mut dyn Progress,
) -> Result<Vec<Record>, StudyError> {
    let mut study = Study { settings, random: Pcg64::seed_from_u64(settings.seed), progress };
    let mut found = study.kernels()?;
    found.extend(study.tracer()?);
    found.extend(study.pictures()?);
    let code = code::of_renderer().map(Record::Code);
    Ok(found.into_iter().map(Record::Omission).chain(code).collect())
}

/// A study under way.
struct Study<'a> {
    settings: &'a OmissionSettings,
    random: Pcg64,
    progress: &'a mut dyn Progress,
}

/// What is timed with parts and without, as records name it.
pub(crate) struct Subject<'a> {
    pub layer: Layer,
    pub scene: &'a str,
    pub of: &'a str,
    pub method: &'a str,
}

/// What was timed in turn.
pub(crate) struct Raced<C> {
    /// Nanoseconds of each sample without any of the parts.
    pub without_ns: Vec<u64>,
    /// Each of the parts.
    pub omissions: Vec<Omission>,
    /// The one without, then those with the parts.
    pub contenders: Vec<C>,
}

/// Times the same work without any of some parts, and with one or another of them, in turn; `sample` does
/// it once, verifies it, and says how long it took.
pub(crate) fn in_turn<C>(
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
