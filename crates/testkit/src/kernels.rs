//! The kernels that a method is tested in, behind pointers that know of no method, precision or width.
//! Their numbers are carried in f64, which holds an f32 exactly.

use core::any::Any;
use core::marker::PhantomData;

use trisect_core::{
    FloatFormat, Hit, InstructionSet, Lanes, LanesVisitor, Precision, Ray, Scalar, Token, Triangle,
};
use trisect_kernels::{
    Arrangement, BLOCK, Common, CommonDirection, CommonOrigin, PADDING, Packets, PreparedPair,
    PreparedTriangles, Tested, one_ray, one_triangle, shared_packets,
};
use trisect_method::{
    Culling, Deferred, Division, Early, Form, Interval, Method, Newton, Reciprocal, ReciprocalKind,
    TrueDivision, UnsuitableMesh,
};

/// A ray that hits a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) ray: u32,
    pub(crate) triangle: u32,
    pub(crate) hit: Hit<f64>,
}

impl Found {
    fn bits(&self) -> [u64; 3] {
        [self.hit.t, self.hit.beta, self.hit.gamma].map(f64::to_bits)
    }

    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.is_same_pair(other) && self.bits() == other.bits()
    }

    pub(crate) fn is_same_pair(&self, other: &Self) -> bool {
        (self.ray, self.triangle) == (other.ray, other.triangle)
    }
}

/// Which rays hit which triangles, in order of ray, then triangle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Results(Vec<Found>);

impl Results {
    /// Notes a hit; rays and triangles that only fill up a block must have none. Out of line, so that
    /// it is not compiled into every kernel.
    #[inline(never)]
    fn note(&mut self, ray: u32, triangle: u32, hit: Hit<f64>) {
        assert!(triangle != PADDING, "a lane without a triangle hits");
        assert!(ray != PADDING, "a lane without a ray hits");
        self.0.push(Found { ray, triangle, hit });
    }

    /// Sorts what was noted; a pair must not be tested twice.
    fn sorted(mut self) -> Self {
        self.0.sort_unstable_by_key(|found| (found.ray, found.triangle));
        let twice = self.0.windows(2).any(|two| two[0].is_same_pair(&two[1]));
        assert!(!twice, "a pair is tested twice");
        self
    }

    pub(crate) fn hits(&self) -> &[Found] {
        &self.0
    }

    /// What a ray hits.
    pub(crate) fn of_ray(&self, ray: usize) -> &[Found] {
        let start = self.0.partition_point(|found| (found.ray as usize) < ray);
        let end = self.0.partition_point(|found| found.ray as usize <= ray);
        &self.0[start..end]
    }

    /// The same with the triangles numbered from the other end.
    pub(crate) fn reversed(&self, triangles: usize) -> Self {
        let last = u32::try_from(triangles).expect("triangles have numbers of 32 bits") - 1;
        let turned = |found: &Found| Found { triangle: last - found.triangle, ..*found };
        Self(self.0.iter().map(turned).collect()).sorted()
    }

    /// The first place where `same` does not hold; `None` where there is none.
    pub(crate) fn difference(
        &self,
        other: &Self,
        same: fn(&Found, &Found) -> bool,
    ) -> Option<[Option<Found>; 2]> {
        (0..self.0.len().max(other.0.len()))
            .map(|place| [self.0.get(place).copied(), other.0.get(place).copied()])
            .find(|two| !matches!(two, [Some(a), Some(b)] if same(a, b)))
    }
}

/// The lanes of a mask and their hits.
#[inline(always)]
fn unpack<L: Lanes>(mask: L::Mask, hit: Hit<L>, mut found: impl FnMut(usize, Hit<f64>)) {
    let zero = L::Elem::from_f64(0.0);
    let (mut t, mut beta, mut gamma) = ([zero; BLOCK], [zero; BLOCK], [zero; BLOCK]);
    hit.t.store(&mut t);
    hit.beta.store(&mut beta);
    hit.gamma.store(&mut gamma);
    each_bit(L::bits(mask), &mut |lane| {
        let [t, beta, gamma] = [t[lane], beta[lane], gamma[lane]].map(Scalar::to_f64);
        found(lane, Hit { t, beta, gamma });
    });
}

/// Out of line and behind a pointer: compiled once, not in every kernel.
fn each_bit(bits: u64, found: &mut dyn FnMut(usize)) {
    for lane in (0..BLOCK).filter(|lane| bits >> lane & 1 == 1) {
        found(lane);
    }
}

