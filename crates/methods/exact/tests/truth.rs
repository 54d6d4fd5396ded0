//! Every decision and every value against the oracle, on every width and instruction set, plain and
//! fused, and in both arrangements; and what a screen says of pairs.

use trisect_core::{
    Float, Hit, Lanes, LanesVisitor, Precision, Ray, Scalar, Token, Triangle, Vec3,
};
use trisect_exact::{Exact, ExactInTrees, Width};
use trisect_kernels::{BLOCK, PADDING, Packets, PreparedTriangles, one_ray, one_triangle};
use trisect_method::{
    Culling, Deferred, ExactMethod, Interval, Record as _, Screened, TrueDivision, rows,
};
use trisect_oracle::Oracle;
use trisect_workloads::{Stream, Stress};

/// Rays, and triangles, of a scene: every ray is made for one of the triangles.
const SIDE: usize = 20;

/// The hits of the rays, ray by ray.
type Answers = Vec<Option<[u64; 3]>>;

fn bits<E: Scalar>(hit: &Hit<E>) -> [u64; 3] {
    // −0 and 0 are one answer.
    [hit.t, hit.beta, hit.gamma].map(|x| (x.to_f64() + 0.0).to_bits())
}

/// A scene and its truth.
struct Scene<E> {
    rays: Vec<Ray<E>>,
    triangles: Vec<Triangle<E>>,
    truth: Answers,
}

impl<E: Precision> Scene<E> {
    fn new(pairs: Vec<(Ray<E>, Triangle<E>)>) -> Self {
        let (rays, triangles): (Vec<_>, Vec<_>) = pairs.into_iter().unzip();
        let mut truth = Vec::new();
        let mut oracle = Oracle::default();
        for ray in &rays {
            for triangle in &triangles {
                truth.push(oracle.intersect(ray, triangle).hit.map(|hit| bits(&hit)));
            }
        }
        Self { rays, triangles, truth }
    }

    /// Pairs of a stress family at a level.
    fn stressed(family: Stress, level: f64, seed: u64) -> Self {
        Self::new(family.pairs::<E>(seed, level, SIDE))
    }
}

/// Runs a scene on all lane types and counts answers that are not the truth.
struct Wrong<'a, M, E: Precision> {
    scene: &'a Scene<E>,
    tests: u64,
    misjudged: u64,
    misscreened: u64,
    first: Option<String>,
    method: core::marker::PhantomData<M>,
}

type Form = Deferred<TrueDivision, true>;

impl<M: ExactMethod, E: Precision> Wrong<'_, M, E> {
    fn judge(&mut self, found: &Answers, kernel: &str) {
        self.tests += found.len() as u64;
        for (place, (found, truth)) in found.iter().zip(&self.scene.truth).enumerate() {
            if found != truth {
                self.misjudged += 1;
                let (ray, triangle) = (place / SIDE, place % SIDE);
                self.first.get_or_insert_with(|| {
                    format!(
                        "{kernel}: {:?} {:?} {:?} instead of {:?}",
                        self.scene.rays[ray],
                        self.scene.triangles[triangle],
                        found.map(|x| x.map(f64::from_bits)),
                        truth.map(|x| x.map(f64::from_bits)),
                    )
                });
            }
        }
    }
}

fn note<L: Lanes>(mask: L::Mask, hit: Hit<L>, mut found: impl FnMut(usize, [u64; 3])) {
    let mut rows = [[L::Elem::from_f64(0.0); BLOCK]; 3];
    let [t, beta, gamma] = &mut rows;
    hit.t.store(t);
    hit.beta.store(beta);
    hit.gamma.store(gamma);
    for lane in (0..BLOCK).filter(|lane| L::bits(mask) >> lane & 1 == 1) {
        let [t, beta, gamma] = [0, 1, 2].map(|row: usize| rows[row][lane]);
        found(lane, bits(&Hit { t, beta, gamma }));
    }
}

