//! Compiled kernels behind one type.

use std::any::Any;
use std::ops::ControlFlow;

use trisect_core::{
    Culling, Division, Hit, InstructionSet, Lanes, Method, Needs, PADDING, Packet, Precision,
    PreparedTriangles, Ray, Scalar, Token, Triangle, one_ray, one_triangle,
};

/// Which way round the lanes are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Arrangement {
    /// One ray against N triangles at a time.
    OneRay,
    /// N rays at a time against one triangle.
    OneTriangle,
}

impl Arrangement {
    /// The name used in records.
    pub const fn name(self) -> &'static str {
        match self {
            Self::OneRay => "one-ray",
            Self::OneTriangle => "one-triangle",
        }
    }
}

/// A lane type, as a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lane {
    /// `f32` or `f64`.
    pub precision: &'static str,
    /// How many lanes; 1 is the scalar.
    pub width: usize,
    /// The instructions it is compiled for.
    pub instruction_set: InstructionSet,
    /// `plain` or `fused`.
    pub arithmetic: &'static str,
}

impl Lane {
    /// The value that stands for `L`.
    pub fn of<L: Lanes<Elem: Precision>>() -> Self {
        Self {
            precision: <L::Elem as trisect_core::Float>::NAME,
            width: L::N,
            instruction_set: L::Token::INSTRUCTION_SET,
            arithmetic: if L::FUSED { "fused" } else { "plain" },
        }
    }
}

/// Which variant of a method a kernel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Precision, width, instruction set, arithmetic.
    pub lane: Lane,
    /// `early` or `deferred`.
    pub division: &'static str,
    /// `true` or `newton`.
    pub reciprocal: &'static str,
}

/// Triangles and rays, prepared for the kernels of one method and precision.
pub struct Scene(Box<dyn Any>);

struct Prepared<M: Method, E: Precision> {
    triangles: PreparedTriangles<M, E>,
    rays: Vec<Ray<E>>,
    packets: Vec<Packet<E>>,
}

impl Scene {
    pub(crate) fn prepare<M: Method, E: Precision>(
        triangles: &[Triangle<E>],
        rays: &[Ray<E>],
    ) -> Self {
        Self(Box::new(Prepared::<M, E> {
            triangles: PreparedTriangles::new(triangles),
            rays: rays.to_vec(),
            packets: Packet::pack(rays),
        }))
    }

    fn get<M: Method, E: Precision>(&self) -> &Prepared<M, E> {
        self.0.downcast_ref().expect("a scene is used with the kernels that it was prepared for")
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
    /// Which way round the lanes are used.
    pub arrangement: Arrangement,
    /// Whether a test ends as soon as no lane can hit.
    pub early_out: bool,
    /// What is asked of a hit.
    pub needs: &'static str,
    run: fn(&Scene) -> Tally,
}

impl Kernel {
    pub(crate) fn new<M, L, D, N>(arrangement: Arrangement) -> Self
    where
        M: Method,
        L: Lanes<Elem: Precision>,
        D: Division,
        N: Needs,
    {
        Self {
            variant: variant::<L, D>(),
            arrangement,
            early_out: D::EARLY_OUT,
            needs: N::NAME,
            run: match arrangement {
                Arrangement::OneRay => tally_one_ray::<M, L, D, N>,
                Arrangement::OneTriangle => tally_one_triangle::<M, L, D, N>,
            },
        }
    }

