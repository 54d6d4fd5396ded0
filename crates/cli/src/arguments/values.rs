//! The values of arguments: what may be chosen, and how numbers are read.

use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use trisect_catalog::Builder;
use trisect_core::Named;

/// Lists the builders in help and completions.
pub(super) fn builders() -> impl TypedValueParser<Value = Builder> {
    PossibleValuesParser::new(Builder::ALL.map(Builder::name))
        .map(|name| name.parse().expect("it is listed"))
}

/// Lists the values of an enumeration in help and completions.
pub(super) fn named<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(T::ALL.iter().map(|value| value.name()))
        .map(|name| T::named(&name).expect("it is listed"))
}

/// A number from 0, which may be infinite.
pub(super) fn positive(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|x| *x >= 0.0).ok_or_else(|| "not a number from 0".to_owned())
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Light {
    /// From the eye through mirrors and glass, and from each point to the lights
    Whitted,
    /// On random paths, whose mean is the picture
    Paths,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Primary {
    /// Rays through trees
    Cast,
    /// The rasteriser, which sees what the method `exact` hits; one sample a pixel
    Raster,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Shade {
    /// The triangles' numbers as colours
    Id,
    Unlit,
    /// Once for each triangle
    Flat,
    /// At the corners
    Gouraud,
    /// At each pixel
    Phong,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Textures {
    None,
    /// Evenly over the triangle in the picture
    Affine,
    /// Evenly over the triangle itself
    Perspective,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Cull {
    None,
    Back,
    Front,
}

impl From<Cull> for trisect_method::Culling {
    fn from(cull: Cull) -> Self {
        match cull {
            Cull::None => Self::None,
            Cull::Back => Self::Back,
            Cull::Front => Self::Front,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Width {
    #[value(name = "1")]
    W1,
    #[value(name = "2")]
    W2,
    #[value(name = "4")]
    W4,
    #[value(name = "8")]
    W8,
    #[value(name = "16")]
    W16,
    Native,
}

impl Width {
    /// The number of lanes asked for; none for the widest.
    pub(crate) fn lanes(self) -> Option<usize> {
        match self {
            Self::W1 => Some(1),
            Self::W2 => Some(2),
            Self::W4 => Some(4),
            Self::W8 => Some(8),
            Self::W16 => Some(16),
            Self::Native => None,
        }
    }
}
