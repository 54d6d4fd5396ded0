//! What several samples come to: medians, as a sample that was interrupted is long, never short.

/// The value below which a share `q` of `values` lies, interpolated between neighbours; `None`
/// for an empty list or when a value is not a number.
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    if values.is_empty() || values.iter().any(|x| x.is_nan()) {
        return None;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = q.clamp(0.0, 1.0) * (sorted.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 <= at < len")]
    let low = at.floor() as usize;
    let high = (low + 1).min(sorted.len() - 1);
    let share = at - at.floor();
    // Equal neighbours are returned untouched, so that infinities stay infinities.
    if sorted[low] == sorted[high] {
        return Some(sorted[low]);
    }
    Some(sorted[low] * (1.0 - share) + sorted[high] * share)
}

/// The median; `None` for an empty list.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// The first and third quartile; `None` for an empty list.
pub fn quartiles(values: &[f64]) -> Option<(f64, f64)> {
    Some((quantile(values, 0.25)?, quantile(values, 0.75)?))
}

/// The median of some times; infinite where there are none.
pub(crate) fn middle(samples_ns: &[u64]) -> f64 {
    let samples: Vec<f64> = samples_ns.iter().map(|&ns| ns as f64).collect();
    median(&samples).unwrap_or(f64::INFINITY)
}