impl<M: ExactMethod, E: Precision> LanesVisitor for Wrong<'_, M, E> {
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        let Some(token) = L::Token::detect() else { return };
        let same = |x: E| L::Elem::from_f64(x.to_f64());
        let rays: Vec<Ray<L::Elem>> = self.scene.rays.iter().map(|r| r.map(|&x| same(x))).collect();
        let triangles: Vec<Triangle<L::Elem>> =
            self.scene.triangles.iter().map(|t| t.map(|&x| same(x))).collect();
        let prepared =
            PreparedTriangles::<M, L::Elem>::new(&triangles).expect("it takes all meshes");
        let packets = Packets::new::<M>(&rays);
        let mut answers: Answers = vec![None; SIDE * SIDE];
        token.run(
            #[inline(always)]
            || {
                for (number, ray) in rays.iter().enumerate() {
                    one_ray::<M, L, Form>(
                        token,
                        ray,
                        &prepared,
                        Culling::None,
                        #[inline(always)]
                        |tested, mask, hit| {
                            note::<L>(mask, hit, |lane, hit| {
                                let triangle = prepared.number(tested.triangle_place + lane);
                                answers[number * SIDE + triangle as usize] = Some(hit);
                            });
                        },
                    );
                }
            },
        );
        let name = format!("{}×{} {} {}", E::FORMAT, L::N, L::Token::INSTRUCTION_SET, L::FUSED);
        self.judge(&answers, &format!("one ray, {name}"));
        let mut answers: Answers = vec![None; SIDE * SIDE];
        token.run(
            #[inline(always)]
            || {
                one_triangle::<M, L, Form>(
                    token,
                    &packets,
                    &prepared,
                    Culling::None,
                    #[inline(always)]
                    |tested, mask, hit| {
                        note::<L>(mask, hit, |lane, hit| {
                            let ray = packets.number(tested.ray_place + lane);
                            assert!(ray != PADDING, "a lane without a ray hits");
                            let triangle = prepared.number(tested.triangle_place);
                            answers[ray as usize * SIDE + triangle as usize] = Some(hit);
                        });
                    },
                );
            },
        );
        self.judge(&answers, &format!("one triangle, {name}"));
        for (number, ray) in rays.iter().enumerate() {
            for first in (0..SIDE).step_by(L::N) {
                let screens = token.run(
                    #[inline(always)]
                    || screen::<M, L>(token, ray, &triangles[first..]),
                );
                let lanes = L::N.min(SIDE - first);
                for (lane, said) in screens.into_iter().enumerate().take(lanes) {
                    let truth = self.scene.truth[number * SIDE + first + lane];
                    self.tests += 1;
                    if !holds(said, truth.map(|bits| f64::from_bits(bits[0]))) {
                        self.misscreened += 1;
                        let triangle = &triangles[first + lane];
                        self.first.get_or_insert_with(|| {
                            format!("screen, {name}: {ray:?} {triangle:?} {said:?}, {truth:?}")
                        });
                    }
                }
            }
        }
    }
}

/// What a screen says of a lane: nothing for a certain miss, between which numbers `t` lies for a certain
/// hit, and else that it is open.
type Said = Option<Option<(f64, f64)>>;

/// Screens a ray and triangles, one for each lane; where there are fewer the last comes again.
#[inline(always)]
fn screen<M: ExactMethod, L: Lanes>(
    token: L::Token,
    ray: &Ray<L::Elem>,
    triangles: &[Triangle<L::Elem>],
) -> [Said; BLOCK] {
    let prepared = rows::<M::Prepared, L::Elem, BLOCK>(|lane| {
        M::prepare(&triangles[lane.min(triangles.len() - 1)].or_nothing(), 0)
    });
    let prepared = M::Prepared::map(&prepared, |row| L::load(token, row));
    let ray = Ray::<L>::splat(token, ray);
    let mut said = [None; BLOCK];
    M::screen(
        &M::prepare_ray(&ray, 0),
        &prepared,
        Interval::of(&ray),
        Culling::None,
        |Screened { certain, open, low, high }| {
            let mut ends = [[L::Elem::from_f64(0.0); BLOCK]; 2];
            low.store(&mut ends[0]);
            high.store(&mut ends[1]);
            let certain = L::bits(certain);
            for lane in (0..L::N).filter(|lane| (certain | open) >> lane & 1 == 1) {
                let [low, high] = [ends[0][lane].to_f64(), ends[1][lane].to_f64()];
                said[lane] = Some((certain >> lane & 1 == 1).then_some((low, high)));
            }
        },
    );
    said
}

