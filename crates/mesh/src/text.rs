//! Text files: their encoding, lines, words and numbers.

use std::borrow::Cow;
use std::path::Path;

use encoding_rs::{UTF_8, WINDOWS_1252};

use crate::error::MeshProblem;
use crate::quote::quoted;
use crate::reading::{ReadProblem, Reading};

impl Reading {
    /// The text of a regular file, as [`file`](Reading::file) and [`decode`](Reading::decode) take it.
    ///
    /// # Errors
    /// As those.
    pub fn text(&mut self, path: &Path) -> Result<String, ReadProblem> {
        let bytes = self.file(path)?;
        Ok(self.decode(&bytes)?.into_owned())
    }

    /// The text that bytes hold, without the byte order mark: UTF-8, or UTF-16 where the mark says so.
    /// Bytes that are not UTF-8 are read as Windows-1252, of which Latin-1 is a part: what formats
    /// give a meaning to is ASCII, and names and comments in an old encoding make no file unreadable.
    ///
    /// # Errors
    /// When the bytes are no text; and where the reading is strict, when they are not UTF-8 without a
    /// mark.
    pub fn decode<'a>(&mut self, bytes: &'a [u8]) -> Result<Cow<'a, str>, ReadProblem> {
        let (mut text, encoding, is_damaged) = UTF_8.decode(bytes);
        if encoding != UTF_8 && is_damaged {
            return Err(ReadProblem::NotText { line: line_at(&text, "\u{fffd}") });
        }
        if is_damaged {
            let tail = &bytes[utf8_mark(bytes)..];
            (text, _) = WINDOWS_1252.decode_without_bom_handling(tail);
        }
        if let Cow::Owned(text) = &text {
            self.claim(text.len() as u64)?;
        }
        if text.contains('\0') {
            return Err(ReadProblem::NotText { line: line_at(&text, "\0") });
        }
        if is_damaged || text.len() != bytes.len() {
            self.tolerate("file", "its encoding is not UTF-8 without a byte order mark")?;
        }
        Ok(text)
    }
}

/// The length of the byte order mark of UTF-8 at the head of a file; 0 where there is none.
pub(crate) fn utf8_mark(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }
}

/// The number of the line, from 1, that first holds `what`.
fn line_at(text: &str, what: &str) -> usize {
    let end = text.find(what).map_or(text.len(), |at| at + what.len());
    lines(&text[..end]).count()
}

/// The lines of a text with their numbers from 1. A line ends with LF, CR LF or CR, and one file may
/// mix them.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text).filter(|text| !text.is_empty());
    let line = move || {
        let text = rest?;
        let end = text.bytes().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (line, after) = match end {
            None => (text, ""),
            Some(end) if text[end..].starts_with("\r\n") => (&text[..end], &text[end + 2..]),
            Some(end) => (&text[..end], &text[end + 1..]),
        };
        rest = Some(after).filter(|after| !after.is_empty());
        Some(line)
    };
    std::iter::from_fn(line).enumerate().map(|(number, line)| (number + 1, line))
}

/// A line without its comment: `#` begins one at the head of the line or after white space, and is part
/// of a name elsewhere.
pub fn without_comment(line: &str) -> &str {
    let begins =
        |&(at, _): &(usize, &str)| line[..at].chars().next_back().is_none_or(char::is_whitespace);
    let comment = line.match_indices('#').find(begins);
    comment.map_or(line, |(at, _)| &line[..at])
}

/// A name without the white space around it, and without quotation marks around all of it.
pub fn unquoted(name: &str) -> &str {
    let name = name.trim();
    let inner = name.strip_prefix('"').and_then(|name| name.strip_suffix('"'));
    inner.filter(|inner| !inner.contains('"')).unwrap_or(name)
}

/// A problem at one line of a text file.
pub(crate) fn malformed_line(line: usize, what: impl Into<String>) -> MeshProblem {
    MeshProblem::Malformed { place: format!("line {line}"), what: what.into() }
}

/// Parses one decimal coordinate of a text file. NaN and infinity are left to where it is used.
pub(crate) fn coordinate(word: Option<&str>, line: usize, axis: char) -> Result<f64, MeshProblem> {
    let word = word.ok_or_else(|| malformed_line(line, format!("{axis} is missing")))?;
    word.parse()
        .map_err(|_| malformed_line(line, format!("{axis} is `{}`, not a number", quoted(word))))
}

/// Parses the three coordinates at the head of `words`.
pub(crate) fn coordinates<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    line: usize,
) -> Result<[f64; 3], MeshProblem> {
    Ok([
        coordinate(words.next(), line, 'x')?,
        coordinate(words.next(), line, 'y')?,
        coordinate(words.next(), line, 'z')?,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::ReadOptions;

    fn decoded(bytes: &[u8], strict: bool) -> Result<String, String> {
        let mut reading = Reading::new(&ReadOptions { strict, ..ReadOptions::default() });
        let text = reading.decode(bytes).map(Cow::into_owned);
        text.map_err(|problem| problem.to_string())
    }

    #[test]
    fn marks_are_dropped_and_old_encodings_are_read() {
        let utf16 = |big: bool| -> Vec<u8> {
            let units = "\u{feff}v é\n".encode_utf16();
            units
                .flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() })
                .collect()
        };
        for bytes in [
            &b"v \xc3\xa9\n"[..],
            b"\xef\xbb\xbfv \xc3\xa9\n",
            b"v \xe9\n",
            b"\xef\xbb\xbfv \xe9\n",
            &utf16(false),
            &utf16(true),
        ] {
            assert_eq!(decoded(bytes, false).as_deref(), Ok("v é\n"), "{bytes:?}");
            assert_eq!(decoded(bytes, true).is_ok(), bytes == b"v \xc3\xa9\n", "{bytes:?}");
        }
        for (bytes, line) in [(&b"a\r\nb\rc\0"[..], 3), (b"\xff\xfe\n\0\0\xd8", 2), (b"v\0 \0", 1)]
        {
            let expected = format!("line {line}: is no text; save the file as UTF-8");
            assert_eq!(decoded(bytes, false), Err(expected), "{bytes:?}");
        }
    }

    #[test]
    fn every_end_of_a_line_counts_once() {
        let found: Vec<_> = lines("a\nb\r\nc\r\rd\n\n e").collect();
        assert_eq!(found, [(1, "a"), (2, "b"), (3, "c"), (4, ""), (5, "d"), (6, ""), (7, " e")]);
        assert_eq!(lines("").count(), 0);
        assert_eq!(lines("a\r\n").count(), 1);
    }

    #[test]
    fn a_comment_begins_after_white_space_alone() {
        for (line, expected) in [
            ("usemtl wood#1", "usemtl wood#1"),
            ("usemtl wood#1 # old", "usemtl wood#1 "),
            ("#usemtl", ""),
            ("\t# x", "\t"),
            ("a ## b", "a "),
        ] {
            assert_eq!(without_comment(line), expected);
        }
    }
}
