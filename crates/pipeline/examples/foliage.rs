//! Leaves cut out of squares: a program for any hit looks where a square is hit, and lets rays pass where there is no
//! leaf. Rays that see and rays for shadow ask the same program.
//!
//! `cargo run --release -p trisect-pipeline --example foliage [PICTURE.png]`

#[allow(unused, reason = "each demonstration asks for a part")]
mod common;

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use common::Camera;
use glam::{Affine3A, EulerRot, Quat, Vec2, Vec3};
use trisect_core::{Ray, Triangle};
use trisect_pipeline::random::Random;
use trisect_pipeline::{
    Buffer, Builder, CommitError, Entry, Graph, Launch, NodeId, On, Place, RayType, Scene, Traces,
    Verdict,
};

const SUN: Vec3 = Vec3::new(0.4, 0.8, 0.3);

#[derive(Clone, Copy, PartialEq)]
enum Material {
    Leaf,
    Ground,
}

/// Whether there is leaf at a point of the square from −1 to 1: a disc, or a leaf with a stalk.
#[derive(Clone, Copy)]
enum Cut {
    #[cfg(test)]
    Disc,
    Leaf,
}

impl Cut {
    fn is_there(self, at: Vec2) -> bool {
        match self {
            #[cfg(test)]
            Self::Disc => at.length() <= 1.0,
            Self::Leaf => {
                let half = 0.6 * (1.0 - at.y * at.y).max(0.0) * (1.0 - 0.4 * at.y);
                at.x.abs() < half.max(0.03)
            }
        }
    }
}

struct Sight;

impl RayType for Sight {
    type Payload = ();
}

struct ToSun;

impl RayType for ToSun {
    type Payload = Vec3;
    const ANY: bool = true;
}

struct Viewer {
    camera: Camera,
    size: [u32; 2],
    cut: Cut,
}

impl Viewer {
    /// Where in its square a leaf is hit. Its triangles are `(−1, −1), (1, −1), (1, 1)` and `(−1, −1), (1, 1), (−1, 1)`.
    fn passes(&self, at: &Place<'_, Material>) -> Verdict {
        let [alpha, beta, gamma] = at.weights();
        let [low, right, high, left] =
            [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::ONE, Vec2::new(-1.0, 1.0)];
        let point = if at.shape() == 0 {
            low * alpha + right * beta + high * gamma
        } else {
            low * alpha + high * beta + left * gamma
        };
        let is_leaf = *at.material() == Material::Leaf;
        if is_leaf && !self.cut.is_there(point) { Verdict::Ignore } else { Verdict::Accept }
    }
}

impl Entry for Viewer {
    type Material = Material;
    type Rays = (Sight, ToSun);
    type Out = Vec3;
    type Append = ();

    fn generate(&self, [x, y, _]: [u32; 3], on: &mut On<'_, Self>) {
        let point = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        on.send(Sight, self.camera.ray(point, self.size), ());
    }
}

impl Traces<Sight> for Viewer {
    const ANY_HIT: bool = true;

    fn any_hit(&self, at: &Place<'_, Material>, (): &mut ()) -> Verdict {
        self.passes(at)
    }

    fn closest_hit(&self, at: &Place<'_, Material>, (): (), on: &mut On<'_, Self>) {
        let color = match at.material() {
            Material::Leaf => Vec3::new(0.2, 0.5, 0.1),
            Material::Ground => Vec3::new(0.5, 0.4, 0.3),
        };
        *on.out() = color * 0.3;
        let (normal, towards) = (at.normal(), SUN.normalize());
        on.send(ToSun, Ray::new(at.leave(towards), towards), color * normal.dot(towards).abs());
    }

    fn miss(&self, _: &Ray<f32>, (): (), on: &mut On<'_, Self>) {
        *on.out() = Vec3::new(0.5, 0.7, 0.9);
    }
}

impl Traces<ToSun> for Viewer {
    const ANY_HIT: bool = true;

    fn any_hit(&self, at: &Place<'_, Material>, _: &mut Vec3) -> Verdict {
        self.passes(at)
    }

    fn miss(&self, _: &Ray<f32>, light: Vec3, on: &mut On<'_, Self>) {
        *on.out() += light;
    }
}

/// The square of a leaf.
fn square() -> Vec<Triangle<f32>> {
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let [low, right, high, left] =
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    vec![Triangle::new(low, right, high), Triangle::new(low, high, left)]
}

