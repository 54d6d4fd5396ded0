//! Polygons split into triangles between their corners.
//!
//! A convex polygon is a fan from its first corner, so that a quad `a b c d` is `a b c` and `a c d`. Any
//! other is split by a constrained Delaunay triangulation of its projection along its normal (Newell's:
//! the sum of the cross products of neighbouring corners). Against ear clipping, that keeps corners in
//! the middle of a straight edge, where a neighbour of the mesh may have a corner too; its predicates
//! are exact; and it says where an outline crosses itself.

use robust::{Coord, orient2d};
use spade::handles::{FixedDirectedEdgeHandle, FixedVertexHandle};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

/// What a polygon is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// It bounds an area, or areas that touch in corners: the triangles fill it.
    Simple,
    /// Its outline crosses itself, or runs around a place twice, seen along its normal: the triangles are
    /// the fan from its first corner.
    Crossing,
    /// All corners lie on one line: no triangles.
    Flat,
    /// It is not convex, and has more corners than [`Splitter::MOST`]: no triangles.
    TooLarge,
}

/// Splits polygons, and keeps its memory between them.
#[derive(Default)]
pub(crate) struct Splitter {
    /// The corners without those that repeat the one before.
    ring: Vec<usize>,
    projected: Vec<[f64; 2]>,
    triangles: Vec<[usize; 3]>,
}

impl Splitter {
    /// The most corners of a polygon that is not convex: the time grows with their square at worst.
    pub(crate) const MOST: usize = 1 << 15;

    /// The triangles between a polygon's corners, as places in `corners`, with its front in front. Corners
    /// that repeat the one before are passed over: n others give n − 2 triangles, where the outline does not
    /// touch itself.
    pub(crate) fn split(&mut self, corners: &[[f64; 3]]) -> (Shape, &[[usize; 3]]) {
        self.triangles.clear();
        self.ring.clear();
        for (i, corner) in corners.iter().enumerate() {
            if self.ring.last().is_none_or(|&last| corners[last] != *corner) {
                self.ring.push(i);
            }
        }
        while self.ring.len() > 1 && self.ring.last().is_some_and(|&i| corners[i] == corners[0]) {
            self.ring.pop();
        }
        let shape = self.shape(corners);
        if shape == Shape::Crossing {
            self.fan();
        }
        (shape, &self.triangles)
    }

    fn shape(&mut self, corners: &[[f64; 3]]) -> Shape {
        if self.ring.len() < 3 {
            return Shape::Flat;
        }
        if let Err(shape) = self.project(corners) {
            return shape;
        }
        if self.is_convex() {
            self.fan();
            return Shape::Simple;
        }
        if self.ring.len() > Self::MOST {
            return Shape::TooLarge;
        }
        match self.triangulate() {
            Some(()) if self.triangles.is_empty() => Shape::Flat,
            Some(()) => Shape::Simple,
            None => Shape::Crossing,
        }
    }

    fn fan(&mut self) {
        let Self { ring, triangles, .. } = self;
        triangles.clear();
        triangles.extend(ring[1..].windows(2).map(|pair| [ring[0], pair[0], pair[1]]));
    }

