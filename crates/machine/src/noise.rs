//! How steady the machine was while a record was taken: what its times can tell apart.

use std::iter::Sum;
use std::ops::AddAssign;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use trisect_report::format::percent;
use trisect_report::stats::{median, median_interval, quantile};

/// What a run measured of its own machine. All three are shares: 0.01 is one in a hundred.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// The part of the timed sections in which the thread did not run: wall clock without processor time. None
    /// where the system does not count a thread's processor time.
    pub stolen: Option<f64>,
    /// How far the machine's speed drifts between rounds: in each round the median, over everything that is
    /// timed in turn, of a sample over the median of its own; of these the ninth decile less the first.
    pub drift: f64,
    /// How far a median is uncertain: half of its 95 % interval, relative, the median over what is timed.
    pub spread: f64,
}

/// What can be said of a record's times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// All of them.
    Quiet,
    /// Differences of less than this share are not told apart.
    Noisy(f64),
    /// No winner is named.
    Unusable,
}

impl Noise {
    /// The smallest difference that is told apart. What is timed in turn drifts together: the medians' spread has in it
    /// what drift does to them.
    pub fn resolution(&self) -> f64 {
        self.spread.max(self.stolen.unwrap_or(0.0))
    }

    /// What can be said of the times.
    pub fn verdict(&self) -> Verdict {
        const QUIET: f64 = 0.03;
        const STEADY: f64 = 0.1;
        const USABLE: f64 = 0.2;
        const SAME: f64 = 0.5;
        let resolution = self.resolution();
        if self.stolen > Some(USABLE / 2.0) || resolution > USABLE || self.drift > SAME {
            Verdict::Unusable
        } else if resolution <= QUIET && self.drift <= STEADY {
            Verdict::Quiet
        } else {
            Verdict::Noisy(resolution)
        }
    }

    /// The verdict in a few words, with its figures.
    pub fn says(&self) -> String {
        let share = |x: f64| percent(x * 100.0);
        let stolen = self.stolen.map_or_else(String::new, |x| format!("{} stolen, ", share(x)));
        let figures = format!("{stolen}drift {}, spread {}", share(self.drift), share(self.spread));
        match self.verdict() {
            Verdict::Quiet => format!("quiet ({figures})"),
            Verdict::Noisy(x) => {
                format!("noisy ({figures}): differences under {} are not told apart", share(x))
            }
            Verdict::Unusable => format!("unusable ({figures}): no winner is named"),
        }
    }
}

/// Time that a piece of work took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spent {
    /// By the clock.
    pub wall: Duration,
    /// Of the thread's processor time, where the system counts it.
    pub processor: Option<Duration>,
}

impl AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.wall += other.wall;
        self.processor = other.processor.map(|more| self.processor.unwrap_or_default() + more);
    }
}

impl Sum for Spent {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |mut sum, spent| {
            sum += spent;
            sum
        })
    }
}

/// Does a piece of work on the calling thread, and says how long that took.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, Spent) {
    let processor = processor_time();
    let start = Instant::now();
    let done = work();
    let wall = start.elapsed();
    let processor = processor_time().zip(processor).and_then(|(end, start)| end.checked_sub(start));
    (done, Spent { wall, processor })
}

/// Processor time of the calling thread.
#[cfg(unix)]
fn processor_time() -> Option<Duration> {
    rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime).try_into().ok()
}

#[cfg(not(unix))]
fn processor_time() -> Option<Duration> {
    None
}

/// Gathers what a run measures of its own machine.
#[derive(Debug, Default)]
pub struct Meter {
    spent: Spent,
    drifts: Vec<f64>,
    spreads: Vec<f64>,
}

