//! glTF 2.0, as JSON with its buffers embedded or beside it, or as one binary file.
//!
//! The library parses and validates the document; the accessors are read here, since its own
//! readers panic where a count is zero or a range overflows.

use std::collections::HashSet;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::{Source, View};
use gltf::json::Root;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Error, Gltf, Node, Primitive, Semantic};

use crate::error::MeshProblem;
use crate::faces::{Corner, Raw, Vertex};
use crate::mesh::Source as Input;
use crate::reading::Reading;

/// A document with the bytes that it refers to.
pub struct GltfFile {
    /// The document, validated.
    pub document: Document,
    buffers: Vec<Vec<u8>>,
}

/// A node, and the matrix from its space to the world's.
pub type PlacedNode<'a> = (Node<'a>, Matrix);

impl GltfFile {
    /// Reads a document; buffers in other files are looked for in `folder`.
    ///
    /// # Errors
    /// When the document breaks the format's rules, or a buffer is missing or too short.
    pub fn open(
        bytes: &[u8],
        folder: Option<&Path>,
        reading: &mut Reading,
    ) -> Result<Self, MeshProblem> {
        check_length(bytes)?;
        let Gltf { document, mut blob } =
            Gltf::from_slice_without_validation(bytes).map_err(|error| problem(&error))?;
        let root = document.into_json();
        check_accessors(&root)?;
        let document = Document::from_json(root).map_err(|error| problem(&error))?;
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let name = format!("buffer {}", buffer.index());
            let data = read_buffer(&buffer.source(), folder, reading, &mut blob, &name)?;
            if data.len() < buffer.length() {
                return Err(MeshProblem::Truncated {
                    what: format!("{name} needs {} bytes, it has {}", buffer.length(), data.len()),
                });
            }
            buffers.push(data);
        }
        Ok(Self { document, buffers })
    }

    /// The nodes of all scenes, each once, parents before their children.
    pub fn nodes(&self) -> Vec<PlacedNode<'_>> {
        // A node has one place in a sound file; a second visit would be a cycle. The stack is ours
        // because a file may nest deeper than the program's.
        let mut seen = HashSet::new();
        let mut open: Vec<PlacedNode<'_>> = Vec::new();
        let mut placed = Vec::new();
        for scene in self.document.scenes() {
            open.extend(scene.nodes().map(|node| (node, IDENTITY)));
            open.reverse();
            while let Some((node, parent)) = open.pop() {
                if !seen.insert(node.index()) {
                    continue;
                }
                let world = multiply(&parent, &node.transform().matrix().map(|c| c.map(f64::from)));
                let children = open.len();
                open.extend(node.children().map(|child| (child, world)));
                open[children..].reverse();
                placed.push((node, world));
            }
        }
        placed
    }

    /// The items of an accessor of so many floats each; `place` stands for the element in messages.
    ///
    /// # Errors
    /// When the accessor is of another kind, or reaches beyond its data.
    pub fn floats<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        place: &str,
    ) -> Result<Vec<[f32; N]>, MeshProblem> {
        if (accessor.dimensions().multiplicity(), accessor.data_type()) != (N, DataType::F32) {
            return Err(MeshProblem::Unsupported {
                what: format!("{place}: accessor {} of other than {N} floats is", accessor.index()),
                mend: "export it without quantisation",
            });
        }
        let float = |item: &[u8], i: usize| {
            f32::from_le_bytes([item[4 * i], item[4 * i + 1], item[4 * i + 2], item[4 * i + 3]])
        };
        let items = items(accessor, &self.buffers, 4 * N, place)?;
        Ok(items.map(|item| std::array::from_fn(|i| float(item, i))).collect())
    }

    /// The corners of a primitive's triangles, as numbers of its vertices: in order where the file has no
    /// indices.
    ///
    /// # Errors
    /// When it is not of triangles, an index is out of range, or the accessor reaches beyond its data.
    pub fn corners(
        &self,
        primitive: &Primitive<'_>,
        vertices: usize,
        place: &str,
    ) -> Result<Vec<[usize; 3]>, MeshProblem> {
        let indices = indices(primitive, &self.buffers, vertices, place)?;
        if let Some(index) = indices.iter().find(|index| **index >= vertices) {
            return Err(MeshProblem::Malformed {
                place: place.to_owned(),
                what: format!("index {index} is out of range, it has {vertices} vertices"),
            });
        }
        Ok(indices.chunks_exact(3).map(|three| [three[0], three[1], three[2]]).collect())
    }

    /// The bytes of a buffer view; none where it reaches beyond its buffer.
    pub fn view(&self, view: &View<'_>) -> Option<&[u8]> {
        let data = self.buffers.get(view.buffer().index())?;
        data.get(view.offset()..view.offset().checked_add(view.length())?)
    }
}

