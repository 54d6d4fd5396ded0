//! Every method against the exact oracle, on a mesh.

use trisect_catalog::{Kernels, entries};
use trisect_core::{Hit, Precision, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Culling, MethodInfo, Output, ReciprocalKind};
use trisect_oracle::{Oracle, Truth};
use trisect_workloads::Mesh;

/// Rays whose true hit is conditioned worse than this are not held to anything.
const WORST_CONDITION: f64 = 1e4;

/// Methods that are not held to the bound on a mesh, whose rays start a thousand edges away: their
/// denominator is a sum of volumes, or of areas, that grow with the distance and cancel; and the one whose
/// axis is that of the mesh and not of the triangle.
const FAR_OFF: [&str; 7] = [
    "segura-feito",
    "signed-areas",
    "signed-volumes",
    "plucker",
    "plucker-translated",
    "plucker-tolerance",
    "wald-fixed-axis",
];

/// The closest true hit of a ray: its triangle, and all there is to know of the pair.
type Closest = Option<(usize, Truth)>;

fn bunny_rays(mesh: &Mesh) -> Vec<Ray<f32>> {
    let side = 9;
    let mut rays = trisect_workloads::primary(mesh, side, side).rays;
    let closest: Vec<_> = rays.iter().map(|ray| closest_f32(ray, &mesh.triangles)).collect();
    let mut next = closest.into_iter();
    let mut look_up = |_: &Ray<f32>| next.next().flatten();
    let diffuse = trisect_workloads::diffuse_bounce(3, mesh, side, side, &mut look_up);
    rays.extend(trisect_workloads::random_through_box(3, mesh, side * side).rays);
    rays.extend(diffuse.rays);
    rays
}

fn closest_f32(ray: &Ray<f32>, triangles: &[Triangle<f32>]) -> Option<(usize, Hit<f32>)> {
    let (number, answer) = Oracle::default().closest(ray, triangles)?;
    Some((number, answer.hit?))
}

/// Rays that a variant was held to, and those among them on which it named a neighbour.
#[derive(Default)]
struct Tally {
    held: usize,
    neighbours: usize,
}

/// The condition numbers of `t`, `beta` and `gamma` for a method that stores its planes in world
/// space: as the oracle's, but with `|O| + |A|` in place of `|O − A|`, since the two meet only in
/// the test and cancel there. Never smaller than the oracle's, which sees the difference alone.
fn condition_in_the_world<E: Precision>(
    ray: &Ray<E>,
    triangle: &Triangle<E>,
    truth: &Truth,
) -> [f64; 3] {
    let wide = |v: Vec3<E>| v.map(Scalar::to_f64);
    let [a, b, c] = triangle.corners().map(wide);
    let (o, d, e1, e2) = (wide(ray.o), wide(ray.d), b - a, c - a);
    let det = e1.dot(d.cross(e2)).abs();
    let [o, a, d, e1, e2] = [o, a, d, e1, e2].map(|v| v.map(f64::abs));
    let s = o + a;
    // The volumes with every factor and term made absolute.
    let cross = |u: Vec3<f64>, v: Vec3<f64>| {
        Vec3::new(u.y * v.z + u.z * v.y, u.z * v.x + u.x * v.z, u.x * v.y + u.y * v.x)
    };
    let of_det = e1.dot(cross(d, e2));
    let volumes = [
        (e2.dot(cross(s, e1)), truth.t),
        (s.dot(cross(d, e2)), truth.beta),
        (d.dot(cross(s, e1)), truth.gamma),
    ];
    volumes.map(|(of_x, x)| (of_x + x.abs() * of_det) / det)
}

