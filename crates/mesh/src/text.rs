//! Text files: their lines, words and numbers.

use crate::error::MeshProblem;

/// A problem at one line of a text file.
pub(crate) fn malformed_line(line: usize, what: impl Into<String>) -> MeshProblem {
    MeshProblem::Malformed { place: format!("line {line}"), what: what.into() }
}

/// Parses one decimal coordinate of a text file. NaN and infinity are left to `build`.
pub(crate) fn coordinate(word: Option<&str>, line: usize, axis: char) -> Result<f64, MeshProblem> {
    let word = word.ok_or_else(|| malformed_line(line, format!("{axis} is missing")))?;
    word.parse().map_err(|_| malformed_line(line, format!("{axis} is `{word}`, not a number")))
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

/// A text file, or the line that is not text.
pub(crate) fn text(bytes: &[u8]) -> Result<&str, MeshProblem> {
    str::from_utf8(bytes)
        .map_err(|error| malformed_line(line_at(bytes, error.valid_up_to()), "not text (UTF-8)"))
}

/// The number of the line, from 1, that holds the byte at `offset`.
pub(crate) fn line_at(bytes: &[u8], offset: usize) -> usize {
    bytes[..offset].split(|&byte| byte == b'\n').count()
}
