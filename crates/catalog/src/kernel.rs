//! Compiled kernels behind one type.
#![allow(
    clippy::redundant_closure,
    reason = "the call of a reference to a closure, `&mut found`, would stay out of line"
)]

use std::any::Any;
use std::cmp::Ordering;
use std::marker::PhantomData;
use std::ops::ControlFlow;

use trisect_core::{Hit, Lanes, Precision, Ray, Scalar, Token, Triangle};
use trisect_formula::Flushing;
use trisect_kernels::{
    Arrangement, Common, CommonDirection, CommonOrigin, PADDING, Packets, PreparedTriangles,
    Tested, intersect_with, one_ray, one_triangle, shared_packets,
};
use trisect_method::{Culling, Division, ExactMethod, Method, Needs, Refine, UnsuitableMesh};
use trisect_tracer::{Builder, Bvh, ErasedBvh, Leaves, Tree};

use crate::variant::Variant;

/// Triangles and rays, prepared for the kernels of one method and precision.
pub struct Scene {
    prepared: Box<dyn Any>,
    common: Common,
}

pub(crate) struct Prepared<M: Method, E: Precision> {
    triangles: PreparedTriangles<M, E>,
    rays: Vec<Ray<E>>,
    packets: Packets<E>,
}

impl Scene {
    pub(crate) fn prepare<M: Method, E: Precision>(
        triangles: &[Triangle<E>],
        rays: &[Ray<E>],
    ) -> Result<Self, UnsuitableMesh> {
        let packets = Packets::new::<M>(rays);
        Ok(Self {
            common: packets.common(),
            prepared: Box::new(Prepared::<M, E> {
                triangles: PreparedTriangles::new(triangles)?,
                rays: rays.to_vec(),
                packets,
            }),
        })
    }

    /// What all rays have in common: decides which arrangements serve.
    pub fn common(&self) -> Common {
        self.common
    }

    fn get<M: Method, E: Precision>(&self) -> &Prepared<M, E> {
        self.prepared
            .downcast_ref()
            .expect("a scene is used with the kernels that it was prepared for")
    }
}

/// What a timed kernel returns: enough to verify that it did its work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tally {
    /// How many pairs hit.
    pub hits: u64,
    /// The sum over the hits of what was asked: `t`, or `t + beta + gamma`; 0 for occlusion.
    pub sum: f64,
}

/// A kernel for measuring time: every ray of a scene against every triangle.
pub struct Kernel {
    /// The variant.
    pub variant: Variant,
    run: fn(&Scene) -> Tally,
}

impl Kernel {
    pub(crate) fn new<M, L, D, N, A>() -> Self
    where
        M: Method,
        L: Lanes<Elem: Precision>,
        D: Division,
        N: Needs,
        A: Arrange,
    {
        Self {
            variant: Variant::of::<M, L, D>(A::ARRANGEMENT, N::OUTPUT),
            run: M::tally::<L, D, N, A>,
        }
    }

    /// Where its code is, for who looks at what was compiled.
    pub fn address(&self) -> usize {
        self.run as *const () as usize
    }

    /// Tests every ray of `scene` against every triangle.
    ///
    /// # Panics
    /// When the processor lacks the variant's instructions, the scene was prepared for another
    /// method or precision, or its rays lack what the arrangement says that they share.
    pub fn run(&self, scene: &Scene) -> Tally {
        let serves = self.variant.arrangement.serves(scene.common);
        assert!(serves, "the rays do not share what they must");
        (self.run)(scene)
    }
}

fn token<L: Lanes>() -> L::Token {
    L::Token::detect().expect("the processor has the instructions of the kernel")
}

/// Counts hits and sums what is asked of them.
struct Accumulator<L> {
    hits: u64,
    sum: L,
    zero: L,
}

impl<L: Lanes> Accumulator<L> {
    #[inline(always)]
    fn new(token: L::Token) -> Self {
        let zero = L::splat(token, L::Elem::from_f64(0.0));
        Self { hits: 0, sum: zero, zero }
    }

    #[inline(always)]
    fn add<M: Method, N: Needs>(&mut self, tested: &Tested<'_, M, L>, mask: L::Mask, hit: Hit<L>) {
        self.hits += u64::from(L::bits(mask).count_ones());
        if let Some(asked) = N::fold::<M, L>(tested.ray, tested.triangle, tested.group, hit) {
            self.sum = self.sum + L::select(mask, asked, self.zero);
        }
    }

