//! The kinds of file that the program reads, and the commands that read them.

use std::io;
use std::path::{Path, PathBuf};

/// A kind of file that the program reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// Polygon file, of text or of either byte order.
    Ply,
    /// Wavefront mesh.
    Obj,
    /// Material library of a Wavefront mesh.
    Mtl,
    /// Stereolithography mesh, of text or binary.
    Stl,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 as one binary file.
    Glb,
    /// Scene file of the program.
    Toml,
    /// Rays as text.
    Csv,
    /// Rays as binary numbers.
    Rays,
    /// Records of measurements, a JSON object a line.
    Records,
    /// Picture, as a texture.
    Png,
    /// Picture, as a texture.
    Jpeg,
    /// Picture that the program writes and does not read: as a texture it is refused.
    Exr,
}

impl Format {
    /// All of them. A mutant's number says its format: the order is part of what a number means.
    pub const ALL: [Self; 13] = [
        Self::Ply,
        Self::Obj,
        Self::Mtl,
        Self::Stl,
        Self::Gltf,
        Self::Glb,
        Self::Toml,
        Self::Csv,
        Self::Rays,
        Self::Records,
        Self::Png,
        Self::Jpeg,
        Self::Exr,
    ];

    /// The name, which is that of its folder in the corpus as well.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Mtl => "mtl",
            Self::Stl => "stl",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
            Self::Toml => "toml",
            Self::Csv => "csv",
            Self::Rays => "rays",
            Self::Records => "records",
            Self::Png => "png",
            Self::Jpeg => "jpeg",
            Self::Exr => "exr",
        }
    }

    /// The ending of a file's name.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Records => "jsonl",
            Self::Jpeg => "jpg",
            other => other.name(),
        }
    }

    /// The format of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// The format of a file, by its ending in either case.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|format| format.ending().eq_ignore_ascii_case(ending))
    }

    /// Whether it holds a mesh, which two verbs read.
    pub fn is_mesh(self) -> bool {
        matches!(self, Self::Ply | Self::Obj | Self::Stl | Self::Gltf | Self::Glb)
    }

    /// The name of a mutant's file.
    pub fn file(self) -> String {
        format!("mutant.{}", self.ending())
    }

    /// The name of the file that is read: the mutant, or the scene in `corpus/company` that refers to it.
    pub fn main_file(self) -> String {
        match self {
            Self::Mtl => "uses.obj".to_owned(),
            Self::Png | Self::Jpeg | Self::Exr => format!("{}.toml", self.ending()),
            _ => self.file(),
        }
    }

    /// The command lines that read a file, each as words. Of a record's, which take longer, the number chooses
    /// two.
    pub(crate) fn commands(self, file: &str, number: u64) -> Vec<Vec<String>> {
        let render = "render --out picture.png --width 8 --height 8 --sampling grid:1 --threads 1";
        let heads = match self {
            Self::Ply | Self::Obj | Self::Stl | Self::Gltf | Self::Glb => {
                vec!["query --rays rays.csv --method exact --mesh", render]
            }
            Self::Mtl | Self::Toml | Self::Png | Self::Jpeg | Self::Exr => vec![render],
            Self::Csv | Self::Rays => vec!["query --mesh tetra.obj --method exact --rays"],
            Self::Records => {
                let read = match number / Self::ALL.len() as u64 % 4 {
                    0 => "rank",
                    1 => "rank --json",
                    2 => "cmp sound.jsonl",
                    _ => "cmp --json sound.jsonl",
                };
                vec![read, "report --json --output page"]
            }
        };
        let words = |head: &str| head.split(' ').chain([file]).map(String::from).collect();
        heads.into_iter().map(words).collect()
    }
}

/// The folder of what is mutated, and of the sound files beside it.
pub fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus")
}

/// The files of a folder, sorted by name, with their content.
///
/// # Errors
/// When the folder or a file cannot be read; the message names the folder.
pub fn files(folder: &Path) -> io::Result<Vec<(PathBuf, Vec<u8>)>> {
    let read = || -> io::Result<_> {
        let mut paths = std::fs::read_dir(folder)?
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<io::Result<Vec<_>>>()?;
        paths.sort();
        paths.into_iter().map(|path| std::fs::read(&path).map(|bytes| (path, bytes))).collect()
    };
    read().map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", folder.display())))
}
