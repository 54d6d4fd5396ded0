//! Rays through the tree, each on its own way.

use std::hint::select_unpredictable;

use trisect_core::{Culling, Lanes, Method, Ray};

use crate::bvh::{Bvh, Child, Node, WIDTH, child};
use crate::exactly::{Given, arrive};
use crate::hit::Found;
use crate::leaf::{end, test_leaf};
use crate::rows::{RAYS, Rows};
use crate::waiting::{self, Stack};

/// A child that waits to be visited: the [`key`](waiting::key) of its number.
type Waiting = u64;

/// Rays that are on their way at the same time: while one waits for the outcome of its last test, the
/// other goes on. More gained nothing where it was tried.
const IN_FLIGHT: usize = 2;

/// A ray under way.
struct Flight<'a> {
    /// Its place.
    place: usize,
    /// The node that was visited last.
    node: &'a Node,
    /// Its children that the ray meets, in bits, and where. They are looked at when it is the ray's
    /// turn again: by then they are known, and a branch on them that was predicted wrongly costs little.
    met: u64,
    distances: [f32; WIDTH],
    waiting: Stack<'a, Waiting>,
}

impl<'a> Flight<'a> {
    /// Puts the next of the rays that are left at the root; whether there is one.
    #[inline(always)]
    fn launch<L: Lanes<Elem = f32>, const ROBUST: bool>(
        &mut self,
        token: L::Token,
        rows: &Rows,
        root: &'a Node,
        left: &mut u64,
    ) -> bool {
        if *left == 0 {
            return false;
        }
        self.place = left.trailing_zeros() as usize;
        *left &= *left - 1;
        self.waiting.clear();
        self.visit::<L, ROBUST>(token, rows, root);
        true
    }

    #[inline(always)]
    fn visit<L: Lanes<Elem = f32>, const ROBUST: bool>(
        &mut self,
        token: L::Token,
        rows: &Rows,
        node: &'a Node,
    ) {
        let slabs = rows.slabs::<L>(token, self.place);
        let interval = rows.interval::<L>(token, self.place);
        self.node = node;
        self.met = 0;
        let mut lane = 0;
        while lane < WIDTH {
            let from = node.planes::<L>(token, [0; 3], lane);
            let to = node.planes::<L>(token, [1; 3], lane);
            let (from, to) = slabs.cross_either_way::<ROBUST>(from, to, interval);
            self.met |= L::bits(from.le(to)) << lane;
            from.store(&mut self.distances[lane..]);
            lane += L::N;
        }
    }

    /// Visits a node or a leaf; whether the ray has arrived.
    #[inline(always)]
    fn step<M, L, const ANY: bool, const ROBUST: bool>(
        &mut self,
        bvh: &'a Bvh<M>,
        token: L::Token,
        culling: Culling,
        rows: &mut Rows,
    ) -> bool
    where
        M: Method,
        L: Lanes<Elem = f32>,
    {
        let current = if self.met != 0 {
            descend::<ANY>(&mut self.waiting, self.node, self.met, &self.distances)
        } else {
            // What begins behind the best hit is not worth a visit any more.
            loop {
                let Some(item) = self.waiting.pop() else { return true };
                if ANY || waiting::distance(item) <= rows.tmax(self.place) {
                    break waiting::place(item);
                }
            }
        };
        match child(current) {
            Child::Node(at) => self.visit::<L, ROBUST>(token, rows, &bvh.nodes[at]),
            Child::Leaf(first, count) => {
                self.met = 0;
                let blocks = first..first + count;
                let (ray, best) = (rows.ray(self.place), &mut rows.best[self.place % RAYS]);
                test_leaf::<M, L, ANY>(token, blocks, Given { bvh, ray, culling }, best);
                if best.is_hit() {
                    let tmax = end::<ANY, ROBUST>(best, ray.tmax);
                    rows.end(self.place, tmax);
                    return ANY;
                }
            }
        }
        false
    }
}