pub(crate) fn parse(bytes: &[u8], input: &mut Input<'_>) -> Result<Raw, MeshProblem> {
    let file = GltfFile::open(bytes, input.folder, input.reading)?;
    let mut raw = Raw::default();
    for (node, world) in file.nodes() {
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let place = format!("mesh {} primitive {}", mesh.index(), primitive.index());
                read_primitive(&mut raw, &primitive, &file, &world, &place)?;
            }
        }
    }
    Ok(raw)
}

/// The binary container must be as long as it says: the library subtracts without asking.
fn check_length(bytes: &[u8]) -> Result<(), MeshProblem> {
    if !bytes.starts_with(b"glTF") {
        return Ok(());
    }
    let actual = bytes.len();
    let promised = match bytes.get(8..12) {
        Some(length) => u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize,
        None => 12,
    };
    if promised > actual {
        Err(MeshProblem::Truncated {
            what: format!("the header promises {promised} bytes, the file has {actual}"),
        })
    } else if promised < actual {
        Err(MeshProblem::Trailing {
            what: format!("the header promises {promised} bytes, the file has {actual}: bytes"),
        })
    } else if promised < 12 {
        Err(MeshProblem::Malformed {
            place: "header".to_owned(),
            what: format!("the length is {promised} bytes"),
        })
    } else {
        Ok(())
    }
}

/// The library's validation follows the accessors of a primitive before it looks whether they
/// exist.
fn check_accessors(root: &Root) -> Result<(), MeshProblem> {
    let count = root.accessors.len();
    for (mesh, primitives) in root.meshes.iter().map(|mesh| &mesh.primitives).enumerate() {
        for (number, primitive) in primitives.iter().enumerate() {
            let accessor = primitive.attributes.values().find(|index| index.value() >= count);
            if let Some(accessor) = accessor {
                return Err(MeshProblem::Malformed {
                    place: format!("mesh {mesh} primitive {number}"),
                    what: format!(
                        "accessor {} is out of range, the document has {count}",
                        accessor.value()
                    ),
                });
            }
        }
    }
    Ok(())
}

/// The bytes of a buffer: the rest of a binary file, text in the document, or another file.
fn read_buffer(
    source: &Source<'_>,
    folder: Option<&Path>,
    reading: &mut Reading,
    blob: &mut Option<Vec<u8>>,
    name: &str,
) -> Result<Vec<u8>, MeshProblem> {
    let missing = |why: &str| MeshProblem::Missing { what: format!("data for {name}{why}") };
    let malformed = |what: String| MeshProblem::Malformed { place: name.to_owned(), what };
    let uri = match source {
        Source::Bin => return blob.take().ok_or_else(|| missing("")),
        Source::Uri(uri) => uri,
    };
    if let Some(embedded) = uri.strip_prefix("data:") {
        let text = embedded.split_once(";base64,").map(|(_, text)| text);
        let text = text.ok_or_else(|| malformed("its data is not in base64".to_owned()))?;
        return BASE64.decode(text).map_err(|error| malformed(error.to_string()));
    }
    let path = percent_encoding::percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| malformed("its path is no text".to_owned()))?;
    let folder = folder.ok_or_else(|| MeshProblem::Unsupported {
        what: format!("{name}: a buffer in another file is, for a mesh in memory,"),
        mend: "embed the buffers (.glb)",
    })?;
    reading.file(&folder.join(path.as_ref())).map_err(|error| missing(&format!(" ({error})")))
}

fn problem(error: &Error) -> MeshProblem {
    let what = error.to_string();
    match error {
        Error::Deserialize(error) if error.is_eof() => MeshProblem::Truncated { what },
        _ => MeshProblem::Malformed { place: "document".to_owned(), what },
    }
}

