//! What is chosen when a rasteriser is compiled: what a type does not ask for is not in its code.

/// Which triangles are left out because they show their back.
pub trait Culls: Send + Sync + 'static {
    /// How that is told.
    const BY: CullBy;
}

/// How a triangle that shows its back is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CullBy {
    /// Not at all: both faces are seen.
    Nothing,
    /// By its normal and the axis of view, which is wrong towards the edges of the picture.
    Axis,
    /// By the side of its plane that the eye is on.
    Eye,
}

/// Which pixels a triangle covers.
pub trait Edges: Send + Sync + 'static {
    /// Whether what rounding leaves open is judged by exact arithmetic.
    const FILTERED: bool;
}

/// How a surface is lit.
pub trait Shading: Send + Sync + 'static {
    /// In what way.
    const BY: ShadeBy;
}

/// How a surface is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadeBy {
    /// Its number as a colour.
    Identity,
    /// Not at all: its own colour.
    Nothing,
    /// Once for each triangle.
    Triangle,
    /// At the corners.
    Corners,
    /// At each pixel.
    Pixels,
}

/// How a texture lies on a triangle.
pub trait Texturing: Send + Sync + 'static {
    /// In what way.
    const BY: MapBy;
}

/// How a texture lies on a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapBy {
    /// There is none.
    Nothing,
    /// Evenly over the triangle in the picture, which is wrong where it is seen at an angle.
    Screen,
    /// Evenly over the triangle itself.
    Surface,
}

macro_rules! choices {
    ($($(#[doc = $says:literal])+ $name:ident: $of:ident = $value:expr;)+) => {$(
        $(#[doc = $says])+
        #[derive(Clone, Copy, Debug, Default)]
        pub struct $name;
        choices!(@ $of $name $value);
    )+};
    (@ Edges $name:ident $value:expr) => {
        impl Edges for $name {
            const FILTERED: bool = $value;
        }
    };
    (@ Culls $name:ident $value:expr) => {
        impl Culls for $name {
            const BY: CullBy = $value;
        }
    };
    (@ Shading $name:ident $value:expr) => {
        impl Shading for $name {
            const BY: ShadeBy = $value;
        }
    };
    (@ Texturing $name:ident $value:expr) => {
        impl Texturing for $name {
            const BY: MapBy = $value;
        }
    };
}

choices! {
    /// Both faces are seen.
    NoCulling: Culls = CullBy::Nothing;
    /// By the normal and the axis of view: quick, and wrong towards the edges of the picture.
    RoughCulling: Culls = CullBy::Axis;
    /// By the side of the plane that the eye is on.
    PerspectiveCulling: Culls = CullBy::Eye;
    /// Covers and orders as exact arithmetic does.
    Filtered: Edges = true;
    /// Covers and orders as f32 says.
    Bare: Edges = false;
    /// A colour for each triangle's number.
    Identity: Shading = ShadeBy::Identity;
    /// The surface's own colour.
    Unlit: Shading = ShadeBy::Nothing;
    /// Lit once for each triangle.
    Flat: Shading = ShadeBy::Triangle;
    /// Lit at the corners, interpolated between them (H. Gouraud: Continuous Shading of Curved Surfaces. IEEE
    /// Transactions on Computers C-20(6), 1971).
    Gouraud: Shading = ShadeBy::Corners;
    /// Lit at each pixel, by an interpolated normal (B. T. Phong: Illumination for Computer Generated
    /// Pictures. Communications of the ACM 18(6), 1975).
    Phong: Shading = ShadeBy::Pixels;
    /// No texture.
    NoTexture: Texturing = MapBy::Nothing;
    /// A texture that lies evenly in the picture.
    Affine: Texturing = MapBy::Screen;
    /// A texture that lies evenly on the surface.
    Perspective: Texturing = MapBy::Surface;
}
