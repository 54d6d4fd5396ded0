//! Meshes: triangles with a name, from a file of any format.

use std::path::Path;
use std::sync::Arc;

use trisect_core::{Triangle, Vec3};

use crate::error::{MeshError, MeshProblem, Place};
use crate::faces::Raw;
use crate::reading::{Note, ReadOptions, Reading, Source};
use crate::{gltf, obj, ply, stl};

/// The smallest box that holds a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vec3<f32>,
    /// Largest coordinates.
    pub max: Vec3<f32>,
}

impl Bounds {
    /// The smallest box that holds the corners of `triangles`; `None` where there are none.
    pub fn of(triangles: &[Triangle<f32>]) -> Option<Self> {
        let mut corners = triangles.iter().flat_map(|triangle| triangle.corners());
        let first = corners.next()?;
        Some(corners.fold(Self { min: first, max: first }, |bounds, p| Self {
            min: Vec3::new(bounds.min.x.min(p.x), bounds.min.y.min(p.y), bounds.min.z.min(p.z)),
            max: Vec3::new(bounds.max.x.max(p.x), bounds.max.y.max(p.y), bounds.max.z.max(p.z)),
        }))
    }

    /// The middle of the box.
    pub fn center(&self) -> Vec3<f32> {
        // Halved first: the sum of two large coordinates could overflow.
        self.min.scale(0.5) + self.max.scale(0.5)
    }

    /// The length of the diagonal.
    pub fn diagonal(&self) -> f32 {
        let d = self.max - self.min;
        d.dot(d).sqrt()
    }
}

/// Triangles with a name. Never empty, and every coordinate is finite in f32.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// The name it was given, or the file's name without its ending.
    pub name: String,
    /// The triangles in f32, each coordinate rounded once, in the order of the file. A polygon of n
    /// corners whose outline does not touch itself is n − 2 of them, one after another.
    pub triangles: Arc<[Triangle<f32>]>,
    /// The triangles as the file holds them, where that is not the same.
    finer: Option<Arc<[Triangle<f64>]>>,
    /// How many of [`triangles`](Mesh::triangles) have no area at all: three points exactly on one
    /// line (or one point). [`degenerate_f64`](Mesh::degenerate_f64) of them are so in the file; the
    /// rest lost their area when they were rounded.
    ///
    /// Decided without rounding error: the points are collinear when the exact orientation
    /// predicate of Shewchuk 1997 vanishes for their projections to the xy, yz and zx planes.
    pub degenerate: usize,
    /// The smallest box that holds the triangles in f32.
    pub bounds: Bounds,
    /// What the reader passed over.
    pub notes: Vec<Note>,
}

/// The file formats that are known, by the ending of the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// `.ply`, ascii or binary of either byte order.
    Ply,
    /// `.obj`: its polygons.
    Obj,
    /// `.stl`, ascii or binary.
    Stl,
    /// `.gltf` and `.glb`: the triangles of the scene that the document names, transformed to the world.
    Gltf,
}

impl MeshFormat {
    /// Every ending with its format.
    pub const ENDINGS: [(&str, Self); 5] = [
        ("ply", Self::Ply),
        ("obj", Self::Obj),
        ("stl", Self::Stl),
        ("gltf", Self::Gltf),
        ("glb", Self::Gltf),
    ];

    /// The format of a file by its ending, in either case; `None` if it is not known.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        Self::ENDINGS
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(ending))
            .map(|&(_, format)| format)
    }
}

