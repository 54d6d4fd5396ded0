//! The published crates: obvhs, parry3d and bvh, each by its own triangle test.

use std::ops::Range;
use std::time::Duration;

use anyhow::{Context as _, Result};
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy as _};
use bvh::bvh::Bvh;
use nalgebra::{Point3, Vector3};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::triangle::Triangle as ObvhsTriangle;
use parry3d::math::Vec3 as ParryVec3;
use parry3d::query::{Ray as ParryRay, RayCast as _};
use parry3d::shape::{CompositeShapeRef, TriMesh};
use trisect_core::{Ray, Triangle, Vec3};

use crate::contender::{Answers, Build, Built, Contender, Entrant, Found, timed};

/// All of them. obvhs has two trees and reorders its triangles as its examples do; its slow build
/// is the best for tracing.
pub(crate) fn entrants() -> Vec<Entrant> {
    let entrant = |name: &str, build: Build| Entrant {
        name: name.to_owned(),
        contenders: vec![name.to_owned()],
        build,
    };
    vec![
        entrant("obvhs bvh2", Box::new(build_obvhs::<Bvh2>)),
        entrant("obvhs cwbvh", Box::new(build_obvhs::<CwBvh>)),
        entrant("parry3d", Box::new(build_parry)),
        entrant("bvh", Box::new(build_bvh)),
    ]
}

/// Answers to be kept, one place per ray.
#[derive(Default)]
struct Kept {
    closest: Vec<Option<Found>>,
    any: Vec<bool>,
}

impl Kept {
    fn of(rays: usize) -> Self {
        Self { closest: vec![None; rays], any: vec![false; rays] }
    }

    fn answers(&self, any: bool) -> Answers {
        if any { Answers::Any(self.any.clone()) } else { Answers::Closest(self.closest.clone()) }
    }
}

/// One of obvhs's trees.
trait ObvhsTree: Send + Sized + 'static {
    fn build(triangles: &[ObvhsTriangle]) -> Self;
    /// The triangles' numbers in the order of the tree.
    fn order(&self) -> &[u32];
    fn closest(&self, ray: ObvhsRay, hit: &mut RayHit, triangles: &[ObvhsTriangle]) -> bool;
    fn misses(&self, ray: ObvhsRay, triangles: &[ObvhsTriangle]) -> bool;
    fn bytes(&self) -> usize;
}

macro_rules! obvhs_tree {
    ($tree:ty, $build:path) => {
        impl ObvhsTree for $tree {
            fn build(triangles: &[ObvhsTriangle]) -> Self {
                $build(triangles, BvhBuildParams::slow_build(), &mut Duration::default())
            }
            fn order(&self) -> &[u32] {
                &self.primitive_indices
            }
            #[inline]
            fn closest(
                &self,
                ray: ObvhsRay,
                hit: &mut RayHit,
                triangles: &[ObvhsTriangle],
            ) -> bool {
                self.ray_traverse(ray, hit, |ray, place| triangles[place].intersect(ray))
            }
            #[inline]
            fn misses(&self, ray: ObvhsRay, triangles: &[ObvhsTriangle]) -> bool {
                self.ray_traverse_miss(ray, |ray, place| triangles[place].intersect(ray))
            }
            fn bytes(&self) -> usize {
                size_of_val(&self.nodes[..]) + size_of_val(&self.primitive_indices[..])
            }
        }
    };
}
obvhs_tree!(Bvh2, build_bvh2_from_tris);
obvhs_tree!(CwBvh, build_cwbvh_from_tris);

struct Obvhs<T> {
    tree: T,
    /// In the order of the tree.
    triangles: Vec<ObvhsTriangle>,
    rays: Vec<ObvhsRay>,
    kept: Kept,
}

