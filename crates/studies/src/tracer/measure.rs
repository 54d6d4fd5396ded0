//! Every method, every builder and every number of threads, in trees.

use std::time::Instant;

use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use rayon::ThreadPool;
use trisect_catalog::{Builder, Entry, Leaves, Statistics, Tracing, Tree};
use trisect_core::FloatFormat;
use trisect_method::{Output, UnsuitableMesh};
use trisect_workloads::{Mesh, RayClass};

use super::race::{Contender, Order, note, race};
use super::rays::{ClassOfRays, classes_of_rays};
use super::record::{Contest, Traced, TreeBuilt};
use super::settings::Tracer;
use crate::comparison::measure::compare;
use crate::comparison::record::{MethodFacts, Refusal, Throughput, Workload};
use crate::comparison::tasks::timing;
use crate::kernels::reference;
use crate::record::Line;
use crate::study::{Run, StudyError, pool};
use crate::timing::{WrongAnswer, nanoseconds};

/// Times the kernels alone, then rays through trees of each scene.
pub(super) fn measure(study: &Tracer, run: &mut Run<'_>) -> Result<(), StudyError> {
    compare(&study.methods, (study.seed, study.rounds), [timing(study.seed)], run)?;
    run.lines.retain(is_kept);
    let mut racing = Racing {
        study,
        one: pool(1)?,
        all: pool(study.threads)?,
        random: Pcg64::seed_from_u64(study.seed),
        run,
    };
    for scene in &study.scenes {
        racing.run.progress.phase(&format!("{}: rays", scene.name), 1);
        let classes =
            racing.all.install(|| classes_of_rays(scene, study.pixels, study.seed, &RayClass::ALL));
        racing.run.progress.step();
        racing.methods(scene, &classes)?;
        racing.trees(scene, &classes)?;
        racing.threads(scene, &classes)?;
    }
    Ok(())
}

/// Whether a line of a comparison is about the kernels that a tracer calls.
fn is_kept(line: &Line) -> bool {
    let is_called = |Throughput { variant, .. }: &Throughput| {
        variant.is_as_in_a_tracer()
            && matches!(variant.needs, Output::Occlusion | Output::T | Output::Barycentrics)
    };
    line.get().is_some_and(is_called)
        || line.get::<MethodFacts>().is_some()
        || line.get::<Workload>().is_some()
}

/// A study under way.
struct Racing<'a, 'r> {
    study: &'a Tracer,
    one: ThreadPool,
    all: ThreadPool,
    random: Pcg64,
    run: &'a mut Run<'r>,
}

/// A tree with what is known of it.
pub(super) struct Resident {
    pub(super) tree: Box<dyn Tree>,
    pub(super) built: TreeBuilt,
}

