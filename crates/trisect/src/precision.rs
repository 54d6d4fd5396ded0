//! The precisions of scenes.

use std::cell::Cell;

use trisect_exact::ExactInTrees;
use trisect_mesh::Mesh;
use trisect_moller_trumbore::MollerTrumbore;
use trisect_tracer::{Builder, Leaves, TriangleHit};
use trisect_watertight::Watertight;

use crate::Triangle;
use crate::trees::{Built, build};

/// `f32` or `f64`: the precision of a [`Scene`](crate::Scene), its rays and its hits.
pub trait Precision: Scenes {}

impl Precision for f32 {}
impl Precision for f64 {}

/// What scenes of a precision are made of. None of it is generic: it is compiled in this crate, once.
pub trait Scenes: trisect_tracer::Precision {
    /// Builds the trees of [`SceneOptions::exact`](crate::SceneOptions::exact).
    ///
    /// # Errors
    /// Never: the method takes every mesh.
    fn exact(triangles: &[Triangle<Self>], builder: Builder, leaves: Leaves) -> Built<Self>;

    /// Those of [`SceneOptions::fast`](crate::SceneOptions::fast).
    ///
    /// # Errors
    /// Never: the method takes every mesh.
    fn fast(triangles: &[Triangle<Self>], builder: Builder, leaves: Leaves) -> Built<Self>;

    /// Those of [`SceneOptions::watertight`](crate::SceneOptions::watertight).
    ///
    /// # Errors
    /// Never: the method takes every mesh.
    fn watertight(triangles: &[Triangle<Self>], builder: Builder, leaves: Leaves) -> Built<Self>;

    /// The triangles of a mesh.
    fn triangles(mesh: &Mesh) -> Vec<Triangle<Self>>;

    /// Where a ray's hits are gathered: kept from ray to ray, so that none allocates. Not there meanwhile.
    fn gathering<T>(gather: impl FnOnce(&mut Vec<TriangleHit<Self>>) -> T) -> T;
}

macro_rules! scenes {
    ($float:ident, $triangles:expr) => {
        impl Scenes for $float {
            fn exact(
                triangles: &[Triangle<$float>],
                builder: Builder,
                leaves: Leaves,
            ) -> Built<$float> {
                build::<ExactInTrees, $float>(triangles, builder, leaves)
            }

            fn fast(
                triangles: &[Triangle<$float>],
                builder: Builder,
                leaves: Leaves,
            ) -> Built<$float> {
                build::<MollerTrumbore, $float>(triangles, builder, leaves)
            }

            fn watertight(
                triangles: &[Triangle<$float>],
                builder: Builder,
                leaves: Leaves,
            ) -> Built<$float> {
                build::<Watertight, $float>(triangles, builder, leaves)
            }


            fn triangles(mesh: &Mesh) -> Vec<Triangle<$float>> {
                $triangles(mesh)
            }

            fn gathering<T>(gather: impl FnOnce(&mut Vec<TriangleHit<$float>>) -> T) -> T {
                thread_local! {
                    static GATHERED: Cell<Vec<TriangleHit<$float>>> = const { Cell::new(Vec::new()) };
                }
                let mut hits = GATHERED.take();
                let got = gather(&mut hits);
                GATHERED.set(hits);
                got
            }
        }
    };
}
scenes!(f32, |mesh: &Mesh| mesh.triangles.to_vec());
scenes!(f64, |mesh: &Mesh| mesh.triangles_f64().to_vec());
