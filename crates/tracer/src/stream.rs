//! Many rays through the tree together: every node is visited once by all rays that meet it.
//!
//! Barringer, Akenine-Möller: Dynamic Ray Stream Traversal. ACM Transactions on Graphics 33(4), 2014.
//! Here a node has eight children, tested at once for each ray, and few rays go on alone.

use trisect_core::{Culling, Lanes, Method, Vec3};

use crate::bvh::{Bvh, Child, Node, WIDTH, child};
use crate::single::{Stacks, fly};
use crate::traveller::{Octant, Traveller};

/// So few rays go on alone: what they would share is not worth its lists.
const FEW: usize = 4;

/// Rays that wait for a node or a leaf.
struct List {
    /// What they wait for.
    child: u32,
    /// The first of them; the last one is followed by the list above.
    start: usize,
}

/// What a stream needs besides its rays; kept from one to the next.
pub(crate) struct Lists {
    stacks: Stacks,
    /// The rays that look into each octant.
    octants: [Vec<u32>; 8],
    waiting: Vec<List>,
    /// The numbers of all that wait, list after list.
    numbers: Vec<u32>,
    /// Where each enters the box that it waits for.
    entries: Vec<f32>,
    /// Those at the node that is visited,
    here: Vec<u32>,
    /// the children that they meet, in bits,
    met: Vec<u8>,
    /// and where.
    distances: Vec<[f32; WIDTH]>,
}

impl Lists {
    /// For trees of a depth.
    pub(crate) fn new(depth: usize) -> Self {
        Self {
            stacks: Stacks::new(depth),
            octants: Default::default(),
            waiting: Vec::new(),
            numbers: Vec::new(),
            entries: Vec::new(),
            here: Vec::new(),
            met: Vec::new(),
            distances: Vec::new(),
        }
    }

    /// Takes the rays of the uppermost list that still have something to find there, and says what they
    /// waited for.
    #[inline(always)]
    fn pop(&mut self, travellers: &[Traveller]) -> Option<u32> {
        let List { child, start } = self.waiting.pop()?;
        let waiting = self.numbers.len() - start;
        self.here.clear();
        self.here.resize(waiting, 0);
        let mut count = 0;
        for (&number, &entry) in self.numbers[start..].iter().zip(&self.entries[start..]) {
            // Always written, and kept where it counts.
            self.here[count] = number;
            count += usize::from(entry <= travellers[number as usize].tmax());
        }
        self.here.truncate(count);
        self.numbers.truncate(start);
        self.entries.truncate(start);
        Some(child)
    }

    /// Puts those that are here and meet a child on a list of their own.
    #[inline(always)]
    fn push(&mut self, node: &Node, lane: usize) {
        let start = self.numbers.len();
        self.numbers.resize(start + self.here.len(), 0);
        self.entries.resize(start + self.here.len(), 0.0);
        let (numbers, entries) = (&mut self.numbers[start..], &mut self.entries[start..]);
        let mut count = 0;
        for ((&number, &met), distances) in self.here.iter().zip(&self.met).zip(&self.distances) {
            // Always written, and kept where it is met.
            numbers[count] = number;
            entries[count] = distances[lane];
            count += usize::from(met >> lane & 1);
        }
        self.numbers.truncate(start + count);
        self.entries.truncate(start + count);
        self.waiting.push(List { child: node.children[lane], start });
    }
}

/// As [`fly`], from the root, for all travellers; each on its own where they do not go `together`.
#[inline(always)]
pub(crate) fn stream<M, L, const ANY: bool, const ROBUST: bool>(
    bvh: &Bvh<M>,
    token: L::Token,
    culling: Culling,
    travellers: &mut [Traveller],
    together: bool,
    lists: &mut Lists,
) where
    M: Method,
    L: Lanes<Elem = f32>,
{
    // Rays that look into one octant find the same planes of a box nearer.
    for (number, traveller) in (0_u32..).zip(&*travellers) {
        if traveller.has_any() {
            let octant = if together { traveller.octant().number() } else { 0 };
            lists.octants[octant].push(number);
        }
    }
    for octant in 0..8 {
        lists.numbers.append(&mut lists.octants[octant]);
        let octant = Octant::of(octant);
        let mut towards = Vec3::new(0.0, 0.0, 0.0);
        if together {
            for &number in &lists.numbers {
                towards = towards + unit(travellers[number as usize].direction());
            }
        }
        lists.entries.resize(lists.numbers.len(), f32::NEG_INFINITY);
        lists.waiting.push(List { child: 0, start: 0 });
        while let Some(from) = lists.pop(travellers) {
            if !together || lists.here.len() <= FEW {
                fly::<M, L, ANY, ROBUST>(
                    bvh,
                    token,
                    culling,
                    travellers,
                    &lists.here,
                    from,
                    &mut lists.stacks,
                );
                continue;
            }
            match child(from) {
                Child::Leaf(first, count) => {
                    for &number in &lists.here {
                        let traveller = &mut travellers[number as usize];
                        let blocks = first..first + count;
                        traveller.test_leaf::<M, L, ANY, ROBUST>(bvh, token, blocks, culling);
                    }
                }
                Child::Node(place) => {
                    let node = &bvh.nodes[place];
                    let here = lists.here.len();
                    lists.met.resize(here, 0);
                    lists.distances.resize(here, [0.0; WIDTH]);
                    let places = lists.met.iter_mut().zip(&mut lists.distances);
                    let mut any = 0;
                    for (&number, (met, distances)) in lists.here.iter().zip(places) {
                        let bits;
                        (bits, *distances) =
                            travellers[number as usize].meet::<L, ROBUST>(token, node, octant);
                        #[allow(clippy::cast_possible_truncation, reason = "eight lanes")]
                        let bits = bits as u8;
                        *met = bits;
                        any |= bits;
                    }
                    // The nearest is visited first.
                    for lane in farthest_first(node, towards) {
                        if any >> lane & 1 == 1 {
                            lists.push(node, lane);
                        }
                    }
                }
            }
        }
    }
}

/// A direction, so that those of all lengths count alike.
#[inline(always)]
fn unit(d: Vec3<f32>) -> Vec3<f32> {
    d.scale(1.0 / (d.x.abs() + d.y.abs() + d.z.abs()))
}

/// The children of a node in the order of their middles along a direction, from the far end.
#[inline(always)]
fn farthest_first(node: &Node, towards: Vec3<f32>) -> [usize; WIDTH] {
    let mut keys = [0_u64; WIDTH];
    for (lane, key) in keys.iter_mut().enumerate() {
        let middle = |axis: usize| node.bounds[axis][0][lane] + node.bounds[axis][1][lane];
        let along = middle(0) * towards.x + middle(1) * towards.y + middle(2) * towards.z;
        // In the order of the numbers: negative ones from below.
        let bits = along.to_bits();
        let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
        *key = u64::from(!ordered) << 32 | lane as u64;
    }
    keys.sort_unstable();
    let mut order = [0; WIDTH];
    #[allow(clippy::cast_possible_truncation, reason = "eight lanes")]
    for (place, key) in order.iter_mut().zip(keys) {
        *place = (key % WIDTH as u64) as usize;
    }
    order
}