/// A way to test every ray against every triangle.
trait Arrange {
    const ARRANGEMENT: Arrangement;
    /// What rays must share for it.
    const NEEDS: Common;
    fn run<M: Method, L: Lanes, D: Division>(
        token: L::Token,
        rays: &[Ray<L::Elem>],
        triangles: &PreparedTriangles<M, L::Elem>,
        culling: Culling,
    ) -> Results;
}

pub(crate) const NOTHING: Common = Common { origin: false, direction: false };

struct ByRay;

impl Arrange for ByRay {
    const ARRANGEMENT: Arrangement = Arrangement::OneRay;
    const NEEDS: Common = NOTHING;
    fn run<M: Method, L: Lanes, D: Division>(
        token: L::Token,
        rays: &[Ray<L::Elem>],
        triangles: &PreparedTriangles<M, L::Elem>,
        culling: Culling,
    ) -> Results {
        let mut results = Results::default();
        token.run(
            #[inline(always)]
            || {
                for (number, ray) in (0..PADDING).zip(rays) {
                    one_ray::<M, L, D>(
                        token,
                        ray,
                        triangles,
                        culling,
                        #[inline(always)]
                        |tested, mask, hit| {
                            unpack(mask, hit, |lane, hit| {
                                let triangle = triangles.number(tested.triangle_place + lane);
                                results.note(number, triangle, hit);
                            });
                        },
                    );
                }
            },
        );
        results.sorted()
    }
}

macro_rules! packets {
    ($name:ident, $arrangement:ident, $common:expr, $run:expr) => {
        struct $name;

        impl Arrange for $name {
            const ARRANGEMENT: Arrangement = Arrangement::$arrangement;
            const NEEDS: Common = $common;
            fn run<M: Method, L: Lanes, D: Division>(
                token: L::Token,
                rays: &[Ray<L::Elem>],
                triangles: &PreparedTriangles<M, L::Elem>,
                culling: Culling,
            ) -> Results {
                let packets = Packets::new::<M>(rays);
                let mut results = Results::default();
                token.run(
                    #[inline(always)]
                    || {
                        $run(
                            token,
                            &packets,
                            triangles,
                            culling,
                            #[inline(always)]
                            |tested: Tested<'_, M, L>, mask, hit| {
                                unpack(mask, hit, |lane, hit| {
                                    let ray = packets.number(tested.ray_place + lane);
                                    let triangle = triangles.number(tested.triangle_place);
                                    results.note(ray, triangle, hit);
                                });
                            },
                        );
                    },
                );
                results.sorted()
            }
        }
    };
}
packets!(ByTriangle, OneTriangle, NOTHING, one_triangle::<M, L, D>);
packets!(
    ByOrigin,
    CommonOrigin,
    Common { origin: true, direction: false },
    shared_packets::<M, L, D, CommonOrigin>
);
packets!(
    ByDirection,
    CommonDirection,
    Common { origin: false, direction: true },
    shared_packets::<M, L, D, CommonDirection>
);

/// What a kernel is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    pub(crate) form: Form,
    pub(crate) early_out: bool,
    pub(crate) reciprocal: ReciprocalKind,
    /// Whether `a·b + c` is rounded once.
    pub(crate) fused: bool,
    pub(crate) arrangement: Arrangement,
    pub(crate) lanes: usize,
    pub(crate) instruction_set: InstructionSet,
}

/// Answers of rays to triangles in some form.
type Answers<Triangles> = fn(&[Ray<f64>], &Triangles, Culling) -> Results;

/// A kernel behind a pointer.
pub(crate) struct Kernel {
    pub(crate) kind: Kind,
    pub(crate) needs: Common,
    run: Answers<dyn Any>,
    /// The answers of the scalar to pairs, one by one.
    pub(crate) one_by_one: Answers<[Triangle<f64>]>,
}

/// Triangles as a method takes them, in one precision.
pub(crate) struct Mesh(Box<dyn Any>);

/// Some of the kernels of a method in one precision: those that the processor has.
pub(crate) struct Kernels {
    pub(crate) precision: FloatFormat,
    prepare: fn(&[Triangle<f64>]) -> Result<Mesh, UnsuitableMesh>,
    pub(crate) list: Vec<Kernel>,
}

impl Kernels {
    fn none<M: Method, E: Precision>() -> Self {
        fn prepare<M: Method, E: Precision>(
            triangles: &[Triangle<f64>],
        ) -> Result<Mesh, UnsuitableMesh> {
            let triangles: Vec<_> = triangles.iter().map(narrow::<E>).collect();
            Ok(Mesh(Box::new(PreparedTriangles::<M, E>::new(&triangles)?)))
        }
        Self { precision: E::FORMAT, prepare: prepare::<M, E>, list: Vec::new() }
    }

    pub(crate) fn prepare(&self, triangles: &[Triangle<f64>]) -> Result<Mesh, UnsuitableMesh> {
        (self.prepare)(triangles)
    }
}

