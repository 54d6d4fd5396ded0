//! The kernels that would do, and how good their answers are.

use trisect_catalog::{Entry, Kernel, Kernels};
use trisect_core::{FloatFormat, Hit, MultiplyAdd, Precision};
use trisect_method::{Form, Output};

use super::decisions::{Kind, Ways, Wrong, rounding};
use super::race::Racer;
use super::{Decided, RecommendError, RecommendSettings};
use crate::answers::Pair;
use crate::comparison::Refusal;
use crate::kernels::{Group, answers_of_widest, contenders};
use crate::subject::{Inputs, Judged, Side, Subject};

/// How good the answers of kernels are that answer alike.
pub(super) struct Quality {
    pub kind: Kind,
    /// See [`Candidate::error`](super::Candidate::error).
    pub error: f64,
    pub wrong: Wrong,
    /// Whether the decisions are those over all rays, and not those over the sample alone.
    pub is_of_all: bool,
    /// Whether a kernel of these takes part.
    pub takes_part: bool,
}

/// A search under way.
pub(super) struct Search<'a> {
    settings: &'a RecommendSettings,
    timed_rays: usize,
    pub groups: Vec<Group>,
    pub judge: Judge<'a>,
    pub refused: Vec<Refusal>,
}

impl<'a> Search<'a> {
    pub(super) fn new(settings: &'a RecommendSettings, timed_rays: usize) -> Self {
        let judge = Judge { settings, qualities: Vec::new() };
        Self { settings, timed_rays, groups: Vec::new(), judge, refused: Vec::new() }
    }

    /// Notes which kernels of a method give what is asked, and how good their answers are.
    pub(super) fn consider(&mut self, entry: &'static Entry, inputs: &Inputs, subject: &Subject) {
        // The whole mesh: what a method asks of all its triangles a part of them may have.
        if let Err(unsuitable) = (entry.f32.prepare)(&inputs.triangles, &[]) {
            self.refused.push(Refusal {
                method: entry.info.name.to_owned(),
                precision: FloatFormat::F32,
                workload: subject.workload.name.clone(),
                reason: unsuitable.to_string(),
            });
            return;
        }
        let rounding = inputs.unrounded.as_ref().map_or(0.0, |unrounded| unrounded.rounding);
        // What rounding does to the mesh itself counts where it is beyond what is allowed.
        let is_coarse = self.settings.max_error.is_some_and(|allowed| rounding > allowed);
        let coarse = if is_coarse { rounding.min(f64::MAX) } else { 0.0 };
        self.consider_in(entry, &entry.f32, &subject.single, coarse);
        self.consider_in(entry, &entry.f64, &subject.double, 0.0);
    }

    fn consider_in<E: Precision>(
        &mut self,
        entry: &'static Entry,
        kernels: &'static Kernels<E>,
        side: &Side<E>,
        coarse: f64,
    ) where
        Side<E>: Judged,
    {
        let Side { rays, triangles, .. } = side;
        let Ok(scene) = (kernels.prepare)(triangles, rays) else { return };
        let truth: Vec<Pair> = side.known().truth.iter().map(Pair::from).collect();
        let timed: Vec<&Kernel> =
            kernels.timed.iter().filter(|kernel| self.would_do(entry, kernel)).collect();
        let needs = self.settings.needs;
        let rounded = self.judge.asks_closest().then(|| rounding(E::FORMAT));
        let answers = answers_of_widest(&kernels.finders, &scene)
            .into_iter()
            .chain(answers_of_widest(&kernels.deciders, &scene));
        for (variant, answers) in answers {
            let kind = Kind { entry, variant };
            let error = match needs {
                Output::Occlusion => 0.0,
                _ => answers.differences(&truth, |hit, exact| off(needs, hit, exact)).max,
            };
            let error = error.max(coarse);
            self.judge.qualities.push(Quality {
                kind,
                error,
                wrong: Wrong::of(answers.pairs(), &truth, rounded),
                is_of_all: false,
                takes_part: timed.iter().any(|kernel| kind.has(&kernel.variant)),
            });
        }
        let Ok(scene) = (kernels.prepare)(triangles, &rays[..self.timed_rays]) else { return };
        self.groups.push(Group::new(entry, kernels, scene, timed));
    }

    /// Whether a kernel runs here and gives what is asked.
    fn would_do(&self, entry: &Entry, kernel: &Kernel) -> bool {
        let variant = &kernel.variant;
        let is_watertight = entry.info.claims.watertight
            && variant.arithmetic == MultiplyAdd::Plain
            && variant.division == Form::Deferred;
        variant.is_available()
            && gives(variant.needs, self.settings.needs)
            && (!self.settings.watertight || is_watertight)
            && (!self.settings.in_tracer || variant.is_as_in_a_tracer())
    }
}

/// Who may be recommended.
pub(super) struct Judge<'a> {
    settings: &'a RecommendSettings,
    /// Those of a method in one precision lie beside each other.
    qualities: Vec<Quality>,
}

