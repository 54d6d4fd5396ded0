//! Where an instance is: how rays are carried to it, and how far off that may be.

use glam::{Affine3A, DAffine3, DVec3, Vec3};
use trisect_core::{Ray, Vec3 as Coordinates};

use crate::bvh::builders::corners::Corners;

/// The unit roundoff of f32.
const U: f64 = 1.0 / (1_u64 << 24) as f64;

/// A chain of four roundings.
const GAMMA: f64 = 4.0 * U / (1.0 - 4.0 * U);

/// A transform whose rounded inverse loses more than this of a point has no inverse in f32.
const SINGULAR: f64 = 0.25;

/// Why nothing can be placed by a transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadTransform {
    /// A number of it is infinite or NaN.
    #[error("the transform is not finite")]
    NotFinite,
    /// It has no inverse, or none that f32 can tell from rounding.
    #[error("the transform is singular, as far as f32 can tell")]
    Singular,
}

/// An affine transform, and its inverse, rounded once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    to_world: Affine3A,
    to_object: Affine3A,
    is_identity: bool,
}

impl Transform {
    /// The transform from the space of what is placed to the world.
    ///
    /// # Errors
    /// When it is not finite, or has no inverse.
    pub fn new(to_world: Affine3A) -> Result<Self, BadTransform> {
        if !to_world.is_finite() {
            return Err(BadTransform::NotFinite);
        }
        // Of f64, so that it is rounded once.
        let to_object = to_world.as_daffine3().inverse().as_affine3a();
        let transform = Self { to_world, to_object, is_identity: to_world == Affine3A::IDENTITY };
        let loss = Off::of(&to_object).loss;
        // NaN where there is no inverse at all.
        if to_object.is_finite() && loss <= SINGULAR {
            Ok(transform)
        } else {
            Err(BadTransform::Singular)
        }
    }

    /// From the space of what is placed to that where it is placed.
    #[inline]
    pub fn to_world(&self) -> &Affine3A {
        &self.to_world
    }

    /// Its inverse, computed in f64 and rounded once: what rays are carried by.
    #[inline]
    pub fn to_object(&self) -> &Affine3A {
        &self.to_object
    }

    /// Whether both spaces are the same; rays are not carried then.
    #[inline]
    pub fn is_identity(&self) -> bool {
        self.is_identity
    }

    /// Whether it turns a right hand into a left one.
    pub fn is_mirrored(&self) -> bool {
        self.to_world.as_daffine3().matrix3.determinant() < 0.0
    }

    /// The ray in the space of what is placed, each coordinate a chain of four roundings at most. The direction is not
    /// made of unit length, so that `t` is the same in both spaces.
    #[inline]
    pub fn carry(&self, ray: &Ray<f32>) -> Ray<f32> {
        if self.is_identity {
            return *ray;
        }
        Ray {
            o: self.carry_point(ray.o),
            d: self.to_object.transform_vector3(ray.d.into()).into(),
            ..*ray
        }
    }

    /// A point in the space of what is placed.
    #[inline]
    pub fn carry_point(&self, point: Coordinates<f32>) -> Coordinates<f32> {
        if self.is_identity {
            return point;
        }
        self.to_object.transform_point3(Vec3::from(point)).into()
    }

    /// A bound of how far the hits of carried rays may be from where the rays hit, see [`Off`].
    pub(super) fn off(&self) -> Off {
        if self.is_identity { Off::NOTHING } else { Off::of(&self.to_object) }
    }

    /// The box in the world around what carried rays meet in some boxes, before they are off.
    pub(super) fn around(&self, boxes: &[[Coordinates<f32>; 2]]) -> [DVec3; 2] {
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let boxes = boxes.iter().map(|corners| corners.map(|v| Vec3::from(v).as_dvec3()));
        if self.is_identity {
            return boxes.fold(empty, |[low, high], [a, b]| [low.min(a), high.max(b)]);
        }
        // Not `to_world`: that is the inverse but for rounding.
        let back = self.to_object.matrix3.as_dmat3().inverse();
        let (sizes, translation) = (back.abs(), self.to_object.translation.as_dvec3());
        boxes.fold(empty, |[low, high], [a, b]| {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            if !middle.is_finite() {
                return [DVec3::NEG_INFINITY, DVec3::INFINITY];
            }
            let (middle, half) = (back * (middle - translation), sizes * half);
            [low.min(middle - half), high.max(middle + half)]
        })
    }
}

