//! Five clients, as programs and by hand.

use std::hint::black_box;

use glam::{Vec2, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_method::Culling;
use trisect_pipeline::random::{Random, cosine_about};
use trisect_pipeline::{Buffer, Entry, Launch, On, Place, RayType, Scene, Traces, Tracing};
use trisect_tracer::{Tree, TriangleHit};

use crate::common::{Camera, ray_to};

/// What is asked of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Client {
    /// What a camera sees, in ambient light.
    Ambient,
    /// What it sees in a mirror, up to four times.
    Mirror,
    /// Four rays around each point that it sees.
    Occlusion,
    /// Diffuse paths of four points, each lit by the sun.
    Paths,
    /// Which of two points see each other.
    Sight,
}

const SKY: Vec3 = Vec3::new(0.34, 0.55, 0.85);
const COLOR: f32 = 0.7;
const DEPTH: u32 = 3;
const AROUND: u32 = 4;
const SUN: Vec3 = Vec3::new(0.48, 0.8, 0.36);
/// As rays leave in the pipeline.
const OFF: f32 = 32.0 * f32::EPSILON;

/// From where both look, and how finely.
#[derive(Clone, Copy)]
struct View {
    camera: Camera,
    side: u32,
    extent: f32,
}

impl View {
    fn ray(&self, x: u32, y: u32) -> Ray<f32> {
        self.camera.ray(Vec2::new(x as f32 + 0.5, y as f32 + 0.5), [self.side; 2])
    }

    fn random(&self, [x, y]: [u32; 2]) -> Random {
        Random { seed: 1, pixel: y * self.side + x, sample: 0 }
    }

    /// From one point of a sphere around the mesh to another.
    fn line(&self, [x, y]: [u32; 2]) -> Ray<f32> {
        let [a, b, c, d] = self.random([x, y]).four(0);
        let of = |u: f32, v: f32| {
            let (sin, cos) = (u * std::f32::consts::TAU).sin_cos();
            let up = 2.0 * v - 1.0;
            let around = (1.0 - up * up).sqrt();
            Vec3::new(cos * around, up, sin * around) * self.extent
        };
        let middle = self.camera.eye - Vec3::new(0.2, 0.2, 0.7) * self.extent;
        let (from, to) = (of(a, b), of(c, d));
        Ray::new(middle + from, to - from).with_interval(0.0, 1.0)
    }
}

