//! Trees with the test inside the traversal loop, in turn on one thread, and held to exact arithmetic.

use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use trisect_catalog::{Builder, Entry, Leaves, Tracing, Tree, TriangleHit};
use trisect_core::{Ray, Scalar as _, Triangle};
use trisect_mesh::Mesh;
use trisect_method::Culling;
use trisect_workloads::RayClass;

use super::measure::{Resident, refuse};
use super::race::{Contender, Order, note, race};
use super::rays::{ClassOfRays, classes_of_rays};
use super::record::{Contest, TreeChecked};
use crate::study::{Run, StudyError, pool, threads};
use crate::subject::{OfRay, ask};
use crate::surface::{at_edges, open_edges};

/// Rays of a class, at least: more than a branch predictor learns.
const MANY: usize = 1 << 15;

/// Pairs that the oracle is asked about, at most: a second on one processor.
const PAIRS: usize = 1 << 20;

/// Rays aimed at edges.
const EDGE_RAYS: usize = 20_000;

/// The rays of a scene that trees are compared on: a user's own, or else those of all classes.
pub(crate) fn both_classes(scene: &Mesh, own: Option<&[Ray<f32>]>, seed: u64) -> [ClassOfRays; 2] {
    const PIXELS: usize = 128;
    let rays = |of: &[RayClass]| {
        let made = || {
            let classes = classes_of_rays(scene, PIXELS, seed, of);
            classes.into_iter().flat_map(|class| class.rays).collect()
        };
        own.map_or_else(made, <[_]>::to_vec)
    };
    let closest = rays(&[RayClass::Primary, RayClass::Random, RayClass::Diffuse]);
    // Where the camera sees nothing there are no shadow rays.
    let any = Some(rays(&[RayClass::Occlusion])).filter(|rays| !rays.is_empty());
    let any = any.unwrap_or_else(|| closest.clone());
    [
        ClassOfRays { name: "closest", any: false, rays: closest },
        ClassOfRays { name: "any", any: true, rays: any },
    ]
}

/// Times every method that is compiled into the traversal loop on a scene, and checks its answers.
pub(crate) fn together(
    methods: &[&'static Entry],
    scene: &Mesh,
    classes: &[ClassOfRays; 2],
    (rounds, random): (usize, &mut Pcg64),
    run: &mut Run<'_>,
) -> Result<(), StudyError> {
    const TREE: (Builder, Leaves) = (Builder::Spatial, Leaves::Cheapest);
    let (one, all) = (pool(1)?, pool(threads(None))?);
    let inline: Vec<_> = methods.iter().filter(|entry| entry.inline_tree.is_some()).collect();
    run.progress.phase(&format!("{}: trees", scene.name), inline.len() as u64 + 3);
    let mut residents = Vec::new();
    for entry in inline {
        match Resident::build(entry, scene, TREE, &all, Contest::Together) {
            Ok(resident) => residents.push(resident),
            Err(unsuitable) => run.add(refuse(entry, scene, &unsuitable)),
        }
        run.progress.step();
    }
    let Some(first) = residents.first() else { return Ok(()) };
    for resident in &residents {
        run.add(resident.built.clone());
    }
    for class in classes {
        let class = ClassOfRays { rays: many(&class.rays, random), ..*class };
        let of = |resident| Contender::new(resident, Tracing::Single, &one);
        let mut contenders: Vec<_> = residents.iter().map(of).collect();
        contenders.extend(residents.iter().map(|resident| of(resident).ray_by_ray()));
        race(&mut contenders, &class, rounds, random, Order::Slices)?;
        note(&mut run.meter, &contenders);
        for (resident, contender) in residents.iter().cycle().zip(&contenders) {
            run.add(resident.traced(&class, contender));
        }
        run.progress.step();
    }
    let [closest, any] = classes;
    let mut rays = closest.rays.clone();
    if any.rays != rays {
        rays.extend_from_slice(&any.rays);
    }
    rays.shuffle(random);
    let truths = truths(&scene.triangles, &*first.tree, &rays);
    let edge_rays = at_edges(&scene.triangles, &rays, EDGE_RAYS, random);
    let open_edges = open_edges(&scene.triangles);
    for resident in &residents {
        let tree = &*resident.tree;
        let checked = || truths.iter().map(|truth| truth.error(tree));
        // They reach the edge at 1.
        let passed = found(tree, &edge_rays)
            .iter()
            .filter(|hit| hit.is_none_or(|hit| hit.hit.t > 1.01))
            .count();
        run.add(TreeChecked {
            method: resident.built.method.clone(),
            scene: scene.name.clone(),
            open_edges,
            rays: truths.len(),
            wrong: checked().filter(Option::is_none).count(),
            error: checked().flatten().fold(0.0, f64::max),
            edge_rays: edge_rays.len(),
            passed,
        });
    }
    run.progress.step();
    Ok(())
}

/// So many rays that their order is not learnt: few come again and again, in another order each time.
fn many(rays: &[Ray<f32>], random: &mut Pcg64) -> Vec<Ray<f32>> {
    let mut many = rays.to_vec();
    while !rays.is_empty() && many.len() < MANY {
        let start = many.len();
        many.extend_from_slice(rays);
        many[start..].shuffle(random);
    }
    many
}

fn found(tree: &dyn Tree, rays: &[Ray<f32>]) -> Vec<Option<TriangleHit>> {
    let mut found = vec![None; rays.len()];
    tree.closest(Tracing::Single, Culling::None, rays, &mut found);
    found
}

/// What is true of a ray.
struct Truth<'a> {
    ray: &'a Ray<f32>,
    of_ray: OfRay,
}