impl Mesh {
    /// Reads a mesh; the ending of the file's name says in which format.
    ///
    /// # Errors
    /// When the file cannot be read, or is not a mesh of triangles with finite coordinates. The
    /// message names the file, the place in it and what mends it.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        Self::load_with(path, &ReadOptions::default())
    }

    /// The same, read as the options say.
    ///
    /// # Errors
    /// As [`load`](Mesh::load), and for what the options refuse.
    pub fn load_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Self, MeshError> {
        let mut reading = Reading::new(options);
        let mut mesh = Self::read(path.as_ref(), &mut reading)?;
        mesh.notes = reading.into_notes();
        Ok(mesh)
    }

    /// The same as a part of a reading of several files, which takes the notes.
    ///
    /// # Errors
    /// As [`load_with`](Mesh::load_with).
    pub fn read(path: &Path, reading: &mut Reading) -> Result<Self, MeshError> {
        let file = path.display().to_string();
        let fail = |problem| MeshError { file: file.clone(), problem };
        let format = MeshFormat::of(path).ok_or_else(|| fail(MeshProblem::UnknownType))?;
        let bytes = reading.file(path).map_err(|problem| fail(problem.into()))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut source = Source { file: &file, folder: path.parent(), reading };
        let triangles = parse(format, &bytes, &mut source).map_err(fail)?;
        Self::new(name, triangles, Vec::new()).map_err(fail)
    }

    /// Reads a mesh from memory. `name` becomes its name and stands for the file in messages.
    ///
    /// # Errors
    /// As [`load`](Mesh::load); and where a glTF file keeps its buffers in other files.
    pub fn from_bytes(name: &str, format: MeshFormat, bytes: &[u8]) -> Result<Self, MeshError> {
        let fail = |problem| MeshError { file: name.to_owned(), problem };
        let mut reading = Reading::new(&ReadOptions::default());
        let mut source = Source { file: name, folder: None, reading: &mut reading };
        let triangles = parse(format, bytes, &mut source).map_err(fail)?;
        Self::new(name.to_owned(), triangles, reading.into_notes()).map_err(fail)
    }

    /// A mesh of triangles that are in memory.
    ///
    /// # Errors
    /// When there are none, or a coordinate is not finite.
    pub fn from_triangles(
        name: impl Into<String>,
        triangles: Vec<Triangle<f32>>,
    ) -> Result<Self, MeshError> {
        let name = name.into();
        let corners = triangles.iter().flat_map(|triangle| triangle.corners()).enumerate();
        let mut coordinates = corners.flat_map(|(number, corner)| {
            ['x', 'y', 'z']
                .into_iter()
                .zip(corner.to_array())
                .map(move |(axis, x)| (number, axis, x))
        });
        let problem = match coordinates.find(|(.., x)| !x.is_finite()) {
            Some((number, axis, value)) => Some(MeshProblem::NotFinite {
                face: Place { number: number / 3, line: None },
                vertex: Place { number, line: None },
                axis,
                value: value.into(),
            }),
            None => triangles.is_empty().then_some(MeshProblem::Empty),
        };
        match problem {
            Some(problem) => Err(MeshError { file: name, problem }),
            None => Ok(Self::of(name, triangles.into(), None, Vec::new())),
        }
    }

    fn new(name: String, finer: Vec<Triangle<f64>>, notes: Vec<Note>) -> Result<Self, MeshProblem> {
        if finer.is_empty() {
            return Err(MeshProblem::Empty);
        }
        let triangles: Arc<[Triangle<f32>]> = finer.iter().map(rounded).collect();
        let is_same = triangles.iter().zip(&finer).all(|(near, of)| Triangle::from(*near) == *of);
        Ok(Self::of(name, triangles, (!is_same).then(|| finer.into()), notes))
    }

    fn of(
        name: String,
        triangles: Arc<[Triangle<f32>]>,
        finer: Option<Arc<[Triangle<f64>]>>,
        notes: Vec<Note>,
    ) -> Self {
        let bounds = Bounds::of(&triangles).expect("the callers refuse a mesh without triangles");
        let degenerate = triangles.iter().filter(|triangle| triangle.is_degenerate()).count();
        Self { name, triangles, finer, degenerate, bounds, notes }
    }

    /// The triangles in f64, as the file holds them: [`triangles`](Mesh::triangles) are these, rounded.
    pub fn triangles_f64(&self) -> Arc<[Triangle<f64>]> {
        let widened = || self.triangles.iter().copied().map(Triangle::from).collect();
        self.finer.clone().unwrap_or_else(widened)
    }

    /// How many of the triangles have no area in f64, as the file holds them; decided as
    /// [`degenerate`](Mesh::degenerate).
    pub fn degenerate_f64(&self) -> usize {
        let Some(finer) = &self.finer else { return self.degenerate };
        finer.iter().filter(|triangle| triangle.is_degenerate()).count()
    }

    /// By how much the corner that moves most moves when it is rounded to f32, relative to the diagonal
    /// of the box around the mesh; 0 where f32 holds every coordinate. Infinite where all corners round
    /// to one point.
    pub fn rounding(&self) -> f64 {
        let Some(finer) = &self.finer else { return 0.0 };
        let corners = |near: &Triangle<f32>, of: &Triangle<f64>| {
            let near = Triangle::<f64>::from(*near).corners();
            let moved = near.into_iter().zip(of.corners()).map(|(near, of)| {
                let by = near - of;
                by.dot(by).sqrt()
            });
            moved.fold(0.0, f64::max)
        };
        let most = self.triangles.iter().zip(&**finer).map(|(near, of)| corners(near, of));
        most.fold(0.0, f64::max) / f64::from(self.bounds.diagonal())
    }
}

fn parse(
    format: MeshFormat,
    bytes: &[u8],
    source: &mut Source<'_>,
) -> Result<Vec<Triangle<f64>>, MeshProblem> {
    match format {
        MeshFormat::Ply => ply::parse(bytes, source),
        MeshFormat::Obj => obj::parse(bytes, source),
        MeshFormat::Stl => stl::parse(bytes, source),
        MeshFormat::Gltf => gltf::parse(bytes, source),
    }
    .and_then(|raw: Raw| raw.triangles(source))
}

#[allow(clippy::cast_possible_truncation, reason = "the nearest is meant")]
fn rounded(triangle: &Triangle<f64>) -> Triangle<f32> {
    let [a, b, c] = triangle.corners().map(|corner| corner.to_array().map(|x| x as f32));
    Triangle::new(a, b, c)
}
