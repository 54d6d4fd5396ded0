//! What the lanes of a loop hold, as a value.

use trisect_core::named;

use crate::prepared::Common;

named! {
    /// What the lanes hold.
    pub enum Arrangement {
        /// N triangles, against one ray at a time.
        OneRay = "one-ray",
        /// N rays, against one triangle at a time.
        OneTriangle = "one-triangle",
        /// N rays with a common origin, against one triangle at a time.
        CommonOrigin = "common-origin",
        /// N rays with a common direction, against one triangle at a time.
        CommonDirection = "common-direction",
    }
}

impl Arrangement {
    /// Whether it serves rays that have that much in common.
    pub const fn serves(self, common: Common) -> bool {
        match self {
            Self::OneRay | Self::OneTriangle => true,
            Self::CommonOrigin => common.origin,
            Self::CommonDirection => common.direction,
        }
    }
}