    /// Tests every ray of `scene` against every triangle.
    ///
    /// # Panics
    /// When the processor lacks the variant's instructions, or the scene was prepared for another
    /// method or precision.
    pub fn run(&self, scene: &Scene) -> Tally {
        (self.run)(scene)
    }
}

fn variant<L: Lanes<Elem: Precision>, D: Division>() -> Variant {
    Variant { lane: Lane::of::<L>(), division: D::NAME, reciprocal: D::RECIPROCAL }
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
    fn add<N: Needs>(&mut self, mask: L::Mask, hit: Hit<L>) {
        self.hits += u64::from(L::bits(mask).count_ones());
        if let Some(asked) = N::fold(hit) {
            self.sum = self.sum + L::select(mask, asked, self.zero);
        }
    }

    #[inline(always)]
    fn tally(self) -> Tally {
        let mut sums = [L::Elem::from_f64(0.0); trisect_core::BLOCK];
        self.sum.store(&mut sums);
        Tally { hits: self.hits, sum: sums.iter().map(|x| x.to_f64()).sum() }
    }
}

fn tally_one_ray<M, L, D, N>(scene: &Scene) -> Tally
where
    M: Method,
    L: Lanes<Elem: Precision>,
    D: Division,
    N: Needs,
{
    let scene = scene.get::<M, L::Elem>();
    let token = token::<L>();
    token.run(
        #[inline(always)]
        || {
            let mut sum = Accumulator::<L>::new(token);
            for ray in &scene.rays {
                one_ray::<M, L, D>(
                    token,
                    ray,
                    &scene.triangles,
                    Culling::None,
                    #[inline(always)]
                    |_, mask, hit| sum.add::<N>(mask, hit),
                );
            }
            sum.tally()
        },
    )
}

fn tally_one_triangle<M, L, D, N>(scene: &Scene) -> Tally
where
    M: Method,
    L: Lanes<Elem: Precision>,
    D: Division,
    N: Needs,
{
    let scene = scene.get::<M, L::Elem>();
    let token = token::<L>();
    token.run(
        #[inline(always)]
        || {
            let mut sum = Accumulator::<L>::new(token);
            for packet in &scene.packets {
                one_triangle::<M, L, D>(
                    token,
                    packet,
                    &scene.triangles,
                    Culling::None,
                    #[inline(always)]
                    |_, _, mask, hit| sum.add::<N>(mask, hit),
                );
            }
            sum.tally()
        },
    )
}

/// Receives a ray's number, a triangle's number and the hit, its numbers widened exactly;
/// `Break` ends the ray.
pub type Find<'a> = dyn FnMut(usize, u32, Hit<f64>) -> ControlFlow<()> + 'a;

/// A kernel for answers: hands out every hit of every ray.
pub struct Finder {
    /// The variant.
    pub variant: Variant,
    find: fn(&Scene, Culling, &mut Find<'_>),
}

impl Finder {
    pub(crate) fn new<M: Method, L: Lanes<Elem: Precision>, D: Division>() -> Self {
        Self { variant: variant::<L, D>(), find: find::<M, L, D> }
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

    /// The closest hit of each of the first `rays` rays of `scene`: smallest `t`, then lowest
    /// triangle number.
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
            let nearer = closest[ray]
                .is_none_or(|(other, best)| hit.t < best.t || (hit.t == best.t && number < other));
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

fn find<M: Method, L: Lanes<Elem: Precision>, D: Division>(
    scene: &Scene,
    culling: Culling,
    found: &mut Find<'_>,
) {
    let scene = scene.get::<M, L::Elem>();
    let token = token::<L>();
    token.run(
        #[inline(always)]
        || {
            for (number, ray) in scene.rays.iter().enumerate() {
                let mut done = false;
                one_ray::<M, L, D>(
                    token,
                    ray,
                    &scene.triangles,
                    culling,
                    #[inline(always)]
                    |place, mask, hit| {
                        if !done {
                            done = hand_out(&scene.triangles, number, place, mask, hit, found);
                        }
                    },
                );
            }
        },
    );
}

/// Hands out the lanes that hit; whether the ray is done with. Rare, so kept out of the loop.
#[inline(never)]
fn hand_out<M: Method, L: Lanes<Elem: Precision>>(
    triangles: &PreparedTriangles<M, L::Elem>,
    ray: usize,
    place: usize,
    mask: L::Mask,
    hit: Hit<L>,
    found: &mut Find<'_>,
) -> bool {
    let zero = L::Elem::from_f64(0.0);
    let mut lanes = [[zero; trisect_core::BLOCK]; 3];
    hit.t.store(&mut lanes[0]);
    hit.beta.store(&mut lanes[1]);
    hit.gamma.store(&mut lanes[2]);
    let mut bits = L::bits(mask);
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        let number = triangles.number(place + lane);
        let [t, beta, gamma] = [0, 1, 2].map(|i: usize| lanes[i][lane].to_f64());
        if number != PADDING && found(ray, number, Hit { t, beta, gamma }).is_break() {
            return true;
        }
    }
    false
}
