//! Triangles as the rasteriser reads them, and where they are.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use trisect_core::{Ray, Triangle, Vec3 as Coordinates};
use trisect_tracer::Transform;

/// Triangles of a block.
pub(crate) const BLOCK: usize = 8;

/// Eight triangles, number by number: the coordinates of A, then of B and C.
#[derive(Clone)]
pub(crate) struct Block {
    pub(crate) rows: [[f32; BLOCK]; 9],
    /// Those that anything can hit, in bits.
    pub(crate) live: u32,
}

/// The triangles of a mesh.
#[derive(Clone, Default)]
pub struct Blocks {
    pub(crate) blocks: Vec<Block>,
    count: usize,
}

impl Blocks {
    /// Of these triangles, which are numbered by their places.
    pub fn new(triangles: &[Triangle<f32>]) -> Self {
        let mut all = Self { blocks: Vec::new(), count: triangles.len() };
        let empty = Block { rows: [[f32::NAN; BLOCK]; 9], live: 0 };
        all.blocks.resize(triangles.len().div_ceil(BLOCK), empty);
        all.fill(triangles.iter().copied());
        all
    }

    /// Puts other triangles in their places, as many as there are.
    fn fill(&mut self, triangles: impl Iterator<Item = Triangle<f32>>) {
        for (place, triangle) in triangles.enumerate().take(self.count) {
            let (block, lane) = (&mut self.blocks[place / BLOCK], place % BLOCK);
            for (row, x) in
                block.rows.iter_mut().zip(triangle.corners().iter().flat_map(|c| c.to_array()))
            {
                row[lane] = x;
            }
            block.live &= !(1 << lane);
            block.live |= u32::from(triangle.can_be_hit()) << lane;
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// A triangle by its place.
    ///
    /// # Panics
    /// When there is none.
    #[inline]
    pub fn triangle(&self, place: usize) -> Triangle<f32> {
        let (rows, lane) = (&self.blocks[place / BLOCK].rows, place % BLOCK);
        let corner = |row: usize| {
            Coordinates::new(rows[row][lane], rows[row + 1][lane], rows[row + 2][lane])
        };
        Triangle { a: corner(0), b: corner(3), c: corner(6) }
    }
}

/// A mesh in its place.
pub struct Object {
    mesh: Arc<Blocks>,
    /// Where rays are carried to the mesh.
    carried: Option<Transform>,
    /// Where the mesh was carried to the world: its corners there.
    world: Option<(Affine3A, Blocks)>,
}

impl Object {
    /// A mesh whose coordinates are the world's.
    pub fn new(mesh: Arc<Blocks>) -> Self {
        Self { mesh, carried: None, world: None }
    }

    /// A mesh to which rays are carried, as the tracer carries them to its instances: what is seen is
    /// what the tracer sees, to the bit.
    pub fn carried(mesh: Arc<Blocks>, transform: Transform) -> Self {
        let carried = (!transform.is_identity()).then_some(transform);
        Self { mesh, carried, world: None }
    }

    /// A mesh that is carried to the world; its corners there are kept until it moves.
    pub fn placed(mesh: Arc<Blocks>, to_world: Affine3A) -> Self {
        let world = (*mesh).clone();
        let mut object = Self { mesh, carried: None, world: Some((Affine3A::NAN, world)) };
        object.move_to(to_world);
        object
    }

    /// Moves a mesh that is [placed](Object::placed): its corners are computed anew, in the memory that they
    /// have, unless it is there already. Whether they were.
    pub fn move_to(&mut self, to_world: Affine3A) -> bool {
        match &mut self.world {
            Some((place, world)) if *place != to_world => {
                *place = to_world;
                let to_world = |corner: Coordinates<f32>| {
                    Coordinates::from(to_world.transform_point3(Vec3::from(corner)))
                };
                let mesh = &*self.mesh;
                world.fill((0..mesh.len()).map(|place| {
                    let Triangle { a, b, c } = mesh.triangle(place);
                    Triangle { a: to_world(a), b: to_world(b), c: to_world(c) }
                }));
                true
            }
            _ => false,
        }
    }

    /// The triangles that are drawn: in the space that rays are carried to.
    #[inline]
    pub fn triangles(&self) -> &Blocks {
        self.world.as_ref().map_or(&*self.mesh, |(_, world)| world)
    }

    /// How rays are carried to the triangles; `None` where they are not.
    pub fn transform(&self) -> Option<&Transform> {
        self.carried.as_ref()
    }

    /// A ray in the space of the triangles.
    #[inline]
    pub fn carry(&self, ray: &Ray<f32>) -> Ray<f32> {
        self.carried.as_ref().map_or(*ray, |transform| transform.carry(ray))
    }
}
