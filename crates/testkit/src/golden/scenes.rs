//! The scenes of the cases: rays, triangles, and what must come of each ray.

use trisect_core::{Float, FloatFormat, Hit, Ray, Scalar, Triangle, Vec3};
use trisect_method::Culling;
use trisect_workloads::{Placement, Stream, Surface};

use super::cases::{Each, Make, Target};
use crate::kernels::Results;

/// Rays against triangles, carried in f64.
#[derive(Clone)]
pub(super) struct Scene {
    pub(super) rays: Vec<Ray<f64>>,
    pub(super) triangles: Vec<Triangle<f64>>,
    pub(super) culling: Culling,
    /// Of each ray.
    pub(super) wanted: Vec<Wanted>,
}

/// What must come of a ray, besides that no hit holds a NaN or an infinity.
#[derive(Clone, Copy, Debug)]
pub(super) enum Wanted {
    Anything,
    Miss,
    /// It hits so many triangles or more.
    AtLeast(usize),
    /// It hits, with these numbers but for so many units in the last place.
    Ulps(Hit<f64>, u64),
    /// It hits, with these numbers but for a relative error.
    Near(Hit<f64>, f64),
    /// The closest hit, of equal ones that with the lowest number, is of this triangle.
    Closest(u32),
    /// It does not hit this triangle.
    Not(u32),
}

/// A precision as the scenes need it.
pub(super) trait Golden: Float {
    fn up(self) -> Self;
    fn down(self) -> Self;
    /// The exponents of the smallest and the largest power of two.
    const EXPONENTS: [f64; 2];
}

impl Golden for f32 {
    const EXPONENTS: [f64; 2] = [-149.0, 127.0];
    fn up(self) -> Self {
        self.next_up()
    }
    fn down(self) -> Self {
        self.next_down()
    }
}

impl Golden for f64 {
    const EXPONENTS: [f64; 2] = [-1074.0, 1023.0];
    fn up(self) -> Self {
        self.next_up()
    }
    fn down(self) -> Self {
        self.next_down()
    }
}

/// How many numbers of the precision lie between two.
fn ulps(precision: FloatFormat, a: f64, b: f64) -> u64 {
    match precision {
        FloatFormat::F32 => {
            let [a, b] = [a, b].map(f32::from_f64);
            u64::from(a.to_bits().abs_diff(b.to_bits()))
        }
        FloatFormat::F64 => a.to_bits().abs_diff(b.to_bits()),
    }
}

impl Scene {
    fn new(
        rays: Vec<Ray<f64>>,
        triangles: Vec<Triangle<f64>>,
        wanted: impl Fn(usize) -> Wanted,
    ) -> Self {
        let wanted = (0..rays.len()).map(wanted).collect();
        Self { rays, triangles, culling: Culling::None, wanted }
    }

    /// Why `results` are not what must come; of a method that gives no weights `t` alone counts.
    pub(super) fn judge(
        &self,
        results: &Results,
        precision: FloatFormat,
        weighs: bool,
    ) -> Result<(), String> {
        let given = |hit: Hit<f64>| {
            let all = [hit.t, hit.beta, hit.gamma];
            all.into_iter().take(if weighs { 3 } else { 1 })
        };
        let odd = results.hits().iter().find(|found| !given(found.hit).all(f64::is_finite));
        if let Some(odd) = odd {
            return Err(format!("{odd:?} is not finite"));
        }
        for (number, (ray, &wanted)) in self.rays.iter().zip(&self.wanted).enumerate() {
            let found = results.of_ray(number);
            let all = |hit: Hit<f64>, near: &dyn Fn(f64, f64) -> bool| {
                !found.is_empty()
                    && found.iter().all(|found| {
                        given(found.hit).zip(given(hit)).all(|(found, exact)| near(found, exact))
                    })
            };
            let good = match wanted {
                Wanted::Anything => true,
                Wanted::Miss => found.is_empty(),
                Wanted::AtLeast(least) => found.len() >= least,
                Wanted::Ulps(hit, most) => all(hit, &|found, exact| {
                    found == exact || ulps(precision, found, exact) <= most
                }),
                Wanted::Near(hit, most) => {
                    all(hit, &|found, exact| (found - exact).abs() <= most * exact.abs())
                }
                Wanted::Closest(triangle) => found
                    .iter()
                    .min_by(|a, b| a.hit.t.total_cmp(&b.hit.t))
                    .is_some_and(|closest| closest.triangle == triangle),
                Wanted::Not(triangle) => found.iter().all(|found| found.triangle != triangle),
            };
            if !good {
                return Err(format!(
                    "{wanted:?} is wanted, found {found:?}, ray {number}: {ray:?}"
                ));
            }
        }
        Ok(())
    }
}