fn mirrored(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

// As programs.

struct Sees;

impl RayType for Sees {
    type Payload = ();
}

struct Weighted;

impl RayType for Weighted {
    type Payload = f32;
}

struct Shadow;

impl RayType for Shadow {
    type Payload = f32;
    const ANY: bool = true;
}

struct Between;

impl RayType for Between {
    type Payload = ();
    const ANY: bool = true;
}

/// Ambient light, with what it can do without.
struct With<const CATCHES: bool, const READS: bool, const ANY_HIT: bool>(View);

struct Mirror(View);
struct Occlusion(View);
struct Paths(View);
struct Sight(View);

macro_rules! entry {
    (@first $first:ident $(, $rest:ident)*) => {
        $first
    };
    ($entry:ty, $rays:ty $(, [$($parameter:ident),+])?; |$view:ident, $x:ident, $y:ident, $on:ident| $generate:expr) => {
        impl $(<$(const $parameter: bool),+>)? Entry for $entry {
            $(const CATCHES: bool = entry!(@first $($parameter),+);)?
            type Material = ();
            type Rays = $rays;
            type Out = Vec3;
            type Append = ();

            #[inline]
            fn generate(&self, [$x, $y, _]: [u32; 3], $on: &mut On<'_, Self>) {
                let $view = &self.0;
                $generate
            }
        }
    };
}
entry!(
    With<CATCHES, READS, ANY_HIT>, (Sees,), [CATCHES, READS, ANY_HIT];
    |view, x, y, on| on.send(Sees, view.ray(x, y), ())
);
entry!(Mirror, (Weighted,); |view, x, y, on| on.send(Weighted, view.ray(x, y), 1.0));
entry!(Occlusion, (Sees, Shadow); |view, x, y, on| on.send(Sees, view.ray(x, y), ()));
entry!(Paths, (Weighted, Shadow); |view, x, y, on| on.send(Weighted, view.ray(x, y), 1.0));
entry!(Sight, (Between,); |view, x, y, on| on.send(Between, view.line([x, y]), ()));

impl<const CATCHES: bool, const READS: bool, const ANY_HIT: bool> Traces<Sees>
    for With<CATCHES, READS, ANY_HIT>
{
    const ANY_HIT: bool = ANY_HIT;

    #[inline]
    fn closest_hit(&self, at: &Place<'_, ()>, (): (), on: &mut On<'_, Self>) {
        if READS {
            black_box(at.surface());
        }
        *on.out() = Vec3::splat(COLOR);
    }

    #[inline]
    fn miss(&self, _: &Ray<f32>, (): (), on: &mut On<'_, Self>) {
        *on.out() = SKY;
    }
}

impl Traces<Weighted> for Mirror {
    #[inline]
    fn closest_hit(&self, at: &Place<'_, ()>, weight: f32, on: &mut On<'_, Self>) {
        *on.out() += Vec3::splat(weight * 0.1);
        if on.round() < DEPTH {
            let surface = at.surface();
            let towards = mirrored(at.direction(), surface.normal);
            on.send(Weighted, Ray::new(surface.leave(towards), towards), weight * COLOR);
        }
    }

    #[inline]
    fn miss(&self, _: &Ray<f32>, weight: f32, on: &mut On<'_, Self>) {
        *on.out() += SKY * weight;
    }
}

impl Traces<Sees> for Occlusion {
    #[inline]
    fn closest_hit(&self, at: &Place<'_, ()>, (): (), on: &mut On<'_, Self>) {
        let ([x, y, _], surface) = (on.index(), at.surface());
        let random = self.0.random([x, y]);
        for number in 0..AROUND {
            let [u, v, ..] = random.four(number);
            let towards = cosine_about(surface.normal, u, v);
            let ray = ray_to(surface.leave(towards), towards, 0.3 * self.0.extent);
            on.send(Shadow, ray, COLOR / AROUND as f32);
        }
    }

    #[inline]
    fn miss(&self, _: &Ray<f32>, (): (), on: &mut On<'_, Self>) {
        *on.out() = SKY;
    }
}

impl Traces<Shadow> for Occlusion {
    #[inline]
    fn miss(&self, _: &Ray<f32>, light: f32, on: &mut On<'_, Self>) {
        *on.out() += Vec3::splat(light);
    }
}

impl Traces<Weighted> for Paths {
    #[inline]
    fn closest_hit(&self, at: &Place<'_, ()>, weight: f32, on: &mut On<'_, Self>) {
        let ([x, y, _], surface) = (on.index(), at.surface());
        let cosine = surface.normal.dot(SUN);
        if cosine > 0.0 {
            on.send(Shadow, Ray::new(surface.leave(SUN), SUN), weight * COLOR * cosine);
        }
        let depth = on.round();
        if depth < DEPTH {
            let [u, v, ..] = self.0.random([x, y]).four(depth);
            let towards = cosine_about(surface.normal, u, v);
            on.send(Weighted, Ray::new(surface.leave(towards), towards), weight * COLOR);
        }
    }

    #[inline]
    fn miss(&self, _: &Ray<f32>, weight: f32, on: &mut On<'_, Self>) {
        *on.out() += SKY * weight;
    }
}

impl Traces<Shadow> for Paths {
    #[inline]
    fn miss(&self, _: &Ray<f32>, light: f32, on: &mut On<'_, Self>) {
        *on.out() += Vec3::splat(light);
    }
}

impl Traces<Between> for Sight {
    #[inline]
    fn miss(&self, _: &Ray<f32>, (): (), on: &mut On<'_, Self>) {
        *on.out() = Vec3::ONE;
    }
}

/// What a client can do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Extra {
    Nothing,
    Exceptions,
    Attributes,
    AnyHit,
    /// It is the scene that has one.
    Transform,
}

/// The answer of a client's programs, and how many rays they sent.
pub(crate) type Answer = (Vec<Vec3>, u64);

fn run<E: Entry<Material = (), Out = Vec3>>(scene: &Scene<()>, entry: &E, side: u32) -> Answer {
    let mut buffer = Buffer::plane([side; 2], Vec3::ZERO);
    let rays = scene.launch(entry, &Launch::default(), &mut buffer).rays;
    (buffer.into_cells(), rays.iter().sum())
}

