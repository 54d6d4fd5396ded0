//! The workloads: each is a name, a sentence, rays and triangles.

use std::sync::Arc;

use trisect_core::{Hit, Ray, Triangle, Vec3};

use crate::mesh::{Bounds, Mesh};
use crate::stream::Stream;

/// Rays and triangles to test against each other.
#[derive(Clone, Debug)]
pub struct Workload {
    /// A short name without spaces, for records.
    pub name: String,
    /// One sentence for reports.
    pub description: String,
    /// The rays.
    pub rays: Vec<Ray<f32>>,
    /// The triangles; shared, since several sets of rays go with one mesh.
    pub triangles: Arc<[Triangle<f32>]>,
}

/// Random rays against random triangles, in the manner of Kensler and Shirley, "Optimizing
/// Ray-Triangle Intersection via Automated Search", IEEE Symposium on Interactive Ray Tracing
/// 2006, and of Havel and Herout, "Yet Faster Ray-Triangle Intersection (Using SSE4)", IEEE TVCG
/// 16(3), 2010.
///
/// Each corner is uniform in the unit ball; each ray starts at one uniform point of the ball and
/// passes through a second one at `t = 1`, with `t` in `[0, ∞]` and a direction of any length.
/// About one pair in ten hits (a million pairs of seed 42: 10.3 %).
///
/// Deviation: the ball is this crate's choice, not checked against the papers' generators; their
/// distribution and share of hits may differ, so times are not comparable with theirs.
pub fn random(seed: u64, rays: usize, triangles: usize) -> Workload {
    Workload {
        name: "random".to_owned(),
        description: "random rays and triangles in the unit ball".to_owned(),
        rays: ball_rays("random/rays", seed, rays),
        triangles: ball_triangles("random/triangles", seed, triangles),
    }
}

/// The distribution of [`random`] in a size of choice: few rays against so many triangles that
/// they fit one level of cache and not the one below. A larger set begins with the smaller one.
pub fn working_set(seed: u64, rays: usize, triangles: usize) -> Workload {
    Workload {
        name: format!("working-set/{triangles}"),
        description: format!("{rays} random rays against {triangles} random triangles"),
        rays: ball_rays("working-set/rays", seed, rays),
        triangles: ball_triangles("working-set/triangles", seed, triangles),
    }
}

fn ball_rays(stream: &str, seed: u64, count: usize) -> Vec<Ray<f32>> {
    let mut stream = Stream::new(stream, seed);
    (0..count)
        .map(|_| {
            let (from, through) = (stream.ball(), stream.ball());
            Ray::<f32>::new(from, through - from)
        })
        .collect()
}

fn ball_triangles(stream: &str, seed: u64, count: usize) -> Arc<[Triangle<f32>]> {
    let mut stream = Stream::new(stream, seed);
    (0..count).map(|_| Triangle::new(stream.ball(), stream.ball(), stream.ball())).collect()
}

/// Rays that all hit the same, exact share of the triangles.
///
/// `round(triangles · percent / 100)` triangles are hit by every ray, the others by none, in
/// random order, so that the share is exact for each ray and for all pairs. Of the misses a
/// quarter each fail by `alpha < 0`, `beta < 0`, `gamma < 0` and `t < 0` (the first kinds take
/// the remainder). Front and back faces are equally likely.
///
/// The rays run along +z, jittered: from a disc of radius 0.2 at z in `[-4, -3)` through one at
/// z in `[3, 4)`. Between the discs they stay within 0.2 of the axis, and triangles there
/// contain, or stay clear of, a cylinder of radius 0.5: no pair is near an edge.
///
/// # Panics
/// When `percent` is above 100.
pub fn hit_rate(seed: u64, percent: u32, rays: usize, triangles: usize) -> Workload {
    assert!(percent <= 100, "a share of {percent} % of the triangles does not exist");
    // One set of rays for all shares, so that they compare.
    let mut stream = Stream::new("hit-rate/rays", seed);
    let rays = (0..rays)
        .map(|_| {
            let mut end = |low, high| {
                let (x, y) = stream.disc();
                Vec3::new(0.2 * x, 0.2 * y, stream.range(low, high))
            };
            let (from, through) = (end(-4.0, -3.0), end(3.0, 4.0));
            Ray::<f32>::new(from, through - from)
        })
        .collect();

    let mut stream = Stream::new(&format!("hit-rate/triangles/{percent}"), seed);
    let hits = (triangles * percent as usize + 50) / 100;
    let mut fates: Vec<Fate> = (0..triangles)
        .map(|i| if i < hits { Fate::Hit } else { Fate::MISSES[(i - hits) % 4] })
        .collect();
    stream.shuffle(&mut fates);
    let triangles = fates.into_iter().map(|fate| fated_triangle(&mut stream, fate)).collect();
    Workload {
        name: format!("hit-rate/{percent}"),
        description: format!("every ray hits exactly {percent} % of the triangles"),
        rays,
        triangles,
    }
}