fn widened<E: Float>(ray: &Ray<E>) -> Ray<f64> {
    ray.map(|&x| x.to_f64())
}

fn rounded<E: Float>(v: Vec3<f64>) -> Vec3<f64> {
    v.map(|x| E::from_f64(x).to_f64())
}

fn unit(v: Vec3<f64>) -> Vec3<f64> {
    v.scale(1.0 / v.dot(v).sqrt())
}

/// The scenes of a generator.
pub(super) fn made<E: Golden>(make: &Make) -> Vec<Scene> {
    match make {
        Make::Surfaces { surfaces, at, rays, pairs, seed, offset, from_the_middle, each } => {
            let placement = Placement { scale: 1.0, offset: Vec3::from(*offset) };
            let aims = surfaces.iter().flat_map(|shape| at.iter().map(move |&at| (shape, at)));
            aims.map(|(shape, at)| {
                let mut surface = shape.surface();
                if *from_the_middle {
                    surface.inside = 0.0;
                }
                let most = pairs.map_or(usize::MAX, |pairs| pairs / surface.faces.len());
                let budget = (*rays).min(most);
                at_surface::<E>(&surface, at, &placement, *seed, budget, *each)
            })
            .collect()
        }
        Make::Crossing { divisions, rays } => vec![crossing(*divisions, *rays)],
        Make::Quad { side, offset } => vec![quad::<E>(*side, Vec3::from(*offset))],
        Make::Grid { side, ulps } => vec![grid::<E>(*side, *ulps)],
        Make::Collinear { triangles, seed } => vec![collinear::<E>(*triangles, *seed)],
        Make::Spawned { triangles, rays, offset, power, seed } => {
            let mut stream = Stream::new("golden/spawned", *seed);
            // A ray is of interest to one triangle: small meshes.
            (0..triangles.div_ceil(SPAWNING))
                .map(|_| spawned::<E>(&mut stream, rays / triangles, *offset, *power))
                .collect()
        }
        Make::Bits { rays, triangles, scenes, seed } => {
            (0..*scenes).map(|number| any_bits::<E>(*rays, *triangles, seed + number)).collect()
        }
        Make::Sizes { rays, triangles, scenes, seed } => {
            (0..*scenes).map(|number| any_size::<E>(*rays, *triangles, seed + number)).collect()
        }
        Make::Random { rays, triangles, seed } => triangles
            .iter()
            .map(|&triangles| {
                let made = trisect_workloads::random(*seed, *rays, triangles);
                let rays = made.rays.iter().map(|&ray| ray.into()).collect();
                let triangles = made.triangles.iter().map(|&triangle| triangle.into()).collect();
                Scene::new(rays, triangles, |_| Wanted::Anything)
            })
            .collect(),
    }
}

/// About `budget` rays spread over what they are aimed at.
fn at_surface<E: Golden>(
    surface: &Surface,
    target: Target,
    placement: &Placement,
    seed: u64,
    budget: usize,
    each: Each,
) -> Scene {
    // Corners are rounded to the precision, whatever is done with them later.
    let triangles: Vec<Triangle<f64>> = surface
        .triangles::<E>(placement)
        .into_iter()
        .map(|triangle| triangle.map(|x| x.to_f64()))
        .collect();
    let of = |first: u32| match each {
        Each::Hits => Wanted::AtLeast(1),
        Each::HitsTheFirst => Wanted::Closest(first),
        Each::Anything => Wanted::Anything,
    };
    let Some(aim) = target.aim() else {
        let rays = surface.outwards::<E>(placement, seed, budget);
        return Scene::new(rays.iter().map(widened).collect(), triangles, |_| of(0));
    };
    let features = surface.inner_features(aim);
    let step = features.len().div_ceil(budget.max(1));
    let repeat = (budget / features.len()).max(1);
    let (mut rays, mut wanted) = (Vec::new(), Vec::new());
    for feature in features.iter().step_by(step) {
        let first = u32::try_from(feature.faces[0]).expect("triangles have numbers of 32 bits");
        for ray in surface.aimed::<E>(feature, placement, seed, repeat) {
            rays.push(widened(&ray));
            wanted.push(of(first));
        }
    }
    Scene { rays, triangles, culling: Culling::None, wanted }
}

