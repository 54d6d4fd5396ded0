//! The edge functions, whose signs decide.

use trisect_core::{Lanes, Scalar, Vec3};

/// How the three edge functions are computed.
pub trait EdgeFunction: Send + Sync + 'static {
    /// Of the edges opposite `a`, `b` and `c`.
    fn edges<L: Lanes>(a: Vec3<L>, b: Vec3<L>, c: Vec3<L>) -> [L; 3];
}

/// `p.x·q.y − p.y·q.x`, in products and a difference of one precision. Products round monotonically,
/// so a sign may become zero but never flip; a fused multiply-add would break that.
#[inline(always)]
fn edge<L: Lanes>(p: Vec3<L>, q: Vec3<L>) -> L {
    p.x * q.y - p.y * q.x
}

/// One precision alone.
pub struct OnePrecision;

impl EdgeFunction for OnePrecision {
    #[inline(always)]
    fn edges<L: Lanes>(a: Vec3<L>, b: Vec3<L>, c: Vec3<L>) -> [L; 3] {
        [edge(c, b), edge(a, c), edge(b, a)]
    }
}

/// Edge functions that come out as zero are computed again in twice the precision, as published for
/// f32 with f64.
pub struct TwicePrecision;

impl EdgeFunction for TwicePrecision {
    #[inline(always)]
    fn edges<L: Lanes>(a: Vec3<L>, b: Vec3<L>, c: Vec3<L>) -> [L; 3] {
        let [u, v, w] = OnePrecision::edges(a, b, c);
        if !L::any(u.is_zero() | v.is_zero() | w.is_zero()) {
            return [u, v, w];
        }
        [again(u, c, b), again(v, a, c), again(w, b, a)]
    }
}

/// An edge function, or where it is zero what rounding took from it: the two products round to one
/// number then, and their difference is that of their errors.
#[inline(always)]
fn again<L: Lanes>(rounded: L, p: Vec3<L>, q: Vec3<L>) -> L {
    let lost = product_error(p.x, q.y) - product_error(p.y, q.x);
    L::select(rounded.is_zero(), lost, rounded)
}

/// `a·b − round(a·b)`, exactly, while nothing under- or overflows: Dekker's product of halves, in
/// plain arithmetic so that every instruction set has the same bits.
#[inline(always)]
fn product_error<L: Lanes>(a: L, b: L) -> L {
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    ((ah * bh - a * b) + ah * bl + al * bh) + al * bl
}

/// Veltkamp's splitting into halves whose products are exact.
#[inline(always)]
fn split<L: Lanes>(x: L) -> (L, L) {
    let scaled = x.constant(L::Elem::splitter()) * x;
    let high = scaled - (scaled - x);
    (high, x - high)
}
