//! The study of the tracer: what a method, a builder or a thread is worth where rays are traced.

mod race;
mod rays;

use std::time::Instant;

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use trisect_catalog::{Builder, Entry, Leaves, Statistics, Tracing, Tree, find};
use trisect_core::{FloatFormat, Output, UnsuitableMesh};
use trisect_workloads::{Mesh, RayClass};

use crate::Progress;
use crate::measure::REFERENCE;
use crate::record::{Contest, Record, Refusal, Throughput, Traced, TreeBuilt};
use crate::timing::{WrongAnswer, nanoseconds};

use race::{Contender, Order, race};
pub use rays::{ClassOfRays, classes_of_rays};

/// What is studied, and how long.
pub struct StudySettings {
    /// Seed of rays and of the order of samples.
    pub seed: u64,
    /// The methods.
    pub methods: Vec<&'static Entry>,
    /// The scenes.
    pub scenes: Vec<Mesh>,
    /// Side, in pixels, of the picture whose rays meet a scene.
    pub pixels: usize,
    /// Samples of everything that is timed.
    pub rounds: usize,
    /// Threads, at most.
    pub threads: usize,
}

/// Why a study ended early.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A timed sample was wrong.
    #[error(transparent)]
    WrongAnswer(#[from] WrongAnswer),
    /// The system gives no threads.
    #[error("the system gives no threads; ask for fewer with --threads")]
    Threads(#[from] ThreadPoolBuildError),
}

/// Whether a line of a measurement is about the kernels that a tracer calls.
pub fn keep_for_study(line: &Record) -> bool {
    match line {
        Record::Throughput(Throughput { variant, .. }) => {
            variant.is_as_in_a_tracer()
                && matches!(variant.needs, Output::Occlusion | Output::T | Output::Barycentrics)
        }
        line => matches!(line, Record::Method(_) | Record::Workload(_)),
    }
}

/// Studies the methods in the tracer, and says what was found as records.
///
/// # Errors
/// When a timed sample finds not as many hits as it should, or there are no threads.
pub fn study(
    settings: &StudySettings,
    progress: &mut dyn Progress,
) -> Result<Vec<Record>, StudyError> {
    let mut run = Run {
        settings,
        one: pool(1)?,
        all: pool(settings.threads)?,
        random: Pcg64::seed_from_u64(settings.seed),
        lines: Vec::new(),
        progress,
    };
    for scene in &settings.scenes {
        run.progress.phase(&format!("{}: rays", scene.name), 1);
        let classes = run
            .all
            .install(|| classes_of_rays(scene, settings.pixels, settings.seed, &RayClass::ALL));
        run.progress.step();
        run.methods(scene, &classes)?;
        run.trees(scene, &classes)?;
        run.threads(scene, &classes)?;
    }
    Ok(run.lines)
}

pub(crate) fn pool(threads: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads).build()
}

/// The method that all are compared with.
pub(crate) fn reference() -> &'static Entry {
    find(REFERENCE).expect("it is in the catalogue")
}

/// A study under way.
struct Run<'a> {
    settings: &'a StudySettings,
    one: ThreadPool,
    all: ThreadPool,
    random: Pcg64,
    lines: Vec<Record>,
    progress: &'a mut dyn Progress,
}

/// A tree with what is known of it.
struct Resident {
    tree: Box<dyn Tree>,
    built: TreeBuilt,
}

impl Resident {
    /// Builds a tree, on the threads of the pool: with the method behind a call, but for
    /// [`Contest::Inline`].
    ///
    /// # Panics
    /// When the contest is about inline trees, and none is compiled for the method.
    fn build(
        entry: &Entry,
        scene: &Mesh,
        (builder, leaves): (Builder, Leaves),
        pool: &ThreadPool,
        contest: Contest,
    ) -> Result<Self, UnsuitableMesh> {
        let build = match contest {
            Contest::Inline => entry.inline_tree.expect("an inline tree is compiled"),
            _ => entry.erased_tree,
        };
        let (tree, time) = pool.install(|| {
            let start = Instant::now();
            let tree = build(&scene.triangles, builder, leaves);
            (tree, start.elapsed())
        });
        let tree = tree?;
        let Statistics { nodes, blocks, references, depth, bytes, cost, .. } = tree.statistics();
        let built = TreeBuilt {
            contest,
            method: entry.info.name.to_owned(),
            scene: scene.name.clone(),
            triangles: scene.triangles.len(),
            builder: builder.name().to_owned(),
            leaves: leaves.name().to_owned(),
            threads: pool.current_num_threads(),
            samples_ns: vec![nanoseconds(time)],
            nodes,
            blocks,
            references,
            depth,
            bytes,
            cost,
        };
        Ok(Self { tree, built })
    }