fn crossing(divisions: usize, rays: usize) -> Scene {
    let mut stream = Stream::new("golden/crossing", 0);
    // Whole sixty-fourths: sums and differences are exact in f32.
    let mut whole = |low: f64, high: f64| (stream.range_f64(low, high) * 64.0).floor() / 64.0;
    let rays = (0..rays)
        .map(|_| {
            // Not at the border, which no triangle lies beyond.
            let target = Vec3::new(whole(-0.98, 1.0), 0.0, 0.0);
            let d = Vec3::new(whole(-2.0, 2.0), whole(-2.0, 2.0), whole(-2.0, -0.5));
            Ray::<f64>::new(target - d, d)
        })
        .collect();
    let triangles = Surface::square(divisions).triangles::<f64>(&Placement::HERE);
    Scene::new(rays, triangles, |_| Wanted::AtLeast(1))
}

fn quad<E: Golden>(side: usize, offset: Vec3<f64>) -> Scene {
    // Two half-diagonals of length 1 at a right angle, along no axis.
    let (p, q) = (Vec3::new(0.48, 0.6, 0.64), Vec3::new(0.64, -0.8, 0.27));
    let q = unit(q - p.scale(p.dot(q)));
    let n = p.cross(q);
    let [a, b, c, d] = [p, q, -p, -q].map(|corner| rounded::<E>(corner + offset));
    let triangles = vec![Triangle { a, b, c }, Triangle { a, b: c, c: d }];
    // The middle of the diagonal, as the precision has it.
    let middle = rounded::<E>((a + c).scale(0.5));
    let place = |k: usize| (2 * k + 1) as f64 / side as f64 - 1.0;
    let rays = (0..side * side)
        .map(|number| {
            // A square folded to an octahedron's upper half, and that blown up to a hemisphere.
            let (u, v) = (place(number / side), place(number % side));
            let (x, y) = (0.5 * (u + v), 0.5 * (u - v));
            let z = 1.0 - x.abs() - y.abs();
            let up = unit(p.scale(x) + q.scale(y) + n.scale(z));
            let o = rounded::<E>(middle + up);
            Ray::<f64>::new(o, rounded::<E>(middle - o))
        })
        .collect();
    Scene::new(rays, triangles, |_| Wanted::AtLeast(1))
}

/// The unit triangle of an edge, and a ray to a quarter of both its edges from as far away.
pub(super) fn sized<E: Golden>(edge: f64) -> Scene {
    let edge = E::from_f64(edge).to_f64();
    let zero = Vec3::new(0.0, 0.0, 0.0);
    let triangle = Triangle { a: zero, b: Vec3 { x: edge, ..zero }, c: Vec3 { y: edge, ..zero } };
    let ray = Ray::<f64>::new([edge / 4.0, edge / 4.0, -edge], [0.0, 0.0, 1.0]);
    let hit = Hit { t: edge, beta: 0.25, gamma: 0.25 };
    Scene::new(vec![ray], vec![triangle], |_| Wanted::Near(hit, 1e-3))
}

fn grid<E: Golden>(side: u16, most: u64) -> Scene {
    let unit = Triangle::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let at = |k: u16| E::from_f64((f64::from(k) + 0.5) / (2.0 * f64::from(side) + 1.0)).to_f64();
    let places = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
    let (rays, wanted) = places
        .map(|(i, j)| {
            let (beta, gamma) = (at(i), at(j));
            let ray = Ray::<f64>::new([beta, gamma, -1.0], [0.0, 0.0, 1.0]);
            (ray, Wanted::Ulps(Hit { t: 1.0, beta, gamma }, most))
        })
        .unzip();
    Scene { rays, triangles: vec![unit], culling: Culling::None, wanted }
}

