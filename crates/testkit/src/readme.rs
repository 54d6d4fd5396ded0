//! Parts of a README that are observed, not written: they stand between marking lines.

use std::path::Path;
use std::sync::Mutex;

/// A part of a README, by its marking lines.
pub(crate) struct Part {
    pub(crate) begin: &'static str,
    pub(crate) end: &'static str,
}

/// Tests of one crate run side by side, and may bless different parts of one file.
static FILE: Mutex<()> = Mutex::new(());

impl Part {
    /// The part as it stands in the README at `path`.
    ///
    /// # Panics
    /// When the README cannot be read or has no markers.
    pub(crate) fn of(&self, path: &Path) -> String {
        let readme = std::fs::read_to_string(path).expect("a method has a README");
        let rest = readme.split_once(self.begin);
        let part = rest.and_then(|(_, rest)| rest.split_once(self.end));
        part.unwrap_or_else(|| self.is_missing(path)).0.trim().to_owned()
    }

    /// Holds the part to `wanted`; with `TRISECT_BLESS` set in the environment, rewrites it.
    ///
    /// # Panics
    /// When the README cannot be read or written, has no markers, or another part.
    pub(crate) fn hold(&self, path: &Path, wanted: &str) {
        let guard = FILE.lock();
        let readme = std::fs::read_to_string(path).expect("a method has a README");
        let wanted = self.spliced(&readme, wanted).unwrap_or_else(|| self.is_missing(path));
        if is_blessing() {
            std::fs::write(path, wanted).expect("blessing needs a README that can be written");
            return;
        }
        drop(guard);
        assert_eq!(
            readme,
            wanted,
            "{} is out of date after {}: TRISECT_BLESS=1 cargo test rewrites it",
            path.display(),
            self.begin
        );
    }

    fn is_missing(&self, path: &Path) -> ! {
        panic!("{} lacks {}{}", path.display(), self.begin, self.end)
    }

    /// `readme` with the text between the markers replaced; `None` without markers.
    fn spliced(&self, readme: &str, text: &str) -> Option<String> {
        let Self { begin, end } = self;
        let (head, rest) = readme.split_once(begin)?;
        let (_, tail) = rest.split_once(end)?;
        Some(format!("{head}{begin}\n{}\n\n{end}{tail}", text.trim_end()))
    }
}

/// Whether tables are rewritten rather than compared.
pub(crate) fn is_blessing() -> bool {
    std::env::var_os("TRISECT_BLESS").is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PART: Part = Part { begin: "<begin>\n", end: "<end>" };

    #[test]
    fn splicing_replaces_what_is_between_the_markers_alone() {
        let once = PART.spliced("a\n<begin>\nold\n<end>\nb", "new\n").expect("there are markers");
        assert_eq!(once, "a\n<begin>\n\nnew\n\n<end>\nb");
        assert_eq!(PART.spliced(&once, "new\n").expect("there are markers"), once);
    }

    #[test]
    fn without_markers_there_is_nothing_to_splice() {
        assert_eq!(PART.spliced("a", "b"), None);
    }
}
