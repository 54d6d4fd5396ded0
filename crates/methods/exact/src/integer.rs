//! Whole numbers of a fixed capacity, on the stack: what is left where floats cannot tell.

use core::cmp::Ordering;

/// A whole number of at most `64 · LIMBS` bits, with a sign. It takes the time of the limbs that it
/// fills, not of its capacity.
///
/// Every operation panics where its result does not fit; the derivation shows that none does here.
#[derive(Clone, Copy)]
pub(crate) struct Integer<const LIMBS: usize> {
    /// The magnitude, lowest limb first; zero from `length` on.
    limbs: [u64; LIMBS],
    /// How many limbs are filled: the last of them is not zero.
    length: usize,
    /// Of zero, never.
    is_negative: bool,
}

impl<const LIMBS: usize> Integer<LIMBS> {
    /// Zero.
    pub(crate) const ZERO: Self = Self { limbs: [0; LIMBS], length: 0, is_negative: false };

    /// `mantissa · 2^places`
    pub(crate) fn new(mantissa: i64, places: usize) -> Self {
        let mut number = Self::ZERO;
        number.limbs[0] = mantissa.unsigned_abs();
        number.length = usize::from(mantissa != 0);
        number.is_negative = mantissa < 0;
        number.shifted(places)
    }

    /// The order of the number and zero.
    pub(crate) fn sign(&self) -> Ordering {
        match (self.length, self.is_negative) {
            (0, _) => Ordering::Equal,
            (_, true) => Ordering::Less,
            (_, false) => Ordering::Greater,
        }
    }

    /// The number with its sign changed where `flips`.
    pub(crate) fn negated_if(&self, flips: bool) -> Self {
        Self { is_negative: self.is_negative ^ (flips && self.length > 0), ..*self }
    }

    /// The magnitude.
    pub(crate) fn magnitude(&self) -> Self {
        Self { is_negative: false, ..*self }
    }

    /// `self · 2^places`
    pub(crate) fn shifted(&self, places: usize) -> Self {
        let (whole, part) = (places / 64, places % 64);
        let mut result = Self { is_negative: self.is_negative, ..Self::ZERO };
        if self.length == 0 {
            return result;
        }
        let mut carry = 0;
        for (place, &limb) in self.limbs[..self.length].iter().enumerate() {
            result.limbs[whole + place] = limb << part | carry;
            carry = if part == 0 { 0 } else { limb >> (64 - part) };
        }
        result.length = whole + self.length;
        if carry != 0 {
            result.limbs[result.length] = carry;
            result.length += 1;
        }
        result
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        if self.is_negative == other.is_negative {
            return self.summed(other);
        }
        match self.compare_magnitudes(other) {
            Ordering::Less => other.reduced(self),
            Ordering::Equal => Self::ZERO,
            Ordering::Greater => self.reduced(other),
        }
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negated_if(true))
    }

    /// The sum of the magnitudes, with the sign that both have.
    fn summed(&self, other: &Self) -> Self {
        let (long, short) = if self.length < other.length { (other, self) } else { (self, other) };
        let mut result = Self { is_negative: self.is_negative || other.is_negative, ..*long };
        let mut carry = false;
        for place in 0..long.length {
            if place >= short.length && !carry {
                break;
            }
            let (sum, first) = long.limbs[place].overflowing_add(short.limbs[place]);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            result.limbs[place] = sum;
            carry = first | second;
        }
        if carry {
            result.limbs[result.length] = 1;
            result.length += 1;
        }
        result
    }

    /// The difference of the magnitudes, of which this one is the larger, with the sign of this one.
    fn reduced(&self, other: &Self) -> Self {
        let mut result = *self;
        let mut borrow = false;
        for place in 0..self.length {
            if place >= other.length && !borrow {
                break;
            }
            let (difference, first) = self.limbs[place].overflowing_sub(other.limbs[place]);
            let (difference, second) = difference.overflowing_sub(u64::from(borrow));
            result.limbs[place] = difference;
            borrow = first | second;
        }
        while result.length > 0 && result.limbs[result.length - 1] == 0 {
            result.length -= 1;
        }
        result
    }

    #[allow(clippy::cast_possible_truncation, reason = "the lower and the upper half are taken")]
    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut result = Self::ZERO;
        if self.length == 0 || other.length == 0 {
            return result;
        }
        for (place, &a) in self.limbs[..self.length].iter().enumerate() {
            let mut carry = 0;
            for (at, &b) in other.limbs[..other.length].iter().enumerate() {
                // At most (2⁶⁴ − 1)² + 2(2⁶⁴ − 1), which is 2¹²⁸ − 1.
                let sum = u128::from(a) * u128::from(b)
                    + u128::from(result.limbs[place + at])
                    + u128::from(carry);
                result.limbs[place + at] = sum as u64;
                carry = (sum >> 64) as u64;
            }
            if carry != 0 {
                result.limbs[place + other.length] = carry;
            }
        }
        let longest = self.length + other.length;
        let is_full = longest <= LIMBS && result.limbs[longest - 1] != 0;
        result.length = if is_full { longest } else { longest - 1 };
        result.is_negative = self.is_negative != other.is_negative;
        result
    }

    fn compare_magnitudes(&self, other: &Self) -> Ordering {
        self.length.cmp(&other.length).then_with(|| {
            let mine = self.limbs[..self.length].iter().rev();
            mine.cmp(other.limbs[..other.length].iter().rev())
        })
    }

    /// The uppermost 64 bits of a magnitude that is not zero, and the power of two that they count:
    /// what is below them is dropped.
    pub(crate) fn leading(&self) -> (u64, i32) {
        let last = self.length - 1;
        let zeros = self.limbs[last].leading_zeros();
        let below = if last > 0 && zeros > 0 { self.limbs[last - 1] >> (64 - zeros) } else { 0 };
        // Below 2¹⁵ bits.
        let exponent = i32::try_from(64 * last).unwrap_or(i32::MAX) - zeros.cast_signed();
        (self.limbs[last] << zeros | below, exponent)
    }
}

impl<const LIMBS: usize> PartialEq for Integer<LIMBS> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<const LIMBS: usize> Eq for Integer<LIMBS> {}

impl<const LIMBS: usize> PartialOrd for Integer<LIMBS> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<const LIMBS: usize> Ord for Integer<LIMBS> {
    fn cmp(&self, other: &Self) -> Ordering {
        match (self.is_negative, other.is_negative) {
            (false, true) => Ordering::Greater,
            (true, false) => Ordering::Less,
            (false, false) => self.compare_magnitudes(other),
            (true, true) => other.compare_magnitudes(self),
        }
    }
}
