//! Surfaces whose triangles share corners to the bit, and rays aimed at where those meet.
//!
//! Nothing here uses a function that machines round differently, so that corners are the same bits
//! everywhere.

use std::collections::{BTreeMap, BTreeSet};

use trisect_core::{Float, Ray, Scalar, Triangle, Vec3};

use crate::stream::Stream;

/// Triangles over shared corners.
#[derive(Clone, Debug)]
pub struct Surface {
    /// A short name without spaces, for records.
    pub name: &'static str,
    /// The corners.
    pub corners: Vec<Vec3<f64>>,
    /// Of each triangle the places of its corners.
    pub faces: Vec<[usize; 3]>,
    /// Half the side of the cube that rays start from, which lies inside a closed surface.
    pub inside: f64,
    /// How far that cube's middle lies above the origin: none for a closed surface, enough to be
    /// clear of an open one.
    pub above: f64,
}

/// Where a surface is put: its corners are scaled, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The factor of size.
    pub scale: f64,
    /// The new place of the origin.
    pub offset: Vec3<f64>,
}

impl Placement {
    /// Where the surface was made.
    pub const HERE: Self = Self { scale: 1.0, offset: Vec3::new(0.0, 0.0, 0.0) };

    fn put<E: Float>(&self, v: Vec3<f64>) -> Vec3<E> {
        v.mul_add(self.scale, self.offset).map(E::from_f64)
    }
}

/// What rays are aimed at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// Points of edges.
    Edges,
    /// Corners.
    Vertices,
}

impl Aim {
    /// `edges` or `vertices`
    pub const fn name(self) -> &'static str {
        match self {
            Self::Edges => "edges",
            Self::Vertices => "vertices",
        }
    }
}

/// An edge or a corner of a surface, with the triangles that meet there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feature {
    /// The places of the ends of the edge; of a corner twice the same.
    pub ends: [usize; 2],
    /// The numbers of the triangles.
    pub faces: Vec<usize>,
}

impl Surface {
    /// The triangles, rounded to `E` where they are put.
    pub fn triangles<E: Float>(&self, placement: &Placement) -> Vec<Triangle<E>> {
        let corners: Vec<Vec3<E>> = self.corners.iter().map(|&v| placement.put(v)).collect();
        self.faces
            .iter()
            .map(|&[a, b, c]| Triangle { a: corners[a], b: corners[b], c: corners[c] })
            .collect()
    }

    /// The edges or the corners, in the order in which the triangles name them first.
    pub fn features(&self, aim: Aim) -> Vec<Feature> {
        let mut places: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        let mut features: Vec<Feature> = Vec::new();
        for (number, &[a, b, c]) in self.faces.iter().enumerate() {
            let ends = match aim {
                Aim::Edges => [[a, b], [b, c], [c, a]],
                Aim::Vertices => [[a, a], [b, b], [c, c]],
            };
            for [from, to] in ends {
                let ends = [from.min(to), from.max(to)];
                let place = *places.entry(ends).or_insert_with(|| {
                    features.push(Feature { ends, faces: Vec::new() });
                    features.len() - 1
                });
                features[place].faces.push(number);
            }
        }
        features
    }

    /// The edges or the corners with triangles all around: all of them in a closed surface, those
    /// that are not on the border in an open one.
    pub fn inner_features(&self, aim: Aim) -> Vec<Feature> {
        let edges = self.features(Aim::Edges);
        let border: BTreeSet<usize> =
            edges.iter().filter(|edge| edge.faces.len() == 1).flat_map(|edge| edge.ends).collect();
        let mut features = match aim {
            Aim::Edges => edges,
            Aim::Vertices => self.features(aim),
        };
        features.retain(|feature| match aim {
            Aim::Edges => feature.faces.len() > 1,
            Aim::Vertices => !border.contains(&feature.ends[0]),
        });
        features
    }