impl Resident {
    /// Builds a tree, on the threads of the pool: with a call of the method for each leaf, but for
    /// [`Contest::Inline`] and [`Contest::Together`].
    ///
    /// # Panics
    /// When the contest is about inline trees, and none is compiled for the method.
    pub(super) fn build(
        entry: &Entry,
        scene: &Mesh,
        (builder, leaves): (Builder, Leaves),
        pool: &ThreadPool,
        contest: Contest,
    ) -> Result<Self, UnsuitableMesh> {
        let build = match contest {
            Contest::Inline | Contest::Together => {
                entry.inline_tree.expect("an inline tree is compiled")
            }
            Contest::Methods | Contest::Trees | Contest::Threads => entry.erased_tree,
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
    pub(super) fn traced(&self, class: &ClassOfRays, contender: &Contender<'_>) -> Traced {
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

impl Racing<'_, '_> {
    /// Every method in turn with the one that all are compared with, on one thread, in the tree that is
    /// the fastest to trace.
    fn methods(&mut self, scene: &Mesh, classes: &[ClassOfRays]) -> Result<(), WrongAnswer> {
        const TREE: (Builder, Leaves) = (Builder::Spatial, Leaves::Cheapest);
        let methods = &self.study.methods;
        let inline = methods.iter().filter(|entry| entry.inline_tree.is_some());
        let steps = ((methods.len() + inline.count()) * classes.len()) as u64;
        self.run.progress.phase(&format!("{}: methods", scene.name), steps);
        let contest = Contest::Methods;
        let Ok(baseline) = Resident::build(reference(), scene, TREE, &self.all, contest) else {
            return Ok(());
        };
        for entry in methods {
            let mut resident = match Resident::build(entry, scene, TREE, &self.all, contest) {
                Ok(resident) => resident,
                Err(unsuitable) => {
                    self.run.add(refuse(entry, scene, &unsuitable));
                    let trees = 1 + usize::from(entry.inline_tree.is_some());
                    (0..trees * classes.len()).for_each(|_| self.run.progress.step());
                    continue;
                }
            };
            for _ in 1..self.study.rounds {
                if let Ok(next) = Resident::build(entry, scene, TREE, &self.all, contest) {
                    resident.build_again(next);
                }
            }
            self.run.add(resident.built.clone());
            // The method that all are compared with is in turn with itself: that says how much times
            // differ by chance.
            self.against(&resident, &baseline, classes)?;
            if entry.inline_tree.is_some() {
                let inline = Resident::build(entry, scene, TREE, &self.all, Contest::Inline);
                self.against(&inline.expect("the method takes this mesh"), &resident, classes)?;
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
            race(&mut contenders, class, self.study.rounds, &mut self.random, Order::Slices)?;
            note(&mut self.run.meter, &contenders);
            let (mine, beside) = contenders.split_at(ways.len());
            for (mine, beside) in mine.iter().zip(beside) {
                let baseline_ns = beside.samples_ns.clone();
                self.run.add(Traced { baseline_ns, ..resident.traced(class, mine) });
            }
            self.run.progress.step();
        }
        Ok(())
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
        let rounds = self.study.rounds;
        let steps = (rounds + classes.len()) as u64;
        self.run.progress.phase(&format!("{}: trees", scene.name), steps);
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
            self.run.progress.step();
        }
        let residents: Vec<Resident> = residents.into_iter().flatten().collect();
        self.run.lines.extend(residents.iter().map(|resident| Line::from(resident.built.clone())));
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
            note(&mut self.run.meter, &contenders);
            for (place, contender) in places.into_iter().zip(&contenders) {
                self.run.add(residents[place].traced(class, contender));
            }
            self.run.progress.step();
        }
        Ok(())
    }

    /// One method: building and tracing by one thread, by two, and so on up to all.
    fn threads(&mut self, scene: &Mesh, classes: &[ClassOfRays]) -> Result<(), StudyError> {
        let rounds = self.study.rounds;
        let counts = thread_counts(self.study.threads);
        let steps = (counts.len() * Builder::ALL.len() + classes.len()) as u64;
        self.run.progress.phase(&format!("{}: threads", scene.name), steps);
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
                self.run.add(resident.built.clone());
                last = Some(resident);
                self.run.progress.step();
            }
        }
        let Some(resident) = last else { return Ok(()) };
        for class in classes {
            let mut contenders: Vec<Contender<'_>> =
                pools.iter().map(|pool| Contender::new(&resident, Tracing::Single, pool)).collect();
            race(&mut contenders, class, rounds, &mut self.random, Order::Whole)?;
            for contender in &contenders {
                self.run.add(resident.traced(class, contender));
            }
            self.run.progress.step();
        }
        Ok(())
    }
}

/// That a method does not take a scene.
pub(super) fn refuse(entry: &Entry, scene: &Mesh, unsuitable: &UnsuitableMesh) -> Refusal {
    Refusal {
        method: entry.info.name.to_owned(),
        precision: FloatFormat::F32,
        workload: scene.name.clone(),
        reason: unsuitable.to_string(),
    }
}

/// One, two, four and so on, and the most.
pub(crate) fn thread_counts(most: usize) -> Vec<usize> {
    let mut counts: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|&n| n < most).collect();
    counts.push(most.max(1));
    counts
}
