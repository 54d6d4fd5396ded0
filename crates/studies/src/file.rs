//! Files that are there whole or not at all, one alone or several together.

use std::fs::{self, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

/// Writes a file beside its place under another name, then renames it: whoever reads sees the old
/// file or the new one, never half of one.
///
/// # Errors
/// When the file cannot be written; nothing is left behind then.
pub fn replace(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let mut files = Files::default();
    files.add(path, write)?;
    files.commit()
}

/// Why a file could not be written. All files are as they were before.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written ({}); nothing was changed", path.display(), self.said())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What the system said. Not a `source`: the message holds it already.
    pub problem: io::Error,
}

impl WriteError {
    /// What the system said, without the name of the temporary file that was tried.
    pub fn said(&self) -> String {
        let of_system = self.problem.raw_os_error().map(io::Error::from_raw_os_error);
        of_system.as_ref().unwrap_or(&self.problem).to_string()
    }
}

/// Files that take their places together or not at all.
///
/// Each is written in full beside its place, under another name. [`commit`](Files::commit) then renames
/// them one after the other, and where one cannot be renamed puts back those that were there before. So
/// a disk that is full, a folder that is read-only or a process that is ended while it writes leaves
/// everything as it was; a process that is killed between two renames may leave some files new and
/// some old. Files dropped without [`commit`](Files::commit) leave nothing.
#[derive(Default)]
pub struct Files {
    /// In the order in which they take their places. Dropped before the folders that hold them.
    staged: Vec<(NamedTempFile, PathBuf)>,
    folders: NewFolders,
}

impl Files {
    /// Writes one more file, beside its place. Folders on the way to it that do not exist are made.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        let staged = self.stage(path, write);
        let staged = staged.map_err(|problem| WriteError { path: path.to_path_buf(), problem })?;
        self.staged.push((staged, path.to_path_buf()));
        Ok(())
    }

    fn stage(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> io::Result<NamedTempFile> {
        let folder = folder_of(path);
        self.folders.make(folder)?;
        let mut file = temporary().tempfile_in(folder)?;
        let mut buffered = BufWriter::new(file.as_file_mut());
        write(&mut buffered)?;
        buffered.flush()?;
        drop(buffered);
        Ok(file)
    }

    /// Puts all files in their places, in the order in which they were added.
    ///
    /// # Errors
    /// When one cannot take its place; then none has.
    pub fn commit(self) -> Result<(), WriteError> {
        let Self { staged, mut folders } = self;
        let last = staged.len().saturating_sub(1);
        let mut placed = Placed(Vec::new());
        for (number, (file, path)) in staged.into_iter().enumerate() {
            // Nothing can fail after the last, so that the file before it is not needed any more.
            let before = if number == last { Ok(None) } else { kept(&path) };
            let done = before.and_then(|before| {
                file.persist(&path)?;
                Ok(before)
            });
            match done {
                Ok(before) => placed.0.push((path, before)),
                Err(problem) => return Err(WriteError { path, problem }),
            }
        }
        placed.0.clear();
        folders.0.clear();
        Ok(())
    }
}

/// Another name for a file that is there, or a copy where the file system has no links; none where no
/// file is.
fn kept(path: &Path) -> io::Result<Option<TempPath>> {
    if !path.is_file() {
        return Ok(None);
    }
    let link = |name: &Path| fs::hard_link(path, name).or_else(|_| fs::copy(path, name).map(drop));
    let kept = temporary().make_in(folder_of(path), link)?;
    Ok(Some(kept.into_temp_path()))
}

/// Files that took their places, each with the one that was there before; dropped, they give them back.
struct Placed(Vec<(PathBuf, Option<TempPath>)>);

impl Drop for Placed {
    fn drop(&mut self) {
        for (path, before) in self.0.drain(..).rev() {
            // What fails here cannot be helped any more.
            match before {
                Some(before) => drop(before.persist(path)),
                None => drop(fs::remove_file(path)),
            }
        }
    }
}

