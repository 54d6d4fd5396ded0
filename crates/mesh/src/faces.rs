//! Vertices and faces, as readers hand them over.

use std::ops::Range;

use trisect_core::Triangle;

use crate::error::{MeshProblem, Place};

/// What a reader hands over: the file's vertices and faces, unchecked.
#[derive(Default)]
pub(crate) struct Raw {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) corners: Vec<Corner>,
    pub(crate) faces: Vec<Face>,
}

pub(crate) struct Vertex {
    pub(crate) at: [f64; 3],
    pub(crate) line: Option<usize>,
}

/// A polygon: its corners follow one another in [`Raw::corners`].
pub(crate) struct Face {
    pub(crate) corners: Range<usize>,
    pub(crate) line: Option<usize>,
}

/// A corner of a face.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    /// The number of its vertex from 0; anything out of range where the file is wrong.
    pub(crate) vertex: i64,
    /// The same as the file writes it.
    pub(crate) written: i64,
}

impl Raw {
    /// Adds a face of a format that numbers its vertices from 0.
    pub(crate) fn push(&mut self, vertices: &[i64], line: Option<usize>) {
        self.push_corners(vertices.iter().map(|&vertex| Corner { vertex, written: vertex }), line);
    }

    /// Adds a face.
    pub(crate) fn push_corners(
        &mut self,
        corners: impl IntoIterator<Item = Corner>,
        line: Option<usize>,
    ) {
        let first = self.corners.len();
        self.corners.extend(corners);
        self.faces.push(Face { corners: first..self.corners.len(), line });
    }

    /// The triangles, in the order of the faces.
    pub(crate) fn triangles(&self) -> Result<Vec<Triangle<f64>>, MeshProblem> {
        all_finite(&self.vertices)?;
        let mut triangles = Vec::with_capacity(self.faces.len());
        for (number, face) in self.faces.iter().enumerate() {
            let place = Place { number, line: face.line };
            let corners = &self.corners[face.corners.clone()];
            let &[a, b, c] = corners else {
                return Err(MeshProblem::NotATriangle { face: place, corners: corners.len() });
            };
            let at = |corner: Corner| vertex_at(&self.vertices, corner, place);
            triangles.push(Triangle::new(at(a)?, at(b)?, at(c)?));
        }
        Ok(triangles)
    }
}

/// The largest coordinate that is finite in f32, where every method works.
const LARGEST: f64 = f32::MAX as f64;

/// Refuses coordinates that are not finite in f32.
pub(crate) fn all_finite(vertices: &[Vertex]) -> Result<(), MeshProblem> {
    for (number, vertex) in vertices.iter().enumerate() {
        if let Some(axis) = vertex.at.iter().position(|x| !(x.abs() <= LARGEST)) {
            return Err(MeshProblem::NotFinite {
                vertex: Place { number, line: vertex.line },
                axis: ['x', 'y', 'z'][axis],
                value: vertex.at[axis],
            });
        }
    }
    Ok(())
}

/// The vertex of a face's corner, if there is one.
pub(crate) fn vertex_at(
    vertices: &[Vertex],
    corner: Corner,
    face: Place,
) -> Result<[f64; 3], MeshProblem> {
    let vertex = usize::try_from(corner.vertex).ok().and_then(|index| vertices.get(index));
    vertex.map(|vertex| vertex.at).ok_or(MeshProblem::IndexOutOfRange {
        face,
        index: corner.written,
        vertices: vertices.len(),
    })
}
