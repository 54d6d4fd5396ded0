//! How many operations of each kind.

use core::iter::Sum;
use core::ops::{Add, Sub};

use crate::graph::Op;

/// How often each operation is done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ops {
    /// Products; a multiply-add is one product and one sum.
    pub multiplies: u32,
    /// Sums and differences.
    pub adds: u32,
    /// Quotients.
    pub divisions: u32,
    /// Comparisons; the smaller or the larger of two is one.
    pub comparisons: u32,
    /// Negations, absolute values and copied signs: one bit operation each.
    pub signs: u32,
}

impl Ops {
    const ZERO: Self = Self { multiplies: 0, adds: 0, divisions: 0, comparisons: 0, signs: 0 };

    /// What one operation counts as. Choices and what joins truth values count as nothing.
    pub fn of(op: Op) -> Self {
        match op {
            Op::Add(..) | Op::Sub(..) => Self { adds: 1, ..Self::ZERO },
            Op::Mul(..) => Self { multiplies: 1, ..Self::ZERO },
            Op::MulAdd(..) | Op::MulSub(..) => Self { multiplies: 1, adds: 1, ..Self::ZERO },
            Op::Div(..) => Self { divisions: 1, ..Self::ZERO },
            Op::Lt(..) | Op::Le(..) | Op::Min(..) | Op::Max(..) => {
                Self { comparisons: 1, ..Self::ZERO }
            }
            Op::Neg(_) | Op::Abs(_) | Op::XorSign(..) => Self { signs: 1, ..Self::ZERO },
            _ => Self::ZERO,
        }
    }

    fn zip(self, other: Self, f: impl Fn(u32, u32) -> u32) -> Self {
        Self {
            multiplies: f(self.multiplies, other.multiplies),
            adds: f(self.adds, other.adds),
            divisions: f(self.divisions, other.divisions),
            comparisons: f(self.comparisons, other.comparisons),
            signs: f(self.signs, other.signs),
        }
    }
}

impl Add for Ops {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Ops {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Sum for Ops {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::ZERO, Add::add)
    }
}
