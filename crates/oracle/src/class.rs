//! What can be true of a ray and a triangle.

/// How a ray meets a triangle. The triangle is closed, and so is the interval `[tmin, tmax]`, whose ends are
/// brought within half the largest number of the precision.
///
/// The variants are tried in the order [`NonFinite`](Class::NonFinite),
/// [`Degenerate`](Class::Degenerate), [`Coplanar`](Class::Coplanar), [`Miss`](Class::Miss),
/// [`OutOfInterval`](Class::OutOfInterval), and last the three that are hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// A hit with `alpha`, `beta` and `gamma` all positive.
    Interior,
    /// A hit with exactly one of `alpha`, `beta`, `gamma` zero.
    Edge,
    /// A hit with exactly two of `alpha`, `beta`, `gamma` zero.
    Vertex,
    /// The line of the ray crosses the plane of the triangle outside the closed triangle.
    Miss,
    /// The direction is parallel to the plane, or zero: `det = 0`.
    Coplanar,
    /// The triangle has no area: its corners are collinear or equal.
    Degenerate,
    /// The line of the ray meets the closed triangle, but `t < tmin` or `t > tmax`: so where `t` is more
    /// than half the largest number, whatever `tmax` says.
    OutOfInterval,
    /// NaN anywhere, or an infinity in the origin, the direction or a corner. (`tmin` and `tmax`
    /// may be infinite.)
    NonFinite,
}

impl Class {
    /// Every class, in the order of declaration.
    pub const ALL: [Self; 8] = [
        Self::Interior,
        Self::Edge,
        Self::Vertex,
        Self::Miss,
        Self::Coplanar,
        Self::Degenerate,
        Self::OutOfInterval,
        Self::NonFinite,
    ];

    /// Whether the ray hits the triangle.
    #[inline]
    pub const fn is_hit(self) -> bool {
        matches!(self, Self::Interior | Self::Edge | Self::Vertex)
    }

    /// The name used in records and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Interior => "interior",
            Self::Edge => "edge",
            Self::Vertex => "vertex",
            Self::Miss => "miss",
            Self::Coplanar => "coplanar",
            Self::Degenerate => "degenerate",
            Self::OutOfInterval => "out-of-interval",
            Self::NonFinite => "non-finite",
        }
    }

    /// The hit with this many of `alpha`, `beta`, `gamma` zero.
    pub(crate) const fn hit(zeros: usize) -> Self {
        match zeros {
            0 => Self::Interior,
            1 => Self::Edge,
            // Three zeros would make `det = alpha + beta + gamma` numerators sum to zero.
            _ => Self::Vertex,
        }
    }
}

impl core::fmt::Display for Class {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::Class;

    #[test]
    fn names_are_distinct_and_all_is_complete() {
        for (i, class) in Class::ALL.into_iter().enumerate() {
            assert_eq!(class as usize, i);
            assert!(Class::ALL[..i].iter().all(|other| other.name() != class.name()));
        }
        assert_eq!(Class::ALL.into_iter().filter(|c| c.is_hit()).count(), 3);
    }
}
