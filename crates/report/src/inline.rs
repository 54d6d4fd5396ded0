//! Marks in prose, `` `code` `` and `**strong**`, and texts that are too long.

/// A text as HTML and SVG hold it.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Prose as HTML.
pub(crate) fn html(text: &str) -> String {
    let strong = |text: &str| tagged(text, "**", "strong");
    escape(text).split('`').enumerate().fold(String::new(), |html, (i, piece)| {
        html + &if i % 2 == 1 { format!("<code>{piece}</code>") } else { strong(piece) }
    })
}

/// Sets what stands between pairs of a mark as an element.
fn tagged(text: &str, mark: &str, element: &str) -> String {
    let pieces = text.split(mark).enumerate();
    pieces.fold(String::new(), |html, (i, piece)| {
        html + &if i % 2 == 1 { format!("<{element}>{piece}</{element}>") } else { piece.into() }
    })
}

/// Prose without its marks.
pub(crate) fn plain(text: &str) -> String {
    text.replace('`', "").replace("**", "")
}

/// Cuts a text that is too long, and says so.
pub fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.into();
    }
    text.chars().take(width.saturating_sub(1)).chain(['…']).collect()
}
