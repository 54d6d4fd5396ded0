//! Where a point is with respect to a solid.

/// Where a point is with respect to the solid that a closed surface bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    /// Inside the solid, not on its surface.
    Inside,
    /// On the surface.
    On,
    /// Outside the solid, not on its surface.
    Outside,
}
