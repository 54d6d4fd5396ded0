//! All statistics of the report, in one place.
//!
//! Times are summarised by medians because a preempted sample is long, never short; ratios by
//! geometric means because only those do not depend on which side is called the base.

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

/// The median between the ends of its 95 % interval, by ranks: all values where they are five or fewer. `None`
/// for an empty list.
pub fn median_interval(values: &[f64]) -> Option<[f64; 3]> {
    let reach = 0.98 / (values.len().max(1) as f64).sqrt();
    let reach = if values.len() > 5 { reach } else { 0.5 };
    Some([quantile(values, 0.5 - reach)?, median(values)?, quantile(values, 0.5 + reach)?])
}

/// The median absolute deviation from the median; `None` for an empty list.
pub fn mad(values: &[f64]) -> Option<f64> {
    let centre = median(values)?;
    let distances: Vec<f64> = values.iter().map(|x| (x - centre).abs()).collect();
    median(&distances)
}

/// The geometric mean of positive numbers; `None` for an empty list or a number that is not
/// positive and finite.
pub fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0u32);
    for x in values {
        if !(x > 0.0 && x.is_finite()) {
            return None;
        }
        sum += x.ln();
        count += 1;
    }
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

/// The straight line through points that is nearest to them upwards, as its slope, and how far the
/// points lie on one line at all, as their correlation; `None` for points without extent.
pub fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| of(p.0 - x, p.1 - y)).sum();
    let (xx, yy, xy): (f64, f64, f64) =
        (sum(&|x, _| x * x), sum(&|_, y| y * y), sum(&|x, y| x * y));
    let (slope, correlation) = (xy / xx, xy / (xx * yy).sqrt());
    (slope.is_finite() && correlation.is_finite()).then_some((slope, correlation))
}

/// Nanoseconds of one test: the median sample over the tests in it. `None` where nothing was
/// timed, so that such a record is left out instead of becoming an infinite speed.
pub fn ns_per_test(samples_ns: &[u64], tests: u64) -> Option<f64> {
    let samples: Vec<f64> = samples_ns.iter().map(|&ns| ns as f64).collect();
    let ns = median(&samples)? / tests as f64;
    (ns > 0.0 && ns.is_finite()).then_some(ns)
}

/// Indices of the points that no other point beats in both coordinates (smaller is better),
/// by growing first coordinate. Of equal points the first is kept; points that are not numbers
/// are never on the front.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| !points[i].0.is_nan() && !points[i].1.is_nan()).collect();
    order.sort_by(|&i, &j| {
        points[i].0.total_cmp(&points[j].0).then(points[i].1.total_cmp(&points[j].1))
    });
    let mut best = f64::INFINITY;
    let mut first = true;
    order.retain(|&i| {
        let on = first || points[i].1 < best;
        if on {
            best = points[i].1;
            first = false;
        }
        on
    });
    order
}