fn collinear<E: Golden>(triangles: usize, seed: u64) -> Scene {
    let mut stream = Stream::new("golden/collinear", seed);
    // With three bits to spare, so that small multiples are exact and sums are not.
    let spare = f64::from(E::SIGNIFICANT_BITS - 3).exp2();
    let mut rays = Vec::new();
    let mut lines = Vec::new();
    for _ in 0..triangles {
        // Small whole numbers for a direction, one of them zero now and then.
        let direction = Vec3::from([0, 1, 2].map(|_| stream.below(15) as f64 - 7.0));
        let mut along = || {
            let size = [1.0, 0.125, 64.0][stream.below(3)];
            direction.scale(size * (stream.range_f64(-1.0, 1.0) * spare).round() / spare)
        };
        let [a, b, c] = [along(), along(), along()];
        lines.push(Triangle { a, b, c });
        let on_line = rounded::<E>((c - a).mul_add(stream.unit_f64(), a));
        for target in [a, b, on_line] {
            let o = rounded::<E>(stream.cube().scale(2.0));
            rays.push(Ray::<f64>::new(o, rounded::<E>(target - o)));
        }
    }
    Scene::new(rays, lines, |_| Wanted::Miss)
}

const SPAWNING: usize = 50;

fn spawned<E: Golden>(stream: &mut Stream, each: usize, offset: f64, power: f64) -> Scene {
    let (mut rays, mut triangles, mut wanted) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..SPAWNING {
        // Coordinates of one size, and no sliver: the offset is measured by the largest of them.
        let size = power_of_ten(stream.range_f64(-power, power));
        let (triangle, normal) = loop {
            let [a, b, c] = [0; 3].map(|_| rounded::<E>(stream.cube().scale(size)));
            let (e1, e2) = (b - a, c - a);
            let normal = e1.cross(e2);
            if normal.dot(normal) > 0.0625 * e1.dot(e1) * e2.dot(e2) {
                break (Triangle { a, b, c }, unit(normal));
            }
        };
        let [a, b, c] = triangle.corners();
        let away = offset
            * E::UNIT_ROUNDOFF
            * [a, b, c].into_iter().map(Vec3::largest_magnitude).fold(0.0, f64::max);
        for _ in 0..each {
            let beta = stream.unit_f64();
            let gamma = (1.0 - beta) * stream.unit_f64();
            let point = rounded::<E>((b - a).mul_add(beta, (c - a).mul_add(gamma, a)));
            // Grazing directions are left out: on which side they lead is for the last bit to say.
            let d = loop {
                let d = rounded::<E>(stream.cube());
                if d.dot(normal).abs() > d.dot(d).sqrt() / 64.0 {
                    break d;
                }
            };
            let side = if d.dot(normal) > 0.0 { away } else { -away };
            rays.push(Ray::<f64>::new(rounded::<E>(normal.mul_add(side, point)), d));
            wanted.push(Wanted::Not(u32::try_from(number).expect("few")));
        }
        triangles.push(triangle);
    }
    Scene { rays, triangles, culling: Culling::None, wanted }
}

/// Ten to a power, by products: no function that machines round differently.
fn power_of_ten(power: f64) -> f64 {
    let whole = power.floor();
    // 10^x is near enough to a line from 1 to 10: what counts is that all sizes occur.
    let rest = 1.0 + 9.0 * (power - whole);
    let factor = if whole < 0.0 { 0.1 } else { 10.0 };
    let steps = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
    steps.into_iter().filter(|&step| step < whole.abs()).fold(rest, |product, _| product * factor)
}

/// A number that hurts: any bits, a power of two, zero, infinity.
fn hurtful<E: Golden>(stream: &mut Stream) -> f64 {
    let bits = stream.bits();
    let number = match stream.below(8) {
        0..4 => E::from_upper_bits(bits).to_f64(),
        4..6 => {
            let [low, high] = E::EXPONENTS;
            stream.range_f64(low, high + 1.0).floor().exp2()
        }
        6 => [0.0, 1.0][stream.below(2)],
        _ => [f64::INFINITY, 0.0][stream.below(2)],
    };
    if bits & 1 == 1 { -number } else { number }
}

