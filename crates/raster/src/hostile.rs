//! Scenes that are hard to agree on: what the rasteriser is held to the exact caster with.

use glam::{Vec2, Vec3};
use trisect_core::Triangle;
use trisect_scene::{Camera, Lens, PixelRays};

/// Triangles that are hard to see, and from where.
pub struct Hostile {
    /// What is hard about them.
    pub name: &'static str,
    /// The triangles.
    pub triangles: Vec<Triangle<f32>>,
    /// From where they are seen.
    pub camera: Camera,
}

/// Numbers that have nothing to do with each other, from −1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        // Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators. 2014.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

const EYE: Vec3 = Vec3::new(0.3, 0.4, 2.5);

fn lenses() -> [Lens; 2] {
    [Lens::Pinhole { field_of_view: 1.2 }, Lens::Orthographic { height: 2.0 }]
}

fn camera(lens: Lens, eye: Vec3) -> Camera {
    let fallback = Camera {
        name: String::new(),
        eye,
        right: Vec3::X,
        up: Vec3::Y,
        forward: Vec3::NEG_Z,
        lens,
    };
    let at = eye - EYE + Vec3::new(0.05, -0.1, 0.0);
    Camera::looking(eye, at, Vec3::Y, lens).unwrap_or(fallback)
}

/// All of them, for a picture of so many pixels: what is aimed at pixels depends on it.
pub fn scenes(size: [u32; 2]) -> Vec<Hostile> {
    let mut all = Vec::new();
    for lens in lenses() {
        let near = camera(lens, EYE);
        let rays = PixelRays::new(near.clone(), size);
        let mut add = |name, triangles: Vec<[Vec3; 3]>, camera: &Camera| {
            let triangles = triangles.into_iter().map(|[a, b, c]| Triangle::new(a, b, c));
            all.push(Hostile { name, triangles: triangles.collect(), camera: camera.clone() });
        };
        add("through the eye", through_the_eye(), &near);
        add("edge-on", edge_on(&near), &near);
        add("slivers", slivers(), &near);
        add("edges at the middles of pixels", aimed(&rays), &near);
        add("around the eye", around(), &near);
        add("twice and in one plane", twice(), &near);
        let away = Vec3::new(4.0e5, -3.0e5, 2.0e5);
        let far = aimed(&rays).into_iter().chain(around());
        let far = far.map(|corners| corners.map(|corner| corner + away)).collect();
        add("far from the origin", far, &camera(lens, EYE + away));
    }
    all
}

/// Corners, edges and insides at the eye itself.
fn through_the_eye() -> Vec<[Vec3; 3]> {
    let mut numbers = Numbers(1);
    let mut all = Vec::new();
    for _ in 0..12 {
        let (p, q) = (EYE + numbers.point(), numbers.point());
        all.push([EYE, p, q]);
        // Its edge goes through the eye, as far as rounding allows.
        all.push([p, EYE + EYE - p, q]);
        // The eye is inside it.
        all.push([p, q, EYE * 3.0 - p - q]);
        all.push([p, q, numbers.point()]);
    }
    all
}

/// Planes that the eye is in, or as good as in.
fn edge_on(camera: &Camera) -> Vec<[Vec3; 3]> {
    let mut numbers = Numbers(2);
    let mut all = Vec::new();
    let [eye, right, up, forward] = [camera.eye, camera.right, camera.up, camera.forward];
    for i in 0..24 {
        let (x, y) = (numbers.next(), numbers.next());
        let across = right * x + up * y;
        let [a, b, c] =
            [0; 3].map(|_| eye + forward * (2.5 + numbers.next()) + across * numbers.next());
        let off = if i % 3 == 0 { 0.0 } else { 1e-7 * numbers.next() };
        all.push([a, b, c + up.cross(across) * off]);
        // A level floor at the height of the eye.
        let y = EYE.y;
        let at = |v: Vec3| Vec3::new(v.x, y, v.z);
        all.push([at(numbers.point()), at(numbers.point()), at(numbers.point())]);
    }
    all
}

/// Thin and small ones.
fn slivers() -> Vec<[Vec3; 3]> {
    let mut numbers = Numbers(3);
    let mut all = Vec::new();
    for i in 0..160 {
        let (a, b) = (numbers.point(), numbers.point());
        let thin = [1e-3, 1e-5, 1e-6, 1e-7][i % 4];
        all.push([a, b, a.lerp(b, 0.5 + 0.5 * numbers.next()) + numbers.point() * thin]);
        let tiny = [3e-3, 1e-3, 1e-4, 1e-6][i % 4];
        all.push([a, a + numbers.point() * tiny, a + numbers.point() * tiny]);
    }
    all
}

/// Triangles that share edges and corners which lie where the rays of pixels pass.
fn aimed(rays: &PixelRays) -> Vec<[Vec3; 3]> {
    let mut numbers = Numbers(4);
    let mut all = Vec::new();
    let [width, height] = rays.size();
    let at = |x: u32, y: u32, t: f32| {
        let (o, d) = rays.ray([x.min(width - 1), y.min(height - 1)]);
        o + d * t
    };
    let steps = [width.div_ceil(9).max(1), height.div_ceil(7).max(1)];
    for y in (0..height).step_by(steps[1] as usize) {
        for x in (0..width).step_by(steps[0] as usize) {
            let t = 2.0 + 0.2 * numbers.next();
            let (x1, y1) = (x + steps[0], y + steps[1]);
            let [a, b, c, d] = [at(x, y, t), at(x1, y, t), at(x1, y1, t), at(x, y1, t)];
            all.extend([[a, b, c], [a, c, d]]);
            // Of one row and one column of pixels.
            let (p, q) = (at(x, y, 1.5), at(x1, y, 1.7));
            all.push([p, q, at(x + steps[0] / 2, y + 1, 1.6)]);
        }
    }
    all
}

/// Large ones in all directions, which cross the plane of the eye.
fn around() -> Vec<[Vec3; 3]> {
    let mut numbers = Numbers(5);
    (0..80)
        .map(|i| {
            let size = [3.0, 0.7, 0.1, 20.0][i % 4];
            let middle = EYE + numbers.point() * 2.0;
            [0; 3].map(|_| middle + numbers.point() * size)
        })
        .collect()
}

/// The same triangle several times, and others in its plane, so that numbers decide.
fn twice() -> Vec<[Vec3; 3]> {
    let mut numbers = Numbers(6);
    let mut all = Vec::new();
    for _ in 0..10 {
        let [a, b, c] = [numbers.point(), numbers.point(), numbers.point()];
        all.extend([[a, b, c], [b, c, a], [c, b, a]]);
        let at = Vec2::new(numbers.next(), numbers.next());
        all.push([a.lerp(b, at.x), b.lerp(c, at.y), c.lerp(a, at.x)]);
        // All in one level plane.
        let flat = |v: Vec3| v.with_z(0.25);
        all.push([flat(a), flat(b), flat(c)]);
    }
    all
}