fn build_obvhs<T: ObvhsTree>(triangles: &[Triangle<f32>], threads: usize) -> Result<Built> {
    let point = |v: Vec3<f32>| obvhs_vector(v);
    let all: Vec<ObvhsTriangle> = triangles
        .iter()
        .map(|t| ObvhsTriangle { v0: point(t.a), v1: point(t.b), v2: point(t.c) })
        .collect();
    let ((tree, triangles), time) = timed(threads, || {
        let tree = T::build(&all);
        let triangles: Vec<_> = tree.order().iter().map(|&number| all[number as usize]).collect();
        (tree, triangles)
    })?;
    let bytes = tree.bytes() + size_of_val(&triangles[..]);
    let contender = Obvhs { tree, triangles, rays: Vec::new(), kept: Kept::default() };
    Ok(Built { contenders: vec![Box::new(contender)], time, bytes: Some(bytes) })
}

fn obvhs_vector(v: Vec3<f32>) -> glam::Vec3A {
    glam::Vec3A::new(v.x, v.y, v.z)
}

impl<T: ObvhsTree> Contender for Obvhs<T> {
    fn load(&mut self, rays: &[Ray<f32>]) {
        self.rays = rays
            .iter()
            .map(|ray| ObvhsRay::new(obvhs_vector(ray.o), obvhs_vector(ray.d), ray.tmin, ray.tmax))
            .collect();
        self.kept = Kept::of(rays.len());
    }

    fn closest(&mut self, rays: Range<usize>) {
        for (ray, kept) in self.rays[rays.clone()].iter().zip(&mut self.kept.closest[rays]) {
            let mut hit = RayHit::none();
            *kept = self.tree.closest(*ray, &mut hit, &self.triangles).then_some(hit).map(|hit| {
                Found { triangle: self.tree.order()[hit.primitive_id as usize], t: hit.t }
            });
        }
    }

    fn any(&mut self, rays: Range<usize>) {
        for (ray, kept) in self.rays[rays.clone()].iter().zip(&mut self.kept.any[rays]) {
            *kept = !self.tree.misses(*ray, &self.triangles);
        }
    }

    fn answers(&self, any: bool) -> Answers {
        self.kept.answers(any)
    }
}

/// parry3d's triangle mesh. It has no `tmin`: the origin moves there.
struct Parry {
    mesh: TriMesh,
    /// With `tmin`, and `tmax` less that.
    rays: Vec<(ParryRay, f32, f32)>,
    kept: Kept,
}

fn build_parry(triangles: &[Triangle<f32>], threads: usize) -> Result<Built> {
    let vertices: Vec<ParryVec3> =
        triangles.iter().flat_map(|triangle| triangle.corners()).map(parry_vector).collect();
    let indices: Vec<[u32; 3]> = (0..u32::try_from(triangles.len())
        .context("too many triangles for parry3d")?)
        .map(|number| [3 * number, 3 * number + 1, 3 * number + 2])
        .collect();
    let (mesh, time) = timed(threads, || TriMesh::new(vertices, indices))?;
    let mesh = mesh.context("parry3d does not take the mesh")?;
    let contender = Parry { mesh, rays: Vec::new(), kept: Kept::default() };
    Ok(Built { contenders: vec![Box::new(contender)], time, bytes: None })
}

fn parry_vector(v: Vec3<f32>) -> ParryVec3 {
    ParryVec3::new(v.x, v.y, v.z)
}

impl Contender for Parry {
    fn load(&mut self, rays: &[Ray<f32>]) {
        self.rays = rays
            .iter()
            .map(|ray| {
                let start = ray.d.mul_add(ray.tmin, ray.o);
                let parry = ParryRay::new(parry_vector(start), parry_vector(ray.d));
                (parry, ray.tmin, ray.tmax - ray.tmin)
            })
            .collect();
        self.kept = Kept::of(rays.len());
    }

    fn closest(&mut self, rays: Range<usize>) {
        let mesh = CompositeShapeRef(&self.mesh);
        for ((ray, tmin, tmax), kept) in
            self.rays[rays.clone()].iter().zip(&mut self.kept.closest[rays])
        {
            *kept = mesh
                .cast_local_ray(ray, *tmax, false)
                .map(|(triangle, t)| Found { triangle, t: t + tmin });
        }
    }

