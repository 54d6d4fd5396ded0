//! What is wrong with a scene file.

use std::ops::Range;

use trisect_mesh::{MeshError, MeshProblem, ReadProblem, cut, quoted};

/// What is wrong with a scene, and in which file.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct SceneError {
    /// The file as it was named: by the caller, or by the scene.
    pub file: String,
    /// What is wrong, where, and what mends it. Not a `source`: the message holds it already.
    pub problem: SceneProblem,
}

/// What is wrong with a scene. The text of each says where, and what mends it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneProblem {
    /// The file, or something in it, is not read.
    #[error("{0}")]
    Unread(#[from] ReadProblem),
    /// The ending of the file's name is not known.
    #[error("unknown file type; scenes are .toml, .gltf, .glb and .obj, meshes .ply and .stl too")]
    UnknownType,
    /// A part of it is missing, or not what it must be.
    #[error("{place}: {field}: {what}; {mend}")]
    Faulty {
        /// The line of a text file; the element of another.
        place: String,
        /// The field.
        field: String,
        /// What is wrong with it.
        what: String,
        /// What to do.
        mend: String,
    },
    /// The triangles cannot be used.
    #[error("{0}")]
    Mesh(MeshProblem),
}

/// A scene has no such camera.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no camera `{wanted}`; give a number from 1 to {}, or a name of {}", names.len(), names.join(", "))]
pub struct UnknownCamera {
    /// What was asked for.
    pub wanted: String,
    /// The names of those that there are.
    pub names: Vec<String>,
}

impl From<MeshError> for SceneError {
    fn from(MeshError { file, problem }: MeshError) -> Self {
        Self { file, problem: SceneProblem::Mesh(problem) }
    }
}

impl SceneProblem {
    pub(crate) fn faulty(
        place: impl Into<String>,
        field: impl Into<String>,
        what: impl Into<String>,
        mend: impl Into<String>,
    ) -> Self {
        Self::Faulty {
            place: place.into(),
            field: quoted(&field.into()),
            // It may quote the file, and the message of another file within it.
            what: cut(&what.into(), 300),
            mend: cut(&mend.into(), 200),
        }
    }

    pub(crate) fn of_file(self, file: impl Into<String>) -> SceneError {
        SceneError { file: file.into(), problem: self }
    }
}

/// The line that a part of a text begins in, as messages name it.
pub(crate) fn line_of(text: &str, span: &Range<usize>) -> String {
    let before = text.get(..span.start).unwrap_or(text);
    format!("line {}", before.matches('\n').count() + 1)
}