/// The nearest hit of each ray, of equally near ones that of the lowest number; any hit where `ANY`. The
/// tests of boxes allow for rounding where `ROBUST`.
#[inline(always)]
pub(crate) fn singly<M, L, T, const ANY: bool, const ROBUST: bool>(
    bvh: &Bvh<M>,
    token: L::Token,
    culling: Culling,
    rays: &[Ray<f32>],
    found: &mut [T],
) where
    M: Method,
    L: Lanes<Elem = f32>,
    T: Found,
{
    let root = &bvh.nodes[0];
    let mut rows = Rows::EMPTY;
    let room = waiting::room(bvh.depth);
    let mut items = vec![0; room * IN_FLIGHT];
    let mut parts = items.chunks_exact_mut(room);
    let mut flights: [Flight<'_>; IN_FLIGHT] = std::array::from_fn(|_| Flight {
        place: 0,
        node: root,
        met: 0,
        distances: [0.0; WIDTH],
        waiting: Stack::new(parts.next().expect("each has its room")),
    });
    for (rays, found) in rays.chunks(RAYS).zip(found.chunks_mut(RAYS)) {
        let mut left = rows.fill::<L, ROBUST>(token, rays.iter());
        let mut count = 0;
        while count < IN_FLIGHT && flights[count].launch::<L, ROBUST>(token, &rows, root, &mut left)
        {
            count += 1;
        }
        // Whose turn it is next: the other's, but when one is left.
        let (mut at, mut other) = (0, count / IN_FLIGHT);
        while count > 0 {
            let flight = &mut flights[at % IN_FLIGHT];
            if flight.step::<M, L, ANY, ROBUST>(bvh, token, culling, &mut rows)
                && !flight.launch::<L, ROBUST>(token, &rows, root, &mut left)
            {
                count -= 1;
                at ^= other;
                other = 0;
                continue;
            }
            at ^= other;
        }
        if const { M::INFO.claims.exact && !ANY } {
            arrive(bvh, &mut rows);
        }
        for (found, best) in found.iter_mut().zip(&rows.best) {
            *found = T::of(best);
        }
    }
}

/// The child to visit next, of those that are met: the nearest, or any where that is all the same. The
/// others wait, the nearer above the farther.
#[inline(always)]
pub(crate) fn descend<const ANY: bool>(
    waiting: &mut Stack<'_, Waiting>,
    node: &Node,
    mut met: u64,
    distances: &[f32; WIDTH],
) -> u32 {
    let first = lowest(met);
    met &= met - 1;
    if met == 0 {
        return node.children[first];
    }
    if ANY {
        // In the order of the lanes: see the builder.
        while met != 0 {
            let last = met.ilog2() as usize % WIDTH;
            waiting.push(u64::from(node.children[last]));
            met ^= 1 << last;
        }
        return node.children[first];
    }
    // Two or three mostly, which is as hard to foretell as their order: so without branches.
    let nearest = item(node, distances, first);
    let second = item(node, distances, lowest(met));
    met &= met - 1;
    let third = select_unpredictable(met != 0, item(node, distances, lowest(met)), NOTHING);
    met &= met.wrapping_sub(1);
    let (nearest, second) = in_order(nearest, second);
    let (second, third) = in_order(second, third);
    let (mut nearest, second) = in_order(nearest, second);
    let base = waiting.count();
    waiting.push_if(third != NOTHING, third);
    waiting.push(second);
    while met != 0 {
        let other = item(node, distances, lowest(met));
        met &= met - 1;
        waiting.insert(base, nearest.max(other), |item| item);
        nearest = nearest.min(other);
    }
    waiting::place(nearest)
}

/// No child: farther than all.
const NOTHING: Waiting = u64::MAX;

/// The nearer first.
#[inline(always)]
fn in_order(a: Waiting, b: Waiting) -> (Waiting, Waiting) {
    let is_less = a < b;
    (select_unpredictable(is_less, a, b), select_unpredictable(is_less, b, a))
}

/// The place of the lowest bit.
#[inline(always)]
fn lowest(bits: u64) -> usize {
    bits.trailing_zeros() as usize % WIDTH
}

/// A child and where the ray enters it.
#[inline(always)]
fn item(node: &Node, distances: &[f32; WIDTH], lane: usize) -> Waiting {
    waiting::key(distances[lane], node.children[lane])
}
