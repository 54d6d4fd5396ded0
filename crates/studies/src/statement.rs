//! What an author says, and whether it holds here.

/// A statement, then whether it holds and the figures.
pub(crate) type Statement = (String, String);

pub(crate) fn said(says: &str, figures: impl Into<String>) -> Statement {
    (says.to_owned(), figures.into())
}

pub(crate) fn found(says: &str, verdict: &str, figures: impl AsRef<str>) -> Statement {
    said(says, format!("**{verdict}** {}", figures.as_ref()))
}

pub(crate) fn unmeasured(says: &str, why: &str) -> Statement {
    found(says, holds(None), why)
}

pub(crate) fn holds(of: Option<bool>) -> &'static str {
    match of {
        Some(true) => "Holds here.",
        Some(false) => "Not here.",
        None => "Not measured.",
    }
}
