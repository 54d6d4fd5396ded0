//! How the axis that a triangle is projected along is kept.

use core::error::Error;
use core::fmt;

use trisect_core::{Lanes, Ray, Scalar, Triangle, Vec3};
use trisect_method::{Of, Record, UnsuitableMesh, record};

record! {
    /// Nothing but the axis `w`; `u` and `v` follow by table.
    pub struct AxisNumber {
        /// 0, 1 or 2.
        w: number,
    }
}

record! {
    /// The three axes in the order `u, v, w`.
    pub struct AxisNumbers {
        /// 0, 1 or 2.
        u: number,
        /// 0, 1 or 2.
        v: number,
        /// 0, 1 or 2.
        w: number,
    }
}

/// How the axis that a triangle is projected along is kept.
pub trait AxisChoice: Send + Sync + 'static {
    /// Name of the method, constants in world space, as typed on the command line.
    const NAME: &'static str;
    /// The same in prose.
    const TITLE: &'static str;
    /// Kinds of triangles: one where each carries its axis.
    const GROUPS: usize;
    /// What is stored per triangle.
    type Stored: Record;
    /// What is stored for axis `w`.
    fn store<X: Scalar>(w: usize) -> Of<Self::Stored, X>;
    /// The ray with its coordinates in the triangle's order `u, v, w`; as it is where the ray was
    /// prepared so.
    fn in_order<L: Lanes>(stored: &Of<Self::Stored, L>, ray: &Ray<L>) -> Ray<L>;
    /// The one axis for all triangles of a mesh, if it is to be one.
    ///
    /// # Errors
    /// When there is none.
    fn mesh_axis<X: Scalar>(_triangles: &[Triangle<X>]) -> Result<Option<usize>, UnsuitableMesh> {
        Ok(None)
    }
}

/// Triangles are sorted into three groups by axis, so that none carries it; or all are of one, `FIXED`
/// for the mesh.
pub struct Sorted<const FIXED: bool>;

/// Each triangle is in the group of the axis that suits it best.
pub type Grouped = Sorted<false>;

/// All triangles of a mesh have one axis.
pub type Fixed = Sorted<true>;

impl<const FIXED: bool> AxisChoice for Sorted<FIXED> {
    const NAME: &'static str = if FIXED { "wald-fixed-axis" } else { "wald" };
    const TITLE: &'static str = if FIXED { "Wald, one axis for the mesh" } else { "Wald" };
    const GROUPS: usize = 3;
    type Stored = ();
    #[inline(always)]
    fn store<X: Scalar>(_w: usize) {}
    #[inline(always)]
    fn in_order<L: Lanes>((): &(), ray: &Ray<L>) -> Ray<L> {
        *ray
    }
    fn mesh_axis<X: Scalar>(triangles: &[Triangle<X>]) -> Result<Option<usize>, UnsuitableMesh> {
        if FIXED { common_axis(triangles).map(Some).map_err(UnsuitableMesh::new) } else { Ok(None) }
    }
}

/// The triangles of a mesh share no axis to be projected along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoCommonAxis {
    /// Per axis, the number of a triangle that is parallel to it.
    pub parallel: [usize; 3],
}

impl fmt::Display for NoCommonAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.parallel;
        write!(
            f,
            "the triangles share no axis to be projected along: triangle {x} is parallel to x, \
             {y} to y, {z} to z; use wald, which has an axis per triangle"
        )
    }
}

impl Error for NoCommonAxis {}

/// The axis that all triangles of a mesh can be projected along: the one along which the least
/// favourable triangle keeps the largest share of its area.
fn common_axis<X: Scalar>(triangles: &[Triangle<X>]) -> Result<usize, NoCommonAxis> {
    let zero = X::from_f64(0.0);
    let mut shares = [(X::from_f64(1.0), 0); 3];
    for (number, triangle) in triangles.iter().enumerate() {
        // What never hits does so whatever the axis.
        let n = triangle.or_nothing().normal().map(X::abs);
        let largest = n.to_array()[n.largest_axis()];
        if largest > zero {
            for (least, share) in shares.iter_mut().zip(n.map(|x| x / largest).to_array()) {
                if share < least.0 {
                    *least = (share, number);
                }
            }
        }
    }
    let mut best = 0;
    for axis in 1..3 {
        if shares[axis].0 > shares[best].0 {
            best = axis;
        }
    }
    if shares[best].0 > zero {
        return Ok(best);
    }
    Err(NoCommonAxis { parallel: shares.map(|(_, number)| number) })
}

/// Each triangle carries its axis `w`; the two others are looked up.
pub struct ByTable;

impl AxisChoice for ByTable {
    const NAME: &'static str = "wald-table";
    const TITLE: &'static str = "Wald, axis by table";
    const GROUPS: usize = 1;
    type Stored = AxisNumber<()>;
    #[inline(always)]
    fn store<X: Scalar>(w: usize) -> AxisNumber<X> {
        AxisNumber { w: axis_number(w) }
    }
    #[inline(always)]
    fn in_order<L: Lanes>(stored: &AxisNumber<L>, ray: &Ray<L>) -> Ray<L> {
        Ray { o: look_up(stored.w, ray.o), d: look_up(stored.w, ray.d), ..*ray }
    }
}

/// Each triangle carries its three axes in order.
pub struct ByIndices;

impl AxisChoice for ByIndices {
    const NAME: &'static str = "wald-indices";
    const TITLE: &'static str = "Wald, axis by indices";
    const GROUPS: usize = 1;
    type Stored = AxisNumbers<()>;
    #[inline(always)]
    fn store<X: Scalar>(w: usize) -> AxisNumbers<X> {
        let [u, v] = [1, 2].map(|step| axis_number((w + step) % 3));
        AxisNumbers { u, v, w: axis_number(w) }
    }
    #[inline(always)]
    fn in_order<L: Lanes>(stored: &AxisNumbers<L>, ray: &Ray<L>) -> Ray<L> {
        Ray { o: stored.take(ray.o), d: stored.take(ray.d), ..*ray }
    }
}

impl<L: Lanes> AxisNumbers<L> {
    /// The coordinates in order.
    #[inline(always)]
    fn take(&self, v: Vec3<L>) -> Vec3<L> {
        Vec3::new(pick(self.u, v), pick(self.v, v), pick(self.w, v))
    }
}

/// The coordinates in the order that table has for axis `w`.
#[inline(always)]
fn look_up<L: Lanes>(w: L, Vec3 { x, y, z }: Vec3<L>) -> Vec3<L> {
    Vec3::new(pick(w, Vec3::new(y, z, x)), pick(w, Vec3::new(z, x, y)), pick(w, Vec3::new(x, y, z)))
}

fn axis_number<X: Scalar>(axis: usize) -> X {
    X::from_f64([0.0, 1.0, 2.0][axis])
}

/// The coordinate of `v` along an axis that differs from lane to lane.
#[inline(always)]
fn pick<L: Lanes>(axis: L, v: Vec3<L>) -> L {
    let half = axis.constant(L::Elem::from_f64(0.5));
    let three_halves = axis.constant(L::Elem::from_f64(1.5));
    L::select(axis.lt(half), v.x, L::select(axis.lt(three_halves), v.y, v.z))
}
