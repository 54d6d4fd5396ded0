//! Rays through a tree whose leaves are behind a call: the way through its nodes is compiled here, once for all
//! methods.

use trisect_core::{Lanes, Ray, Token as _};

use crate::hit::Found;
use crate::lanes::{Job, OnFast, OnLanes, OnOne, OnPlain};
use crate::leaves::Whole;
use crate::order::Order;
use crate::packet::in_packets;
use crate::single::singly;

/// The lanes that leaves are tested on, and the nodes as well.
#[derive(Clone, Copy)]
pub(crate) enum On {
    Fast,
    Plain,
    One,
}

/// Rays, and the tree that they are to go through.
pub(crate) struct Called<'a> {
    pub(crate) tree: Whole<'a>,
    /// Whether tests of boxes allow for rounding.
    pub(crate) is_robust: bool,
    /// Whether any hit will do.
    pub(crate) any: bool,
    pub(crate) rays: &'a [Ray<f32>],
    pub(crate) order: Order,
}

impl Called<'_> {
    /// Traces the rays.
    pub(crate) fn trace<T: Found>(self, on: On, found: &mut [T]) {
        match (on, self.any, self.is_robust) {
            (On::Fast, false, false) => self.run::<OnFast, T, false, false>(found),
            (On::Fast, false, true) => self.run::<OnFast, T, false, true>(found),
            (On::Fast, true, false) => self.run::<OnFast, T, true, false>(found),
            (On::Fast, true, true) => self.run::<OnFast, T, true, true>(found),
            (On::Plain, ..) => self.run::<OnPlain, T, false, true>(found),
            (On::One, ..) => self.run::<OnOne, T, false, true>(found),
        }
    }

    fn run<O: OnLanes, T: Found, const ANY: bool, const ROBUST: bool>(self, found: &mut [T]) {
        O::run(Through::<T, ANY, ROBUST> { called: self, found });
    }
}

/// Rays on their way, on lanes of choice.
struct Through<'a, T, const ANY: bool, const ROBUST: bool> {
    called: Called<'a>,
    found: &'a mut [T],
}

impl<T: Found, const ANY: bool, const ROBUST: bool> Job for Through<'_, T, ANY, ROBUST> {
    type Output = ();
    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { called: Called { tree, rays, order, .. }, found } = self;
        match order {
            Order::Packets(numbers) => {
                in_packets::<L, T, ROBUST>(tree, token, rays, &numbers, found);
            }
            Order::Singly => token.run(
                #[inline(always)]
                || singly::<_, L, T, ANY, ROBUST>(&tree, token, rays, found),
            ),
        }
    }
}
