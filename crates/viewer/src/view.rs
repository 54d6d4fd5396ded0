//! What a window shows.

use std::fmt;
use std::str::FromStr;

/// Samples of a pixel after which a picture is done, and paths.
pub(crate) const SAMPLES: u32 = 64;
pub(crate) const PATHS: u32 = 4096;

/// What is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// The picture after Whitted.
    Picture,
    /// The picture by traced paths.
    Paths,
    /// How many triangles the camera's rays are tested against.
    Triangles,
    /// How many nodes they visit.
    Nodes,
    /// How far off the method's `t` is from the exact one, and where it decides wrongly.
    Error,
}

impl View {
    /// All of them, in the order of their keys.
    pub const ALL: [Self; 5] =
        [Self::Picture, Self::Paths, Self::Triangles, Self::Nodes, Self::Error];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Paths => "paths",
            Self::Triangles => "triangles",
            Self::Nodes => "nodes",
            Self::Error => "error",
        }
    }

    /// How many passes there are at full size.
    pub(crate) const fn passes(self) -> u32 {
        match self {
            Self::Picture => SAMPLES,
            Self::Paths => PATHS,
            Self::Triangles | Self::Nodes | Self::Error => 1,
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is no such view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownView;

impl fmt::Display for UnknownView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no such view; there are {}", View::ALL.map(View::name).join(", "))
    }
}

impl std::error::Error for UnknownView {}

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(name: &str) -> Result<Self, UnknownView> {
        Self::ALL.into_iter().find(|view| view.name() == name).ok_or(UnknownView)
    }
}