impl Judge<'_> {
    /// Whether the closest triangle matters: where hits alone are asked for, any will do.
    fn asks_closest(&self) -> bool {
        self.settings.needs != Output::Occlusion
    }

    /// How good the answers of a racer are.
    pub(super) fn quality(&self, (_, contender): &Racer<'_>) -> &Quality {
        let variant = &contender.kernel.variant;
        let quality = self.qualities.iter().find(|q| q.kind.has(variant));
        quality.expect("what is timed has answered")
    }

    /// Whether a racer may be recommended.
    pub(super) fn allows(&self, racer: &Racer<'_>) -> bool {
        self.is_good(self.quality(racer))
    }

    /// A wrong decision is an error beyond any that is allowed.
    fn is_good(&self, quality: &Quality) -> bool {
        quality.wrong.total() == 0 && self.settings.max_error.is_none_or(|max| quality.error <= max)
    }

    /// Whether a racer stays: it may be recommended, or is to be seen beside what is.
    pub(super) fn keeps(&self, racer: &Racer<'_>) -> bool {
        self.allows(racer) || Some(racer.0.method) == self.settings.beside
    }

    /// The kernels that race.
    ///
    /// # Errors
    /// When none may be recommended.
    pub(super) fn racers<'a>(
        &self,
        groups: &'a [Group],
        subject: &Subject,
    ) -> Result<Vec<Racer<'a>>, RecommendError> {
        let mut racing = contenders(groups, subject);
        if !racing.iter().any(|racer| self.allows(racer)) {
            let qualities = || racing.iter().map(|racer| self.quality(racer));
            let right = qualities().filter(|quality| quality.wrong.total() == 0);
            let least = right.map(|quality| quality.error).min_by(f64::total_cmp);
            let wrong = qualities().map(|quality| quality.wrong.total()).min();
            let needs = self.settings.needs;
            return Err(match (wrong, least, self.settings.max_error) {
                (None, ..) => RecommendError::NoneWatertight { needs },
                (_, Some(least), Some(allowed)) => RecommendError::Imprecise { allowed, least },
                (Some(wrong), ..) => RecommendError::NoneRight { needs, wrong },
            });
        }
        racing.retain(|racer| self.keeps(racer));
        Ok(racing)
    }

    /// Looks at the decisions of those that `asks` picks over all rays. What any of them decides wrongly
    /// all others are asked as well: who is wrong there is out before it races again.
    pub(super) fn check(&mut self, ways: &Ways, asks: impl Fn(&Kind) -> bool) {
        let may_win = |q: &&Quality| q.takes_part && !q.is_of_all && self.is_good(q);
        let (asked, others): (Vec<Kind>, Vec<Kind>) =
            self.qualities.iter().filter(may_win).map(|q| q.kind).partition(asks);
        let asks_closest = self.asks_closest();
        let (found, hard) = ways.wrong(&asked, asks_closest, None);
        self.note(&asked, found, true);
        if !hard.is_empty() {
            let (found, _) = ways.wrong(&others, asks_closest, Some(&hard));
            self.note(&others, found, false);
        }
    }

    fn note(&mut self, kinds: &[Kind], found: Vec<Wrong>, is_of_all: bool) {
        for (kind, wrong) in kinds.iter().zip(found) {
            let is_it = |q: &&mut Quality| q.kind.has(kind.variant);
            if let Some(quality) = self.qualities.iter_mut().find(is_it) {
                (quality.wrong, quality.is_of_all) = (wrong, is_of_all);
            }
        }
    }

    /// What all that took part decided wrongly.
    pub(super) fn decisions(&self) -> Vec<Decided> {
        let took_part = self.qualities.iter().filter(|quality| quality.takes_part);
        let decided = |Quality { kind, wrong, is_of_all, .. }: &Quality| Decided {
            method: kind.entry.info.name,
            precision: kind.variant.precision,
            arithmetic: kind.variant.arithmetic,
            division: kind.variant.division,
            reciprocal: kind.variant.reciprocal,
            wrong: *wrong,
            of_all_rays: *is_of_all,
        };
        took_part.map(decided).collect()
    }
}

/// Whether a kernel that was asked for `output` gives `asked`.
fn gives(output: Output, asked: Output) -> bool {
    match asked {
        Output::Occlusion => true,
        Output::T => matches!(output, Output::T | Output::Barycentrics | Output::Normal),
        other => output == other,
    }
}

/// How far a hit is off in what is asked: `t` relatively, barycentrics absolutely.
fn off(asked: Output, hit: &Hit<f64>, exact: &Hit<f64>) -> f64 {
    let t = (hit.t - exact.t).abs();
    let t = if t == 0.0 { 0.0 } else { (t / exact.t.abs()).min(f64::MAX) };
    match asked {
        Output::Barycentrics => {
            t.max((hit.beta - exact.beta).abs()).max((hit.gamma - exact.gamma).abs())
        }
        _ => t,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_gives_more_answers_as_well() {
        assert!(gives(Output::Barycentrics, Output::T));
        assert!(gives(Output::Normal, Output::Occlusion));
        assert!(!gives(Output::T, Output::Barycentrics));
        assert!(!gives(Output::Occlusion, Output::T));
    }

    #[test]
    fn errors_are_relative_of_t_and_absolute_of_weights() {
        let exact = Hit { t: 8.0, beta: 0.25, gamma: 0.0 };
        let hit = Hit { t: 10.0, beta: 0.25, gamma: 0.5 };
        assert_eq!(off(Output::T, &hit, &exact), 0.25);
        assert_eq!(off(Output::Barycentrics, &hit, &exact), 0.5);
        assert_eq!(off(Output::Barycentrics, &exact, &exact), 0.0);
    }
}
