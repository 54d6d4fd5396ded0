//! What is decided of a pair.

/// What a ray does to a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// It misses.
    Miss,
    /// It hits the front: `det > 0`.
    Front,
    /// It hits the back: `det < 0`.
    Back,
}
