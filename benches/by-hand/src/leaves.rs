//! What leaves of any size cost: A. S. Morozov's experiment (2011), a chair of as many triangles as his, in a plain
//! binary tree.

use anyhow::{Result, ensure};
use fearless_simd::f32x8;
use fearless_simd::x86::Avx2;
use trisect_core::{Fused, Hit, Lanes as _, Ray, Token as _, Triangle, Vec3, Vector};
use trisect_kernels::{BLOCK, PreparedTriangles, one_ray_until};
use trisect_machine::forms::LeafTime;
use trisect_method::{Culling, Deferred, TrueDivision};
use trisect_moller_trumbore::MollerTrumbore;
use trisect_scene::Mesh;
use trisect_workloads::{Bounds, primary};

use crate::Tally;
use crate::loops::nearest;
use crate::record::Record;
use crate::timed::{Timed, in_turn};

/// The lanes of the tests in a leaf.
pub(crate) type Wide = Vector<Avx2, f32x8<Avx2>, Fused>;

/// Pixels across and down.
const SIDE: usize = 96;

/// Times trees with leaves of 4 triangles to 16,384, and no tree, where the processor has the instructions.
pub(crate) fn time(record: &mut Record) -> Result<()> {
    if Avx2::detect().is_none() {
        return Ok(());
    }
    let mesh = trisect_workloads::Mesh::from_triangles("chair", Mesh::chair().triangles)?;
    let rays = primary(&mesh, SIDE, SIDE).rays;
    let sizes = [usize::MAX].into_iter().chain((2..=14).map(|log| 1 << log));
    let trees = sizes.map(|leaf| Tree::new(mesh.triangles.to_vec(), leaf));
    let trees: Vec<Tree> = trees.collect::<Result<_>>()?;
    let mut all: Vec<Timed<'_, LeafTime>> = Vec::new();
    for tree in &trees {
        let what = LeafTime {
            leaf: if tree.leaf == usize::MAX { 0 } else { tree.leaf },
            leaves: tree.leaves.len(),
            triangles: mesh.triangles.len(),
            rays: rays.len() as u64,
            hits: 0,
            tests: tree.trace(&rays).1,
            samples_ns: Vec::new(),
        };
        all.push(Timed::new(what, 1, || tree.trace(&rays).0));
    }
    let same = all.iter().all(|tree| tree.found.hits == all[0].found.hits);
    ensure!(same, "the size of leaves changes what is hit");
    in_turn(&mut all, record.rounds, &mut record.meter)?;
    for Timed { what, samples_ns, found, .. } in all {
        record.add("leaf", &LeafTime { hits: found.hits, samples_ns, ..what })?;
    }
    Ok(())
}

/// A binary tree, cut at the median of the longest axis until leaves are small enough.
struct Tree {
    /// Triangles of a leaf, at most; without a limit there is no box either.
    leaf: usize,
    root: Node,
    leaves: Vec<Leaf>,
}

/// How many triangles, and these.
type Leaf = (u64, PreparedTriangles<MollerTrumbore, f32>);

struct Node {
    low: [f32; 3],
    high: [f32; 3],
    inside: Inside,
}

enum Inside {
    /// The number of a leaf.
    Leaf(usize),
    /// The lower half along an axis, and the upper one.
    Halves(usize, Box<[Node; 2]>),
}

impl Tree {
    fn new(mut triangles: Vec<Triangle<f32>>, leaf: usize) -> Result<Self> {
        let mut leaves = Vec::new();
        let mut root = Node::new(&mut triangles, leaf, &mut leaves)?;
        if leaf == usize::MAX {
            (root.low, root.high) = ([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        }
        Ok(Self { leaf, root, leaves })
    }

    /// The closest hits, and how many tests they took.
    fn trace(&self, rays: &[Ray<f32>]) -> (Tally, u64) {
        let (mut tally, mut tests) = (Tally::default(), 0);
        for ray in rays {
            let mut best = None;
            let inverse = ray.d.to_array().map(f32::recip);
            self.visit(&self.root, ray, inverse, &mut best, &mut tests);
            tally.take(&mut best);
        }
        (tally, tests)
    }

    fn visit(
        &self,
        node: &Node,
        ray: &Ray<f32>,
        inverse: [f32; 3],
        best: &mut Option<f32>,
        tests: &mut u64,
    ) {
        if !node.is_met(ray, inverse, best.unwrap_or(ray.tmax)) {
            return;
        }
        match &node.inside {
            Inside::Leaf(leaf) => {
                let (count, triangles) = &self.leaves[*leaf];
                *tests += count;
                closest(ray, triangles, best);
            }
            Inside::Halves(axis, halves) => {
                let first = usize::from(inverse[*axis] < 0.0);
                for half in [first, 1 - first] {
                    self.visit(&halves[half], ray, inverse, best, tests);
                }
            }
        }
    }
}

/// The closest hit of a leaf, or the best so far.
fn closest(
    ray: &Ray<f32>,
    triangles: &PreparedTriangles<MollerTrumbore, f32>,
    best: &mut Option<f32>,
) {
    let Some(token) = Avx2::detect() else { return };
    token.run(
        #[inline(always)]
        || {
            let ray = Ray { tmax: best.unwrap_or(ray.tmax), ..*ray };
            one_ray_until::<MollerTrumbore, Wide, Deferred<TrueDivision, true>>(
                token,
                &ray,
                triangles,
                Culling::None,
                #[inline(always)]
                |_, mask, Hit { t, .. }| {
                    let mut all = [0.0; BLOCK];
                    t.store(&mut all);
                    nearest(Wide::bits(mask), &all, best);
                    *best
                },
            );
        },
    );
}

impl Node {
    fn new(triangles: &mut [Triangle<f32>], leaf: usize, leaves: &mut Vec<Leaf>) -> Result<Self> {
        let [low, high] = Bounds::of(triangles)
            .map_or([[0.0; 3]; 2], |bounds| [bounds.min, bounds.max].map(Vec3::to_array));
        let inside = if triangles.len() <= leaf {
            leaves.push((triangles.len() as u64, PreparedTriangles::new(triangles)?));
            Inside::Leaf(leaves.len() - 1)
        } else {
            let side = |axis: &usize| high[*axis] - low[*axis];
            let axis = (0..3).max_by(|a, b| side(a).total_cmp(&side(b))).unwrap_or(0);
            let middle = |triangle: &Triangle<f32>| {
                triangle.corners().map(|corner| corner.to_array()[axis]).iter().sum::<f32>()
            };
            let half = triangles.len() / 2;
            triangles.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
            let (lower, upper) = triangles.split_at_mut(half);
            let halves = [Self::new(lower, leaf, leaves)?, Self::new(upper, leaf, leaves)?];
            Inside::Halves(axis, Box::new(halves))
        };
        Ok(Self { low, high, inside })
    }

    /// Whether a ray meets the box before `end`.
    fn is_met(&self, ray: &Ray<f32>, inverse: [f32; 3], end: f32) -> bool {
        let o = ray.o.to_array();
        let (mut near, mut far) = (ray.tmin, end);
        for axis in 0..3 {
            let [a, b] = [self.low, self.high].map(|side| (side[axis] - o[axis]) * inverse[axis]);
            // A NaN, of a ray in a side, is passed over.
            (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        }
        // Three roundings of each, so that no hit is lost.
        near <= far * (1.0 + 4.0 * f32::EPSILON)
    }
}