fn any_bits<E: Golden>(rays: usize, triangles: usize, seed: u64) -> Scene {
    let mut stream = Stream::new("golden/bits", seed);
    let mut vector = || Vec3::from([0; 3].map(|_| hurtful::<E>(&mut stream)));
    let corners: Vec<_> = (0..3 * triangles).map(|_| vector()).collect();
    let triangles =
        corners.chunks(3).map(|v| Triangle { a: v[0], b: v[1], c: v[2] }).collect::<Vec<_>>();
    let rays = (0..rays)
        .map(|number| {
            let [o, d, ends] = [0; 3].map(|_| vector());
            // Aimed at a corner, with an open interval, a ray has a chance.
            if number % 2 == 0 {
                let (tmin, tmax) = (f64::NEG_INFINITY, f64::INFINITY);
                let target = triangles[number % triangles.len()].a;
                Ray { o, d: rounded::<E>(target - o), tmin, tmax }
            } else {
                Ray { o, d, tmin: ends.x, tmax: ends.y }
            }
        })
        .collect();
    Scene::new(rays, triangles, |_| Wanted::Anything)
}

fn any_size<E: Golden>(rays: usize, triangles: usize, seed: u64) -> Scene {
    let mut stream = Stream::new("golden/sizes", seed);
    let [low, high] = E::EXPONENTS;
    let power = |stream: &mut Stream| stream.range_f64(low, high).floor().exp2();
    let size = power(&mut stream);
    let mut vector = |size: f64| rounded::<E>(stream.cube().scale(size));
    let triangles: Vec<_> = (0..triangles)
        .map(|_| Triangle { a: vector(size), b: vector(size), c: vector(size) })
        .collect();
    let starts: Vec<_> = (0..rays).map(|_| vector(size)).collect();
    let rays = starts
        .into_iter()
        .enumerate()
        .map(|(number, o)| {
            let Triangle { a, b, c } = triangles[number % triangles.len()];
            let middle = a.scale(0.25) + b.scale(0.25) + c.scale(0.5);
            // Directions of the size of the scene, or of any other.
            let speed = if number % 2 == 0 { 1.0 } else { power(&mut stream) / size };
            let d = rounded::<E>((middle - o).scale(speed));
            Ray { o, d, tmin: f64::NEG_INFINITY, tmax: f64::INFINITY }
        })
        .collect();
    Scene::new(rays, triangles, |_| Wanted::Anything)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_method_that_never_hits_is_judged() {
        let hit = Hit { t: 1.0, beta: 0.25, gamma: 0.25 };
        for (wanted, good) in [
            (Wanted::Anything, true),
            (Wanted::Miss, true),
            (Wanted::Not(0), true),
            (Wanted::AtLeast(1), false),
            (Wanted::Ulps(hit, 0), false),
            (Wanted::Near(hit, 1.0), false),
            (Wanted::Closest(0), false),
        ] {
            let scene = Scene { wanted: vec![wanted], ..sized::<f32>(1.0) };
            let judged = scene.judge(&Results::default(), FloatFormat::F32, true);
            assert_eq!(judged.is_ok(), good, "{wanted:?}");
        }
    }

    #[test]
    fn neighbours_are_a_unit_in_the_last_place_apart() {
        assert_eq!(ulps(FloatFormat::F32, 1.0, f64::from(1.0_f32.next_up())), 1);
        assert_eq!(ulps(FloatFormat::F64, 1.0, 1.0_f64.next_down()), 1);
    }

    /// They start on the side of the plane that they lead to.
    #[test]
    fn spawned_rays_lead_away() {
        let mut stream = Stream::new("golden/test", 1);
        let scene = spawned::<f32>(&mut stream, 2, 64.0, 8.0);
        for (ray, wanted) in scene.rays.iter().zip(&scene.wanted) {
            let &Wanted::Not(number) = wanted else { panic!("{wanted:?}") };
            let triangle = scene.triangles[number as usize];
            let height = (ray.o - triangle.a).dot(triangle.normal());
            assert!(height * ray.d.dot(triangle.normal()) > 0.0, "{ray:?}");
        }
    }
}
