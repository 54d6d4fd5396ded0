//! Vertices and faces, as readers hand them over, and the triangles that they become.

use std::ops::Range;

use trisect_core::Triangle;

use crate::error::{MeshProblem, Place};
use crate::polygon::{Shape, Splitter};
use crate::reading::Source;
use crate::reading::{ReadProblem, Reading};

/// What a reader hands over: the file's vertices and faces, unchecked.
#[derive(Default)]
pub(crate) struct Raw {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) corners: Vec<Corner>,
    pub(crate) faces: Vec<Face>,
    /// The bytes that are claimed for these.
    claimed: u64,
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
    /// Room for so many vertices and triangles, where memory allows it.
    pub(crate) fn with_capacity(
        vertices: usize,
        faces: usize,
        reading: &mut Reading,
    ) -> Result<Self, ReadProblem> {
        let bytes =
            vertices * size_of::<Vertex>() + faces * (size_of::<Face>() + 3 * size_of::<Corner>());
        reading.claim(bytes as u64)?;
        Ok(Self {
            vertices: Vec::with_capacity(vertices),
            corners: Vec::with_capacity(3 * faces),
            faces: Vec::with_capacity(faces),
            claimed: bytes as u64,
        })
    }

    /// Adds a face of a format that numbers its vertices from 0.
    pub(crate) fn push(&mut self, vertices: impl IntoIterator<Item = i64>, line: Option<usize>) {
        self.push_corners(vertices.into_iter().map(|v| Corner { vertex: v, written: v }), line);
    }

    /// Claims the memory that has been taken since the last claim.
    pub(crate) fn claim(&mut self, reading: &mut Reading) -> Result<(), ReadProblem> {
        let taken =
            size_of_val(&*self.vertices) + size_of_val(&*self.corners) + size_of_val(&*self.faces);
        let taken = taken as u64;
        reading.claim(taken.saturating_sub(self.claimed))?;
        self.claimed = self.claimed.max(taken);
        Ok(())
    }

    /// Adds a face.
    pub(crate) fn push_corners(
        &mut self,
        corners: impl IntoIterator<Item = Corner>,
        line: Option<usize>,
    ) {
        let first = self.corners.len();
        self.corners.extend(corners);
        self.close_face(first, line);
    }

    /// Makes a face of the corners from that place on.
    pub(crate) fn close_face(&mut self, first: usize, line: Option<usize>) {
        self.faces.push(Face { corners: first..self.corners.len(), line });
    }

    /// The triangles, in the order of the faces.
    pub(crate) fn triangles(
        &self,
        source: &mut Source<'_>,
    ) -> Result<Vec<Triangle<f64>>, MeshProblem> {
        let count = self.corners.len().saturating_sub(2 * self.faces.len());
        source.reading.claim((count * size_of::<Triangle<f64>>()) as u64)?;
        let mut triangles = Vec::with_capacity(count);
        self.each_triangle(source, |_, [a, b, c], _| triangles.push(Triangle::new(a, b, c)))?;
        Ok(triangles)
    }

    /// Calls `take` with every triangle, in the order of the faces: the number of its face, its corners,
    /// and their places in [`Raw::corners`]. Polygons are split; of what has no area only triangles are
    /// kept.
    pub(crate) fn each_triangle(
        &self,
        source: &mut Source<'_>,
        mut take: impl FnMut(usize, [[f64; 3]; 3], [usize; 3]),
    ) -> Result<(), MeshProblem> {
        let all_finite = self.vertices.iter().flat_map(|vertex| vertex.at).all(is_finite);
        let mut splitter = Splitter::default();
        let mut polygon = Vec::new();
        for (number, face) in self.faces.iter().enumerate() {
            let place = Place { number, line: face.line };
            let at = |corner: usize| self.vertex(self.corners[corner], place, all_finite);
            let first = face.corners.start;
            match face.corners.len() {
                3 => {
                    let corners = [first, first + 1, first + 2];
                    take(number, [at(first)?, at(first + 1)?, at(first + 2)?], corners);
                }
                0..3 => {
                    let what = "a face of fewer than three corners has no area and is left out";
                    source.reading.note(source.file, &format!("face {place}"), what)?;
                }
                _ => {
                    polygon.clear();
                    for corner in face.corners.clone() {
                        polygon.push(at(corner)?);
                    }
                    let (shape, triangles) = splitter.split(&polygon);
                    let what = match shape {
                        Shape::Simple => None,
                        Shape::Flat => Some("a polygon without area is left out"),
                        Shape::Crossing => Some(
                            "a polygon whose outline crosses itself, seen along its normal, is \
                             taken as a fan of triangles from its first corner",
                        ),
                        Shape::TooLarge => {
                            let (corners, most) = (polygon.len(), Splitter::MOST);
                            return Err(MeshProblem::Unsupported {
                                what: format!(
                                    "face {place}: {corners} corners, more than {most}, are"
                                ),
                                mend: "split it into smaller polygons",
                            });
                        }
                    };
                    if let Some(what) = what {
                        source.reading.note(source.file, &format!("face {place}"), what)?;
                    }
                    for corners in triangles {
                        take(number, corners.map(|i| polygon[i]), corners.map(|i| first + i));
                    }
                }
            }
        }
        Ok(())
    }

    /// The vertex of a face's corner.
    fn vertex(
        &self,
        corner: Corner,
        face: Place,
        all_finite: bool,
    ) -> Result<[f64; 3], MeshProblem> {
        let number = usize::try_from(corner.vertex).unwrap_or(usize::MAX);
        let vertex = self.vertices.get(number).ok_or(MeshProblem::IndexOutOfRange {
            face,
            index: corner.written,
            vertices: self.vertices.len(),
        })?;
        let faulty = || vertex.at.iter().position(|x| !is_finite(*x));
        if !all_finite && let Some(axis) = faulty() {
            return Err(MeshProblem::NotFinite {
                face,
                vertex: Place { number, line: vertex.line },
                axis: ['x', 'y', 'z'][axis],
                value: vertex.at[axis],
            });
        }
        Ok(vertex.at)
    }
}

/// The largest coordinate that is finite in f32, where every method works.
const LARGEST: f64 = f32::MAX as f64;

fn is_finite(x: f64) -> bool {
    x.abs() <= LARGEST
}