    /// Projects the corners along the polygon's normal to the plane of two axes that it leans on least,
    /// where the outline runs counter-clockwise. The result is exact where the normal is an axis.
    fn project(&mut self, corners: &[[f64; 3]]) -> Result<(), Shape> {
        let origin = corners[self.ring[0]];
        let from_origin = |i: usize| [0, 1, 2].map(|axis| corners[i][axis] - origin[axis]);
        let ring = self.ring.iter().map(|&i| from_origin(i));
        let extent = ring.clone().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        // A power of two changes no digit, and keeps the products inside the range of numbers.
        let scale = inverse_power_of_two(extent);
        let ring = ring.map(|p| p.map(|x| x * scale));
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let products = ring.clone().zip(ring.clone().skip(1)).map(|(a, b)| cross(a, b));
        let add = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let normal = products.clone().fold([0.0; 3], add);
        let mut axis = 0;
        for other in [1, 2] {
            if normal[other].abs() > normal[axis].abs() {
                axis = other;
            }
        }
        if normal[axis] == 0.0 {
            let is_flat = products.flatten().all(|x| x == 0.0);
            return Err(if is_flat { Shape::Flat } else { Shape::Crossing });
        }
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            (u, v) = (v, u);
        }
        let (du, dv) = (normal[u] / normal[axis], normal[v] / normal[axis]);
        let projected = ring.map(|p| [p[u] - p[axis] * du, p[v] - p[axis] * dv]);
        self.projected.clear();
        self.projected.extend(projected);
        Ok(())
    }

    /// Whether every triangle of the fan from the first corner has an area, and all lie side by side.
    fn is_convex(&self) -> bool {
        let coord = |p: [f64; 2]| Coord { x: p[0], y: p[1] };
        let [first, second] = [self.projected[0], self.projected[1]].map(coord);
        let left = |a: Coord<f64>, b: Coord<f64>, c: Coord<f64>| orient2d(a, b, c) > 0.0;
        let mut pairs = self.projected[1..].windows(2).map(|pair| [coord(pair[0]), coord(pair[1])]);
        pairs.all(|[a, b]| left(first, a, b) && left(first, second, b))
    }

    /// Triangulates what the outline runs around; `None` where it crosses itself.
    fn triangulate(&mut self) -> Option<()> {
        let mut plane = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
        let mut vertices: Vec<FixedVertexHandle> = Vec::with_capacity(self.ring.len());
        // Of corners at one point the first stands for all.
        let mut corner_of = Vec::new();
        for (&corner, p) in self.ring.iter().zip(&self.projected) {
            // The library refuses numbers near the least; the extent here is about 1.
            let vertex = plane.insert(spade::mitigate_underflow(Point2::from(*p))).ok()?;
            if vertex.index() == corner_of.len() {
                corner_of.push(corner);
            }
            // At once, not when all corners are there: an edge then crosses few others.
            if let Some(&before) = vertices.last()
                && plane.try_add_constraint(before, vertex).is_empty()
            {
                return None;
            }
            vertices.push(vertex);
        }
        let turns = turns(&mut plane, &vertices)?;

        // Every triangle gets the number of times that the outline runs around it, from the outside in:
        // an edge of the outline changes it by one for each time that it is run along.
        let change = |edge: FixedDirectedEdgeHandle| {
            let along = turns[edge.as_undirected().index()];
            if edge == edge.as_undirected().as_directed() { along } else { -along }
        };
        let mut around: Vec<Option<i32>> = vec![None; plane.num_all_faces()];
        let mut open = Vec::new();
        for edge in plane.convex_hull() {
            let inside = if edge.is_outer_edge() { edge.rev() } else { edge };
            open.push((inside.face().fix(), change(inside.fix())));
        }
        while let Some((face, times)) = open.pop() {
            let Some(inner) = plane.face(face).as_inner() else { continue };
            if around[face.index()].replace(times).is_some() {
                continue;
            }
            for edge in inner.adjacent_edges() {
                let beyond = edge.rev();
                if around[beyond.face().fix().index()].is_none() {
                    open.push((beyond.face().fix(), times + change(beyond.fix())));
                }
            }
        }
        for face in plane.inner_faces() {
            let times = around[face.fix().index()].unwrap_or_default();
            if times.abs() > 1 {
                return None;
            }
            if times != 0 {
                let mut triangle = face.vertices().map(|vertex| corner_of[vertex.fix().index()]);
                if times < 0 {
                    triangle.reverse();
                }
                let least =
                    triangle.iter().position(|corner| Some(corner) == triangle.iter().min());
                triangle.rotate_left(least.unwrap_or_default());
                self.triangles.push(triangle);
            }
        }
        self.triangles.sort_unstable();
        Some(())
    }
}

/// How many times the outline runs along each edge in the edge's own direction more than against it;
/// `None` where the outline crosses itself.
fn turns(
    plane: &mut ConstrainedDelaunayTriangulation<Point2<f64>>,
    vertices: &[FixedVertexHandle],
) -> Option<Vec<i32>> {
    let ends = || vertices.iter().copied().zip(vertices.iter().copied().cycle().skip(1));
    let (last, first) = ends().last()?;
    plane.try_add_constraint(last, first);
    let mut turns = vec![0; plane.num_undirected_edges()];
    for (from, to) in ends() {
        // All are there: nothing changes. An edge that runs through other corners comes in pieces.
        let pieces = plane.try_add_constraint(from, to);
        if pieces.is_empty() {
            return None;
        }
        let mut at = from;
        for piece in pieces {
            let [start, end] = plane.directed_edge(piece).vertices().map(|vertex| vertex.fix());
            let is_along = start == at;
            at = if is_along { end } else { start };
            let edge = piece.as_undirected();
            let is_own_direction = piece == edge.as_directed();
            turns[edge.index()] += if is_along == is_own_direction { 1 } else { -1 };
        }
    }
    Some(turns)
}

/// The power of two that brings a positive number near 1; 1 for 0.
fn inverse_power_of_two(x: f64) -> f64 {
    const BIAS: u64 = 1023;
    let exponent = x.to_bits() >> 52 & 0x7ff;
    if x == 0.0 { 1.0 } else { f64::from_bits((2 * BIAS - exponent).clamp(1, 2 * BIAS) << 52) }
}