    /// Takes in the tree that was built next: the same one, so that its time alone is new.
    fn build_again(&mut self, next: Self) {
        self.tree = next.tree;
        self.built.samples_ns.extend(next.built.samples_ns);
    }

    /// Takes in the tree that was built first, or next.
    fn keep(place: &mut Option<Self>, next: Self) {
        match place {
            Some(resident) => resident.build_again(next),
            empty => *empty = Some(next),
        }
    }

    /// The line of what a contender did with the tree.
    fn traced(&self, class: &ClassOfRays, contender: &Contender<'_>) -> Traced {
        let TreeBuilt { contest, method, scene, builder, leaves, .. } = self.built.clone();
        Traced {
            contest,
            method,
            scene,
            builder,
            leaves,
            class: class.name.to_owned(),
            any: class.any,
            tracing: contender.tracing_name().to_owned(),
            calls: contender.calls_name().to_owned(),
            threads: contender.pool.current_num_threads(),
            rays: class.rays.len() as u64,
            hits: contender.hits,
            differ: contender.differ,
            samples_ns: contender.samples_ns.clone(),
            baseline_ns: Vec::new(),
        }
    }
}

impl Run<'_> {
    /// Every method in turn with the one that all are compared with, on one thread, in the tree that is
    /// the fastest to trace.
    fn methods(&mut self, scene: &Mesh, classes: &[ClassOfRays]) -> Result<(), WrongAnswer> {
        const TREE: (Builder, Leaves) = (Builder::Spatial, Leaves::Cheapest);
        let methods = self.settings.methods.clone();
        let inline = methods.iter().filter(|entry| entry.inline_tree.is_some());
        let steps = ((methods.len() + inline.count()) * classes.len()) as u64;
        self.progress.phase(&format!("{}: methods", scene.name), steps);
        let contest = Contest::Methods;
        let Ok(baseline) = Resident::build(reference(), scene, TREE, &self.all, contest) else {
            return Ok(());
        };
        for entry in methods {
            let mut resident = match Resident::build(entry, scene, TREE, &self.all, contest) {
                Ok(resident) => resident,
                Err(unsuitable) => {
                    self.refuse(entry, scene, &unsuitable);
                    let trees = 1 + usize::from(entry.inline_tree.is_some());
                    (0..trees * classes.len()).for_each(|_| self.progress.step());
                    continue;
                }
            };
            for _ in 1..self.settings.rounds {
                if let Ok(next) = Resident::build(entry, scene, TREE, &self.all, contest) {
                    resident.build_again(next);
                }
            }
            self.lines.push(Record::Tree(resident.built.clone()));
            // The method that all are compared with is in turn with itself: that says how much times
            // differ by chance.
            self.against(&resident, &baseline, classes)?;
            if entry.inline_tree.is_some() {
                let inline = Resident::build(entry, scene, TREE, &self.all, Contest::Inline);
                self.against(&inline.expect("it takes this mesh"), &resident, classes)?;
            }
        }
        Ok(())
    }

    /// Traces a tree in turn with another, by single rays and in packets.
    fn against(
        &mut self,
        resident: &Resident,
        baseline: &Resident,
        classes: &[ClassOfRays],
    ) -> Result<(), WrongAnswer> {
        for class in classes {
            let ways = [Tracing::Single, Tracing::Packets];
            let of = |resident| ways.map(|way| Contender::new(resident, way, &self.one));
            let mut contenders = Vec::from(of(resident));
            contenders.extend(of(baseline));
            race(
                &mut contenders,
                class,
                self.settings.rounds,
                &mut self.random,
                Order::Slices,
            )?;
            let (mine, beside) = contenders.split_at(ways.len());
            for (mine, beside) in mine.iter().zip(beside) {
                let baseline_ns = beside.samples_ns.clone();
                let traced = Traced { baseline_ns, ..resident.traced(class, mine) };
                self.lines.push(Record::Traced(traced));
            }
            self.progress.step();
        }
        Ok(())
    }

    fn refuse(&mut self, entry: &Entry, scene: &Mesh, unsuitable: &UnsuitableMesh) {
        self.lines.push(Record::Refusal(Refusal {
            method: entry.info.name.to_owned(),
            precision: FloatFormat::F32,
            workload: scene.name.clone(),
            reason: unsuitable.to_string(),
        }));
    }

    /// One method: every builder, every size of leaf, and of the default tree every way to trace it.
    fn trees(&mut self, scene: &Mesh, classes: &[ClassOfRays]) -> Result<(), WrongAnswer> {
        let kinds = [
            (Builder::Linear, Leaves::Cheapest),
            (Builder::Binned, Leaves::Cheapest),
            (Builder::Spatial, Leaves::Cheapest),
            (Builder::Spatial, Leaves::Sixteen),
            (Builder::Spatial, Leaves::ThirtyTwo),
        ];
        let rounds = self.settings.rounds;
        let steps = (rounds + classes.len()) as u64;
        self.progress.phase(&format!("{}: trees", scene.name), steps);
        let mut residents: Vec<Option<Resident>> = kinds.iter().map(|_| None).collect();
        let mut order: Vec<usize> = (0..kinds.len()).collect();
        for _ in 0..rounds {
            order.shuffle(&mut self.random);
            for &place in &order {
                let contest = Contest::Trees;
                let next = Resident::build(reference(), scene, kinds[place], &self.all, contest);
                let Ok(next) = next else { return Ok(()) };
                Resident::keep(&mut residents[place], next);
            }
            self.progress.step();
        }
        let residents: Vec<Resident> = residents.into_iter().flatten().collect();
        self.lines.extend(residents.iter().map(|resident| Record::Tree(resident.built.clone())));
        let default = residents
            .iter()
            .position(|resident| {
                resident.built.builder == Builder::Spatial.name()
                    && resident.built.leaves == Leaves::Cheapest.name()
            })
            .expect("it is one of the kinds");
        for class in classes {
            let of = |place: usize, way| Contender::new(&residents[place], way, &self.one);
            let mut places: Vec<usize> = (0..residents.len()).collect();
            let mut contenders: Vec<Contender<'_>> =
                places.iter().map(|&place| of(place, Tracing::Single)).collect();
            places.extend([default, default]);
            contenders.push(of(default, Tracing::Plain));
            contenders.push(of(default, Tracing::Single).ray_by_ray());
            race(&mut contenders, class, rounds, &mut self.random, Order::Slices)?;
            for (place, contender) in places.into_iter().zip(&contenders) {
                self.lines.push(Record::Traced(residents[place].traced(class, contender)));
            }
            self.progress.step();
        }
        Ok(())
    }

    /// One method: building and tracing by one thread, by two, and so on up to all.
    fn threads(&mut self, scene: &Mesh, classes: &[ClassOfRays]) -> Result<(), StudyError> {
        let rounds = self.settings.rounds;
        let counts = thread_counts(self.settings.threads);
        let steps = (counts.len() * Builder::ALL.len() + classes.len()) as u64;
        self.progress.phase(&format!("{}: threads", scene.name), steps);
        let pools = counts.iter().map(|&threads| pool(threads)).collect::<Result<Vec<_>, _>>()?;
        let mut last = None;
        for builder in Builder::ALL {
            let mut of_builder: Vec<Option<Resident>> = pools.iter().map(|_| None).collect();
            for _ in 0..rounds {
                for (pool, resident) in pools.iter().zip(&mut of_builder) {
                    let kind = (builder, Leaves::Cheapest);
                    let next = Resident::build(reference(), scene, kind, pool, Contest::Threads);
                    let Ok(next) = next else { return Ok(()) };
                    Resident::keep(resident, next);
                }
            }
            for resident in of_builder.into_iter().flatten() {
                self.lines.push(Record::Tree(resident.built.clone()));
                last = Some(resident);
                self.progress.step();
            }
        }
        let Some(resident) = last else { return Ok(()) };
        for class in classes {
            let mut contenders: Vec<Contender<'_>> =
                pools.iter().map(|pool| Contender::new(&resident, Tracing::Single, pool)).collect();
            race(&mut contenders, class, rounds, &mut self.random, Order::Whole)?;
            for contender in &contenders {
                self.lines.push(Record::Traced(resident.traced(class, contender)));
            }
            self.progress.step();
        }
        Ok(())
    }
}

/// One, two, four and so on, and the most.
pub(crate) fn thread_counts(most: usize) -> Vec<usize> {
    let mut counts: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|&n| n < most).collect();
    counts.push(most.max(1));
    counts
}