    #[inline(always)]
    fn tally(self) -> Tally {
        let mut sums = [L::Elem::from_f64(0.0); trisect_kernels::BLOCK];
        self.sum.store(&mut sums);
        Tally { hits: self.hits, sum: sums.iter().map(|x| x.to_f64()).sum() }
    }
}

/// An [`Arrangement`], as a type.
pub(crate) trait Arrange: 'static {
    const ARRANGEMENT: Arrangement;
    /// Tests every ray against every triangle.
    fn run<M: Method, L: Lanes<Elem: Precision>, D: Division>(
        token: L::Token,
        scene: &Prepared<M, L::Elem>,
        found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
    );
}

pub(crate) struct OneRay;

impl Arrange for OneRay {
    const ARRANGEMENT: Arrangement = Arrangement::OneRay;
    #[inline(always)]
    fn run<M: Method, L: Lanes<Elem: Precision>, D: Division>(
        token: L::Token,
        scene: &Prepared<M, L::Elem>,
        mut found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
    ) {
        for ray in &scene.rays {
            one_ray::<M, L, D>(
                token,
                ray,
                &scene.triangles,
                Culling::None,
                #[inline(always)]
                |tested, mask, hit| found(tested, mask, hit),
            );
        }
    }
}

pub(crate) struct OneTriangle;

impl Arrange for OneTriangle {
    const ARRANGEMENT: Arrangement = Arrangement::OneTriangle;
    #[inline(always)]
    fn run<M: Method, L: Lanes<Elem: Precision>, D: Division>(
        token: L::Token,
        scene: &Prepared<M, L::Elem>,
        found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
    ) {
        one_triangle::<M, L, D>(token, &scene.packets, &scene.triangles, Culling::None, found);
    }
}

impl Arrange for CommonOrigin {
    const ARRANGEMENT: Arrangement = Arrangement::CommonOrigin;
    #[inline(always)]
    fn run<M: Method, L: Lanes<Elem: Precision>, D: Division>(
        token: L::Token,
        scene: &Prepared<M, L::Elem>,
        found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
    ) {
        let Prepared { triangles, packets, .. } = scene;
        shared_packets::<M, L, D, Self>(token, packets, triangles, Culling::None, found);
    }
}

impl Arrange for CommonDirection {
    const ARRANGEMENT: Arrangement = Arrangement::CommonDirection;
    #[inline(always)]
    fn run<M: Method, L: Lanes<Elem: Precision>, D: Division>(
        token: L::Token,
        scene: &Prepared<M, L::Elem>,
        found: impl FnMut(Tested<'_, M, L>, L::Mask, Hit<L>),
    ) {
        let Prepared { triangles, packets, .. } = scene;
        shared_packets::<M, L, D, Self>(token, packets, triangles, Culling::None, found);
    }
}

/// What is compiled for a method. Its provided functions are instances of the method's own type, so
/// that the compiler puts the kernels of each method crate into a unit of their own, and compiles the
/// units side by side.
pub(crate) trait Instances: Method {
    /// Runs a [`Kernel`].
    fn tally<L, D, N, A>(scene: &Scene) -> Tally
    where
        L: Lanes<Elem: Precision>,
        D: Division,
        N: Needs,
        A: Arrange,
    {
        let scene = scene.get::<Self, L::Elem>();
        let token = token::<L>();
        token.run(
            #[inline(always)]
            || {
                let mut sum = Accumulator::<L>::new(token);
                A::run::<Self, L, N::Asks<D>>(
                    token,
                    scene,
                    #[inline(always)]
                    |tested, mask, hit| sum.add::<Self, N>(&tested, mask, hit),
                );
                sum.tally()
            },
        )
    }