/// How a triangle meets the rays of [`hit_rate`].
#[derive(Clone, Copy)]
enum Fate {
    Hit,
    /// The rays pass outside the edge opposite this corner.
    Beside(usize),
    Behind,
}

impl Fate {
    const MISSES: [Self; 4] = [Self::Beside(0), Self::Beside(1), Self::Beside(2), Self::Behind];
}

/// A jittered equilateral triangle across the axis of the rays.
fn fated_triangle(stream: &mut Stream, fate: Fate) -> Triangle<f32> {
    const HALF_SQRT_3: f32 = 0.866_025_4;
    // Each corner moves by less than √2 · 0.3 < 0.43 across the axis, so that the incircle of
    // radius scale / 2 keeps at least scale / 2 − 0.43.
    const JITTER: f32 = 0.3;
    let (x, y) = stream.circle();
    let (scale, z) = match fate {
        Fate::Behind => (stream.range(4.0, 6.0), stream.range(-9.0, -7.0)),
        _ => (stream.range(2.0, 4.0), stream.range(-2.0, 2.0)),
    };
    let directions = [
        (x, y),
        (-0.5 * x - HALF_SQRT_3 * y, HALF_SQRT_3 * x - 0.5 * y),
        (-0.5 * x + HALF_SQRT_3 * y, -HALF_SQRT_3 * x - 0.5 * y),
    ];
    // The edge opposite the first corner lies at −scale / 2 along (x, y), up to the jitter; the
    // shift takes it to at least 0.5 on the other side of the axis.
    let shift = match fate {
        Fate::Beside(_) => 0.5 * scale + 0.43 + stream.range(0.5, 1.5),
        _ => 0.0,
    };
    let mut corners = directions.map(|(u, v)| {
        Vec3::new(
            scale * u + shift * x + stream.range(-JITTER, JITTER),
            scale * v + shift * y + stream.range(-JITTER, JITTER),
            z + stream.range(-0.5, 0.5),
        )
    });
    if stream.flip() {
        corners.swap(1, 2);
    }
    if let Fate::Beside(corner) = fate {
        corners.rotate_right(corner);
    }
    let [a, b, c] = corners;
    Triangle { a, b, c }
}

/// Camera rays in rows from the top left: a pinhole looks at the mesh from a diagonal, so that
/// the sphere around its bounds touches the shorter side of the picture.
///
/// Rays go through the middles of the pixels; `t` is in `[0, ∞]` and directions are not of unit
/// length. Nothing is random. A mesh of one point is seen from distance zero.
pub fn primary(mesh: &Mesh, width: usize, height: usize) -> Workload {
    Workload {
        name: format!("{}/primary", mesh.name),
        description: format!("camera rays at {}, {width} by {height}", mesh.name),
        rays: camera_rays(&mesh.bounds, width, height),
        triangles: Arc::clone(&mesh.triangles),
    }
}

fn camera_rays(bounds: &Bounds, width: usize, height: usize) -> Vec<Ray<f32>> {
    // The tangent of half the angle of view along the shorter side: 53 degrees in all.
    const TANGENT: f32 = 0.5;
    let towards_eye = normalize(Vec3::new(0.6, 0.4, 0.8));
    let up = Vec3::new(0.0, 1.0, 0.0);
    let right = normalize(up.cross(towards_eye));
    let up = towards_eye.cross(right);
    let radius = 0.5 * bounds.diagonal();
    let distance = radius * (1.0 + TANGENT * TANGENT).sqrt() / TANGENT;
    let eye = towards_eye.mul_add(distance, bounds.center());
    let shorter = width.min(height) as f32;
    // From −1 to 1 along the shorter side, further along the longer one.
    let place =
        |pixel: usize, side: usize| TANGENT * (2.0 * pixel as f32 + 1.0 - side as f32) / shorter;
    (0..height)
        .flat_map(|row| (0..width).map(move |column| (row, column)))
        .map(|(row, column)| {
            let across = right.scale(place(column, width));
            let down = up.scale(-place(row, height));
            Ray::<f32>::new(eye, across + down - towards_eye)
        })
        .collect()
}

/// Rays through two uniform points of the mesh's bounding box, starting at the first. A mesh
/// without extent gives directions of zero.
pub fn random_through_box(seed: u64, mesh: &Mesh, rays: usize) -> Workload {
    let mut stream = Stream::new("box", seed);
    let Bounds { min, max } = mesh.bounds;
    let mut point = || {
        Vec3::new(
            stream.range(min.x, max.x),
            stream.range(min.y, max.y),
            stream.range(min.z, max.z),
        )
    };
    let rays = (0..rays)
        .map(|_| {
            let (from, through) = (point(), point());
            Ray::<f32>::new(from, through - from)
        })
        .collect();
    Workload {
        name: format!("{}/random", mesh.name),
        description: format!("random rays in the bounding box of {}", mesh.name),
        rays,
        triangles: Arc::clone(&mesh.triangles),
    }
}