impl Meter {
    /// Takes in contenders that were timed in turn, by their samples of each round, and the time that all
    /// samples took. One sample or two say nothing of a machine.
    pub fn take<'a>(&mut self, samples: impl IntoIterator<Item = &'a [u64]>, spent: Spent) {
        let mut by_round: Vec<Vec<f64>> = Vec::new();
        for samples in samples {
            let samples: Vec<f64> = samples.iter().map(|&ns| ns as f64).collect();
            let interval = median_interval(&samples).filter(|i| i[1] > 0.0 && samples.len() > 2);
            let Some([low, middle, high]) = interval else { continue };
            self.spreads.push((high - low) / (2.0 * middle));
            by_round.resize(by_round.len().max(samples.len()), Vec::new());
            by_round.iter_mut().zip(samples).for_each(|(round, ns)| round.push(ns / middle));
        }
        let rounds: Vec<f64> = by_round.iter().filter_map(|ratios| median(ratios)).collect();
        if let (Some(low), Some(high)) = (quantile(&rounds, 0.1), quantile(&rounds, 0.9)) {
            self.drifts.push(high - low);
            self.spent += spent;
        }
    }

    /// What was measured; nothing where nothing was timed.
    pub fn noise(&self) -> Option<Noise> {
        let share = |processor: Duration| {
            (1.0 - processor.as_secs_f64() / self.spent.wall.as_secs_f64().max(1e-9)).max(0.0)
        };
        Some(Noise {
            stolen: self.spent.processor.map(share),
            drift: quantile(&self.drifts, 0.75)?,
            spread: median(&self.spreads)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: [u64; 5] = [1000, 1002, 999, 1001, 1000];

    fn of(contenders: &[[u64; 5]], processor_ms: u64) -> Noise {
        let mut meter = Meter::default();
        let spent = Spent {
            wall: Duration::from_secs(1),
            processor: Some(Duration::from_millis(processor_ms)),
        };
        meter.take(contenders.iter().map(|samples| &samples[..]), spent);
        meter.noise().expect("something was timed")
    }

    #[test]
    fn steady_times_of_a_thread_that_always_ran_are_quiet() {
        let noise = of(&[QUIET, QUIET], 999);
        assert_eq!(noise.verdict(), Verdict::Quiet);
        assert_eq!(noise.says(), "quiet (0.1 % stolen, drift 0.2 %, spread 0.2 %)");
    }

    /// One that jumps is uncertain, and shows nothing of the machine; when all jump in one round it does.
    #[test]
    fn what_all_have_in_common_is_drift() {
        let jumps = [1000, 1000, 1300, 1300, 1300];
        assert_eq!(of(&[QUIET, QUIET, jumps], 1000).verdict(), Verdict::Quiet);
        let noise = of(&[jumps, jumps], 1000);
        assert!((noise.drift - 0.3 / 1.3).abs() < 1e-9, "{noise:?}");
        let Verdict::Noisy(resolution) = noise.verdict() else { panic!("{noise:?}") };
        assert!((resolution - 0.15 / 1.3).abs() < 1e-9, "{noise:?}");
        assert!(noise.says().ends_with("differences under 11.5 % are not told apart"), "{noise:?}");
        // Twice as fast in some rounds as in others is another machine.
        let twice = of(&[[1000, 1000, 2500, 2500, 2500]; 2], 1000);
        assert_eq!(twice.verdict(), Verdict::Unusable, "{twice:?}");
        // As drift alone: the medians are certain, and what is compared goes in turn.
        let drift = |drift| Noise { stolen: Some(0.0), drift, spread: 0.01 }.verdict();
        let noisy = Verdict::Noisy(0.01);
        assert_eq!([0.05, 0.3, 0.6].map(drift), [Verdict::Quiet, noisy, Verdict::Unusable]);
    }

    /// As with a busy loop on every core: times between two interruptions may look steady.
    #[test]
    fn stolen_time_is_unusable_however_steady() {
        let noise = of(&[QUIET, QUIET], 600);
        assert_eq!(noise.verdict(), Verdict::Unusable);
        assert!(noise.says().starts_with("unusable (40 % stolen"), "{}", noise.says());
    }

    #[test]
    fn nothing_timed_says_nothing() {
        assert_eq!(Meter::default().noise(), None);
        let mut meter = Meter::default();
        meter.take([&[][..], &[5, 6]], Spent::default());
        assert_eq!(meter.noise(), None);
    }

    #[test]
    fn a_thread_that_sleeps_does_not_run() {
        let ((), spent) = timed(|| std::thread::sleep(Duration::from_millis(5)));
        assert!(spent.wall >= Duration::from_millis(5));
        assert!(spent.processor.is_none_or(|processor| processor < spent.wall), "{spent:?}");
    }
}
