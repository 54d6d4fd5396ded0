//! Triangle meshes from PLY, OBJ, STL and glTF files.
//!
//! Each reader hands over vertices and faces as the file writes them; one function, `build`,
//! decides what a mesh is. Vertices and faces are numbered from 0 in the order of the file.

mod gltf;
mod hall;
mod obj;
mod ply;
mod stl;

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use trisect_core::{Triangle, Vec3};

pub use self::gltf::{GltfFile, Matrix, PlacedNode};
pub use self::obj::{ObjCorner, ObjFile, ObjLine, ObjTriangle};

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

/// Triangles with a name. Never empty, and every coordinate is finite.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// The name it was given, or the file's name without its ending.
    pub name: String,
    /// The triangles, in the order of the file.
    pub triangles: Arc<[Triangle<f32>]>,
    /// How many triangles have no area at all: three points exactly on one line (or one point).
    ///
    /// Decided without rounding error: the points are collinear when the exact orientation
    /// predicate of Shewchuk 1997 vanishes for their projections to the xy, yz and zx planes.
    pub degenerate: usize,
    /// The smallest box that holds the triangles.
    pub bounds: Bounds,
}

/// The file formats that are known, by the ending of the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// `.ply`, ascii or binary of either byte order.
    Ply,
    /// `.obj`: its `v` and `f` lines; everything else is passed over.
    Obj,
    /// `.stl`, ascii or binary.
    Stl,
    /// `.gltf` and `.glb`: the triangles of all nodes of all scenes, transformed to the world.
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

/// What is wrong with a mesh file, and with which.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct MeshError {
    /// The file as it was named by the caller.
    pub file: String,
    /// What is wrong, where, and what mends it. Not a `source`: the message holds it already.
    pub problem: MeshProblem,
}

/// An element of a mesh file: its number counts from 0, its line (in text formats) from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The number of the vertex or face.
    pub number: usize,
    /// The line of the file, where the format has lines.
    pub line: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.number)?;
        self.line.map_or(Ok(()), |line| write!(f, " (line {line})"))
    }
}

/// What is wrong with a mesh file. The text of each says where, and what mends it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshProblem {
    /// The file could not be read.
    #[error("cannot be read ({0}); check the path")]
    Unreadable(#[from] std::io::Error),
    /// The ending of the file's name is not known.
    #[error("unknown file type; known are .ply, .obj, .stl, .gltf and .glb")]
    UnknownType,
    /// The file breaks the rules of its format.
    #[error("{place}: {what}; re-export the mesh")]
    Malformed {
        /// The line, header or element.
        place: String,
        /// What is wrong there.
        what: String,
    },
    /// The file ends before all that it promises.
    #[error("truncated: {what}; copy or export the file again")]
    Truncated {
        /// What is missing.
        what: String,
    },
    /// The file goes on after all that it promises.
    #[error("{what} after the last element; re-export the mesh")]
    Trailing {
        /// What stands there.
        what: String,
    },
    /// The file lacks something that every mesh needs.
    #[error("no {what}; re-export the mesh with it")]
    Missing {
        /// The element, property or buffer.
        what: String,
    },
    /// The file uses a part of its format that is not read.
    #[error("{what} not supported; {mend}")]
    Unsupported {
        /// The feature, with its verb.
        what: String,
        /// What to do instead.
        mend: &'static str,
    },
    /// A face is not a triangle.
    #[error("face {face} has {corners} corners; triangulate the mesh first")]
    NotATriangle {
        /// The face.
        face: Place,
        /// How many corners it has.
        corners: usize,
    },
    /// A face names a vertex that does not exist.
    #[error(
        "face {face}: index {index} is out of range, the mesh has {vertices} vertices; re-export \
         the mesh"
    )]
    IndexOutOfRange {
        /// The face.
        face: Place,
        /// The index as the file writes it.
        index: i64,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// A coordinate is NaN, or infinite in f32.
    #[error("vertex {vertex}: {axis} is {value}; every coordinate must be a finite f32")]
    NotFinite {
        /// The vertex.
        vertex: Place,
        /// Which coordinate.
        axis: char,
        /// Its value.
        value: f32,
    },
    /// The file has no face.
    #[error("the mesh has no triangles; export it with its faces")]
    Empty,
}

/// A problem at one line of a text file.
fn malformed_line(line: usize, what: impl Into<String>) -> MeshProblem {
    MeshProblem::Malformed { place: format!("line {line}"), what: what.into() }
}

/// Parses one decimal coordinate of a text file. NaN and infinity are left to `build`.
fn coordinate(word: Option<&str>, line: usize, axis: char) -> Result<f32, MeshProblem> {
    let word = word.ok_or_else(|| malformed_line(line, format!("{axis} is missing")))?;
    word.parse().map_err(|_| malformed_line(line, format!("{axis} is `{word}`, not a number")))
}

/// Parses the three coordinates at the head of `words`.
fn coordinates<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    line: usize,
) -> Result<[f32; 3], MeshProblem> {
    Ok([
        coordinate(words.next(), line, 'x')?,
        coordinate(words.next(), line, 'y')?,
        coordinate(words.next(), line, 'z')?,
    ])
}

/// A text file, or the line that is not text.
fn text(bytes: &[u8]) -> Result<&str, MeshProblem> {
    str::from_utf8(bytes)
        .map_err(|error| malformed_line(line_at(bytes, error.valid_up_to()), "not text (UTF-8)"))
}