fn check<E: Precision>(
    info: &MethodInfo,
    kernels: &Kernels<E>,
    rays: &[Ray<E>],
    triangles: &[Triangle<E>],
    truth: &[Closest],
) {
    let name = info.name;
    // A method that has one axis for all triangles may refuse a mesh, and claims nothing about those
    // that lie badly to the axis.
    let Ok(scene) = (kernels.prepare)(triangles, rays) else { return };
    for finder in &kernels.finders {
        let variant = &finder.variant;
        if !variant.is_available() {
            continue;
        }
        // How far an answer may be off, per unit of condition. The estimate and one Newton step
        // fall short of the division by a few roundings.
        let newton = match variant.reciprocal {
            ReciprocalKind::True => 0.0,
            ReciprocalKind::Newton => 4.0,
        };
        let unit = (info.error_factor + newton) * E::UNIT_ROUNDOFF;
        let found = finder.closest(&scene, Culling::None, rays.len());
        let mut tally = Tally::default();
        for (i, (found, truth)) in found.iter().zip(truth).enumerate() {
            let place = format!("{name}, {variant:?}, ray {i}");
            let Some((number, truth)) = truth else {
                assert_eq!(*found, None, "{place}: nothing is there");
                continue;
            };
            if truth.condition.max() >= WORST_CONDITION {
                continue;
            }
            let condition = condition_in_the_world(&rays[i], &triangles[*number], truth);
            tally.held += 1;
            let (found, hit) = found.unwrap_or_else(|| panic!("{place}: misses {truth:?}"));
            if found as usize == *number {
                let pairs = [
                    (hit.t, truth.t, condition[0]),
                    (hit.beta, truth.beta, condition[1]),
                    (hit.gamma, truth.gamma, condition[2]),
                ];
                let given = if info.gives(Output::Barycentrics) { 3 } else { 1 };
                for (found, exact, condition) in pairs.into_iter().take(given) {
                    assert!(
                        (found - exact).abs() <= unit * condition,
                        "{place}: {found} instead of {exact}, {} times the bound",
                        (found - exact).abs() / (unit * condition)
                    );
                }
            } else {
                // Another triangle is right as well where the oracle cannot tell the two hits
                // apart by more than the bound: so it is at a shared edge, which no method here
                // meets at exactly one side.
                let named = &triangles[found as usize];
                let other = Oracle::default().truth(&rays[i], named);
                let others = condition_in_the_world(&rays[i], named, &other);
                let bound = unit * (condition[0] + others[0]);
                assert!(
                    (other.t - truth.t).abs() <= bound,
                    "{place}: triangle {found} at {other:?} instead of {number} at {truth:?}"
                );
                tally.neighbours += 1;
            }
        }
        assert!(tally.held > rays.len() / 3, "{name}: {} rays show little", tally.held);
        assert!(tally.neighbours * 50 <= tally.held, "{name}: {} neighbours", tally.neighbours);
    }
}

#[test]
fn closest_hits_on_the_bunny_are_the_oracles() {
    let bunny = trisect_workloads::bunny();
    let rays = bunny_rays(&bunny);
    let rays64: Vec<Ray<f64>> = rays.iter().map(|&ray| ray.into()).collect();
    let triangles64: Vec<Triangle<f64>> = bunny.triangles.iter().map(|&t| t.into()).collect();
    let mut oracle = Oracle::default();
    let truth: Vec<Closest> = rays
        .iter()
        .map(|ray| {
            let (number, _) = oracle.closest(ray, &bunny.triangles)?;
            Some((number, oracle.truth(ray, &bunny.triangles[number])))
        })
        .collect();
    let mut wrong = Vec::new();
    for entry in entries() {
        let held = std::panic::catch_unwind(|| {
            check(&entry.info, &entry.f32, &rays, &bunny.triangles, &truth);
            check(&entry.info, &entry.f64, &rays64, &triangles64, &truth);
        });
        if held.is_err() && !FAR_OFF.contains(&entry.info.name) {
            wrong.push(entry.info.name);
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}; the reasons stand above");
}

#[test]
fn the_oracle_says_so_of_its_own_answer() {
    let triangle = Triangle::<f32>::new([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let ray = Ray::<f32>::new([0.25, 0.25, -3.0], [0.0, 0.0, 1.0]);
    let (number, answer) = Oracle::default().closest(&ray, &[triangle]).expect("aimed inside");
    let truth = Oracle::default().truth(&ray, &triangle);
    let hit = answer.hit.expect("a closest hit is one");
    assert_eq!((number, hit.t.to_f64()), (0, truth.t));
    assert!(truth.condition.max() < WORST_CONDITION);
}