/// So many leaves above the ground.
fn scene(leaves: u32) -> Result<Scene<Material>, CommitError> {
    let mut graph = Graph::new();
    let geometry = graph.geometry(common::mesh(square(), Builder::Binned));
    let ground = graph.geometry(common::mesh(common::ground(0.0, 12.0), Builder::Binned));
    let (leaf, earth) = (graph.material(Material::Leaf), graph.material(Material::Ground));
    let leaf = graph.instance(geometry, leaf);
    let ground = graph.instance(ground, earth);
    let mut all: Vec<NodeId> = vec![ground];
    for number in 0..leaves {
        let random = Random { seed: 1, pixel: number, sample: 0 };
        let ([a, b, c, d], [x, y, z, _]) = (random.four(0), random.four(1));
        let turn = Quat::from_euler(EulerRot::XYZ, a * 6.0, b * 6.0, c * 6.0);
        let at = Vec3::new(x, y, z) * 2.0 - 1.0;
        let at = at.normalize_or_zero() * d.cbrt() * 2.0 + Vec3::Y * 3.0;
        let place = Affine3A::from_scale_rotation_translation(Vec3::splat(0.15), turn, at);
        all.push(graph.transform(place, leaf));
    }
    let root = graph.group(all);
    Ok(graph.commit(root)?)
}

fn main() -> Result<()> {
    let scene = scene(6000)?;
    let size = [800, 600];
    let camera = Camera::pinhole(Vec3::new(0.0, 3.0, 9.0), Vec3::new(0.0, 2.5, 0.0), 45.0);
    let mut picture = Buffer::plane(size, Vec3::ZERO);
    let start = Instant::now();
    let viewer = Viewer { camera, size, cut: Cut::Leaf };
    let rays: u64 = scene.launch(&viewer, &Launch::default(), &mut picture).rays.iter().sum();
    let time = start.elapsed().as_secs_f64();
    println!("{:.1} ms, {:.2} Mrays/s", time * 1e3, rays as f64 / time * 1e-6);
    if let Some(path) = std::env::args().nth(1) {
        common::write(Path::new(&path), size, picture.cells())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use trisect_pipeline::{Disc, Geometry};

    /// A disc that is cut out by a program looks as one that is a shape of its own.
    #[test]
    fn what_is_cut_out_looks_like_a_shape_of_its_own() {
        let size = [48, 48];
        let camera = Camera::pinhole(Vec3::new(0.5, 6.0, 5.0), Vec3::new(0.0, 1.0, 0.0), 40.0);
        let picture = |is_cut: bool| {
            let mut graph = Graph::new();
            let leaf = if is_cut {
                common::mesh(square(), Builder::Binned)
            } else {
                let disc = Disc { center: Vec3::ZERO, normal: Vec3::Z, radius: 1.0 };
                Geometry::of::<Disc>(vec![disc], Builder::Binned).expect("it is taken")
            };
            let leaf = graph.geometry(leaf);
            let ground = graph.geometry(common::mesh(common::ground(0.0, 12.0), Builder::Binned));
            // A disc has nothing to be cut out of it.
            let material = if is_cut { Material::Leaf } else { Material::Ground };
            let (leaf_material, earth) =
                (graph.material(material), graph.material(Material::Ground));
            let leaf = graph.instance(leaf, leaf_material);
            let turned =
                Affine3A::from_rotation_translation(Quat::from_rotation_x(1.2), Vec3::Y * 2.0);
            let leaf = graph.transform(turned, leaf);
            let ground = graph.instance(ground, earth);
            let root = graph.group([leaf, ground]);
            let scene = graph.commit(root).expect("it is placed");
            let mut picture = Buffer::plane(size, Vec3::ZERO);
            let viewer = Viewer { camera, size, cut: Cut::Disc };
            let rays = scene.launch(&viewer, &Launch::default(), &mut picture).rays;
            // Whether each pixel is lit, or dark, or sky; the colours of both materials differ.
            let is_lit = |color: &Vec3| color.max_element() > 0.16;
            (picture.cells().iter().map(is_lit).collect::<Vec<_>>(), rays)
        };
        let ((cut, rays), (own, _)) = (picture(true), picture(false));
        let differ = cut.iter().zip(&own).filter(|(a, b)| a != b).count();
        assert!(differ <= 4, "{differ} pixels differ: more than at the rim");
        let dark = cut.iter().filter(|is_lit| !**is_lit).count();
        assert!(dark > 50, "the leaf casts its shadow on {dark} pixels");
        assert_eq!(rays[0], 48 * 48);
    }

    #[test]
    fn threads_change_nothing() {
        let scene = scene(300).expect("it is placed");
        let camera = Camera::pinhole(Vec3::new(0.0, 3.0, 9.0), Vec3::new(0.0, 2.5, 0.0), 45.0);
        let viewer = Viewer { camera, size: [40, 30], cut: Cut::Leaf };
        let picture = |threads: usize, tile: u32| {
            let launch = Launch { tile, ..Launch::default() };
            let mut picture = Buffer::plane(viewer.size, Vec3::ZERO);
            common::on_threads(threads, || scene.launch(&viewer, &launch, &mut picture));
            picture
        };
        let first = picture(1, 64);
        assert_eq!(first, picture(3, 7));
        assert!(first.cells().iter().any(|color| color.y > 2.0 * color.x && color.y < 0.7));
    }
}