/// Asks the oracle about rays, from the first, and the triangles whose boxes each meets, until it was asked
/// about enough.
fn truths<'a>(
    triangles: &[Triangle<f32>],
    tree: &dyn Tree,
    rays: &'a [Ray<f32>],
) -> Vec<Truth<'a>> {
    let of = |ray: &'a Ray<f32>| {
        let mut met = Vec::new();
        tree.candidates(ray, &mut |triangle| {
            met.push(triangle);
            ray.tmax
        });
        met.sort_unstable();
        met.dedup();
        let met = || met.iter().map(|&id| (id, &triangles[id as usize]));
        (Truth { ray, of_ray: ask(0, ray, met()) }, met().count())
    };
    let (mut truths, mut pairs) = (Vec::new(), 0);
    for some in rays.chunks(256) {
        let found: Vec<_> = some.par_iter().map(of).collect();
        pairs += found.iter().map(|(_, pairs)| pairs).sum::<usize>();
        truths.extend(found.into_iter().map(|(truth, _)| truth));
        if pairs > PAIRS {
            break;
        }
    }
    truths
}

impl Truth<'_> {
    /// The relative error of `t` in a tree's answer; nothing where a decision is wrong.
    fn error(&self, tree: &dyn Tree) -> Option<f64> {
        let mut any = [false];
        tree.any(Tracing::Single, Culling::None, std::slice::from_ref(self.ray), &mut any);
        let closest = found(tree, std::slice::from_ref(self.ray))[0];
        if any[0] != self.of_ray.closest.is_some() || any[0] != closest.is_some() {
            return None;
        }
        let (Some(closest), Some(meant)) = (closest, self.of_ray.closest) else { return Some(0.0) };
        let t = |id: u32| {
            let truth = self.of_ray.truth.iter().find(|truth| truth.triangle == id);
            truth.map(|truth| truth.hit.t)
        };
        // Of triangles whose distances are one number in single precision either will do.
        let rounded = |t: f64| f32::from_f64(t);
        let (chosen, first) = (t(closest.triangle)?, t(meant)?);
        let error = (f64::from(closest.hit.t) - chosen).abs();
        let relative = if error == 0.0 { 0.0 } else { (error / chosen.abs()).min(f64::MAX) };
        (rounded(chosen) <= rounded(first)).then_some(relative)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};
    use trisect_catalog::find;
    use trisect_workloads::{Placement, Surface};

    use super::*;

    /// What nothing is wrong about, and what is told: exact arithmetic has no wrong decision and no crack.
    #[test]
    fn trees_are_held_to_the_truth() {
        let triangles = Surface::sphere(2).triangles::<f32>(&Placement::HERE);
        let mut random = Pcg64::seed_from_u64(1);
        let origin = [0.1_f32, 0.2, -0.1];
        let rays: Vec<_> = (0..500)
            .map(|_| Ray::<f32>::new(origin, [0, 1, 2].map(|_| random.random_range(-1.0..1.0))))
            .collect();
        let entry = find("exact").expect("it is in the catalogue");
        let tree = entry.tree(&triangles, Builder::Binned).expect("it takes every mesh");
        let truths = truths(&triangles, &*tree, &rays);
        assert_eq!(truths.len(), rays.len());
        assert!(truths.iter().all(|truth| truth.error(&*tree).is_some_and(|error| error < 1e-6)));
        let edges = at_edges(&triangles, &rays, 1000, &mut random);
        assert_eq!(edges.len(), 1000);
        assert!(found(&*tree, &edges).iter().all(|hit| hit.is_some_and(|hit| hit.hit.t < 1.01)));
        // A tree of other triangles is wrong about all rays that hit what it lacks.
        let half = entry.tree(&triangles[..triangles.len() / 2], Builder::Binned).expect("as well");
        let wrong = truths.iter().filter(|truth| truth.error(&*half).is_none()).count();
        assert!((100..400).contains(&wrong), "{wrong}");
    }

    #[test]
    fn few_rays_come_often() {
        let ray = |x: f32| Ray::<f32>::new([x, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let rays = many(&[ray(1.0), ray(2.0)], &mut Pcg64::seed_from_u64(1));
        assert_eq!(rays.len(), MANY);
        assert_eq!(rays.iter().filter(|ray| ray.o.x == 1.0).count(), MANY / 2);
        assert!(many(&[], &mut Pcg64::seed_from_u64(1)).is_empty());
    }
}
