//! A precision: what is asked of a scene in it.

use numpy::Element;
use trisect::core::Ray;
use trisect::{Place, SceneOptions, Statistics, UpdateError};

use crate::ask::Sight;

/// A hit: the triangle, `t`, and the weights of its second and third corners.
pub(crate) type Found<X> = (u32, X, X, X);

/// A number that scenes are made of. What goes ray by ray ends as soon as [`Sight::lasts`] no more.
pub(crate) trait Precision: Element + Copy + Send + Sync + 'static {
    /// A scene of such numbers.
    type Scene: Send + Sync + 'static;

    const ZERO: Self;
    const INFINITY: Self;

    /// # Errors
    /// What is amiss, and where.
    fn build(
        options: SceneOptions,
        vertices: &[[Self; 3]],
        faces: &[[u32; 3]],
    ) -> Result<Self::Scene, String>;

    /// Moves the vertices; whether the tree could be fitted to them.
    ///
    /// # Errors
    /// What is amiss, and where.
    fn update(scene: &mut Self::Scene, vertices: &[[Self; 3]]) -> Result<bool, String>;

    fn statistics(scene: &Self::Scene) -> Statistics;

    /// The first hit of each ray.
    fn first(
        scene: &Self::Scene,
        sight: Sight,
        rays: &[Ray<Self>],
        take: impl FnMut(usize, Option<Found<Self>>),
    );

    /// Whether each ray hits anything.
    fn any(scene: &Self::Scene, sight: Sight, rays: &[Ray<Self>], hits: &mut [bool]);

    /// All hits of each ray in order: `take` gets a ray's, one ray after another.
    fn all(
        scene: &Self::Scene,
        sight: Sight,
        rays: &[Ray<Self>],
        take: impl FnMut(&mut dyn Iterator<Item = Found<Self>>),
    );

    /// How many hits each ray has.
    fn count(scene: &Self::Scene, sight: Sight, rays: &[Ray<Self>], take: impl FnMut(usize, u32));

    /// Where each point is.
    ///
    /// # Errors
    /// When the scene's method is not exact.
    fn places(
        scene: &Self::Scene,
        sight: Sight,
        points: &[[Self; 3]],
        take: impl FnMut(usize, Place),
    ) -> Result<(), String>;
}

/// Fewer rays than these are traced one by one, where they are: the answers are the same, and no thread is woken.
pub(crate) const FEW: usize = 64;

macro_rules! precision {
    ($x:ident, $scene:ty) => {
        impl Precision for $x {
            type Scene = $scene;

            const ZERO: Self = 0.0;
            const INFINITY: Self = $x::INFINITY;

            fn build(
                options: SceneOptions,
                vertices: &[[Self; 3]],
                faces: &[[u32; 3]],
            ) -> Result<Self::Scene, String> {
                options.build(vertices, faces).map_err(|error| error.to_string())
            }

            fn update(scene: &mut Self::Scene, vertices: &[[Self; 3]]) -> Result<bool, String> {
                match scene.update(vertices) {
                    Ok(()) => Ok(true),
                    Err(UpdateError::Refit(_)) => Ok(false),
                    Err(error) => Err(error.to_string()),
                }
            }

            fn statistics(scene: &Self::Scene) -> Statistics {
                scene.statistics()
            }

            fn first(
                scene: &Self::Scene,
                sight: Sight,
                rays: &[Ray<Self>],
                mut take: impl FnMut(usize, Option<Found<Self>>),
            ) {
                let view = scene.seen(sight.culling);
                let mut hits = vec![None; rays.len()];
                if sight.mask.is_some() {
                    for (ray, hit) in rays.iter().zip(&mut hits).take_while(|_| sight.lasts()) {
                        *hit = view.filtered(ray, |hit| sight.verdict(hit.triangle));
                    }
                } else if rays.len() < FEW {
                    for (ray, hit) in rays.iter().zip(&mut hits) {
                        *hit = view.first(ray);
                    }
                } else {
                    view.first_of(rays, &mut hits);
                }
                for (at, hit) in hits.into_iter().enumerate() {
                    take(at, hit.map(|hit| (hit.triangle, hit.t, hit.beta, hit.gamma)));
                }
            }

            fn any(scene: &Self::Scene, sight: Sight, rays: &[Ray<Self>], hits: &mut [bool]) {
                let view = scene.seen(sight.culling);
                if sight.mask.is_some() {
                    for (ray, hit) in rays.iter().zip(hits).take_while(|_| sight.lasts()) {
                        let found = view.filtered(ray, |hit| sight.verdict(hit.triangle));
                        *hit = found.is_some();
                    }
                } else if rays.len() < FEW {
                    for (ray, hit) in rays.iter().zip(hits) {
                        *hit = view.any(ray);
                    }
                } else {
                    view.any_of(rays, hits);
                }
            }

            fn all(
                scene: &Self::Scene,
                sight: Sight,
                rays: &[Ray<Self>],
                mut take: impl FnMut(&mut dyn Iterator<Item = Found<Self>>),
            ) {
                let view = scene.seen(sight.culling).crossings(sight.crossings);
                let mut hits = vec![];
                for ray in rays.iter().take_while(|_| sight.lasts()) {
                    view.all(ray, &mut hits);
                    let seen = hits.iter().filter(|hit| sight.sees(hit.triangle));
                    take(&mut seen.map(|hit| (hit.triangle, hit.t, hit.beta, hit.gamma)));
                }
            }

            fn count(
                scene: &Self::Scene,
                sight: Sight,
                rays: &[Ray<Self>],
                mut take: impl FnMut(usize, u32),
            ) {
                let view = scene.seen(sight.culling).crossings(sight.crossings);
                let mut hits = vec![];
                for (at, ray) in rays.iter().enumerate().take_while(|_| sight.lasts()) {
                    if sight.mask.is_some() {
                        view.all(ray, &mut hits);
                        hits.retain(|hit| sight.sees(hit.triangle));
                        take(at, u32::try_from(hits.len()).unwrap_or(u32::MAX));
                    } else {
                        take(at, view.count(ray));
                    }
                }
            }

            fn places(
                scene: &Self::Scene,
                sight: Sight,
                points: &[[Self; 3]],
                mut take: impl FnMut(usize, Place),
            ) -> Result<(), String> {
                for (at, &point) in points.iter().enumerate().take_while(|_| sight.lasts()) {
                    take(at, scene.contains(point).map_err(|error| error.to_string())?);
                }
                Ok(())
            }
        }
    };
}

precision!(f32, trisect::Scene);
