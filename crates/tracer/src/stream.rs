//! Many rays through the tree together: every node is visited once by all rays that meet it.
//!
//! Barringer, Akenine-Möller: Dynamic Ray Stream Traversal. ACM Transactions on Graphics 33(4), 2014.
//! Here a node has eight children, tested at once for each ray.

use trisect_core::{Culling, Lanes, Method, Vec3};

use crate::bvh::{Bvh, Child, Node, WIDTH, child};
use crate::traveller::{Octant, Traveller};

/// Rays that wait for a node or a leaf.
struct List {
    /// What they wait for.
    child: u32,
    /// The first of them; the last one is followed by the list above.
    start: usize,
}

/// What a stream needs besides its rays.
struct Lists {
    waiting: Vec<List>,
    /// All that wait, list after list, and room for more.
    numbers: Vec<u32>,
    /// Where each enters the box that it waits for.
    entries: Vec<f32>,
    /// How many wait.
    count: usize,
    /// Those at the node that is visited, and room for more,
    here: Vec<u32>,
    /// the children that they meet, in bits,
    met: Vec<u8>,
    /// and where.
    distances: Vec<[f32; WIDTH]>,
}

impl Lists {
    /// For so many rays at a time.
    fn new(rays: usize) -> Self {
        Self {
            waiting: Vec::new(),
            numbers: Vec::new(),
            entries: Vec::new(),
            count: 0,
            here: vec![0; rays],
            met: vec![0; rays],
            distances: vec![[0.0; WIDTH]; rays],
        }
    }

    /// Room for so many rays more.
    #[inline(always)]
    fn reserve(&mut self, more: usize) {
        if self.numbers.len() < self.count + more {
            self.numbers.resize(2 * (self.count + more), 0);
            self.entries.resize(2 * (self.count + more), 0.0);
        }
    }

    /// Puts rays on the list of the root.
    #[inline(always)]
    fn start(&mut self, rays: &[u32]) {
        self.reserve(rays.len());
        self.numbers[..rays.len()].copy_from_slice(rays);
        self.entries[..rays.len()].fill(f32::NEG_INFINITY);
        self.count = rays.len();
        self.waiting.push(List { child: 0, start: 0 });
    }

    /// Takes the rays of the uppermost list that still have something to find there, and says what they
    /// waited for, and how many they are.
    #[inline(always)]
    fn pop(&mut self, travellers: &[Traveller]) -> Option<(u32, usize)> {
        let List { child, start } = self.waiting.pop()?;
        let (numbers, entries) =
            (&self.numbers[start..self.count], &self.entries[start..self.count]);
        let here = &mut self.here[..numbers.len()];
        let mut count = 0;
        for (&number, &entry) in numbers.iter().zip(entries) {
            // Always written, and kept where it counts.
            here[count] = number;
            count += usize::from(entry <= travellers[number as usize].tmax());
        }
        self.count = start;
        Some((child, count))
    }

    /// Puts those of the first `here` that meet a child on a list of their own.
    #[inline(always)]
    fn push(&mut self, here: usize, node: &Node, lane: usize) {
        self.reserve(here);
        let start = self.count;
        let numbers = &mut self.numbers[start..start + here];
        let entries = &mut self.entries[start..start + here];
        let (all, met) = (&self.here[..here], &self.met[..here]);
        let mut count = 0;
        for ((&number, &met), distances) in all.iter().zip(met).zip(&self.distances[..here]) {
            // Always written, and kept where it is met.
            numbers[count] = number;
            entries[count] = distances[lane];
            count += usize::from(met >> lane & 1);
        }
        self.count = start + count;
        self.waiting.push(List { child: node.children[lane], start });
    }
}

/// As [`singly`](crate::single::singly), for rays that go together.
#[inline(always)]
pub(crate) fn stream<M, L, const ANY: bool, const ROBUST: bool>(
    bvh: &Bvh<M>,
    token: L::Token,
    culling: Culling,
    travellers: &mut [Traveller],
) where
    M: Method,
    L: Lanes<Elem = f32>,
{
    let mut lists = Lists::new(travellers.len());
    // Rays that look into one octant find the same planes of a box nearer.
    let mut octants: [Vec<u32>; 8] = Default::default();
    for (number, traveller) in (0_u32..).zip(&*travellers) {
        if traveller.has_any() {
            octants[traveller.octant().number()].push(number);
        }
    }
    for (octant, rays) in octants.iter().enumerate() {
        lists.start(rays);
        let towards = if ANY { Vec3::new(0.0, 0.0, 0.0) } else { towards(rays, travellers) };
        let octant = Octant::of(octant);
        while let Some((from, here)) = lists.pop(travellers) {
            match child(from) {
                Child::Leaf(first, count) => {
                    for &number in &lists.here[..here] {
                        let traveller = &mut travellers[number as usize];
                        let blocks = first..first + count;
                        traveller.test_leaf::<M, L, ANY, ROBUST>(bvh, token, blocks, culling);
                    }
                }
                Child::Node(place) => {
                    let node = &bvh.nodes[place];
                    let met = lists.met[..here].iter_mut();
                    let places = met.zip(&mut lists.distances[..here]);
                    let mut any = 0;
                    for (&number, (met, distances)) in lists.here[..here].iter().zip(places) {
                        let traveller = &travellers[number as usize];
                        let bits = traveller.meet::<L, ROBUST>(token, node, octant, distances);
                        #[allow(clippy::cast_possible_truncation, reason = "eight lanes")]
                        let bits = bits as u8;
                        *met = bits;
                        any |= bits;
                    }
                    if ANY {
                        while any != 0 {
                            lists.push(here, node, any.trailing_zeros() as usize);
                            any &= any - 1;
                        }
                    } else {
                        // The nearest is visited first.
                        let (order, count) = farthest_first(node, any, towards);
                        for &lane in &order[..count] {
                            lists.push(here, node, lane as usize % WIDTH);
                        }
                    }
                }
            }
        }
    }
}

/// Where rays look, those with directions of all lengths counting alike.
#[inline(always)]
fn towards(rays: &[u32], travellers: &[Traveller]) -> Vec3<f32> {
    let mut sum = Vec3::new(0.0, 0.0, 0.0);
    for &number in rays {
        let d = travellers[number as usize].direction();
        sum = sum + d.scale(1.0 / (d.x.abs() + d.y.abs() + d.z.abs()));
    }
    sum
}

/// Some children of a node, in bits, in the order of their middles along a direction from the far end;
/// and how many.
#[inline(always)]
fn farthest_first(node: &Node, mut some: u8, towards: Vec3<f32>) -> ([u32; WIDTH], usize) {
    let (mut order, mut along, mut count) = ([0; WIDTH], [0.0; WIDTH], 0);
    while some != 0 {
        let lane = some.trailing_zeros();
        some &= some - 1;
        let at = lane as usize % WIDTH;
        let [x, y, z] = &node.bounds;
        let key = (x[0][at] + x[1][at]) * towards.x
            + (y[0][at] + y[1][at]) * towards.y
            + (z[0][at] + z[1][at]) * towards.z;
        let mut place = count;
        while place > 0 && along[place - 1] < key {
            along[place] = along[place - 1];
            order[place] = order[place - 1];
            place -= 1;
        }
        along[place] = key;
        order[place] = lane;
        count += 1;
    }
    (order, count)
}
