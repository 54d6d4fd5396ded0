//! What a pixel's ray costs, and how right its answer is.

use std::cmp::Ordering;

use trisect_core::{Ray, Triangle};
use trisect_oracle::{Oracle, compare_t};
use trisect_render::{Sight, Stage};
use trisect_tracer::TriangleHit;

/// Values of `t` so near each other, relatively, may be in either order: the oracle's are good to 2⁻³⁰.
const UNSURE: f64 = 1.0 / (1_u64 << 29) as f64;

/// The triangles of each of a stage's trees, by their numbers.
pub type Triangles = Vec<Vec<Triangle<f32>>>;

/// How many tests a ray takes, in all trees that it goes through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Nodes visited, of eight boxes each.
    pub nodes: usize,
    /// Triangles tested.
    pub triangles: usize,
}

/// How right a method's answer is for a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// There is no triangle, and it found none.
    Nothing,
    /// It found the triangle; how far off its `t` is, relatively.
    Error(f64),
    /// It found a triangle that the ray truly misses.
    FalseHit,
    /// It missed the nearest triangle, or took it for a farther one.
    FalseMiss,
}

/// The nearest triangle of a ray: the place of its tree, and what is known of it there.
struct Nearest<T> {
    place: usize,
    triangle: u32,
    ray: Ray<f32>,
    t: T,
}

/// What the method finds, in plain arithmetic, and what that takes.
fn trace(stage: &Stage, ray: Ray<f32>) -> (Cost, Option<Nearest<f32>>) {
    let (mut cost, mut best, mut tmax) = (Cost::default(), None, ray.tmax);
    for (place, Sight { tree, ray, .. }) in stage.sights(ray).enumerate() {
        let counted = tree.inspect(&Ray { tmax, ..ray });
        cost.nodes += counted.nodes;
        cost.triangles += counted.triangles;
        if let Some(TriangleHit { triangle, hit }) = counted.found
            && hit.t < tmax
        {
            tmax = hit.t;
            best = Some(Nearest { place, triangle, ray, t: hit.t });
        }
    }
    (cost, best)
}

/// How many tests a ray takes.
pub fn cost(stage: &Stage, ray: Ray<f32>) -> Cost {
    trace(stage, ray).0
}

/// How right the method's answer is, given the triangles of each tree. Instances are judged by the ray
/// as it was carried to them: so the error is the method's, not that of carrying it.
pub fn judge(
    stage: &Stage,
    triangles: &[Vec<Triangle<f32>>],
    oracle: &mut Oracle,
    ray: Ray<f32>,
) -> Verdict {
    let (_, found) = trace(stage, ray);
    let truth = truth(stage, triangles, oracle, ray);
    match (found, truth) {
        (None, None) => Verdict::Nothing,
        (Some(_), None) => Verdict::FalseHit,
        (None, Some(_)) => Verdict::FalseMiss,
        (Some(found), Some((truth, of_tree))) => {
            let error = Verdict::Error((f64::from(found.t) - truth.t).abs() / truth.t);
            if (found.place, found.triangle) == (truth.place, truth.triangle) {
                return error;
            }
            // Another one: on their common edge it may be as right.
            let number = stage.sights(ray).nth(found.place).map_or(0, |sight| sight.number);
            let other = &triangles[number][found.triangle as usize];
            if !oracle.classify(&found.ray, other).is_hit() {
                return Verdict::FalseHit;
            }
            let is_as_near = found.place == truth.place
                && compare_t(&truth.ray, other, &of_tree[truth.triangle as usize])
                    .is_some_and(Ordering::is_eq);
            if is_as_near { error } else { Verdict::FalseMiss }
        }
    }
}

/// What the ray truly meets first, with the triangles of that tree.
fn truth<'a>(
    stage: &Stage,
    triangles: &'a [Vec<Triangle<f32>>],
    oracle: &mut Oracle,
    ray: Ray<f32>,
) -> Option<(Nearest<f64>, &'a [Triangle<f32>])> {
    let mut best: Option<(Nearest<f64>, &[Triangle<f32>])> = None;
    let mut tmax = ray.tmax;
    for (place, Sight { number, tree, ray }) in stage.sights(ray).enumerate() {
        let of_tree = &triangles[number][..];
        tree.candidates(&Ray { tmax, ..ray }, &mut |triangle| {
            let tested = &of_tree[triangle as usize];
            let truth = oracle.truth(&ray, tested);
            let is_nearer = |(other, _): &(Nearest<f64>, _)| {
                let is_unsure = (truth.t - other.t).abs() <= other.t * UNSURE;
                if is_unsure && other.place == place {
                    let other = &of_tree[other.triangle as usize];
                    return compare_t(&ray, tested, other).is_some_and(Ordering::is_lt);
                }
                truth.t < other.t
            };
            if truth.class.is_hit() && best.as_ref().is_none_or(is_nearer) {
                best = Some((Nearest { place, triangle, ray, t: truth.t }, of_tree));
                tmax = above(truth.t);
            }
            tmax
        });
    }
    best
}

