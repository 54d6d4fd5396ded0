//! A number taken apart.

/// A finite number as `mantissa · 2^exponent` with an odd mantissa; zero is `(0, 0)`.
pub fn decode(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let fraction = (bits & ((1 << 52) - 1)).cast_signed();
    // Eleven bits always fit.
    let biased = i32::try_from((bits >> 52) & 0x7ff).unwrap_or_default();
    let (magnitude, exponent) =
        if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
    if magnitude == 0 {
        return (0, 0);
    }
    let zeros = magnitude.trailing_zeros();
    let mantissa = magnitude >> zeros;
    (if x.is_sign_negative() { -mantissa } else { mantissa }, exponent + zeros.cast_signed())
}

#[cfg(test)]
mod tests {
    use super::decode;

    #[test]
    fn numbers_are_what_they_are_taken_apart_to() {
        assert_eq!(decode(0.0), (0, 0));
        assert_eq!(decode(-0.0), (0, 0));
        assert_eq!(decode(1.0), (1, 0));
        assert_eq!(decode(-6.5), (-13, -1));
        assert_eq!(decode(f64::from_bits(1)), (1, -1074));
        assert_eq!(decode(f64::MIN_POSITIVE), (1, -1022));
        assert_eq!(decode(-f64::MAX), (-((1 << 53) - 1), 971));
    }
}