    /// An [`Entry::erased_tree`](crate::Entry::erased_tree).
    fn erased_tree(
        triangles: &[Triangle<f32>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Box<dyn Tree>, UnsuitableMesh> {
        Ok(Box::new(ErasedBvh::build_with::<Self>(triangles, builder, leaves)?))
    }

    /// An [`Entry::inline_tree`](crate::Entry::inline_tree).
    fn inline_tree(
        triangles: &[Triangle<f32>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Box<dyn Tree>, UnsuitableMesh> {
        Ok(Box::new(Bvh::<Self>::build_with(triangles, builder, leaves)?))
    }

    /// A [`FlushingTest`](crate::FlushingTest).
    fn flushing<D: Division>(ray: &Ray<f32>, triangle: &Triangle<f32>) -> Option<Hit<f64>> {
        let number = |&x: &f32| Flushing::from_f64(f64::from(x));
        let (ray, triangle) = (ray.map(number), triangle.map(number));
        let hit = intersect_with::<Self, D, Flushing>(&ray, &triangle, Culling::None)?;
        Some(Hit { t: hit.t.to_f64(), beta: hit.beta.to_f64(), gamma: hit.gamma.to_f64() })
    }

    /// Runs a [`Finder`].
    fn find<L: Lanes<Elem: Precision>, D: Division>(
        scene: &Scene,
        culling: Culling,
        found: &mut Find<'_>,
    ) {
        let scene = scene.get::<Self, L::Elem>();
        let token = token::<L>();
        token.run(
            #[inline(always)]
            || {
                for (number, ray) in scene.rays.iter().enumerate() {
                    let mut done = false;
                    one_ray::<Self, L, D>(
                        token,
                        ray,
                        &scene.triangles,
                        culling,
                        #[inline(always)]
                        |tested, mask, hit| {
                            if !done {
                                let numbers = scene.triangles.numbers(tested.triangle_place);
                                done = hand_out::<L>(numbers, number, mask, hit, found);
                            }
                        },
                    );
                }
            },
        );
    }

    /// The same with the lanes the other way round, triangle by triangle.
    fn find_packets<L: Lanes<Elem: Precision>, D: Division>(
        scene: &Scene,
        culling: Culling,
        found: &mut Find<'_>,
    ) {
        let Prepared { triangles, packets, .. } = scene.get::<Self, L::Elem>();
        let token = token::<L>();
        token.run(
            #[inline(always)]
            || {
                one_triangle::<Self, L, D>(
                    token,
                    packets,
                    triangles,
                    culling,
                    #[inline(always)]
                    |tested, mask, hit| {
                        let triangle = triangles.number(tested.triangle_place);
                        let of = |lane| (packets.number(tested.ray_place + lane), triangle);
                        let _ = each_hit::<L>(mask, hit, &mut |lane, hit| {
                            let (ray, triangle) = of(lane);
                            if ray == PADDING {
                                return ControlFlow::Continue(());
                            }
                            // The other lanes are of other rays.
                            let _ = found(ray as usize, triangle, hit);
                            ControlFlow::Continue(())
                        });
                    },
                );
            },
        );
    }

    /// Which of two triangles that a ray of the scene hits at one rounded `t` is first: that of the lower
    /// number, unless the method knows better.
    fn order<E: Precision>(scene: &Scene, ray: usize, numbers: [u32; 2]) -> Ordering {
        Self::refine(Order::<E> { scene, ray, numbers, precision: PhantomData })
    }
}

impl<M: Method> Instances for M {}

/// See [`Instances::order`].
struct Order<'a, E> {
    scene: &'a Scene,
    ray: usize,
    numbers: [u32; 2],
    precision: PhantomData<E>,
}

impl<M: Method, E: Precision> Refine<M> for Order<'_, E> {
    type Output = Ordering;

    fn rounded(self) -> Ordering {
        self.numbers[0].cmp(&self.numbers[1])
    }

    fn exact(self) -> Ordering
    where
        M: ExactMethod,
    {
        let Self { scene, ray, numbers, .. } = self;
        let Prepared { triangles, rays, .. } = scene.get::<M, E>();
        let [first, second] = numbers.map(|number| {
            let place = triangles.numbers(0).iter().position(|&other| other == number);
            triangles.prepared(place.expect("it is a triangle of the scene"))
        });
        M::order(&rays[ray], first, second).then(numbers[0].cmp(&numbers[1]))
    }
}

/// The packets' finder, which is compiled for exact methods alone.
struct FindPackets<L, D>(PhantomData<(L, D)>);

impl<M: Method, L: Lanes<Elem: Precision>, D: Division> Refine<M> for FindPackets<L, D> {
    type Output = Option<Run>;

    fn rounded(self) -> Option<Run> {
        None
    }

    fn exact(self) -> Option<Run>
    where
        M: ExactMethod,
    {
        Some(M::find_packets::<L, D>)
    }
}

/// Hands out the lanes that hit, given the numbers of their triangles; whether the ray is done with.
/// Rare, so kept out of the loop.
#[inline(never)]
fn hand_out<L: Lanes>(
    numbers: &[u32],
    ray: usize,
    mask: L::Mask,
    hit: Hit<L>,
    found: &mut Find<'_>,
) -> bool {
    each_hit::<L>(mask, hit, &mut |lane, hit| match numbers[lane] {
        PADDING => ControlFlow::Continue(()),
        number => found(ray, number, hit),
    })
    .is_break()
}

/// Hands out the lanes that hit, until one breaks.
#[inline(never)]
fn each_hit<L: Lanes>(
    mask: L::Mask,
    hit: Hit<L>,
    found: &mut dyn FnMut(usize, Hit<f64>) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let zero = L::Elem::from_f64(0.0);
    let mut lanes = [[zero; trisect_kernels::BLOCK]; 3];
    hit.t.store(&mut lanes[0]);
    hit.beta.store(&mut lanes[1]);
    hit.gamma.store(&mut lanes[2]);
    let mut bits = L::bits(mask);
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        let [t, beta, gamma] = [0, 1, 2].map(|i: usize| lanes[i][lane].to_f64());
        found(lane, Hit { t, beta, gamma })?;
    }
    ControlFlow::Continue(())
}

/// Receives a ray's number, a triangle's number and the hit, its numbers widened exactly;
/// `Break` ends the ray.
pub type Find<'a> = dyn FnMut(usize, u32, Hit<f64>) -> ControlFlow<()> + 'a;

/// A kernel for answers: hands out every hit of every ray.
pub struct Finder {
    /// The variant: one ray at a time, early-out, asked for the fullest hit that the method gives.
    pub variant: Variant,
    find: Run,
    /// For methods that claim to be exact.
    find_packets: Option<Run>,
    order: fn(&Scene, usize, [u32; 2]) -> Ordering,
}

/// Hands out every hit of every ray of a scene.
type Run = fn(&Scene, Culling, &mut Find<'_>);

impl Finder {
    pub(crate) fn new<M: Method, L: Lanes<Elem: Precision>, D: Division>() -> Self {
        let find_packets = M::refine(FindPackets::<L, D>(PhantomData));
        let order = <M as Instances>::order::<L::Elem>;
        let variant = Variant::of::<M, L, D>(Arrangement::OneRay, M::INFO.fullest());
        Self { variant, find: M::find::<L, D>, find_packets, order }
    }

    /// Calls `found` for each hit of each ray of `scene`, ray by ray; the triangles of a ray come
    /// in no order that is promised.
    ///
    /// # Panics
    /// When the processor lacks the variant's instructions, or the scene was prepared for another
    /// method or precision.
    pub fn find(&self, scene: &Scene, culling: Culling, found: &mut Find<'_>) {
        (self.find)(scene, culling, found);
    }

    /// The same with as many rays as there are lanes against one triangle, triangle by triangle: `Break`
    /// ends nothing. `None` where that is not compiled: it is for methods that claim to be exact.
    ///
    /// # Panics
    /// As [`Finder::find`].
    pub fn find_packets(
        &self,
        scene: &Scene,
        culling: Culling,
        found: &mut Find<'_>,
    ) -> Option<()> {
        self.find_packets.map(|find| find(scene, culling, found))
    }

    /// The closest hit of each of the first `rays` rays of `scene`: smallest `t`, then what comes first
    /// for a method that claims to be exact, then lowest triangle number.
    ///
    /// # Panics
    /// As [`Finder::find`], and when the scene has more rays.
    pub fn closest(
        &self,
        scene: &Scene,
        culling: Culling,
        rays: usize,
    ) -> Vec<Option<(u32, Hit<f64>)>> {
        let mut closest: Vec<Option<(u32, Hit<f64>)>> = vec![None; rays];
        self.find(scene, culling, &mut |ray, number, hit| {
            let nearer = closest[ray].is_none_or(|(other, best)| {
                let comes_first = || (self.order)(scene, ray, [number, other]).is_lt();
                hit.t < best.t || hit.t == best.t && comes_first()
            });
            if nearer {
                closest[ray] = Some((number, hit));
            }
            ControlFlow::Continue(())
        });
        closest
    }

    /// Whether each of the first `rays` rays of `scene` hits anything.
    ///
    /// # Panics
    /// As [`Finder::closest`].
    pub fn any(&self, scene: &Scene, culling: Culling, rays: usize) -> Vec<bool> {
        let mut any = vec![false; rays];
        self.find(scene, culling, &mut |ray, _, _| {
            any[ray] = true;
            ControlFlow::Break(())
        });
        any
    }
}
