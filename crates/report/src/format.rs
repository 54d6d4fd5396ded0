//! How numbers are written, the same in terminals, tables and figures.

/// Digits grouped by commas.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// Three significant digits, or all digits before the point.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if !x.is_finite() {
        return x.to_string();
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 10^15")]
    let rounded = || grouped(size.round() as u64);
    match size {
        0.0 => "0".into(),
        s if !(1e-3..1e15).contains(&s) => scientific(x),
        s if s >= 99.95 => format!("{}{}", if x < 0.0 { "-" } else { "" }, rounded()),
        s if s >= 9.995 => format!("{x:.1}"),
        s if s >= 0.9995 => format!("{x:.2}"),
        _ => format!("{x:.3}"),
    }
}

/// A number without zeros that say nothing, for ticks of axes.
pub fn tick(x: f64) -> String {
    let text = number(x);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

/// One digit after the point, and an exponent.
pub fn scientific(x: f64) -> String {
    if x == 0.0 { "0".into() } else { format!("{x:.1e}") }
}

/// A ratio with its sign of multiplication.
pub fn ratio(x: f64) -> String {
    if x >= 9.95 { format!("{}×", number(x)) } else { format!("{x:.2}×") }
}

/// Million tests per second, from nanoseconds per test.
pub fn mtests(ns: f64) -> f64 {
    1e3 / ns
}

/// A size in memory.
pub fn bytes(x: f64) -> String {
    let (value, unit) = match x {
        x if x < 1024.0 => (x, "B"),
        x if x < 1024.0 * 1024.0 => (x / 1024.0, "KiB"),
        x if x < 1024.0 * 1024.0 * 1024.0 => (x / (1024.0 * 1024.0), "MiB"),
        x => (x / (1024.0 * 1024.0 * 1024.0), "GiB"),
    };
    let text = if value.fract() == 0.0 { format!("{value}") } else { number(value) };
    format!("{text} {unit}")
}

/// A power of ten as it is set in print.
pub fn power_of_ten(exponent: i32) -> String {
    let plain = exponent.to_string();
    let digits = plain.chars().map(|c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁰',
    });
    format!("10{}", digits.collect::<String>())
}

/// A multiple of a power of ten as it is set in print, for ticks of axes.
#[expect(clippy::cast_possible_truncation, reason = "exponents of finite floats")]
pub fn times_power_of_ten(x: f64) -> String {
    let exponent = (x.log10() + 1e-9).floor();
    let factor = x / 10f64.powf(exponent);
    if (factor - 1.0).abs() < 1e-6 {
        return power_of_ten(exponent as i32);
    }
    format!("{}·{}", tick(factor), power_of_ten(exponent as i32))
}

/// A value that may be missing.
pub fn or_dash(x: Option<f64>, write: fn(f64) -> String) -> String {
    x.map_or_else(|| "–".into(), write)
}

/// A number with two digits after the point.
pub fn fixed(x: f64) -> String {
    format!("{x:.2}")
}

/// A share in per cent, its number with a digit after the point at most.
pub fn percent(x: f64) -> String {
    format!("{} %", tick((x * 10.0).round() / 10.0))
}