/// The kernels of a method in one precision, listed by what they are compared for.
pub(crate) struct Lists {
    pub(crate) widths: fn() -> Kernels,
    pub(crate) divisions: fn() -> Kernels,
    pub(crate) fused: fn() -> Kernels,
    pub(crate) newton: fn() -> Kernels,
    pub(crate) by_triangle: fn() -> Kernels,
    pub(crate) by_origin: fn() -> Kernels,
    pub(crate) by_direction: fn() -> Kernels,
}

impl Lists {
    pub(crate) fn of<M: Method, E: Precision>() -> Self {
        Self {
            widths: widths::<M, E>,
            divisions: divisions::<M, E>,
            fused: fused::<M, E>,
            newton: newton::<M, E>,
            by_triangle: arranged::<M, E, ByTriangle>,
            by_origin: arranged::<M, E, ByOrigin>,
            by_direction: arranged::<M, E, ByDirection>,
        }
    }

    /// All that rays without anything in common are tested with.
    pub(crate) fn all(&self) -> Kernels {
        let mut kernels = (self.widths)();
        for more in [self.divisions, self.by_triangle, self.fused, self.newton] {
            for kernel in more().list {
                if kernels.list.iter().all(|other| other.kind != kernel.kind) {
                    kernels.list.push(kernel);
                }
            }
        }
        kernels
    }
}

impl Kernel {
    pub(crate) fn run(&self, rays: &[Ray<f64>], mesh: &Mesh, culling: Culling) -> Results {
        (self.run)(rays, mesh.0.as_ref(), culling)
    }
}

fn narrow<E: Scalar>(triangle: &Triangle<f64>) -> Triangle<E> {
    triangle.map(|&x| E::from_f64(x))
}

fn run<M: Method, L: Lanes, D: Division, A: Arrange>(
    rays: &[Ray<f64>],
    triangles: &dyn Any,
    culling: Culling,
) -> Results {
    let token = L::Token::detect().expect("what the processor lacks is not listed");
    let triangles = triangles.downcast_ref::<PreparedTriangles<M, L::Elem>>();
    let triangles = triangles.expect("a mesh is prepared for its own kernels");
    let rays: Vec<_> = rays.iter().map(|ray| ray.map(|&x| L::Elem::from_f64(x))).collect();
    A::run::<M, L, D>(token, &rays, triangles, culling)
}

fn one_by_one<M: Method, D: Division, E: Scalar>(
    rays: &[Ray<f64>],
    triangles: &[Triangle<f64>],
    culling: Culling,
) -> Results {
    let triangles: Vec<Triangle<E>> = triangles.iter().map(narrow).collect();
    let fixed = M::mesh_group(&triangles).expect("random triangles suit every method");
    let mut results = Results::default();
    for (number, ray) in (0..PADDING).zip(rays) {
        let ray = ray.map(|&x| E::from_f64(x));
        for (place, triangle) in (0..PADDING).zip(&triangles) {
            let pair = match fixed {
                Some(group) => PreparedPair::<M, E>::of_group(&ray, triangle, group),
                None => PreparedPair::new(&ray, triangle),
            };
            if let Some(Hit { t, beta, gamma }) = pair.test::<D>(Interval::of(&ray), culling) {
                let [t, beta, gamma] = [t, beta, gamma].map(Scalar::to_f64);
                results.note(number, place, Hit { t, beta, gamma });
            }
        }
    }
    results
}

/// Which lane types kernels are listed for.
trait Widths {
    /// Whether widths that are not native to an instruction set are among them.
    const ALL: bool = false;
    /// Whether there is one instruction set alone: AVX2 or Neon, which nearly every processor has.
    const ONE: bool = false;
}

/// Whether all that is listed is compiled on every width, see the feature in the manifest.
const EVERY_WIDTH: bool = cfg!(feature = "every-width");

/// Every width on every instruction set; without the feature, the native ones, which other tests compile
/// anyway.
struct Every;

impl Widths for Every {
    const ALL: bool = EVERY_WIDTH;
}

/// The native widths; without the feature, one of them.
struct NativeOrOne;

impl Widths for NativeOrOne {
    const ONE: bool = !EVERY_WIDTH;
}

/// The width that is native to each instruction set.
struct Native;

impl Widths for Native {}

/// The width that is native to one instruction set.
struct One;

impl Widths for One {
    const ONE: bool = true;
}

/// Lists a kernel per lane type, in the arithmetic that is asked for.
struct Listing<'a, M, D, A, W, const FUSED: bool> {
    list: &'a mut Vec<Kernel>,
    method: PhantomData<(M, D, A, W)>,
}

