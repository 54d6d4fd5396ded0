//! How is a method of one's own traced with? It is a formula over lanes; the tree, its loops and the vectors come from
//! here. This one finds the signs of three volumes between the ray and the edges.
use trisect::core::{Lanes, Scalar, Vec3};
use trisect::method::{Corners, Given, Homogeneous, Input, MethodInfo, Of};
use trisect::{Method, Scene};

struct Volumes;

impl Method for Volumes {
    const INFO: MethodInfo =
        MethodInfo { name: "volumes", input: Input::Points, ..MethodInfo::USUAL };
    type Prepared = Corners<()>;
    type PreparedRay<L: Lanes> = trisect::core::Ray<L>;
    type Alpha<L: Lanes> = Given<L>;

    fn prepare<X: Scalar>(
        triangle: &trisect::core::Triangle<X>,
        _: usize,
    ) -> Of<Self::Prepared, X> {
        Corners::new(triangle)
    }

    fn prepare_ray<L: Lanes>(ray: &trisect::core::Ray<L>, _: usize) -> trisect::core::Ray<L> {
        *ray
    }

    /// `t`, `alpha`, `beta` and `gamma` before the division by `det`.
    #[inline(always)]
    fn intersect<L: Lanes>(
        ray: &trisect::core::Ray<L>,
        corners: &Corners<L>,
    ) -> Homogeneous<L, Given<L>> {
        let [a, b, c]: [Vec3<L>; 3] = [corners.a, corners.b, corners.c].map(|v| v - ray.o);
        let alpha = ray.d.dot(b.cross(c));
        let beta = ray.d.dot(c.cross(a));
        let gamma = ray.d.dot(a.cross(b));
        let t = a.dot(corners.normal());
        Homogeneous { det: alpha + (beta + gamma), t, alpha: Given(alpha), beta, gamma }
    }

    /// Positive at the front.
    fn facing<L: Lanes>(_: &trisect::core::Ray<L>, _: &Corners<L>, det: L) -> L {
        -det
    }
}

fn main() -> Result<(), trisect::SceneError> {
    let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let scene = Scene::with_method::<Volumes>(&vertices, &[[0, 1, 2]])?;
    let ray = trisect::Ray::new([0.25, 0.25, 1.0], [0.0, 0.0, -1.0]);
    println!("{:?}", scene.first(&ray));
    Ok(())
}
