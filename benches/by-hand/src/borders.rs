//! What the forms of a test decide where a numerator is zero, or nearly so: tests by sign bits take a zero as its sign
//! has it.

use anyhow::Result;
use trisect_badouel::BadouelCramer;
use trisect_core::{Ray, Triangle};
use trisect_havel_herout::HavelHerout;
use trisect_keidy::Keidy;
use trisect_kensler_shirley::{KenslerShirley, Points};
use trisect_kernels::intersect_with;
use trisect_machine::forms::{Border, TestForm};
use trisect_method::{BySigns, Culling, Deferred, Division, Early, Method, TrueDivision};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_oracle::Oracle;
use trisect_perpendicular_planes::PerpendicularPlanes;
use trisect_shevtsov::Shevtsov;
use trisect_wald::Wald;
use trisect_workloads::{Aim, Pair, Placement, Stress, Surface};

use crate::SEED;
use crate::record::Record;

/// Pairs of a level, and about as many rays at a surface.
const COUNT: usize = 2048;

/// Families of the stability study with the level at which numerators are zero, or ought to be.
const FAMILIES: [(Stress, f64); 8] = [
    (Stress::NearEdge, 0.0),
    (Stress::NearVertex, 0.0),
    (Stress::IntervalEnd, 0.0),
    (Stress::NearCollinear, 0.0),
    (Stress::AxisAligned, 0.0),
    (Stress::AxisAligned, 1.0),
    (Stress::AxisAligned, 2.0),
    (Stress::RandomBits, 0.0),
];

/// Pairs, and what is true of them.
struct Set {
    name: String,
    pairs: Vec<(Pair<f32>, bool)>,
    /// Triangles that each ray meets in turn, where they are a closed surface around it.
    surface: Option<usize>,
}

impl Set {
    fn new(name: impl Into<String>, pairs: Vec<Pair<f32>>, surface: Option<usize>) -> Self {
        let mut oracle = Oracle::default();
        let mut judged = |pair: Pair<f32>| (pair, oracle.classify(&pair.0, &pair.1).is_hit());
        let pairs = pairs.into_iter().map(&mut judged).collect();
        Self { name: name.into(), pairs, surface }
    }

    fn aimed(surface: &Surface, aim: Aim) -> Self {
        let triangles: Vec<Triangle<f32>> = surface.triangles(&Placement::HERE);
        let features = surface.features(aim);
        let each = COUNT.div_ceil(features.len());
        let rays = features
            .iter()
            .flat_map(|feature| surface.aimed(feature, &Placement::HERE, SEED, each));
        let pairs = rays.flat_map(|ray: Ray<f32>| triangles.iter().map(move |&t| (ray, t)));
        let name = format!("{} {}", surface.name, aim.name());
        Self::new(name, pairs.collect(), Some(triangles.len()))
    }
}

/// All sets, families first.
fn sets() -> Vec<Set> {
    let mut sets: Vec<Set> = Vec::new();
    for (family, level) in FAMILIES {
        let pairs = family.pairs::<f32>(SEED, level, COUNT);
        let more = Set::new(family.name(), pairs, None);
        match sets.last_mut().filter(|last| last.name == more.name) {
            Some(last) => last.pairs.extend(more.pairs),
            None => sets.push(more),
        }
    }
    for surface in [Surface::sphere(1), Surface::cube(2)] {
        sets.extend([Aim::Edges, Aim::Vertices].map(|aim| Set::aimed(&surface, aim)));
    }
    sets
}

/// Adds what every form of every method decides.
pub(crate) fn decide(record: &mut Record) -> Result<()> {
    let sets = sets();
    let mut all = Vec::new();
    of_method::<MollerTrumbore>(&sets, &mut all);
    of_method::<KenslerShirley<Points>>(&sets, &mut all);
    of_method::<Keidy>(&sets, &mut all);
    of_method::<BadouelCramer>(&sets, &mut all);
    of_method::<Wald>(&sets, &mut all);
    of_method::<Shevtsov>(&sets, &mut all);
    of_method::<PerpendicularPlanes>(&sets, &mut all);
    of_method::<HavelHerout>(&sets, &mut all);
    all.iter().try_for_each(|border| record.add("border", border))
}

fn of_method<M: Method>(sets: &[Set], all: &mut Vec<Border>) {
    for set in sets {
        if const { M::INFO.forms.early() } {
            all.push(of_form::<M, Early<TrueDivision, true>>(TestForm::Early, set));
        }
        if const { M::INFO.forms.deferred() } {
            all.push(of_form::<M, Deferred<TrueDivision, true>>(TestForm::Deferred, set));
            all.push(of_form::<M, BySigns<TrueDivision, true>>(TestForm::Signs, set));
        }
    }
}

fn of_form<M: Method, D: Division>(form: TestForm, set: &Set) -> Border {
    let mut border = Border {
        method: M::INFO.name.to_owned(),
        form,
        set: set.name.clone(),
        pairs: set.pairs.len() as u64,
        false_hits: 0,
        false_misses: 0,
        rays: 0,
        escaped: 0,
    };
    for of_ray in set.pairs.chunks(set.surface.unwrap_or(1)) {
        let mut is_met = false;
        for ((ray, triangle), is_true) in of_ray {
            let is_hit = intersect_with::<M, D, f32>(ray, triangle, Culling::None).is_some();
            border.false_hits += u64::from(is_hit && !is_true);
            border.false_misses += u64::from(!is_hit && *is_true);
            is_met |= is_hit;
        }
        if set.surface.is_some() {
            border.rays += 1;
            border.escaped += u64::from(!is_met);
        }
    }
    border
}