/// The nearest hit of a ray and the number of its triangle, as the caller's tracer finds it.
pub type Closest<'a> = &'a mut dyn FnMut(&Ray<f32>) -> Option<(usize, Hit<f32>)>;

/// How far secondary rays start from the surface, as a share of the diagonal of the bounds.
pub const OFFSET: f32 = 1.0 / 4096.0;

/// Diffuse bounces: from each hit of a [`primary`] ray one ray in a cosine-weighted random
/// direction about the normal on the ray's side.
///
/// It starts [`OFFSET`] · diagonal above the surface along the unit normal, with `t` in
/// `[0, ∞]` and a direction not of unit length. Pixels that miss, and hits of triangles too
/// small or thin to have a normal in f32, give no ray; the random numbers of the others stay.
///
/// # Panics
/// When `closest` names a triangle that the mesh does not have.
pub fn diffuse_bounce(
    seed: u64,
    mesh: &Mesh,
    width: usize,
    height: usize,
    closest: Closest<'_>,
) -> Workload {
    let rays = surface_points(mesh, width, height, closest)
        .into_iter()
        .map(|(pixel, Surface { point, normal })| {
            let mut stream = Stream::new(&format!("bounce/{pixel}"), seed);
            Ray::<f32>::new(point, stream.cosine(normal))
        })
        .collect();
    Workload {
        name: format!("{}/diffuse", mesh.name),
        description: format!("diffuse bounces from {}", mesh.name),
        rays,
        triangles: Arc::clone(&mesh.triangles),
    }
}

/// A parallelogram that shines: the points `corner + r·u + s·v` with `r` and `s` in `[0, 1)`. A
/// point light has `u = v = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// One corner.
    pub corner: Vec3<f32>,
    /// One side.
    pub u: Vec3<f32>,
    /// The other side.
    pub v: Vec3<f32>,
}

impl Light {
    /// A level square above the bounds, as wide as half their diagonal and one diagonal above
    /// their middle.
    pub fn above(bounds: &Bounds) -> Self {
        let size = bounds.diagonal();
        Self {
            corner: bounds.center() + Vec3::new(-0.25 * size, size, -0.25 * size),
            u: Vec3::new(0.5 * size, 0.0, 0.0),
            v: Vec3::new(0.0, 0.0, 0.5 * size),
        }
    }
}

/// Shadow rays: from each hit of a [`primary`] ray one ray to a random point of the light, which
/// lies at `t = 1`; `t` is in `[2⁻¹², 1 − 2⁻¹²]`. They start where those of [`diffuse_bounce`] do.
///
/// # Panics
/// When `closest` names a triangle that the mesh does not have.
pub fn occlusion(
    seed: u64,
    mesh: &Mesh,
    light: &Light,
    width: usize,
    height: usize,
    closest: Closest<'_>,
) -> Workload {
    const MARGIN: f32 = 1.0 / 4096.0;
    let rays = surface_points(mesh, width, height, closest)
        .into_iter()
        .map(|(pixel, Surface { point, .. })| {
            let mut stream = Stream::new(&format!("occlusion/{pixel}"), seed);
            let (r, s) = (stream.unit(), stream.unit());
            let target = light.v.mul_add(s, light.u.mul_add(r, light.corner));
            Ray { o: point, d: target - point, tmin: MARGIN, tmax: 1.0 - MARGIN }
        })
        .collect();
    Workload {
        name: format!("{}/occlusion", mesh.name),
        description: format!("shadow rays from {} to an area light", mesh.name),
        rays,
        triangles: Arc::clone(&mesh.triangles),
    }
}

/// A point just above a surface, and the unit normal there.
struct Surface {
    point: Vec3<f32>,
    normal: Vec3<f32>,
}

/// Where camera rays hit, by pixel.
fn surface_points(
    mesh: &Mesh,
    width: usize,
    height: usize,
    closest: Closest<'_>,
) -> Vec<(usize, Surface)> {
    let offset = OFFSET * mesh.bounds.diagonal();
    camera_rays(&mesh.bounds, width, height)
        .iter()
        .enumerate()
        .filter_map(|(pixel, ray)| {
            let (index, hit) = closest(ray)?;
            let Triangle { a, b, c } = mesh.triangles[index];
            let (e1, e2) = (b - a, c - a);
            let normal = normalize(e1.cross(e2));
            let normal = if normal.dot(ray.d) > 0.0 { -normal } else { normal };
            let point = normal.mul_add(offset, e1.mul_add(hit.beta, e2.mul_add(hit.gamma, a)));
            // NaN where the normal has no length.
            normal.dot(normal).is_finite().then_some((pixel, Surface { point, normal }))
        })
        .collect()
}

fn normalize(v: Vec3<f32>) -> Vec3<f32> {
    let length = v.dot(v).sqrt();
    v.map(|x| x / length)
}
