//! What a caller asks of a hit. A kernel computes what is asked and nothing else.

use crate::geometry::Hit;
use crate::lanes::Lanes;

/// What a caller asks of a hit.
pub trait Needs: 'static {
    /// The name used in records.
    const NAME: &'static str;
    /// Everything asked, folded into one number, so that a measured kernel can neither leave out
    /// what is asked nor be made to compute what is not; nothing where nothing is asked.
    fn fold<L: Lanes>(hit: Hit<L>) -> Option<L>;
}

/// Whether there is a hit; no division, no `t`.
pub struct Occlusion;

impl Needs for Occlusion {
    const NAME: &'static str = "occlusion";
    #[inline(always)]
    fn fold<L: Lanes>(_hit: Hit<L>) -> Option<L> {
        None
    }
}

/// `t` alone.
pub struct Distance;

impl Needs for Distance {
    const NAME: &'static str = "t";
    #[inline(always)]
    fn fold<L: Lanes>(hit: Hit<L>) -> Option<L> {
        Some(hit.t)
    }
}

/// `t`, `beta` and `gamma`.
pub struct Barycentrics;

impl Needs for Barycentrics {
    const NAME: &'static str = "barycentrics";
    #[inline(always)]
    fn fold<L: Lanes>(hit: Hit<L>) -> Option<L> {
        Some(hit.t + (hit.beta + hit.gamma))
    }
}
