//! How a tree is built.

use std::fmt;
use std::str::FromStr;

/// How a tree is built: the more time it takes, the faster it is traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Builder {
    /// Triangles in the order of a space-filling curve, split where the curve turns. The quickest to
    /// build: for scenes that move, or that few rays are traced through.
    Linear,
    /// The surface area heuristic, over bins: no triangle is in two leaves.
    Binned,
    /// The same, and large triangles are divided between leaves where that makes boxes smaller, up to
    /// half as many references again. The fastest to trace, most of all indoors.
    #[default]
    Spatial,
}

impl Builder {
    /// The builders, the quickest first.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Binned, Self::Spatial];

    /// The name that it is asked for by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Binned => "binned",
            Self::Spatial => "spatial",
        }
    }
}

impl fmt::Display for Builder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// When triangles that are together in the tree become a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leaves {
    /// Where that is cheaper than a node over them, up to sixteen: the fastest to trace. Eight always do,
    /// as they are tested at once.
    #[default]
    Cheapest,
    /// Sixteen always do: a smaller tree, in which more triangles are tested.
    Sixteen,
    /// Thirty-two always do.
    ThirtyTwo,
}

impl Leaves {
    /// All, those with the fewest triangles first.
    pub const ALL: [Self; 3] = [Self::Cheapest, Self::Sixteen, Self::ThirtyTwo];

    /// The name that records use.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cheapest => "cheapest",
            Self::Sixteen => "16",
            Self::ThirtyTwo => "32",
        }
    }

    /// Blocks of eight triangles of one kind, at most; triangles of several kinds may take two more.
    pub(crate) const fn blocks(self) -> usize {
        match self {
            Self::Cheapest | Self::Sixteen => 2,
            Self::ThirtyTwo => 4,
        }
    }

    /// Whether so many blocks become a leaf, given whether a node over them is cheaper.
    pub(crate) const fn take(self, blocks: usize, node_is_cheaper: bool) -> bool {
        blocks <= self.blocks() && !(matches!(self, Self::Cheapest) && node_is_cheaper)
    }
}

/// No builder has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no builder is called {0:?}: they are linear, binned and spatial")]
pub struct UnknownBuilder(pub String);

impl FromStr for Builder {
    type Err = UnknownBuilder;

    fn from_str(name: &str) -> Result<Self, UnknownBuilder> {
        let found = Self::ALL.into_iter().find(|builder| builder.name() == name);
        found.ok_or_else(|| UnknownBuilder(name.to_owned()))
    }
}
