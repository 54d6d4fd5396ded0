//! What is asked of a scene, a part of the rays at a time.

use std::time::{Duration, Instant};

use numpy::Element;
use trisect::core::Ray;
use trisect::{Hit, NotExact, Place, Precision, Scene};

use crate::ask::Sight;

/// A number that scenes and arrays are made of.
pub(crate) trait Number: Precision + Element + Copy {}

impl Number for f32 {}
impl Number for f64 {}

/// A hit: the triangle, `t`, and the weights of its second and third corners.
pub(crate) type Found<X> = (u32, X, X, X);

/// A hit in numbers.
pub(crate) fn found<X: Number>(hit: &Hit<X>) -> Found<X> {
    (hit.triangle, hit.t, hit.beta, hit.gamma)
}

/// Fewer rays than these are traced one by one, where they are: the answers are the same, and no thread is woken.
pub(crate) const FEW: usize = 64;

// What goes ray by ray ends as soon as nobody waits for it.

/// The first hit of each ray.
pub(crate) fn first<X: Number>(
    scene: &Scene<X>,
    sight: Sight,
    rays: &[Ray<X>],
    mut take: impl FnMut(usize, Option<Found<X>>),
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
        take(at, hit.as_ref().map(found));
    }
}

/// Whether each ray hits anything.
pub(crate) fn any<X: Number>(scene: &Scene<X>, sight: Sight, rays: &[Ray<X>], hits: &mut [bool]) {
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

/// All hits of each ray in order: `take` gets a ray's, one ray after another.
pub(crate) fn all<X: Number>(
    scene: &Scene<X>,
    sight: Sight,
    rays: &[Ray<X>],
    mut take: impl FnMut(&[Hit<X>]),
) {
    let view = scene.seen(sight.culling).crossings(sight.crossings);
    let mut hits = vec![];
    for ray in rays.iter().take_while(|_| sight.lasts()) {
        view.all(ray, &mut hits);
        if sight.mask.is_some() {
            hits.retain(|hit| sight.sees(hit.triangle));
        }
        take(&hits);
    }
}

/// How many hits each ray has.
pub(crate) fn count<X: Number>(
    scene: &Scene<X>,
    sight: Sight,
    rays: &[Ray<X>],
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

/// Where each point is.
///
/// # Errors
/// When the scene's method is not exact.
pub(crate) fn places<X: Number>(
    scene: &Scene<X>,
    sight: Sight,
    points: &[[X; 3]],
    mut take: impl FnMut(usize, Place),
) -> Result<(), NotExact> {
    let (mut done, mut count) = (0, 1);
    while done < points.len() && sight.lasts() {
        let end = points.len().min(done + count);
        let start = Instant::now();
        let placed = scene.contains_of(&points[done..end])?;
        placed.into_iter().enumerate().for_each(|(at, place)| take(done + at, place));
        // The more there are the quicker each is; but one who waits is not to wait long.
        if start.elapsed() < SHORT {
            count *= 16;
        }
        done = end;
    }
    Ok(())
}

/// Work that takes no longer may be sixteen times as much.
const SHORT: Duration = Duration::from_millis(3);
