//! What a file says, fit for a message of one line.

/// What a file says, fit for a message of one line: at most 60 characters of it, control characters
/// escaped. A file may hold line ends where a name is expected, and a name of any length.
pub fn quoted(text: &str) -> String {
    cut(text, 60)
}

/// The same with another length.
pub fn cut(text: &str, longest: usize) -> String {
    let mut shown = String::new();
    for (place, c) in text.chars().enumerate() {
        if place == longest {
            shown.push('…');
            break;
        }
        if c.is_control() {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}