/// Ambient light, with what it could do without.
pub(crate) fn ambient_with(
    scene: &Scene<()>,
    extra: Extra,
    camera: Camera,
    side: u32,
    extent: f32,
) -> Answer {
    let view = View { camera, side, extent };
    match extra {
        Extra::Nothing | Extra::Transform => run(scene, &With::<false, false, false>(view), side),
        Extra::Exceptions => run(scene, &With::<true, false, false>(view), side),
        Extra::Attributes => run(scene, &With::<false, true, false>(view), side),
        Extra::AnyHit => run(scene, &With::<false, false, true>(view), side),
    }
}

/// The answer of a client's programs, and how many rays they sent.
pub(crate) fn by_programs(
    scene: &Scene<()>,
    client: Client,
    camera: Camera,
    side: u32,
    extent: f32,
) -> Answer {
    let view = View { camera, side, extent };
    match client {
        Client::Ambient => run(scene, &With::<false, false, false>(view), side),
        Client::Mirror => run(scene, &Mirror(view), side),
        Client::Occlusion => run(scene, &Occlusion(view), side),
        Client::Paths => run(scene, &Paths(view), side),
        Client::Sight => run(scene, &Sight(view), side),
    }
}

// By hand.

/// Loops over the tracer's calls, tile by tile, with room that is kept.
pub(crate) struct ByHand<'a> {
    tree: &'a dyn Tree,
    triangles: &'a [Triangle<f32>],
    view: View,
    rays: Vec<Ray<f32>>,
    carried: Vec<(u32, f32)>,
    found: Vec<Option<TriangleHit>>,
    next_rays: Vec<Ray<f32>>,
    next_carried: Vec<(u32, f32)>,
    shadow_rays: Vec<Ray<f32>>,
    shadow_carried: Vec<(u32, f32)>,
    blocked: Vec<bool>,
}

impl<'a> ByHand<'a> {
    pub(crate) fn new(
        tree: &'a dyn Tree,
        triangles: &'a [Triangle<f32>],
        camera: Camera,
        side: u32,
        extent: f32,
    ) -> Self {
        Self {
            tree,
            triangles,
            view: View { camera, side, extent },
            rays: vec![],
            carried: vec![],
            found: vec![],
            next_rays: vec![],
            next_carried: vec![],
            shadow_rays: vec![],
            shadow_carried: vec![],
            blocked: vec![],
        }
    }

    /// The answer.
    pub(crate) fn run(&mut self, client: Client) -> Vec<Vec3> {
        let side = self.view.side;
        let mut picture = vec![Vec3::ZERO; (side * side) as usize];
        for top in (0..side).step_by(64) {
            for left in (0..side).step_by(64) {
                self.rays.clear();
                self.carried.clear();
                for y in top..side.min(top + 64) {
                    for x in left..side.min(left + 64) {
                        let ray = match client {
                            Client::Sight => self.view.line([x, y]),
                            _ => self.view.ray(x, y),
                        };
                        self.rays.push(ray);
                        self.carried.push((y * side + x, 1.0));
                    }
                }
                match client {
                    Client::Ambient => self.ambient(&mut picture),
                    Client::Mirror => self.mirror(&mut picture),
                    Client::Occlusion => self.occlusion(&mut picture),
                    Client::Paths => self.paths(&mut picture),
                    Client::Sight => self.sight(&mut picture),
                }
            }
        }
        picture
    }

    fn find(&mut self) {
        self.found.clear();
        self.found.resize(self.rays.len(), None);
        self.tree.closest(Tracing::Single, Culling::None, &self.rays, &mut self.found);
    }

    fn ambient(&mut self, picture: &mut [Vec3]) {
        self.find();
        for ((pixel, _), found) in self.carried.iter().zip(&self.found) {
            picture[*pixel as usize] = if found.is_some() { Vec3::splat(COLOR) } else { SKY };
        }
    }

    fn mirror(&mut self, picture: &mut [Vec3]) {
        for depth in 0..=DEPTH {
            self.find();
            for ((ray, &(pixel, weight)), found) in
                self.rays.iter().zip(&self.carried).zip(&self.found)
            {
                let out = &mut picture[pixel as usize];
                let Some(found) = found else {
                    *out += SKY * weight;
                    continue;
                };
                *out += Vec3::splat(weight * 0.1);
                if depth < DEPTH {
                    let surface = Surface::new(self.triangles, ray, found);
                    let towards = mirrored(ray.d.into(), surface.normal);
                    self.next_rays.push(Ray::new(surface.leave(towards), towards));
                    self.next_carried.push((pixel, weight * COLOR));
                }
            }
            self.turn();
        }
    }

