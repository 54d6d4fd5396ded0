//! Rays in batches: all rays of a tile that are equally far from the camera go together.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;
use trisect_core::Ray;
use trisect_method::Culling;
use trisect_scene::{Color, luminance};
use trisect_tracer::{Crossings, Tracing, Tree, TriangleHit};

use crate::needs::{Needs, Part, Parts};
use crate::settings::{Mode, Occlusion, Settings};
use crate::stage::Stage;
use crate::surface::{Target, crossings, meet_plane, meet_sphere};

/// How many rays were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// From the camera.
    pub primary: u64,
    /// Reflected, refracted or scattered.
    pub secondary: u64,
    /// To lights, and for ambient occlusion.
    pub shadow: u64,
}

impl Counts {
    /// All together.
    pub fn total(self) -> u64 {
        self.primary + self.secondary + self.shadow
    }

    pub(crate) fn add(&mut self, other: Self) {
        self.primary += other.primary;
        self.secondary += other.secondary;
        self.shadow += other.shadow;
    }
}

/// What a ray carries to where it goes.
#[derive(Clone, Copy)]
pub(crate) struct Carrying {
    /// The sample that it adds to.
    pub(crate) slot: u32,
    /// The share of what it finds that is added.
    pub(crate) weight: Color,
}

impl Carrying {
    /// Of a ray from the camera: each has its own sample, in their order.
    #[inline]
    fn primary(slot: u32) -> Self {
        Self { slot, weight: Vec3::ONE }
    }
}

/// Rays that go together, and room for what comes of them. Kept from tile to tile.
#[derive(Default)]
pub(crate) struct Wave {
    /// Those at hand; where there are [`Part::Shapes`](crate::Part::Shapes), each interval ends at what the
    /// ray has met.
    rays: Vec<Ray<f32>>,
    /// Of each of them; where there is nothing [`Part::Onward`](crate::Part::Onward), what each carries is
    /// known without.
    carrying: Vec<Carrying>,
    /// What each has met, where there are shapes; elsewhere `found` says it.
    targets: Vec<Target>,
    found: Vec<Option<TriangleHit>>,
    /// Whether that is known of the rays from the camera.
    is_seen: bool,
    /// Those that are to go next.
    next_rays: Vec<Ray<f32>>,
    next_carrying: Vec<Carrying>,
    /// Those to lights, and what each adds if nothing is in its way.
    shadow_rays: Vec<Ray<f32>>,
    shadow_carrying: Vec<Carrying>,
    is_dark: Vec<bool>,
    blocked: Vec<bool>,
    /// What one ray to a light goes through.
    passed: Vec<TriangleHit>,
    /// What the samples have so far.
    radiance: Vec<Color>,
    /// For random numbers: which pixel and sample each slot is. Only where there are
    /// [`Part::Shadows`](crate::Part::Shadows), as nothing else asks for any.
    pub(crate) samples: Vec<[u32; 2]>,
    pub(crate) counts: Counts,
}

/// A ray of no length limit.
#[inline]
pub(crate) fn ray(o: Vec3, d: Vec3, tmax: f32) -> Ray<f32> {
    Ray { o: o.into(), d: d.into(), tmin: 0.0, tmax }
}

