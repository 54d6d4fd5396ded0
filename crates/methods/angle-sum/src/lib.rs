#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{
    Corners, Forms, Given, Homogeneous, Input, Method, MethodInfo, Of, Output, Quotients,
    Reciprocal, TrueDivision,
};

/// How far the sum of the angles may seem to be off, in units of roundoff.
const TOLERANCE: f64 = 32.0;

/// Sum of angles, a common method, as Havel 2008 describes it.
pub struct AngleSum;

impl Method for AngleSum {
    const INFO: MethodInfo = MethodInfo {
        name: "angle-sum",
        title: "Angle sum",
        year: 2008,
        source: "Common; described by J. Havel: Rychlý výpočet průsečíku paprsku s trojúhelníkem \
                 (Fast Ray-Triangle Intersection). Master's thesis, Brno University of Technology, \
                 2008, section 3.4.4.1",
        input: Input::Points,
        outputs: Output::FLAG_T_AND_NORMAL,
        forms: Forms::Early,
        // The angles are those at the point itself; as numerators they would be products of eighteen
        // lengths, which f32 does not hold.
        always_divides: true,
        ..MethodInfo::USUAL
    };
    type Prepared = Corners<()>;
    type PreparedRay<L: Lanes> = Ray<L>;
    type Alpha<L: Lanes> = Given<L>;

    #[inline(always)]
    fn prepare<X: Scalar>(triangle: &Triangle<X>, _group: usize) -> Of<Self::Prepared, X> {
        Corners::new(triangle)
    }

    #[inline(always)]
    fn prepare_ray<L: Lanes>(ray: &Ray<L>, _group: usize) -> Ray<L> {
        *ray
    }

    #[inline(always)]
    fn intersect<L: Lanes>(ray: &Ray<L>, corners: &Corners<L>) -> Homogeneous<L, Given<L>> {
        let divided = Self::intersect_early(ray, corners, TrueDivision::reciprocal::<L>);
        let Quotients { det, t, alpha: Given(alpha), beta, gamma } = divided;
        Homogeneous {
            det: det.constant(L::Elem::from_f64(1.0)).xor_sign(det),
            t: t.xor_sign(det),
            alpha: Given(alpha.xor_sign(det)),
            beta: beta.xor_sign(det),
            gamma: gamma.xor_sign(det),
        }
    }

    /// The weights are numbers that are at least zero where the angles sum to 360°.
    #[inline(always)]
    fn intersect_early<L: Lanes>(
        ray: &Ray<L>,
        corners: &Corners<L>,
        reciprocal: impl Fn(L) -> L,
    ) -> Quotients<L, Given<L>> {
        let n = corners.normal();
        let squared = n.dot(n);
        let det = n.dot(ray.d);
        let t = n.dot(corners.a - ray.o) * reciprocal(det);
        let p = ray.at(t);
        let (a, b, c) = (corners.a - p, corners.b - p, corners.c - p);
        // Of each angle the cosine, and the sine over |N|, times the lengths of its sides.
        let area = n.scale(reciprocal(squared));
        let (xa, ya) = (b.dot(c), area.dot(b.cross(c)).magnitude());
        let (xb, yb) = (c.dot(a), area.dot(c.cross(a)).magnitude());
        let (xc, yc) = (a.dot(b), area.dot(a.cross(b)).magnitude());
        // The product of the three complex numbers has the sum of the angles: its imaginary part,
        // over |N|, must vanish, its real part be positive.
        let (ab, bc, ca) = (xa * xb, xb * xc, xc * xa);
        let sines = squared * (ya * (yb * yc));
        let imaginary = ab.mul_add(yc, bc.mul_add(ya, ca.mul_sub(yb, sines)));
        let size = (ab * yc).magnitude() + (bc * ya).magnitude() + (ca * yb).magnitude() + sines;
        let real = (ab * xc) - squared * (xa * (yb * yc) + xb * (yc * ya) + xc * (ya * yb));
        let roundoff = L::Elem::from_f64(TOLERANCE * L::Elem::unit_roundoff().to_f64());
        Quotients {
            det,
            t,
            alpha: Given(size * size.constant(roundoff) - imaginary.magnitude()),
            beta: real,
            // Far outside all angles are small, and their sum is nearly zero instead.
            gamma: -xa.min(xb).min(xc),
        }
    }

    /// Here `det = D·N`, which is negative at the front.
    #[inline(always)]
    fn facing<L: Lanes>(_ray: &Ray<L>, _triangle: &Of<Self::Prepared, L>, det: L) -> L {
        -det
    }

    #[inline(always)]
    fn normal<L: Lanes>(corners: &Corners<L>, _group: usize) -> Option<Vec3<L>> {
        Some(corners.normal())
    }
}

trisect_method::methods!(AngleSum);
