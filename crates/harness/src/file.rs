//! Files that are there whole or not at all.

use std::fs::Permissions;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes a file beside its place under another name, then renames it: whoever reads sees the old
/// file or the new one, never half of one.
///
/// # Errors
/// When the file cannot be written; nothing is left behind then.
pub fn replace(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut beside = tempfile::Builder::new();
    beside.prefix(".trisect-");
    if let Some(permissions) = readable_by_all() {
        beside.permissions(permissions);
    }
    let mut beside = beside.tempfile_in(folder.unwrap_or(Path::new(".")))?;
    let mut buffered = BufWriter::new(beside.as_file_mut());
    write(&mut buffered)?;
    buffered.flush()?;
    drop(buffered);
    beside.persist(path)?;
    Ok(())
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
    use std::io;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        super::replace(&path, |out| out.write_all(b"old")).expect("written");
        super::replace(&path, |out| {
            out.write_all(b"ne")?;
            Err(io::Error::other("no more"))
        })
        .expect_err("the writer failed");
        assert_eq!(std::fs::read(&path).expect("there"), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).expect("there").count(), 1);
    }
}
