//! The workloads: each is a name, a sentence, rays and triangles.

use std::sync::Arc;

use trisect_core::{Hit, Ray, Triangle, Vec3};

use crate::stream::Stream;
use crate::surface::{Aim, Placement, Surface};
use trisect_mesh::{Bounds, Mesh};

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

/// Rays that [`random`]'s could be but for one thing that they share, against the same triangles.
pub fn random_sharing(seed: u64, share: Share, rays: usize, triangles: usize) -> Workload {
    let mut all = ball_rays("random/rays", seed, rays);
    if let Some(&first) = all.first() {
        for ray in &mut all {
            match share {
                Share::Origin => ray.o = first.o,
                Share::Direction => ray.d = first.d,
            }
        }
    }
    let what = share.name();
    Workload {
        name: format!("packets/{what}"),
        description: format!("random rays with one {what} for all, and random triangles"),
        rays: all,
        triangles: ball_triangles("random/triangles", seed, triangles),
    }
}

/// What all rays of a workload have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// The origin, as of a camera.
    Origin,
    /// The direction, as of the sun.
    Direction,
}

impl Share {
    /// `origin` or `direction`
    pub const fn name(self) -> &'static str {
        match self {
            Self::Origin => "origin",
            Self::Direction => "direction",
        }
    }
}

/// A closed sphere of 20·4^`subdivisions` triangles and radius 2, and rays from within the cube
/// [−1, 1]³ that are aimed at random points of random edges, the point and the difference rounded.
///
/// Whatever rounding does to its aim, a ray from inside hits a closed surface: each ray without a
/// hit has passed through a crack between two triangles.
pub fn edge_aimed(seed: u64, rays: usize, subdivisions: u32) -> Workload {
    let sphere = Surface::sphere(subdivisions);
    let edges = sphere.features(Aim::Edges);
    let each = rays.div_ceil(edges.len());
    let mut aimed: Vec<_> =
        edges.iter().flat_map(|edge| sphere.aimed(edge, &Placement::HERE, seed, each)).collect();
    Stream::new("edges", seed).shuffle(&mut aimed);
    aimed.truncate(rays);
    Workload {
        name: "edges".to_owned(),
        description: "rays from inside a closed sphere, aimed at its edges".to_owned(),
        rays: aimed,
        triangles: sphere.triangles(&Placement::HERE).into(),
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

/// Triangles that are all hit by the same, exact share of the rays: `round(rays · percent / 100)`.
///
/// The rays are parallel and pass through the unit circle; each triangle is cut off along a chord
/// of random direction, so that it covers the share and no more. Which rays those are differs from
/// triangle to triangle, and which triangles from ray to ray: no branch predictor learns them by
/// heart. Misses pass outside one edge, any of the three alike; front and back faces are equally
/// likely. Planes are tilted at random. Of eight chords the one farthest from any ray is taken,
/// so that no pair is near an edge.
///
/// # Panics
/// When `percent` is above 100.
pub fn hit_rate(seed: u64, percent: u32, rays: usize, triangles: usize) -> Workload {
    assert!(percent <= 100, "a share of {percent} % of the rays does not exist");
    // One set of rays for all shares, so that they compare.
    let mut stream = Stream::new("hit-rate/rays", seed);
    let frame = Frame::random(&mut stream);
    let circle: Vec<(f32, f32)> = (0..rays).map(|_| stream.circle()).collect();
    let rays = circle
        .iter()
        .map(|&(x, y)| {
            let from = frame.point(x, y, stream.range(-4.0, -3.0));
            Ray::<f32>::new(from, frame.w.scale(stream.range(1.0, 2.0)))
        })
        .collect();
    let mut stream = Stream::new(&format!("hit-rate/triangles/{percent}"), seed);
    let covered = (circle.len() * percent as usize + 50) / 100;
    let triangles =
        (0..triangles).map(|_| covering(&mut stream, &frame, &circle, covered)).collect();
    Workload {
        name: format!("hit-rate/{percent}"),
        description: format!("every triangle is hit by exactly {percent} % of the rays"),
        rays,
        triangles,
    }
}

/// Three unit vectors at right angles.
struct Frame {
    u: Vec3<f32>,
    v: Vec3<f32>,
    w: Vec3<f32>,
}

impl Frame {
    fn random(stream: &mut Stream) -> Self {
        let w = stream.sphere();
        loop {
            let across = w.cross(stream.sphere());
            // Nearly parallel vectors span no plane worth having.
            if across.dot(across) > 0.25 {
                let u = normalize(across);
                return Self { u, v: w.cross(u), w };
            }
        }
    }

    fn point(&self, x: f32, y: f32, z: f32) -> Vec3<f32> {
        self.u.mul_add(x, self.v.mul_add(y, self.w.scale(z)))
    }
}

/// A triangle that contains exactly `covered` of the points on the unit circle, seen along `w`.
fn covering(
    stream: &mut Stream,
    frame: &Frame,
    circle: &[(f32, f32)],
    covered: usize,
) -> Triangle<f32> {
    let chord = |(nx, ny): (f32, f32)| {
        // Sentinels, for the chords that cut off nothing and everything.
        let mut along = vec![-2.0, 2.0];
        along.extend(circle.iter().map(|&(x, y)| x * nx + y * ny));
        along.sort_unstable_by(f32::total_cmp);
        let (last_in, first_out) = (along[covered], along[covered + 1]);
        (first_out - last_in, (nx, ny), 0.5 * (first_out + last_in))
    };
    let (_, (nx, ny), edge) = (0..8)
        .map(|_| chord(stream.circle()))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .expect("eight is more than none");
    // In coordinates along and across the normal of the chord: its two ends, and a corner so far
    // behind that the other two edges stay clear of the circle.
    let ends = [stream.range(6.0, 12.0), -stream.range(6.0, 12.0)];
    let behind = -stream.range(6.0, 12.0);
    let (height, slopes) = (stream.range(-1.0, 1.0), [0, 1].map(|_| stream.range(-0.5, 0.5)));
    let mut corners = [(edge, ends[0]), (edge, ends[1]), (behind, 0.0)].map(|(n, m)| {
        let (x, y) = (n * nx - m * ny, n * ny + m * nx);
        frame.point(x, y, height + slopes[0] * x + slopes[1] * y)
    });
    stream.shuffle(&mut corners);
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
        .map(|(pixel, Spot { point, normal })| {
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
        .map(|(pixel, Spot { point, .. })| {
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
struct Spot {
    point: Vec3<f32>,
    normal: Vec3<f32>,
}

/// Where camera rays hit, by pixel.
fn surface_points(
    mesh: &Mesh,
    width: usize,
    height: usize,
    closest: Closest<'_>,
) -> Vec<(usize, Spot)> {
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
            normal.dot(normal).is_finite().then_some((pixel, Spot { point, normal }))
        })
        .collect()
}

fn normalize(v: Vec3<f32>) -> Vec3<f32> {
    let length = v.dot(v).sqrt();
    v.map(|x| x / length)
}
