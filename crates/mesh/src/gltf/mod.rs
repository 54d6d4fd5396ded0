//! glTF 2.0, as JSON with its buffers embedded or beside it, or as one binary file (GLB).
//!
//! Everything is read from the document's own terms ([`document`]): the library at hand keeps nodes in
//! f32, refuses what the specification allows, and panics on what a hostile document holds.

mod accessor;
mod container;
mod document;
mod nodes;
mod parts;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::error::MeshProblem;
use crate::faces::{Corner, Raw, Vertex};
use crate::quote::{cut, quoted};
use crate::reading::Source as Input;
use crate::reading::{ReadProblem, Reading};

pub use document::{
    Camera as GltfCamera, Document as GltfDocument, Light as GltfLight, Material as GltfMaterial,
    Texture as GltfTexture,
};
pub use nodes::Matrix;
use nodes::{determinant, transform};
pub use parts::{Part, PlacedMesh};

/// The extensions that are read.
const EXTENSIONS: [&str; 6] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// A document with the bytes that it refers to.
pub struct GltfFile {
    /// What the JSON says, unchecked: numbers in it may be out of range.
    pub document: GltfDocument,
    /// Stands for the file in notes.
    file: String,
    folder: Option<PathBuf>,
    buffers: Vec<Buffer>,
    /// Each node's matrix to the world.
    worlds: Vec<Matrix>,
    /// The nodes of the scene that is shown, each once, parents before their children.
    shown: Vec<usize>,
    /// Bytes of the file and its buffers: what has no data of its own is not larger.
    size: usize,
}

/// The bytes of a buffer, or why there are none: what nothing refers to may be missing.
enum Buffer {
    Sound(Vec<u8>),
    Missing(String),
    Short(String),
}

fn malformed(place: impl Into<String>, what: impl Into<String>) -> MeshProblem {
    // It may quote the document.
    MeshProblem::Malformed { place: place.into(), what: cut(&what.into(), 200) }
}

/// The element of a list, or the message that there is none.
fn element<'a, T>(
    list: &'a [T],
    number: usize,
    kind: &str,
    place: &str,
) -> Result<&'a T, MeshProblem> {
    list.get(number).ok_or_else(|| {
        let count = list.len();
        malformed(place, format!("{kind} {number} is out of range, the document has {count}"))
    })
}

impl GltfFile {
    /// Reads a document, and the buffers that it names from `folder`. `file` stands for it in notes.
    ///
    /// # Errors
    /// When it is no glTF 2.0, needs an extension that is not read, or its nodes form no trees.
    pub fn open(
        file: &str,
        bytes: &[u8],
        folder: Option<&Path>,
        reading: &mut Reading,
    ) -> Result<Self, MeshProblem> {
        let (json, mut blob) = container::split(bytes, reading)?;
        let document = container::parse(json, reading)?;
        check_extensions(file, &document, reading)?;
        let mut this = Self {
            document,
            file: file.to_owned(),
            folder: folder.map(Path::to_owned),
            buffers: Vec::new(),
            worlds: Vec::new(),
            shown: Vec::new(),
            size: bytes.len(),
        };
        for number in 0..this.document.buffers.len() {
            let buffer = this.read_buffer(number, &mut blob, reading)?;
            if let Buffer::Sound(bytes) = &buffer {
                this.size += bytes.len();
            }
            this.buffers.push(buffer);
        }
        (this.worlds, this.shown) = nodes::place(file, &this.document, reading)?;
        Ok(this)
    }