fn read_primitive(
    raw: &mut Raw,
    primitive: &Primitive<'_>,
    file: &GltfFile,
    world: &Matrix,
    place: &str,
) -> Result<(), MeshProblem> {
    let positions = primitive
        .get(&Semantic::Positions)
        .ok_or_else(|| MeshProblem::Missing { what: format!("POSITION in {place}") })?;
    let first = raw.vertices.len();
    let positions = file.floats::<3>(&positions, place)?;
    let placed = positions.iter().map(|at| transform(world, at.map(f64::from)));
    raw.vertices.extend(placed.map(|at| Vertex { at, line: None }));
    let count = raw.vertices.len() - first;
    let indices = indices(primitive, &file.buffers, count, place)?;
    // A mirror turns front to back; the corners' order turns it again.
    let order = if determinant(world) < 0.0 { [0, 2, 1] } else { [0, 1, 2] };
    for corners in indices.chunks_exact(3) {
        let corners = order.map(|corner| {
            let index = corners[corner];
            // Indices count within the primitive: beyond its own vertices lie another's.
            let resolved = if index < count { first + index } else { usize::MAX };
            Corner {
                vertex: i64::try_from(resolved).unwrap_or(-1),
                written: i64::try_from(index).unwrap_or(i64::MAX),
            }
        });
        if let Some(Corner { written: index, .. }) = corners.iter().find(|corner| corner.vertex < 0)
        {
            return Err(MeshProblem::Malformed {
                place: format!("face {}", raw.faces.len()),
                what: format!("index {index} is out of range, {place} has {count} vertices"),
            });
        }
        raw.push_corners(corners, None);
    }
    Ok(())
}

/// The corners of a primitive's triangles, one after another, unchecked.
fn indices(
    primitive: &Primitive<'_>,
    buffers: &[Vec<u8>],
    count: usize,
    place: &str,
) -> Result<Vec<usize>, MeshProblem> {
    if primitive.mode() != Mode::Triangles {
        return Err(MeshProblem::Unsupported {
            what: format!("{place}: mode {:?} is", primitive.mode()),
            mend: "export it as triangles",
        });
    }
    let indices: Vec<usize> = match primitive.indices() {
        None => (0..count).collect(),
        Some(accessor) => {
            let size = match (accessor.dimensions(), accessor.data_type()) {
                (Dimensions::Scalar, DataType::U8) => 1,
                (Dimensions::Scalar, DataType::U16) => 2,
                (Dimensions::Scalar, DataType::U32) => 4,
                (dimensions, data_type) => {
                    return Err(MeshProblem::Malformed {
                        place: place.to_owned(),
                        what: format!("indices are {dimensions:?} of {data_type:?}"),
                    });
                }
            };
            items(&accessor, buffers, size, place)?
                .map(|item| item.iter().rev().fold(0, |high, &byte| high << 8 | usize::from(byte)))
                .collect()
        }
    };
    if !indices.len().is_multiple_of(3) {
        return Err(MeshProblem::Malformed {
            place: place.to_owned(),
            what: format!("{} corners are not a multiple of three", indices.len()),
        });
    }
    Ok(indices)
}

/// The items of an accessor, each of `size` bytes.
fn items<'a>(
    accessor: &Accessor<'_>,
    buffers: &'a [Vec<u8>],
    size: usize,
    place: &str,
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, MeshProblem> {
    if accessor.sparse().is_some() {
        return Err(MeshProblem::Unsupported {
            what: format!("{place}: a sparse accessor is"),
            mend: "export it dense",
        });
    }
    let view = accessor.view().ok_or_else(|| MeshProblem::Missing {
        what: format!("buffer view for accessor {} of {place}", accessor.index()),
    })?;
    let stride = view.stride().unwrap_or(size);
    let count = accessor.count();
    let range = || {
        let data: &'a [u8] = buffers.get(view.buffer().index())?;
        let data = data.get(view.offset()..view.offset().checked_add(view.length())?)?;
        let data = data.get(accessor.offset()..)?;
        let needed = match count {
            0 => 0,
            _ => stride.checked_mul(count - 1)?.checked_add(size)?,
        };
        (stride >= size && needed <= data.len()).then_some(data)
    };
    let data = range().ok_or_else(|| MeshProblem::Malformed {
        place: place.to_owned(),
        what: format!("accessor {} reaches beyond its buffer view", accessor.index()),
    })?;
    Ok((0..count).map(move |i| &data[i * stride..i * stride + size]))
}

/// Columns of a 4×4 matrix; f64, so that a vertex is rounded once.
pub type Matrix = [[f64; 4]; 4];

const IDENTITY: Matrix =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    b.map(|column| {
        [0, 1, 2, 3].map(|row| {
            a[0][row] * column[0]
                + a[1][row] * column[1]
                + a[2][row] * column[2]
                + a[3][row] * column[3]
        })
    })
}

fn transform(m: &Matrix, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| m[0][row] * x + m[1][row] * y + m[2][row] * z + m[3][row])
}

fn determinant(m: &Matrix) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[2][1] * m[1][2])
        - m[1][0] * (m[0][1] * m[2][2] - m[2][1] * m[0][2])
        + m[2][0] * (m[0][1] * m[1][2] - m[1][1] * m[0][2])
}