impl<M: Method, D: Division, A: Arrange, W: Widths, const FUSED: bool> LanesVisitor
    for Listing<'_, M, D, A, W, FUSED>
{
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        if const { L::FUSED != FUSED || (W::ONE && !is_common::<L>()) }
            || L::Token::detect().is_none()
        {
            return;
        }
        self.list.push(Kernel {
            kind: Kind {
                form: D::FORM,
                early_out: D::EARLY_OUT,
                reciprocal: D::Reciprocal::KIND,
                fused: FUSED,
                arrangement: A::ARRANGEMENT,
                lanes: L::N,
                instruction_set: L::Token::INSTRUCTION_SET,
            },
            needs: A::NEEDS,
            run: run::<M, L, D, A>,
            one_by_one: one_by_one::<M, D, L::Elem>,
        });
    }
}

/// Whether lanes are of an instruction set that nearly every processor has.
const fn is_common<L: Lanes>() -> bool {
    matches!(L::Token::INSTRUCTION_SET, InstructionSet::Avx2 | InstructionSet::Neon)
}

/// Something to list for each form of a method.
trait FormVisitor {
    fn visit<M: Method, D: Division>(&mut self);
}

/// Visits the forms that a method has, with the true division.
fn each_form<M: Method, const EARLY_OUT: bool>(visitor: &mut impl FormVisitor) {
    if const { M::INFO.forms.early() } {
        visitor.visit::<M, Early<TrueDivision, EARLY_OUT>>();
    }
    if const { M::INFO.forms.deferred() } {
        visitor.visit::<M, Deferred<TrueDivision, EARLY_OUT>>();
    }
}

/// Visits the one form that decides without quotients, where there is one.
fn one_form<M: Method, R: Reciprocal>(visitor: &mut impl FormVisitor) {
    if const { M::INFO.forms.deferred() } {
        visitor.visit::<M, Deferred<R, true>>();
    } else {
        visitor.visit::<M, Early<R, true>>();
    }
}

/// Lists the kernels of a form.
struct Forms<'a, E, A, W, const FUSED: bool> {
    list: &'a mut Vec<Kernel>,
    kind: PhantomData<(E, A, W)>,
}

impl<'a, E, A, W, const FUSED: bool> Forms<'a, E, A, W, FUSED> {
    fn new(list: &'a mut Vec<Kernel>) -> Self {
        Self { list, kind: PhantomData }
    }
}

impl<E: Precision, A: Arrange, W: Widths, const FUSED: bool> FormVisitor
    for Forms<'_, E, A, W, FUSED>
{
    fn visit<M: Method, D: Division>(&mut self) {
        let list = &mut *self.list;
        let mut listing = Listing::<M, D, A, W, FUSED> { list, method: PhantomData };
        if const { W::ALL } {
            E::visit_all(&mut listing);
        } else {
            E::visit_native(&mut listing);
        }
    }
}

/// One form on every width and instruction set, plain.
fn widths<M: Method, E: Precision>() -> Kernels {
    let mut kernels = Kernels::none::<M, E>();
    one_form::<M, TrueDivision>(&mut Forms::<E, ByRay, Every, false>::new(&mut kernels.list));
    kernels
}

/// Every form on the native widths, plain: with early-out on all of them, without on one.
fn divisions<M: Method, E: Precision>() -> Kernels {
    let mut kernels = Kernels::none::<M, E>();
    each_form::<M, true>(&mut Forms::<E, ByRay, Native, false>::new(&mut kernels.list));
    each_form::<M, false>(&mut Forms::<E, ByRay, One, false>::new(&mut kernels.list));
    kernels
}

/// One form in another arrangement, on one width, plain.
fn arranged<M: Method, E: Precision, A: Arrange>() -> Kernels {
    let mut kernels = Kernels::none::<M, E>();
    one_form::<M, TrueDivision>(&mut Forms::<E, A, One, false>::new(&mut kernels.list));
    kernels
}

/// One form on the native widths, fused.
fn fused<M: Method, E: Precision>() -> Kernels {
    let mut kernels = Kernels::none::<M, E>();
    one_form::<M, TrueDivision>(&mut Forms::<E, ByRay, Native, true>::new(&mut kernels.list));
    kernels
}

/// One form on the native widths with Newton's reciprocal, plain and fused.
fn newton<M: Method, E: Precision>() -> Kernels {
    let mut kernels = Kernels::none::<M, E>();
    one_form::<M, Newton>(&mut Forms::<E, ByRay, NativeOrOne, false>::new(&mut kernels.list));
    one_form::<M, Newton>(&mut Forms::<E, ByRay, NativeOrOne, true>::new(&mut kernels.list));
    kernels
}
