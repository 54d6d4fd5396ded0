//! STL, ascii and binary.
//!
//! Read here, not by a library: a binary file whose header says `solid` is common, and only its
//! length and its zero bytes tell it from an ascii one; and no library at hand keeps line numbers.

use std::str::SplitAsciiWhitespace;

use crate::error::{MeshProblem, Place};
use crate::faces::{Raw, Vertex};
use crate::quote::quoted;
use crate::reading::Source;
use crate::text::{coordinates, lines, malformed_line, utf8_mark};

/// Bytes before the first record: a comment of 80 and the count of 4.
const HEADER: usize = 84;
/// Bytes of a record: twelve f32 (the normal, three corners) and two unused bytes.
const RECORD: usize = 50;

pub(crate) fn parse(bytes: &[u8], source: &mut Source<'_>) -> Result<Raw, MeshProblem> {
    let actual = bytes.len() as u64;
    let promised = bytes
        .get(HEADER - 4..HEADER)
        .map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]))
        .map(|count| (count, HEADER as u64 + RECORD as u64 * u64::from(count)));
    let (count, length) = match promised {
        Some((count, length)) if length == actual => (count, length),
        _ if is_ascii(bytes) => return parse_ascii(&source.reading.decode(bytes)?, source),
        Some(promised) => promised,
        None => {
            return Err(MeshProblem::Truncated {
                what: format!("the header needs {HEADER} bytes, the file has {actual}"),
            });
        }
    };
    let compared = || format!("{count} triangles need {length} bytes, the file has {actual}");
    if length > actual {
        return Err(MeshProblem::Truncated { what: compared() });
    }
    let tail = actual - length;
    // Whole records are triangles that the count misses, not something that a program has added.
    if tail > 0 && (count == 0 || tail.is_multiple_of(RECORD as u64)) {
        return Err(MeshProblem::Trailing { what: format!("{}: bytes", compared()) });
    }
    if tail > 0 {
        let what = "bytes after the last triangle are left out";
        source.reading.note(source.file, &format!("{tail} bytes"), what)?;
    }
    let records = bytes[HEADER..].chunks_exact(RECORD).take(count as usize);
    let mut raw = Raw::with_capacity(3 * records.len(), records.len(), source.reading)?;
    for record in records {
        let number =
            |i: usize| f32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]]);
        let corners =
            [12, 24, 36].map(|at| [number(at), number(at + 4), number(at + 8)].map(f64::from));
        push_facet(&mut raw, corners.map(|at| Vertex { at, line: None }), None);
    }
    Ok(raw)
}

/// Whether a file that is not as long as a binary one is text: it says `solid`, and has none of the zero
/// bytes that the records of a binary one have.
fn is_ascii(bytes: &[u8]) -> bool {
    let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    let text = bytes[utf8_mark(bytes)..].trim_ascii_start();
    let is_solid = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    is_utf16 || is_solid && !bytes.contains(&0)
}

/// Adds a facet with its own vertices: STL shares none.
fn push_facet(raw: &mut Raw, corners: impl IntoIterator<Item = Vertex>, line: Option<usize>) {
    let first = raw.vertices.len();
    raw.vertices.extend(corners);
    let index = |index: usize| i64::try_from(index).unwrap_or(i64::MAX);
    raw.push((first..raw.vertices.len()).map(index), line);
}

/// Where in the nested `solid`, `facet`, `loop` a word stands.
#[derive(Clone, Copy, PartialEq)]
enum Inside {
    Nothing,
    Solid,
    /// After `facet`, before its loop: the normal.
    Normal,
    Loop,
    /// After the loop.
    Facet,
}

/// The words of a text and the line of the last of them. White space of any kind divides them.
struct Words<'a, L> {
    lines: L,
    line: usize,
    rest: SplitAsciiWhitespace<'a>,
}

impl<'a, L: Iterator<Item = (usize, &'a str)>> Iterator for Words<'a, L> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.rest.next() {
                return Some(word);
            }
            let (line, text) = self.lines.next()?;
            (self.line, self.rest) = (line, text.split_ascii_whitespace());
        }
    }
}

fn parse_ascii(text: &str, source: &mut Source<'_>) -> Result<Raw, MeshProblem> {
    let mut raw = Raw::default();
    let mut words = Words { lines: lines(text), line: 0, rest: "".split_ascii_whitespace() };
    let mut inside = Inside::Nothing;
    let mut facet_line = 0;
    let mut corners = Vec::new();
    while let Some(word) = words.next() {
        let line = words.line;
        let place = || format!("line {line}");
        let mut keyword = word.to_ascii_lowercase();
        if keyword == "end" {
            keyword.extend(words.rest.next().map(str::to_ascii_lowercase));
            source.reading.tolerate(place(), "`end` apart from the word that it ends")?;
        } else if keyword != word && inside != Inside::Normal {
            source.reading.tolerate(place(), "a keyword in upper case")?;
        }
        inside = match (inside, keyword.as_str()) {
            (Inside::Nothing, "solid") => {
                words.skip_line();
                Inside::Solid
            }
            (Inside::Solid, "endsolid") => {
                words.skip_line();
                Inside::Nothing
            }
            (Inside::Nothing, _) if !raw.faces.is_empty() => {
                words.skip_line();
                let what = "text after the last solid is left out";
                source.reading.note(source.file, &place(), what)?;
                Inside::Nothing
            }
            (Inside::Solid, "facet") => {
                facet_line = line;
                Inside::Normal
            }
            (Inside::Normal, "outer")
                if words.next().is_some_and(|word| word.eq_ignore_ascii_case("loop")) =>
            {
                Inside::Loop
            }
            // The normal, which nobody reads: it may be anything.
            (Inside::Normal, other)
                if !matches!(other, "vertex" | "endfacet" | "facet" | "endsolid") =>
            {
                Inside::Normal
            }
            (Inside::Loop, "vertex") => {
                let at = coordinates(&mut words, line)?;
                corners.push(Vertex { at, line: Some(line) });
                Inside::Loop
            }
            (Inside::Loop, "endloop") => {
                close_facet(&mut raw, &mut corners, facet_line, source)?;
                Inside::Facet
            }
            (Inside::Facet, "endfacet") => Inside::Solid,
            (Inside::Solid | Inside::Facet, "color") => {
                words.skip_line();
                source.reading.note(source.file, &place(), "a colour is left out")?;
                inside
            }
            _ => {
                return Err(malformed_line(
                    line,
                    format!("`{}` does not belong here", quoted(word)),
                ));
            }
        };
    }
    if inside == Inside::Nothing {
        Ok(raw)
    } else {
        Err(MeshProblem::Truncated { what: "`endsolid` is missing".to_owned() })
    }
}

impl<L> Words<'_, L> {
    fn skip_line(&mut self) {
        self.rest = "".split_ascii_whitespace();
    }
}

fn close_facet(
    raw: &mut Raw,
    corners: &mut Vec<Vertex>,
    line: usize,
    source: &mut Source<'_>,
) -> Result<(), MeshProblem> {
    let face = Place { number: raw.faces.len(), line: Some(line) };
    if corners.len() < 3 {
        return Err(MeshProblem::TooFewCorners { face, corners: corners.len() });
    }
    if corners.len() > 3 {
        let what = "a facet of more than three corners is split into triangles";
        source.reading.note(source.file, &format!("face {face}"), what)?;
    }
    push_facet(raw, corners.drain(..), Some(line));
    if raw.faces.len().is_multiple_of(1 << 12) {
        raw.claim(source.reading)?;
    }
    Ok(())
}
