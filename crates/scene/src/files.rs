//! Files that a scene is read from, and those that it names.

use std::path::{Path, PathBuf};

use trisect_mesh::{ReadProblem, Reading};

use crate::error::{SceneError, SceneProblem};

/// The text of a file.
pub(crate) fn read_text(path: &Path, reading: &mut Reading) -> Result<String, SceneError> {
    let fail =
        |problem: ReadProblem| SceneProblem::from(problem).of_file(path.display().to_string());
    reading.text(path).map_err(fail)
}

/// A file that another names: beside it, and with the separators of Windows where it is not there so.
pub(crate) fn beside(folder: Option<&Path>, name: &str) -> PathBuf {
    let folder = folder.unwrap_or(Path::new(""));
    let path = folder.join(name);
    if name.contains('\\') && !path.exists() { folder.join(name.replace('\\', "/")) } else { path }
}

/// Whether a file is not there, or is none; all else about it is an error.
pub(crate) fn is_missing(problem: &ReadProblem) -> bool {
    matches!(problem, ReadProblem::Unreadable(_) | ReadProblem::NotAFile)
}