/// The number of the line, from 1, that holds the byte at `offset`.
fn line_at(bytes: &[u8], offset: usize) -> usize {
    bytes[..offset].split(|&byte| byte == b'\n').count()
}

/// What a reader hands over: the file's vertices and faces, unchecked.
#[derive(Default)]
struct Raw {
    vertices: Vec<Vertex>,
    faces: Vec<Face>,
}

struct Vertex {
    at: [f32; 3],
    line: Option<usize>,
}

/// The first three corners of a face, and how many it has.
struct Face {
    corners: usize,
    /// Vertex numbers from 0; anything out of range where the file is wrong.
    indices: [i64; 3],
    /// The same as the file writes them.
    written: [i64; 3],
    line: Option<usize>,
}

impl Face {
    /// A face of a format that numbers its vertices from 0.
    fn from_indices(indices: &[i64], line: Option<usize>) -> Self {
        Self::from_pairs(indices.iter().map(|&index| (index, index)), line)
    }

    /// A face from pairs of a vertex number and its spelling in the file.
    fn from_pairs(pairs: impl IntoIterator<Item = (i64, i64)>, line: Option<usize>) -> Self {
        let mut face = Self { corners: 0, indices: [0; 3], written: [0; 3], line };
        for (index, written) in pairs {
            if face.corners < 3 {
                face.indices[face.corners] = index;
                face.written[face.corners] = written;
            }
            face.corners += 1;
        }
        face
    }
}

impl Mesh {
    /// Reads a mesh; the ending of the file's name says in which format.
    ///
    /// # Errors
    /// When the file cannot be read, or is not a mesh of triangles with finite coordinates. The
    /// message names the file, the place in it and what mends it.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let fail = |problem| MeshError { file: path.display().to_string(), problem };
        let format = MeshFormat::of(path).ok_or_else(|| fail(MeshProblem::UnknownType))?;
        let bytes = std::fs::read(path).map_err(|error| fail(error.into()))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        parse(format, &bytes, path.parent()).and_then(|raw| build(name, &raw)).map_err(fail)
    }

    /// Reads a mesh from memory. `name` becomes its name and stands for the file in messages.
    ///
    /// # Errors
    /// As [`load`](Mesh::load); and where a glTF file keeps its buffers in other files.
    pub fn from_bytes(name: &str, format: MeshFormat, bytes: &[u8]) -> Result<Self, MeshError> {
        parse(format, bytes, None)
            .and_then(|raw| build(name.to_owned(), &raw))
            .map_err(|problem| MeshError { file: name.to_owned(), problem })
    }

    /// The Stanford bunny that is compiled into the program: 69,451 triangles. Stanford Computer
    /// Graphics Laboratory; `data/README.md` has its licence.
    ///
    /// # Panics
    /// Never: a test loads it.
    pub fn bunny() -> Self {
        Self::from_bytes(
            "bunny",
            MeshFormat::Ply,
            include_bytes!("../../../../data/meshes/bunny.ply"),
        )
        .expect("the mesh compiled into the program is sound")
    }
}

fn parse(format: MeshFormat, bytes: &[u8], folder: Option<&Path>) -> Result<Raw, MeshProblem> {
    match format {
        MeshFormat::Ply => ply::parse(bytes),
        MeshFormat::Obj => obj::parse(bytes),
        MeshFormat::Stl => stl::parse(bytes),
        MeshFormat::Gltf => gltf::parse(bytes, folder),
    }
}

/// Refuses coordinates that are not finite.
fn all_finite(vertices: &[Vertex]) -> Result<(), MeshProblem> {
    for (number, vertex) in vertices.iter().enumerate() {
        if let Some(axis) = vertex.at.iter().position(|x| !x.is_finite()) {
            return Err(MeshProblem::NotFinite {
                vertex: Place { number, line: vertex.line },
                axis: ['x', 'y', 'z'][axis],
                value: vertex.at[axis],
            });
        }
    }
    Ok(())
}

/// The vertex of a face's corner, by its number from 0 and as it is written.
fn vertex_at(
    vertices: &[Vertex],
    index: i64,
    written: i64,
    face: Place,
) -> Result<[f32; 3], MeshProblem> {
    let vertex = usize::try_from(index).ok().and_then(|index| vertices.get(index));
    vertex.map(|vertex| vertex.at).ok_or(MeshProblem::IndexOutOfRange {
        face,
        index: written,
        vertices: vertices.len(),
    })
}

/// Checks what a reader handed over and makes the mesh.
fn build(name: String, raw: &Raw) -> Result<Mesh, MeshProblem> {
    all_finite(&raw.vertices)?;
    let mut triangles = Vec::with_capacity(raw.faces.len());
    for (number, face) in raw.faces.iter().enumerate() {
        let place = Place { number, line: face.line };
        if face.corners != 3 {
            return Err(MeshProblem::NotATriangle { face: place, corners: face.corners });
        }
        let corner = |i: usize| vertex_at(&raw.vertices, face.indices[i], face.written[i], place);
        triangles.push(Triangle::new(corner(0)?, corner(1)?, corner(2)?));
    }
    let bounds = Bounds::of(&triangles).ok_or(MeshProblem::Empty)?;
    let degenerate = triangles.iter().filter(|triangle| triangle.is_degenerate()).count();
    Ok(Mesh { name, triangles: triangles.into(), degenerate, bounds })
}