/// Folders that were made; dropped, they go again where nothing is in them.
#[derive(Default)]
struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    fn make(&mut self, folder: &Path) -> io::Result<()> {
        let missing = folder.ancestors().take_while(|folder| {
            // The last ancestor of a relative path is empty, and stands for the current folder.
            !folder.as_os_str().is_empty() && !folder.is_dir()
        });
        let mut missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        missing.reverse();
        self.0.append(&mut missing);
        fs::create_dir_all(folder)
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // One that was not made, or that holds something by now, stays.
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Whether files can be written into a folder, which need not exist. Leaves nothing behind.
///
/// # Errors
/// What the system says where they cannot.
pub fn check_folder(folder: &Path) -> Result<(), WriteError> {
    Files::default()
        .add(&folder.join("file"), |_| Ok(()))
        .map_err(|error| WriteError { path: folder.to_path_buf(), ..error })
}

/// The folder that a file lies in.
fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Names of temporary files, which are as readable as others.
fn temporary() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".trisect-");
    if let Some(permissions) = readable_by_all() {
        builder.permissions(permissions);
    }
    builder
}

/// Temporary files are private unless told otherwise; the user's mask still applies.
#[cfg(unix)]
#[allow(clippy::unnecessary_wraps, reason = "there is no such thing on other systems")]
fn readable_by_all() -> Option<Permissions> {
    use std::os::unix::fs::PermissionsExt as _;
    Some(Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn readable_by_all() -> Option<Permissions> {
    None
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Every file below a folder with its content; folders have none.
    fn content(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut all = BTreeMap::new();
        for entry in fs::read_dir(folder).expect("there") {
            let path = entry.expect("there").path();
            if path.is_dir() {
                all.extend(content(&path));
                all.insert(path, None);
            } else {
                let bytes = fs::read(&path).expect("there");
                all.insert(path, Some(bytes));
            }
        }
        all
    }

    fn text(files: &mut Files, path: &Path, text: &str) {
        files.add(path, |out| out.write_all(text.as_bytes())).expect("there is room");
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        replace(&path, |out| out.write_all(b"old")).expect("written");
        let error = replace(&path, |out| {
            out.write_all(b"ne")?;
            Err(io::Error::other("no more"))
        });
        let error = error.expect_err("the writer failed").to_string();
        assert!(
            error.ends_with("file: cannot be written (no more); nothing was changed"),
            "{error}"
        );
        assert_eq!(content(folder.path()), [(path, Some(b"old".to_vec()))].into());
    }

    #[test]
    fn files_take_their_places_together() {
        let folder = tempfile::tempdir().expect("a folder");
        let [new, old] = ["a/b/new", "old"].map(|name| folder.path().join(name));
        fs::write(&old, "before").expect("written");
        let mut files = Files::default();
        text(&mut files, &new, "1");
        text(&mut files, &old, "2");
        assert_eq!(fs::read(&old).expect("there"), b"before", "nothing moves before the commit");
        files.commit().expect("they can be renamed");
        assert_eq!(fs::read(&new).expect("there"), b"1");
        assert_eq!(fs::read(&old).expect("there"), b"2");
        assert_eq!(content(folder.path()).len(), 4, "two files and two folders");
    }

    /// A folder stands in the place of the last file, so that it cannot be renamed.
    #[test]
    fn what_took_its_place_already_is_put_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        fs::write(path("old"), "before").expect("written");
        fs::create_dir_all(path("taken/inside")).expect("made");
        let before = content(folder.path());
        let mut files = Files::default();
        for name in ["old", "new/file", "taken"] {
            text(&mut files, &path(name), "after");
        }
        let error = files.commit().expect_err("a folder is in the way");
        assert_eq!(error.path, path("taken"));
        assert_eq!(content(folder.path()), before);
    }

    #[test]
    fn what_is_not_committed_leaves_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut files = Files::default();
        text(&mut files, &folder.path().join("a/b/c"), "1");
        drop(files);
        check_folder(&folder.path().join("d/e")).expect("it could be made");
        assert_eq!(content(folder.path()), BTreeMap::new());
        fs::write(folder.path().join("file"), "").expect("written");
        let error = check_folder(&folder.path().join("file/folder")).expect_err("it is a file");
        assert_eq!(error.path, folder.path().join("file/folder"));
    }
}
