//! STL, ascii and binary.
//!
//! Read here, not by a library: a binary file whose header says `solid` is common, and only its
//! length tells it from an ascii one; and no library at hand keeps line numbers.

use crate::error::MeshProblem;
use crate::faces::{Raw, Vertex};
use crate::mesh::Source;
use crate::text::{bom_length, coordinates, lines, malformed_line};

/// Bytes before the first record: a comment of 80 and the count of 4.
const HEADER: usize = 84;
/// Bytes of a record: twelve f32 (the normal, three corners) and two unused bytes.
const RECORD: usize = 50;

pub(crate) fn parse(bytes: &[u8], source: &mut Source<'_>) -> Result<Raw, MeshProblem> {
    let promised = bytes
        .get(HEADER - 4..HEADER)
        .map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]))
        .map(|count| (count, HEADER as u64 + RECORD as u64 * u64::from(count)));
    let actual = bytes.len() as u64;
    match promised {
        Some((_, length)) if length == actual => Ok(parse_binary(bytes)),
        _ if bytes[bom_length(bytes)..].trim_ascii_start().starts_with(b"solid") => {
            parse_ascii(&source.reading.decode(bytes)?)
        }
        Some((count, length)) if length > actual => Err(MeshProblem::Truncated {
            what: format!("{count} triangles need {length} bytes, the file has {actual}"),
        }),
        Some((count, length)) => Err(MeshProblem::Trailing {
            what: format!("{count} triangles need {length} bytes, the file has {actual}: bytes"),
        }),
        None => Err(MeshProblem::Truncated {
            what: format!("the header needs {HEADER} bytes, the file has {actual}"),
        }),
    }
}

fn parse_binary(bytes: &[u8]) -> Raw {
    let mut raw = Raw::default();
    for record in bytes[HEADER..].chunks_exact(RECORD) {
        let number =
            |i: usize| f32::from_le_bytes([record[i], record[i + 1], record[i + 2], record[i + 3]]);
        let corners =
            [12, 24, 36].map(|at| [number(at), number(at + 4), number(at + 8)].map(f64::from));
        push_facet(&mut raw, &corners, None, &[None; 3]);
    }
    raw
}

/// Adds a facet with its own vertices: STL shares none.
fn push_facet(raw: &mut Raw, corners: &[[f64; 3]], line: Option<usize>, lines: &[Option<usize>]) {
    let first = raw.vertices.len();
    raw.vertices.extend(corners.iter().zip(lines).map(|(&at, &line)| Vertex { at, line }));
    let indices = (first..raw.vertices.len())
        .map(|index| i64::try_from(index).unwrap_or(i64::MAX))
        .collect::<Vec<_>>();
    raw.push(&indices, line);
}

/// Where in the nested `solid`, `facet`, `loop` a line stands.
#[derive(Clone, Copy, PartialEq)]
enum Inside {
    Nothing,
    Solid,
    Facet,
    Loop,
}

fn parse_ascii(content: &str) -> Result<Raw, MeshProblem> {
    let mut raw = Raw::default();
    let mut inside = Inside::Nothing;
    let mut facet_line = 0;
    let (mut corners, mut at) = (Vec::new(), Vec::new());
    for (line, content) in lines(content) {
        let mut words = content.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        inside = match (inside, keyword.to_ascii_lowercase().as_str()) {
            (Inside::Nothing, "solid") | (Inside::Facet, "endfacet") => Inside::Solid,
            (Inside::Solid, "facet") => {
                facet_line = line;
                Inside::Facet
            }
            (Inside::Facet, "outer") => Inside::Loop,
            (Inside::Loop, "vertex") => {
                corners.push(coordinates(&mut words, line)?);
                at.push(Some(line));
                if let Some(word) = words.next() {
                    return Err(malformed_line(line, format!("`{word}` after z")));
                }
                Inside::Loop
            }
            (Inside::Loop, "endloop") => {
                push_facet(&mut raw, &corners, Some(facet_line), &at);
                corners.clear();
                at.clear();
                Inside::Facet
            }
            (Inside::Solid, "endsolid") => Inside::Nothing,
            _ => return Err(malformed_line(line, format!("`{keyword}` does not belong here"))),
        };
    }
    if inside == Inside::Nothing {
        Ok(raw)
    } else {
        Err(MeshProblem::Truncated { what: "`endsolid` is missing".to_owned() })
    }
}