    /// A random point that rays start from.
    fn start<E: Float>(&self, placement: &Placement, stream: &mut Stream) -> Vec3<E> {
        let middle = Vec3::new(0.0, 0.0, self.above);
        placement.put(stream.cube().mul_add(self.inside, middle))
    }

    /// Rays from random points of the cube, each aimed at a random point of the feature; the point,
    /// the origin and their difference are rounded to `E`.
    pub fn aimed<E: Float>(
        &self,
        feature: &Feature,
        placement: &Placement,
        seed: u64,
        rays: usize,
    ) -> Vec<Ray<E>> {
        let [from, to] = feature.ends;
        let name = format!("surface/{}/{from}/{to}", self.name);
        let mut stream = Stream::new(&name, seed);
        let [from, to] =
            [from, to].map(|end| placement.put::<E>(self.corners[end]).map(Scalar::to_f64));
        (0..rays)
            .map(|_| {
                let target = (to - from).mul_add(stream.unit_f64(), from).map(E::from_f64);
                let o = self.start::<E>(placement, &mut stream);
                Ray::<E>::new(o, target - o)
            })
            .collect()
    }

    /// Rays from random points of the cube, in random directions.
    pub fn outwards<E: Float>(&self, placement: &Placement, seed: u64, rays: usize) -> Vec<Ray<E>> {
        let mut stream = Stream::new(&format!("surface/{}/outwards", self.name), seed);
        (0..rays)
            .map(|_| {
                let o = self.start::<E>(placement, &mut stream);
                let d = stream.sphere();
                Ray::<E>::new(o, d.map(|x| E::from_f64(f64::from(x))))
            })
            .collect()
    }

    /// A sphere of radius 2 and 20·4^`subdivisions` triangles: an icosahedron whose faces are divided
    /// into four again and again, its corners on the sphere. Closed.
    pub fn sphere(subdivisions: u32) -> Self {
        Self::icosphere("sphere", 2.0, subdivisions)
    }

    /// A sphere whose corners have random distances of 1 to 6 from the origin, 320 triangles. Closed,
    /// and so ragged that rays pass it more than once.
    pub fn ragged_sphere(seed: u64) -> Self {
        let mut surface = Self::icosphere("ragged-sphere", 1.0, 2);
        let mut stream = Stream::new("surface/ragged", seed);
        for corner in &mut surface.corners {
            *corner = corner.scale(1.0 + 5.0 * stream.unit_f64());
        }
        surface.inside = 0.25;
        surface
    }

    fn icosphere(name: &'static str, radius: f64, subdivisions: u32) -> Self {
        let onto = |v: Vec3<f64>| v.scale(radius / v.dot(v).sqrt());
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        let mut corners: Vec<Vec3<f64>> = (0..3)
            .flat_map(|axis| {
                [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
                    .map(|(x, y)| onto(Vec3::new(x, y * golden, 0.0).with_axis_last(axis)))
            })
            .collect();
        // The faces are the triples of corners that are neighbours of each other.
        let side = radius * 4.0 / (10.0 + 2.0 * 5.0_f64.sqrt()).sqrt();
        let near = |i: usize, j: usize| {
            let d: Vec3<f64> = corners[i] - corners[j];
            d.dot(d) < 1.1 * side * side
        };
        let mut faces = Vec::new();
        for i in 0..12 {
            for j in i + 1..12 {
                for k in j + 1..12 {
                    if near(i, j) && near(j, k) && near(k, i) {
                        faces.push([i, j, k]);
                    }
                }
            }
        }
        for _ in 0..subdivisions {
            let mut middles: BTreeMap<[usize; 2], usize> = BTreeMap::new();
            let mut middle = |i: usize, j: usize| {
                *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                    corners.push(onto(corners[i] + corners[j]));
                    corners.len() - 1
                })
            };
            faces = faces
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        Self { name, corners, faces, inside: 0.5 * radius, above: 0.0 }
    }