/// A number of f32 that is above one of f64, by a little.
#[allow(clippy::cast_possible_truncation, reason = "rounded, and made larger by more than that")]
fn above(t: f64) -> f32 {
    (t as f32) * (1.0 + 4.0 * f32::EPSILON)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use trisect_catalog::{Builder, find};
    use trisect_core::Vec3;
    use trisect_method::{Culling, Place};
    use trisect_render::Settings;
    use trisect_scene::Scene;
    use trisect_tracer::{
        Counted, Crossings, Extent, NotExact, RefitError, Statistics, Tracing, Tree,
    };

    use super::*;

    /// What a tree says in place of what it found.
    type Change = fn(Option<TriangleHit>) -> Option<TriangleHit>;

    /// A tree that answers as it is told.
    struct Told(Box<dyn Tree>, Change);

    impl Tree for Told {
        fn closest(&self, _: Tracing, _: Culling, _: &[Ray<f32>], _: &mut [Option<TriangleHit>]) {
            unreachable!("rays are inspected here");
        }
        fn any(&self, _: Tracing, _: Culling, _: &[Ray<f32>], _: &mut [bool]) {
            unreachable!("rays are inspected here");
        }
        fn all(
            &self,
            _: Tracing,
            _: Culling,
            _: Crossings,
            _: &Ray<f32>,
            _: &mut Vec<TriangleHit>,
        ) {
            unreachable!("rays are inspected here");
        }
        fn count(&self, _: Tracing, _: Culling, _: Crossings, _: &Ray<f32>) -> u32 {
            unreachable!("rays are inspected here");
        }
        fn filtered(
            &self,
            _: Tracing,
            _: Culling,
            _: &Ray<f32>,
            _: &mut dyn FnMut(&TriangleHit) -> trisect_tracer::Verdict,
        ) -> Option<TriangleHit> {
            unreachable!("rays are inspected here");
        }
        fn contains(&self, point: Vec3<f32>) -> Result<Place, NotExact> {
            self.0.contains(point)
        }
        fn inspect(&self, ray: &Ray<f32>) -> Counted {
            let counted = self.0.inspect(ray);
            Counted { found: self.1(counted.found), ..counted }
        }
        fn candidates(&self, ray: &Ray<f32>, visit: &mut dyn FnMut(u32) -> f32) {
            self.0.candidates(ray, visit);
        }
        fn refit(&mut self, _: &[Triangle<f32>]) -> Result<(), RefitError> {
            unreachable!("nothing moves here");
        }
        fn statistics(&self) -> Statistics {
            self.0.statistics()
        }
        fn extent(&self) -> Extent {
            self.0.extent()
        }
    }

    const SIZE: [u32; 2] = [80, 60];

    /// The verdicts on a picture of teapots that share a tree.
    fn verdicts(method: &str, change: Change) -> Vec<Verdict> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/scenes/teapots.toml");
        let scene = Scene::load(path).expect("it is shipped");
        let entry = find(method).expect("it is in the catalogue");
        let triangles = RefCell::new(Vec::new());
        let stage = Stage::new(scene, |of_tree| {
            triangles.borrow_mut().push(of_tree.to_vec());
            Ok(Box::new(Told(entry.tree(of_tree, Builder::Spatial)?, change)) as Box<dyn Tree>)
        });
        let (stage, triangles) = (stage.expect("it takes all"), triangles.into_inner());
        let settings = Settings::new(SIZE);
        let mut oracle = Oracle::default();
        let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
        pixels
            .map(|pixel| {
                let ray = stage.primary(&settings, pixel);
                let cost = cost(&stage, ray);
                assert!(cost.nodes > 0 || cost.triangles == 0);
                judge(&stage, &triangles, &mut oracle, ray)
            })
            .collect()
    }

    fn errors(verdicts: &[Verdict]) -> Vec<f64> {
        let error = |verdict: &Verdict| match verdict {
            Verdict::Error(error) => Some(*error),
            _ => None,
        };
        verdicts.iter().filter_map(error).collect()
    }

    #[test]
    fn a_sound_method_is_found_sound() {
        for method in ["watertight", "moller-trumbore", "badouel"] {
            let verdicts = verdicts(method, |found| found);
            let errors = errors(&verdicts);
            assert!(errors.len() > 500, "{method}: {}", errors.len());
            let worst = errors.iter().copied().fold(0.0, f64::max);
            assert!(worst > 1e-9 && worst < 1e-4, "{method}: {worst}");
            let nothing = verdicts.iter().filter(|verdict| **verdict == Verdict::Nothing).count();
            // A ray or two may come to an edge.
            assert!(verdicts.len() - errors.len() - nothing <= 2, "{method}");
        }
    }

    #[test]
    fn every_kind_of_mistake_is_found() {
        let right = verdicts("watertight", |found| found);
        let hits = errors(&right).len();
        let count = |verdicts: &[Verdict], kind| verdicts.iter().filter(|v| **v == kind).count();
        let missed = verdicts("watertight", |_| None);
        assert_eq!(count(&missed, Verdict::FalseMiss), hits);
        let invented = verdicts("watertight", |found| {
            let hit = trisect_core::Hit { t: 1.0, beta: 0.1, gamma: 0.1 };
            found.or(Some(TriangleHit { triangle: 0, hit }))
        });
        // Where a ray comes to the box of a teapot, but passes it.
        assert!(count(&invented, Verdict::FalseHit) > 100);
        let off = verdicts("watertight", |found| {
            found.map(|mut found| {
                found.hit.t *= 0.75;
                found
            })
        });
        assert!(errors(&off).iter().all(|error| (error - 0.25).abs() < 1e-4));
        assert!(errors(&off).len() > hits / 2);
        let another = verdicts("watertight", |found| {
            found.map(|found| TriangleHit { triangle: found.triangle / 2, ..found })
        });
        assert!(count(&another, Verdict::FalseHit) > hits / 2);
    }
}