/// How far, in the world, a ray passes by the hit that its carried ray has at the same `t`.
///
/// Rays are carried by `A` and `b`, the rounded inverse of the transform. With `γ = 4u/(1 − 4u)`, `u = 2⁻²⁴`, and
/// `η = 2⁻¹⁵⁰` for each product that underflows, the carried ray is
///
/// ```text
/// o' = A·o + b + e     |e| ≤ γ·(|A|·|o| + |b|) + 3η
/// d' = A·d + f         |f| ≤ γ·|A|·|d| + 3η
/// ```
///
/// It hits at `p' = o' + t·d'`, a point of the boxes of what is placed, and the ray is at `p = o + t·d` then. Let
/// `w = A⁻¹·(p' − b)`, which is in the image of the boxes under the exact inverse of `A`. So
///
/// ```text
/// p = w − A⁻¹·(e + t·f)
/// |t·d| = |p − o| ≤ |p| + |o|    and    |t| ≤ (|p| + |o|) / |d|
/// ```
///
/// in the norm of the largest coordinate. Let `C` be the norm of `|A⁻¹|·|A|`, `N` that of `A⁻¹`, `B` that of
/// `|A⁻¹|·|b|`, and let no direction be shorter than 2⁻⁶⁰. Then with `k = γ·C + 2⁻⁸⁸·N`
///
/// ```text
/// |p − w| ≤ γ·(C·|o| + B) + 3η·N + k·(|p| + |o|) ≤ k·(2·|o| + |p|) + γ·B + 3η·N
/// ```
///
/// and since `|p| ≤ |w| + |p − w|` and `k ≤ 1/4` it is at most 4/3 of `k·(2·|o| + |w|) + γ·B + 3η·N`. Twice that is
/// taken: the rest is room for the rounding of `A⁻¹` and of `w` here. Its cofactors are differences of exact products,
/// so they round once, and `1/det` is off by 2⁻⁵¹·C, so both are off by less than 2⁻³⁰ relative to what `k` bounds.
///
/// **Of several levels**, a hit is beside the boxes of what is placed by up to `per_origin'·|o'|`, where
/// `|o'| ≤ |A|·|o| + |b|` up to rounding: `N` times that comes on top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Off {
    /// `γ·C`.
    loss: f64,
    /// `k`, by which the largest coordinates of the origin, twice, and of the hit count.
    pub(super) relative: f64,
    /// What does not depend on the ray.
    pub(super) fixed: f64,
    /// The largest sum of magnitudes in a row of the inverse of the matrix.
    pub(super) longer: f64,
    /// Such a sum of the matrix itself, and its largest translation.
    own: [f64; 2],
}

impl Off {
    const NOTHING: Self =
        Self { loss: 0.0, relative: 0.0, fixed: 0.0, longer: 1.0, own: [1.0, 0.0] };

    fn of(to_object: &Affine3A) -> Self {
        let DAffine3 { matrix3, translation } = to_object.as_daffine3();
        let (inverse, own) = (matrix3.inverse().abs(), matrix3.abs());
        let sums = |matrix: glam::DMat3| (matrix * DVec3::ONE).max_element();
        let (loss, longer) = (GAMMA * sums(inverse * own), sums(inverse));
        Self {
            loss,
            relative: loss + longer * 2.0_f64.powi(-88),
            fixed: GAMMA * (inverse * translation.abs()).max_element()
                + longer * 2.0_f64.powi(-148),
            longer,
            own: [sums(own), translation.abs().max_element()],
        }
    }

    /// Where what is placed is off itself.
    pub(super) fn over(self, per_origin: f64) -> Self {
        let more = 1.01 * self.longer * per_origin;
        Self {
            relative: self.relative + more * self.own[0],
            fixed: self.fixed + more * self.own[1],
            ..self
        }
    }

    /// Whether anything is known; rays are carried everywhere otherwise.
    pub(super) fn is_bounded(&self) -> bool {
        self.relative <= SINGULAR
    }

    /// A box, widened for rays whose origins have no larger coordinates than `reach`; rounded outwards.
    #[allow(clippy::cast_possible_truncation, reason = "rounds, and the next number is taken")]
    pub(super) fn widened(&self, [low, high]: [DVec3; 2], reach: f64) -> Corners {
        let largest = low.abs().max(high.abs()).max_element();
        let by = 2.0 * (self.relative * (2.0 * reach + largest) + self.fixed);
        let down = |x: f64| {
            let rounded = x as f32;
            // It may be infinite, or NaN where the box is.
            let rounded = if f64::from(rounded) <= x { rounded } else { rounded.next_down() };
            rounded.max(f32::MIN)
        };
        let is_bounded = self.is_bounded() && by.is_finite();
        let begin = |x: f64| if is_bounded { down(x - by) } else { f32::MIN };
        let [x, y, z] = low.to_array().map(begin);
        let [p, q, r] = (-high).to_array().map(begin);
        Corners([x, y, z, 0.0, p, q, r, 0.0])
    }
}