    /// The cube [−1, 1]³, each side in `divisions`² squares of two triangles. Closed.
    pub fn cube(divisions: usize) -> Self {
        let (corners, faces) = (Vec::new(), Vec::new());
        let mut surface = Self { name: "cube", corners, faces, inside: 0.75, above: 0.0 };
        let mut places: BTreeMap<[usize; 3], usize> = BTreeMap::new();
        let place = |k: usize| 2.0 * k as f64 / divisions as f64 - 1.0;
        for axis in 0..3 {
            for height in [0, divisions] {
                surface.squares(divisions, |i, j| {
                    let key = Vec3::new(i, j, height).with_axis_last(axis).to_array();
                    let corners_before = places.len();
                    let at = *places.entry(key).or_insert(corners_before);
                    (at, Vec3::from(key.map(place)))
                });
            }
        }
        surface
    }

    /// The square [−1, 1]² at `z = 0` in `divisions`² squares of two triangles.
    pub fn square(divisions: usize) -> Self {
        let (corners, faces) = (Vec::new(), Vec::new());
        let mut surface = Self { name: "square", corners, faces, inside: 0.5, above: 2.0 };
        let place = |k: usize| 2.0 * k as f64 / divisions as f64 - 1.0;
        surface.squares(divisions, |i, j| {
            (i * (divisions + 1) + j, Vec3::new(place(i), place(j), 0.0))
        });
        surface
    }

    /// Adds a lattice of squares, whose corners `corner` numbers and places; a number beyond those
    /// that are there is new.
    fn squares(
        &mut self,
        divisions: usize,
        mut corner: impl FnMut(usize, usize) -> (usize, Vec3<f64>),
    ) {
        let mut at = |surface: &mut Self, i, j| {
            let (number, place) = corner(i, j);
            if number >= surface.corners.len() {
                surface.corners.resize(number + 1, place);
            }
            surface.corners[number] = place;
            number
        };
        for i in 0..divisions {
            for j in 0..divisions {
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| at(self, i, j));
                self.faces.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// The square [−1, 1]² at `z = 0`, in two triangles of which random ones are split into three at
    /// random inner points until there are `triangles` or one more.
    pub fn split_square(seed: u64, triangles: usize) -> Self {
        let mut stream = Stream::new("surface/split", seed);
        let mut surface = Self { name: "split-square", ..Self::square(1) };
        while surface.faces.len() < triangles {
            let chosen = stream.below(surface.faces.len());
            let [a, b, c] = surface.faces[chosen];
            // Weights of a quarter or more keep the pieces from being slivers at once.
            let [beta, gamma] = [0, 1].map(|_| 0.25 + 0.125 * stream.unit_f64());
            let [p, q, r] = [a, b, c].map(|i| surface.corners[i]);
            let inner = surface.corners.len();
            surface.corners.push((q - p).mul_add(beta, (r - p).mul_add(gamma, p)));
            surface.faces[chosen] = [a, b, inner];
            surface.faces.extend([[b, c, inner], [c, a, inner]]);
        }
        surface
    }

    /// `triangles` around the origin at `z = 0`, the rim on the unit circle.
    pub fn fan(triangles: usize) -> Self {
        let mut corners = vec![Vec3::new(0.0, 0.0, 0.0)];
        for i in 0..triangles {
            // Half-way round the circle by its rational points, then the other half.
            let turn = 2.0 * i as f64 / triangles as f64;
            let (half, s) = if turn < 1.0 { (1.0, turn) } else { (-1.0, turn - 1.0) };
            let s = 2.0 * s - 1.0;
            let (x, y) = (2.0 * s / (1.0 + s * s), (1.0 - s * s) / (1.0 + s * s));
            corners.push(Vec3::new(-half * x, half * y, 0.0));
        }
        let rim = |i: usize| 1 + i % triangles;
        let faces = (0..triangles).map(|i| [0, rim(i), rim(i + 1)]).collect();
        Self { name: "fan", corners, faces, inside: 0.5, above: 2.0 }
    }
}
