//! A batch of rays or one ray, one query, and the tree that they go through.

use trisect_core::{Lanes, Ray, Token as _};

use super::packet::in_packets;
use super::single::{one, singly};
use super::target::{PacketTarget, Target};
use crate::lanes::Job;
use crate::query::Query;
use crate::rays::reorder::Order;

/// A batch of rays to be traced on lanes of choice.
pub(crate) struct Trace<'a, A: PacketTarget<'a, Q>, Q: Query> {
    pub(crate) target: A,
    pub(crate) seed: A::Seed,
    pub(crate) query: Q,
    pub(crate) rays: &'a [Ray<f32>],
    pub(crate) order: &'a Order,
    pub(crate) found: &'a mut [Q::Output],
}

impl<'a, A: PacketTarget<'a, Q>, Q: Query> Job for Trace<'a, A, Q> {
    type Output = ();

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { target, seed, query, rays, order, found } = self;
        let indices = match order {
            Order::Singly => {
                return token.run(
                    #[inline(always)]
                    || singly::<A, L, Q>(target, seed, token, query, rays, found),
                );
            }
            Order::Packets => None,
            Order::Reordered(indices) => Some(&indices[..]),
        };
        let leaves = &mut target.packets::<L>(token, query, seed);
        in_packets::<_, L, Q>(target.tree(), leaves, token, rays, indices, found);
    }
}

/// Rays to be traced on lanes of choice, each on its own way.
pub(crate) struct TraceSingly<'a, A: Target<'a, Q>, Q: Query> {
    pub(crate) target: A,
    pub(crate) seed: A::Seed,
    pub(crate) query: Q,
    pub(crate) rays: &'a [Ray<f32>],
    pub(crate) found: &'a mut [Q::Output],
}

impl<'a, A: Target<'a, Q>, Q: Query> Job for TraceSingly<'a, A, Q> {
    type Output = ();

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { target, seed, query, rays, found } = self;
        token.run(
            #[inline(always)]
            || singly::<A, L, Q>(target, seed, token, query, rays, found),
        );
    }
}

/// One ray to be traced on lanes of choice.
pub(crate) struct TraceOne<'a, A: Target<'a, Q, 1>, Q: Query> {
    pub(crate) target: A,
    pub(crate) seed: A::Seed,
    pub(crate) query: Q,
    pub(crate) ray: &'a Ray<f32>,
    /// Where what it finds is written, if it has anything to find. Not returned: what is handed on field by field
    /// and copied as a whole costs as much as visiting a node.
    pub(crate) found: &'a mut Q::Output,
}

impl<'a, A: Target<'a, Q, 1>, Q: Query> Job for TraceOne<'a, A, Q> {
    type Output = ();

    fn run<L: Lanes<Elem = f32>>(self, token: L::Token) {
        let Self { target, seed, query, ray, found } = self;
        token.run(
            #[inline(always)]
            move || one::<A, L, Q>(target, seed, token, query, ray, found),
        );
    }
}