/// Whether what a screen says is so of a pair with that `t`, or that misses.
fn holds(said: Said, truth: Option<f64>) -> bool {
    match (said, truth) {
        // Rounding keeps the order of numbers, of which the ends are two.
        (Some(Some((low, high))), Some(t)) => low <= t && t <= high,
        (Some(Some(_)), None) => false,
        (Some(None), _) => true,
        (None, truth) => truth.is_none(),
    }
}

fn run<M: ExactMethod, E: Precision>(scene: &Scene<E>) -> Wrong<'_, M, E> {
    let method = core::marker::PhantomData;
    let mut wrong = Wrong { scene, tests: 0, misjudged: 0, misscreened: 0, first: None, method };
    E::visit_all(&mut wrong);
    wrong
}

fn is_right<E: Precision>(scene: &Scene<E>, what: &str) -> u64 {
    fn by<M: ExactMethod, E: Precision>(scene: &Scene<E>, what: &str) -> u64 {
        let Wrong { tests, misjudged, misscreened, first, .. } = run::<M, E>(scene);
        assert_eq!((misjudged, misscreened), (0, 0), "{what}: {first:?}");
        tests
    }
    by::<Exact, E>(scene, what) + by::<ExactInTrees, E>(scene, what)
}

/// Scenes per family and level; the long run has its own number.
fn scenes() -> u64 {
    std::env::var("TRISECT_EXACT_SCENES").ok().and_then(|text| text.parse().ok()).unwrap_or(2)
}

fn stress_families<E: Precision>() {
    let mut tests = 0;
    for family in Stress::ALL {
        for level in family.levels::<E>() {
            for seed in 0..scenes() {
                let scene = Scene::stressed(family, level, seed);
                tests += is_right::<E>(&scene, &format!("{} {level}", family.name()));
            }
        }
    }
    println!("{}: {tests} tests", E::FORMAT);
}

#[test]
fn f32_is_right_on_all_stress_families() {
    stress_families::<f32>();
}

#[test]
fn f64_is_right_on_all_stress_families() {
    stress_families::<f64>();
}

/// Numbers over the whole range of exponents, ends and zeros among them, with few bits or many.
fn hostile<E: Float>(stream: &mut Stream) -> E {
    let bits = stream.bits();
    match bits & 7 {
        0..=2 => E::from_upper_bits(stream.bits()),
        3 => E::from_f64(0.0),
        4 => E::from_bits64(stream.bits() & 0xff),
        5 => {
            let x = E::from_upper_bits(stream.bits());
            E::from_bits64(x.bits64() & !((1 << (E::SIGNIFICANT_BITS - 1)) - 1))
        }
        _ => E::from_f64(stream.range_f64(-4.0, 4.0).round()),
    }
}

fn hostile_scene<E: Precision>(stream: &mut Stream) -> Scene<E> {
    let near = stream.bits() & 1 == 0;
    let mut number = || {
        if near { E::from_f64(stream.range_f64(-3.0, 3.0).round()) } else { hostile(stream) }
    };
    let mut vector = || Vec3::new(number(), number(), number());
    let mut pairs = Vec::new();
    for place in 0..SIDE {
        let (o, d, a, b, c) = (vector(), vector(), vector(), vector(), vector());
        let half = E::from_f64(0.5);
        let d = match place % 4 {
            0 => a - o,
            1 => (a + b).scale(half) - o,
            _ => d,
        };
        let ray = Ray::<E>::new(o, d);
        let ray = if place % 3 == 0 { Ray { tmin: -ray.tmax, ..ray } } else { ray };
        pairs.push((ray, Triangle { a, b, c }));
    }
    Scene::new(pairs)
}

