//! What studies are asked for alike: methods, meshes, and how files are read.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use clap::Args;
use trisect_catalog::{Entry, entries, find};
use trisect_mesh::{Mesh, MeshError, ReadOptions};

use crate::study::StudyError;

/// Methods, meshes and seed.
#[derive(Debug, Args)]
pub struct Subjects {
    /// Methods, separated by commas; all if left out
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Mesh (PLY, OBJ, STL or glTF), any number of times; the Stanford bunny if left out
    #[arg(long, value_name = "FILE")]
    pub mesh: Vec<PathBuf>,
    /// Seed of every random choice
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "a comment here would become the command's")]
    pub reading: Reading,
}

const READING: &str = "Reading files";

/// How files are read.
#[derive(Debug, Args)]
pub struct Reading {
    /// Refuse what the standard of a file's format does not allow; otherwise what is unambiguous is
    /// read, and what is lost is said once
    #[arg(long, help_heading = READING)]
    pub strict: bool,
    /// Refuse files that a file names outside its own folder
    #[arg(long, help_heading = READING)]
    pub sandbox: bool,
    /// The most memory that a file may take, with what it names and what is decoded from both: bytes,
    /// or with K, M or G, 1024 at a time
    #[arg(long, help_heading = READING, value_name = "SIZE", default_value = "8G", value_parser = size)]
    pub max_memory: u64,
}

impl From<&Reading> for ReadOptions {
    fn from(&Reading { strict, sandbox, max_memory }: &Reading) -> Self {
        Self { strict, sandbox, max_memory }
    }
}

/// The method of that name.
///
/// # Errors
/// When there is none.
pub fn method(name: &str) -> Result<&'static Entry, StudyError> {
    find(name).ok_or_else(|| StudyError::UnknownMethod(name.to_owned()))
}

/// The methods named, or all.
///
/// # Errors
/// When there is no such method, or one is named twice.
pub fn methods(names: &[String]) -> Result<Vec<&'static Entry>, StudyError> {
    if names.is_empty() {
        return Ok(entries().iter().collect());
    }
    let mut methods: Vec<&'static Entry> = Vec::new();
    for name in names {
        let entry = method(name)?;
        if methods.iter().any(|other| other.info.name == entry.info.name) {
            return Err(StudyError::MethodTwice(name.clone()));
        }
        methods.push(entry);
    }
    Ok(methods)
}

impl Subjects {
    /// The meshes named, or those that stand in. `say` takes what their readers passed over, and by how
    /// much f32 moves their corners, with what mends that.
    ///
    /// # Errors
    /// When a mesh cannot be read, or two have one name.
    pub fn meshes(
        &self,
        others: impl FnOnce() -> Vec<Mesh>,
        mend: &str,
        say: &dyn Fn(&dyn Display),
    ) -> Result<Vec<Mesh>, StudyError> {
        if self.mesh.is_empty() {
            return Ok(others());
        }
        let mut meshes: Vec<Mesh> = Vec::new();
        for path in &self.mesh {
            let mesh = load_mesh(path, &self.reading, say)?;
            if meshes.iter().any(|other| other.name == mesh.name) {
                return Err(StudyError::MeshTwice { path: path.clone(), name: mesh.name.clone() });
            }
            meshes.push(mesh);
        }
        for (path, mesh) in self.mesh.iter().zip(&meshes) {
            say_rounding(path, mesh.rounding(), mend, say);
        }
        Ok(meshes)
    }
}

/// What to do about rounding where everything is in f32.
pub const MOVE: &str = "f32 is finest at the origin: move it there before it is written";

/// Reads a mesh for f32. `say` takes what its reader passed over, and how many triangles are degenerate.
///
/// # Errors
/// When it cannot be read.
pub fn load_mesh(
    path: &Path,
    reading: &Reading,
    say: &dyn Fn(&dyn Display),
) -> Result<Mesh, MeshError> {
    let mesh = read_mesh(path, reading, say)?;
    say_degenerate(path, mesh.degenerate, &mesh, say);
    Ok(mesh)
}

/// Reads a mesh. `say` takes what its reader passed over.
///
/// # Errors
/// When it cannot be read.
pub fn read_mesh(
    path: &Path,
    reading: &Reading,
    say: &dyn Fn(&dyn Display),
) -> Result<Mesh, MeshError> {
    let mesh = Mesh::load_with(path, &reading.into())?;
    mesh.notes.iter().for_each(|note| say(note));
    Ok(mesh)
}

/// Says how many triangles of a mesh are degenerate in the precision that is asked for.
pub fn say_degenerate(path: &Path, degenerate: usize, mesh: &Mesh, say: &dyn Fn(&dyn Display)) {
    if degenerate > 0 {
        let (path, all) = (path.display(), mesh.triangles.len());
        say(&format_args!("{path}: {degenerate} of {all} triangles are degenerate and never hit"));
    }
}

/// Says by how much rounding to f32 moves a mesh or a scene, relative to its size, where a corner moves at
/// all. `mend` says what to do.
pub fn say_rounding(path: &Path, rounding: f64, mend: &str, say: &dyn Fn(&dyn Display)) {
    if rounding > 0.0 {
        say(&format_args!(
            "{}: rounded to f32 its corners move by up to {rounding:.1e} of its size; {mend}",
            path.display()
        ));
    }
}

/// A count, in digits or as `1e9`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and in range")]
pub(crate) fn count(text: &str) -> Result<u64, String> {
    let asked: f64 = text.parse().map_err(|_| "not a number; give a count, as 1e9".to_owned())?;
    if asked.fract() == 0.0 && (0.0..=1e15).contains(&asked) {
        Ok(asked as u64)
    } else {
        Err("not a whole number from 0 to 1e15".to_owned())
    }
}

/// A size in memory, in bytes or with a unit.
fn size(text: &str) -> Result<u64, String> {
    let units = [('K', 10), ('M', 20), ('G', 30)];
    let unit = units.into_iter().find_map(|(unit, shift)| {
        let digits = text.strip_suffix([unit, unit.to_ascii_lowercase()])?;
        Some((digits, shift))
    });
    let (digits, shift) = unit.unwrap_or((text, 0));
    let count: Option<u64> = digits.parse().ok();
    count
        .and_then(|count| count.checked_mul(1 << shift))
        .ok_or_else(|| "not a size; give bytes, or as 512M or 2G".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        assert_eq!(size("4096"), Ok(4096));
        assert_eq!((size("3K"), size("3m"), size("1G")), (Ok(3 << 10), Ok(3 << 20), Ok(1 << 30)));
        assert_eq!(size("8G"), Ok(ReadOptions::MAX_MEMORY), "the default");
        for wrong in ["", "G", "1.5G", "-1", "1T", "99999999999G"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