    /// The nodes of the scene that is shown, each once, parents before their children, with their
    /// matrices to the world.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, &Matrix)> {
        self.shown.iter().map(|&node| (node, &self.worlds[node]))
    }

    fn read_buffer(
        &self,
        number: usize,
        blob: &mut Option<Vec<u8>>,
        reading: &mut Reading,
    ) -> Result<Buffer, MeshProblem> {
        let buffer = &self.document.buffers[number];
        let name = format!("buffer {number}");
        let bytes = match &buffer.uri {
            None => match blob.take_if(|_| number == 0) {
                Some(blob) => blob,
                None => return Ok(Buffer::Missing(format!("data for {name}"))),
            },
            Some(uri) => match self.resource(uri, &name, reading) {
                Ok(bytes) => bytes,
                Err(MeshProblem::Unread(
                    problem @ (ReadProblem::Unreadable(_) | ReadProblem::NotAFile),
                )) => return Ok(Buffer::Missing(format!("data for {name} ({problem})"))),
                Err(problem) => return Err(problem),
            },
        };
        let (promised, actual) = (buffer.byte_length, bytes.len());
        Ok(if actual < promised {
            Buffer::Short(format!("{name} needs {promised} bytes, it has {actual}"))
        } else {
            Buffer::Sound(bytes)
        })
    }

    /// The bytes that a URI stands for: those in its text, or those of a file.
    fn resource(
        &self,
        uri: &str,
        place: &str,
        reading: &mut Reading,
    ) -> Result<Vec<u8>, MeshProblem> {
        if uri.get(..5).is_some_and(|head| head.eq_ignore_ascii_case("data:")) {
            reading.claim(uri.len() as u64)?;
            return container::decode_data(&uri[5..]).map_err(|what| malformed(place, what));
        }
        let path = percent_encoding::percent_decode_str(uri)
            .decode_utf8()
            .map_err(|_| malformed(place, "its path is no text"))?;
        let folder = self.folder.as_ref().ok_or_else(|| MeshProblem::Unsupported {
            what: format!("{place}: a buffer in another file is, for a mesh in memory,"),
            mend: "embed the buffers (.glb)",
        })?;
        let (named, slashed) = (folder.join(&*path), path.replace('\\', "/"));
        if slashed != *path && !named.exists() {
            reading.tolerate(place, "a URI with `\\`")?;
            return Ok(reading.file(&folder.join(slashed))?);
        }
        Ok(reading.file(&named)?)
    }

    /// The bytes of an image: a whole picture file.
    ///
    /// # Errors
    /// When there is no such image, or its bytes cannot be read.
    pub fn image(
        &self,
        number: usize,
        reading: &mut Reading,
    ) -> Result<Cow<'_, [u8]>, MeshProblem> {
        let place = format!("image {number}");
        let image = element(&self.document.images, number, "image", &place)?;
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => self.resource(uri, &place, reading).map(Cow::Owned),
            (None, Some(view)) => Ok(Cow::Borrowed(self.view(view, &place)?.0)),
            (None, None) => Err(malformed(place, "it has neither uri nor bufferView")),
        }
    }
}

/// Refuses a document that needs what is not read, and says what is lost of one that only uses it.
fn check_extensions(
    file: &str,
    document: &GltfDocument,
    reading: &mut Reading,
) -> Result<(), MeshProblem> {
    let is_unknown = |name: &&String| !EXTENSIONS.contains(&name.as_str());
    let required = &document.extensions_required;
    if let Some(name) = required.iter().find(is_unknown) {
        let compressed =
            ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];
        return Err(MeshProblem::Unsupported {
            what: format!("{}, which the document requires, is", quoted(name)),
            mend: match name.as_str() {
                name if compressed.contains(&name) => "export it without compression",
                "KHR_texture_basisu" => "export it with textures in PNG or JPEG",
                _ => "export it without this extension",
            },
        });
    }
    for name in document.extensions_used.iter().filter(is_unknown) {
        reading.remark(
            file,
            &quoted(name),
            "an extension that is not read: what it adds is left out",
        );
    }
    if !document.animations.is_empty() {
        reading.remark(file, "animation 0", "animations are not played");
    }
    Ok(())
}

/// The triangles of the scene that is shown, carried to the world.
pub(crate) fn parse(bytes: &[u8], input: &mut Input<'_>) -> Result<Raw, MeshProblem> {
    let Input { file, folder, reading } = input;
    let file = GltfFile::open(file, bytes, *folder, reading)?;
    let mut raw = Raw::default();
    let mut known: Vec<Option<Vec<Part>>> = Vec::new();
    known.resize_with(file.document.meshes.len(), || None);
    for placed in file.placed_meshes()? {
        let own;
        let parts = match known.get_mut(placed.mesh).filter(|_| placed.is_shared()) {
            Some(Some(parts)) => &*parts,
            Some(empty) => empty.insert(file.parts(&placed, reading)?),
            None => {
                own = file.parts(&placed, reading)?;
                &own
            }
        };
        file.check_range(&placed, parts)?;
        // A mirror turns front to back; the corners' order turns it again.
        let order = if determinant(&placed.world) < 0.0 { [0, 2, 1] } else { [0, 1, 2] };
        for part in parts {
            let needed = part.positions.len() * size_of::<Vertex>()
                + part.corners.len() * 3 * size_of::<Corner>();
            reading.claim(needed as u64)?;
            let first = raw.vertices.len();
            let at = part.positions.iter().map(|&at| transform(&placed.world, at));
            raw.vertices.extend(at.map(|at| Vertex { at, line: None }));
            for corners in &part.corners {
                let corners = order.map(|corner| corners[corner]);
                let corner = |index: usize| Corner {
                    vertex: i64::try_from(first + index).unwrap_or(-1),
                    written: i64::try_from(index).unwrap_or(-1),
                };
                raw.push_corners(corners.map(corner), None);
            }
        }
    }
    Ok(raw)
}