fn any_bits<E: Precision>() {
    let mut stream = Stream::new("exact/hostile", 1);
    for _ in 0..50 * scenes() {
        is_right::<E>(&hostile_scene(&mut stream), "hostile");
    }
}

#[test]
fn f32_is_right_on_any_bits() {
    any_bits::<f32>();
}

#[test]
fn f64_is_right_on_any_bits() {
    any_bits::<f64>();
}

/// Small whole numbers times a power of two, near the ends of what the filter takes: volumes of zero,
/// and the smallest that are not.
fn at_the_ends_of_the_range<E: Precision>() {
    let mut stream = Stream::new("exact/ends", 1);
    for round in 0..10 * scenes() {
        for exponent in [-44, -36, -34, -22, -20, -10, 0, 8, 10, 12, 20, 30, 40] {
            let mut pairs = Vec::new();
            for _ in 0..SIDE {
                let scale = f64::from(exponent).exp2();
                let speed = f64::from(i32::try_from(stream.bits() % 48).unwrap_or(0) - 24).exp2();
                let mut vector = |scale: f64, most: f64| {
                    [0, 1, 2]
                        .map(|_| E::from_f64(stream.range_f64(-most, most).round() * scale))
                        .into()
                };
                let most = if round % 2 == 0 { 3.0 } else { 4096.0 };
                let (a, b, c, o): (Vec3<E>, Vec3<E>, Vec3<E>, Vec3<E>) = (
                    vector(scale, most),
                    vector(scale, most),
                    vector(scale, most),
                    vector(scale, most),
                );
                let d = (a + b).scale(E::from_f64(0.5)) - o;
                let d = d.map(|x| E::from_f64(x.to_f64() * speed / scale));
                pairs.push((Ray::<E>::new(o, d), Triangle { a, b, c }));
            }
            is_right::<E>(&Scene::new(pairs), &format!("scale 2^{exponent}"));
        }
    }
}

#[test]
fn f32_is_right_at_the_ends_of_the_range() {
    at_the_ends_of_the_range::<f32>();
}

#[test]
fn f64_is_right_at_the_ends_of_the_range() {
    at_the_ends_of_the_range::<f64>();
}

/// The filter's bounds are of norms, which random pairs stay far below: a two-hundredth is too little for them.
struct NarrowFilter;

impl Width for NarrowFilter {
    const FILTER: f64 = 0.005;
    const DOUBLE: f64 = 1.0;
}

struct NarrowDouble;

impl Width for NarrowDouble {
    const FILTER: f64 = 1.0;
    const DOUBLE: f64 = 0.1;
}

/// Answers and screens that are wrong.
fn wrong_answers<W: Width, E: Precision>() -> [u64; 2]
where
    Exact<W>: ExactMethod,
{
    let families = [Stress::NearEdge, Stress::NearVertex, Stress::IntervalEnd, Stress::AxisAligned];
    let mut wrong = [0, 0];
    for family in families {
        for level in family.levels::<E>() {
            for seed in 0..4 {
                let scene = Scene::<E>::stressed(family, level, seed);
                let Wrong { misjudged, misscreened, .. } = run::<Exact<W>, E>(&scene);
                wrong[0] += misjudged;
                wrong[1] += misscreened;
            }
        }
    }
    wrong
}

/// The tests above have teeth: with narrower bounds they would fail. (That errors reach a tenth of the
/// filter's bounds is shown beside them.)
#[test]
fn narrower_bounds_are_too_little() {
    let [filter, screens] = wrong_answers::<NarrowFilter, f32>();
    let [double, _] = wrong_answers::<NarrowDouble, f64>();
    println!("filter {filter}, screens {screens}, double {double}");
    assert!(filter > 0, "the filter's bound could be a two-hundredth");
    assert!(screens > 0, "and those of where t is");
    assert!(double > 0, "the bound of f64 could be a tenth");
}