    fn any(&mut self, rays: Range<usize>) {
        for ((ray, _, tmax), kept) in self.rays[rays.clone()].iter().zip(&mut self.kept.any[rays]) {
            *kept = self.mesh.intersects_local_ray(ray, *tmax);
        }
    }

    fn answers(&self, any: bool) -> Answers {
        self.kept.answers(any)
    }
}

/// A triangle of the crate bvh, which knows its place in the tree.
struct Shape {
    corners: [Point3<f32>; 3],
    number: u32,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = self.corners;
        Aabb::empty().grow(&a).grow(&b).grow(&c)
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

/// A ray of the crate bvh, whose direction is of unit length; with the length it had, and its
/// interval.
struct UnitRay {
    ray: bvh::ray::Ray<f32, 3>,
    length: f32,
    tmin: f32,
    tmax: f32,
}

/// The crate bvh, in the order that it finds nearer boxes first. Its rays have no interval: all
/// triangles whose boxes are met are tested. Its triangle test sees one side: both orders of
/// corners are asked.
struct SvenstaroBvh {
    tree: Bvh<f32, 3>,
    shapes: Vec<Shape>,
    rays: Vec<UnitRay>,
    kept: Kept,
}

fn build_bvh(triangles: &[Triangle<f32>], threads: usize) -> Result<Built> {
    let mut shapes: Vec<Shape> = (0_u32..)
        .zip(triangles)
        .map(|(number, triangle)| {
            let corners = triangle.corners().map(|v| Point3::new(v.x, v.y, v.z));
            Shape { corners, number, node: 0 }
        })
        .collect();
    let (tree, time) = timed(threads, || Bvh::build_par(&mut shapes))?;
    let bytes = size_of_val(&tree.nodes[..]) + size_of_val(&shapes[..]);
    let contender = SvenstaroBvh { tree, shapes, rays: Vec::new(), kept: Kept::default() };
    Ok(Built { contenders: vec![Box::new(contender)], time, bytes: Some(bytes) })
}

impl SvenstaroBvh {
    /// The hits of a ray within its interval.
    fn hits<'a>(&'a self, ray: &'a UnitRay) -> impl Iterator<Item = Found> + 'a {
        let UnitRay { ray, length, tmin, tmax } = ray;
        self.tree.nearest_child_traverse_iterator(ray, &self.shapes).filter_map(move |shape| {
            let [a, b, c] = &shape.corners;
            let one = ray.intersects_triangle(a, b, c).distance;
            let t = one.min(ray.intersects_triangle(a, c, b).distance) / length;
            let is_hit = *tmin <= t && t <= *tmax && t.is_finite();
            is_hit.then_some(Found { triangle: shape.number, t })
        })
    }
}

impl Contender for SvenstaroBvh {
    fn load(&mut self, rays: &[Ray<f32>]) {
        self.rays = rays
            .iter()
            .map(|ray| {
                let Ray { o, d, tmin, tmax } = *ray;
                let (origin, direction) = (Point3::new(o.x, o.y, o.z), Vector3::new(d.x, d.y, d.z));
                let ray = bvh::ray::Ray::new(origin, direction);
                UnitRay { ray, length: direction.norm(), tmin, tmax }
            })
            .collect();
        self.kept = Kept::of(rays.len());
    }

    fn closest(&mut self, rays: Range<usize>) {
        for at in rays {
            let nearest = self.hits(&self.rays[at]).min_by(|a, b| a.t.total_cmp(&b.t));
            self.kept.closest[at] = nearest;
        }
    }

    fn any(&mut self, rays: Range<usize>) {
        for at in rays {
            let found = self.hits(&self.rays[at]).next().is_some();
            self.kept.any[at] = found;
        }
    }

    fn answers(&self, any: bool) -> Answers {
        self.kept.answers(any)
    }
}