    fn turn(&mut self) {
        self.rays.clear();
        self.carried.clear();
        std::mem::swap(&mut self.rays, &mut self.next_rays);
        std::mem::swap(&mut self.carried, &mut self.next_carried);
    }

    fn occlusion(&mut self, picture: &mut [Vec3]) {
        self.find();
        let side = self.view.side;
        for ((ray, &(pixel, _)), found) in self.rays.iter().zip(&self.carried).zip(&self.found) {
            let Some(found) = found else {
                picture[pixel as usize] = SKY;
                continue;
            };
            let surface = Surface::new(self.triangles, ray, found);
            let random = self.view.random([pixel % side, pixel / side]);
            for number in 0..AROUND {
                let [u, v, ..] = random.four(number);
                let towards = cosine_about(surface.normal, u, v);
                let ray = ray_to(surface.leave(towards), towards, 0.3 * self.view.extent);
                self.shadow_rays.push(ray);
                self.shadow_carried.push((pixel, COLOR / AROUND as f32));
            }
        }
        self.light(picture);
    }

    /// Adds what arrives of lights.
    fn light(&mut self, picture: &mut [Vec3]) {
        self.blocked.clear();
        self.blocked.resize(self.shadow_rays.len(), false);
        self.tree.any(Tracing::Single, Culling::None, &self.shadow_rays, &mut self.blocked);
        for (&(pixel, light), blocked) in self.shadow_carried.iter().zip(&self.blocked) {
            if !blocked {
                picture[pixel as usize] += Vec3::splat(light);
            }
        }
        self.shadow_rays.clear();
        self.shadow_carried.clear();
    }

    fn paths(&mut self, picture: &mut [Vec3]) {
        let side = self.view.side;
        for depth in 0..=DEPTH {
            self.find();
            for ((ray, &(pixel, weight)), found) in
                self.rays.iter().zip(&self.carried).zip(&self.found)
            {
                let Some(found) = found else {
                    picture[pixel as usize] += SKY * weight;
                    continue;
                };
                let surface = Surface::new(self.triangles, ray, found);
                let cosine = surface.normal.dot(SUN);
                if cosine > 0.0 {
                    self.shadow_rays.push(Ray::new(surface.leave(SUN), SUN));
                    self.shadow_carried.push((pixel, weight * COLOR * cosine));
                }
                if depth < DEPTH {
                    let random = self.view.random([pixel % side, pixel / side]);
                    let [u, v, ..] = random.four(depth);
                    let towards = cosine_about(surface.normal, u, v);
                    self.next_rays.push(Ray::new(surface.leave(towards), towards));
                    self.next_carried.push((pixel, weight * COLOR));
                }
            }
            self.light(picture);
            self.turn();
        }
    }

    fn sight(&mut self, picture: &mut [Vec3]) {
        self.blocked.clear();
        self.blocked.resize(self.rays.len(), false);
        self.tree.any(Tracing::Single, Culling::None, &self.rays, &mut self.blocked);
        for ((pixel, _), blocked) in self.carried.iter().zip(&self.blocked) {
            picture[*pixel as usize] = if *blocked { Vec3::ZERO } else { Vec3::ONE };
        }
    }
}

/// Where a ray hits a triangle.
struct Surface {
    point: Vec3,
    /// On the side of the ray.
    normal: Vec3,
    front: Vec3,
    reach: f32,
}

impl Surface {
    fn new(triangles: &[Triangle<f32>], ray: &Ray<f32>, found: &TriangleHit) -> Self {
        let (o, d) = (Vec3::from(ray.o), Vec3::from(ray.d));
        let front = Vec3::from(triangles[found.triangle as usize].normal()).normalize_or_zero();
        let point = o + d * found.hit.t;
        Self {
            point,
            normal: if front.dot(d) <= 0.0 { front } else { -front },
            front,
            reach: point.abs().max(o.abs()).max_element(),
        }
    }

    fn leave(&self, direction: Vec3) -> Vec3 {
        self.point + self.front * (self.reach * OFF).copysign(self.front.dot(direction))
    }
}