impl Wave {
    /// Forgets all rays and samples.
    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.samples.clear();
    }

    /// Adds a sample's ray, whose direction has unit length.
    #[inline]
    pub(crate) fn push_primary<N: Needs>(&mut self, pixel: u32, sample: u32, o: Vec3, d: Vec3) {
        if N::SHADOWS {
            self.samples.push([pixel, sample]);
        }
        self.rays.push(ray(o, d, f32::INFINITY));
    }

    /// Forgets all samples, and gives room for rays of others; whatever rays it holds are to be written over.
    #[inline]
    pub(crate) fn primary(&mut self, count: usize) -> &mut [Ray<f32>] {
        self.samples.clear();
        self.rays.resize(count, ray(Vec3::ZERO, Vec3::ZERO, 0.0));
        &mut self.rays
    }

    /// Takes what the rays at hand hit, one after another, so that they are not traced.
    pub(crate) fn see(&mut self, hits: impl Iterator<Item = Option<TriangleHit>>) {
        self.found.clear();
        self.found.extend(hits);
        self.is_seen = true;
    }

    /// Follows the rays, and those that come of them, to their ends; what each sample receives. Ends early
    /// when it is asked to stop.
    pub(crate) fn follow<N: Needs>(
        &mut self,
        stage: &Stage,
        settings: &Settings,
        parts: Parts,
        stop: &AtomicBool,
    ) -> &[Color] {
        self.radiance.clear();
        self.radiance.resize(self.rays.len(), Vec3::ZERO);
        self.carrying.clear();
        if N::ONWARD {
            self.carrying.extend((0..).take(self.rays.len()).map(Carrying::primary));
        }
        self.counts.primary += self.rays.len() as u64;
        let occlusion = match settings.mode {
            Mode::Whitted { occlusion } => occlusion.map(|occlusion| Occlusion {
                distance: stage.frame.length(occlusion.distance),
                ..occlusion
            }),
            Mode::Paths => None,
        };
        for depth in 0.. {
            if self.rays.is_empty() || stop.load(Ordering::Relaxed) {
                break;
            }
            self.find_targets::<N>(stage, settings.tracing);
            // Out of the wave, which what they meet adds to.
            let mut rays = std::mem::take(&mut self.rays);
            let mut carrying = std::mem::take(&mut self.carrying);
            let (targets, found) =
                (std::mem::take(&mut self.targets), std::mem::take(&mut self.found));
            for (slot, (at, ray)) in (0..).zip(rays.iter().enumerate()) {
                let carrying = if N::ONWARD { carrying[at] } else { Carrying::primary(slot) };
                let met = if N::SHAPES {
                    targets[at].is_something().then(|| (*ray, targets[at]))
                } else {
                    found[at].map(|found| (up_to(ray, &found), Target::triangle(&found)))
                };
                match met {
                    None => self.add(carrying, stage.scene.sky(ray.d.into())),
                    Some((ray, target)) if N::PATHS => {
                        self.shade_path(stage, settings, depth, &ray, carrying, target);
                    }
                    Some((ray, target)) => self.shade_whitted::<N>(
                        stage, settings, occlusion, depth, &ray, carrying, target,
                    ),
                }
            }
            (self.targets, self.found) = (targets, found);
            if N::SHADOWS {
                self.add_lights(stage, settings.tracing, parts.has(Part::Transparency));
            }
            if !N::ONWARD {
                // Rays stay, for others to be written over them.
                (self.rays, self.carrying) = (rays, carrying);
                break;
            }
            rays.clear();
            carrying.clear();
            self.rays = std::mem::replace(&mut self.next_rays, rays);
            self.carrying = std::mem::replace(&mut self.next_carrying, carrying);
            self.counts.secondary += self.rays.len() as u64;
        }
        &self.radiance
    }

    /// Adds light to a sample.
    #[inline]
    pub(crate) fn add(&mut self, Carrying { slot, weight }: Carrying, light: Color) {
        self.radiance[slot as usize] += weight * light;
    }

    /// A ray for the next round.
    #[inline]
    pub(crate) fn push(&mut self, o: Vec3, d: Vec3, slot: u32, weight: Color) {
        self.next_rays.push(ray(o, d, f32::INFINITY));
        self.next_carrying.push(Carrying { slot, weight });
    }

    /// A ray that adds its weight to a sample if nothing casts a shadow within a distance; of what is clear
    /// on the way, what it lets through.
    #[inline]
    pub(crate) fn push_shadow(
        &mut self,
        o: Vec3,
        d: Vec3,
        distance: f32,
        slot: u32,
        weight: Color,
    ) {
        self.shadow_rays.push(ray(o, d, distance));
        self.shadow_carrying.push(Carrying { slot, weight });
    }

    /// What each ray meets first: where there are shapes a target, at which its interval ends, and else no
    /// more than what is found in the only tree.
    fn find_targets<N: Needs>(&mut self, stage: &Stage, tracing: Tracing) {
        let Self { rays, targets, found, is_seen, .. } = self;
        if N::SHAPES {
            targets.clear();
            targets.extend(rays.iter_mut().map(|ray| nearest_simple(stage, ray)));
        }
        if !std::mem::take(is_seen) {
            found.resize(rays.len(), None);
            stage.all.closest(tracing, Culling::None, rays, found);
        }
        if N::SHAPES {
            for ((ray, target), found) in rays.iter_mut().zip(targets).zip(found) {
                if let Some(found) = found
                    && found.hit.t < ray.tmax
                {
                    (ray.tmax, *target) = (found.hit.t, Target::triangle(found));
                }
            }
        }
    }

    /// Adds what reaches the samples of those lights that no shadow falls on.
    fn add_lights(&mut self, stage: &Stage, tracing: Tracing, shines_through: bool) {
        let Self { shadow_rays, is_dark, blocked, .. } = self;
        self.counts.shadow += shadow_rays.len() as u64;
        is_dark.clear();
        is_dark.extend(shadow_rays.iter_mut().map(|ray| {
            let dark = is_blocked_simply(stage, ray);
            if dark {
                // Nothing is left to be found.
                ray.tmax = f32::NEG_INFINITY;
            }
            dark
        }));
        blocked.resize(shadow_rays.len(), false);
        stage.solid.any(tracing, Culling::None, shadow_rays, blocked);
        for (dark, blocked) in is_dark.iter_mut().zip(&*blocked) {
            *dark |= blocked;
        }
        if shines_through {
            self.shine_through(stage, tracing);
        }
        for (carrying, dark) in self.shadow_carrying.iter().zip(&self.is_dark) {
            if !dark {
                self.radiance[carrying.slot as usize] += carrying.weight;
            }
        }
        self.shadow_rays.clear();
        self.shadow_carrying.clear();
    }

    /// Weakens the light that goes through what is clear, at each surface by its transmission: one instance after
    /// another, so that two that touch both count.
    fn shine_through(&mut self, stage: &Stage, tracing: Tracing) {
        let Self { shadow_rays, shadow_carrying, is_dark, blocked, passed, .. } = self;
        for ((ray, carrying), dark) in
            shadow_rays.iter_mut().zip(&mut *shadow_carrying).zip(&*is_dark)
        {
            if *dark {
                ray.tmax = f32::NEG_INFINITY;
            } else {
                carrying.weight *= passed_simply(stage, ray);
            }
        }
        // Most meet nothing clear.
        stage.clear.any(tracing, Culling::None, shadow_rays, blocked);
        let passing = shadow_rays.iter().zip(shadow_carrying).zip(blocked);
        for ((ray, Carrying { weight, .. }), _) in passing.filter(|(_, passes)| **passes) {
            stage.clear.all(tracing, Culling::None, Crossings::Every, ray, passed);
            // By instance, and of each by distance as they were.
            let of = |hit: &TriangleHit| stage.clear.locate(hit.triangle);
            passed.sort_by_key(|hit| of(hit).0);
            let (mut last, mut from) = (usize::MAX, f32::NEG_INFINITY);
            for hit in &*passed {
                let (instance, triangle) = of(hit);
                if instance != last || hit.hit.t >= from {
                    let group = stage.clear.instances()[instance].of();
                    let material = group.materials[triangle as usize] as usize;
                    *weight *= stage.scene.materials[material].transmission;
                    (last, from) = (instance, behind(hit.hit.t));
                }
            }
        }
    }
}

/// A ray whose interval ends at what it has met.
#[inline]
fn up_to(ray: &Ray<f32>, found: &TriangleHit) -> Ray<f32> {
    Ray { tmax: found.hit.t, ..*ray }
}

/// What is behind a hit: so far that rounding does not find the same surface again, or its neighbour over
/// the edge.
fn behind(t: f32) -> f32 {
    (t * (1.0 + 4.0 * f32::EPSILON)).next_up()
}

/// The nearest sphere or plane; the ray's interval ends there.
#[inline]
pub(crate) fn nearest_simple(stage: &Stage, ray: &mut Ray<f32>) -> Target {
    let (o, d) = (Vec3::from(ray.o), Vec3::from(ray.d));
    let mut target = Target::NONE;
    for (number, sphere) in (0_u32..).zip(&stage.spheres) {
        let t = meet_sphere(sphere, o, d, ray.tmax);
        if t < ray.tmax {
            ray.tmax = t;
            target = Target::sphere(number);
        }
    }
    for (number, plane) in (0_u32..).zip(&stage.planes) {
        let t = meet_plane(plane, o, d, ray.tmax);
        if t < ray.tmax {
            ray.tmax = t;
            target = Target::plane(number);
        }
    }
    target
}

/// Whether a sphere or plane casts its shadow on a ray.
#[inline]
fn is_blocked_simply(stage: &Stage, ray: &Ray<f32>) -> bool {
    let (o, d) = (Vec3::from(ray.o), Vec3::from(ray.d));
    let [spheres, planes] = &stage.casting;
    let mut spheres = stage.spheres.iter().zip(spheres);
    let mut planes = stage.planes.iter().zip(planes);
    spheres.any(|(sphere, casts)| *casts && meet_sphere(sphere, o, d, ray.tmax) < ray.tmax)
        || planes.any(|(plane, casts)| *casts && meet_plane(plane, o, d, ray.tmax) < ray.tmax)
}

/// What clear spheres and planes leave of a ray's light.
fn passed_simply(stage: &Stage, ray: &Ray<f32>) -> Color {
    let (o, d) = (Vec3::from(ray.o), Vec3::from(ray.d));
    let [spheres, planes] = &stage.casting;
    let transmission = |material: usize| stage.scene.materials[material].transmission;
    let mut left = Vec3::ONE;
    for (sphere, _) in stage.spheres.iter().zip(spheres).filter(|(_, casts)| !**casts) {
        for _ in 0..crossings(sphere, o, d, ray.tmax) {
            left *= transmission(sphere.material);
        }
    }
    for (plane, _) in stage.planes.iter().zip(planes).filter(|(_, casts)| !**casts) {
        if meet_plane(plane, o, d, ray.tmax) < ray.tmax {
            left *= transmission(plane.material);
        }
    }
    left
}

/// The largest part of a colour.
#[inline]
pub(crate) fn largest(color: Color) -> f32 {
    color.max_element()
}

/// How bright a colour is, for choices that are made by chance.
#[inline]
pub(crate) fn chance(color: Color) -> f32 {
    luminance(color)
}
