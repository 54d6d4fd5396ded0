//! Wavefront OBJ: `v` and `f` lines.
//!
//! Read here, not by a library: those at hand drop or merge what they do not like, renumber the
//! vertices and keep no line numbers, so that no message could name the place of a mistake.

use super::{Face, MeshProblem, Raw, Vertex, coordinates, malformed_line, text};

pub(super) fn parse(bytes: &[u8]) -> Result<Raw, MeshProblem> {
    let mut raw = Raw::default();
    for (number, content) in text(bytes)?.lines().enumerate() {
        let line = number + 1;
        let content = content.split('#').next().unwrap_or_default();
        if content.trim_end().ends_with('\\') {
            return Err(MeshProblem::Unsupported {
                what: format!("line {line}: continued lines (\\) are"),
                mend: "re-export the mesh",
            });
        }
        let mut words = content.split_whitespace();
        match words.next() {
            Some("v") => {
                raw.vertices.push(Vertex { at: coordinates(&mut words, line)?, line: Some(line) });
            }
            Some("f") => {
                let pairs = words
                    .map(|word| vertex_index(word, line, raw.vertices.len()))
                    .collect::<Result<Vec<_>, _>>()?;
                raw.faces.push(Face::from_pairs(pairs, Some(line)));
            }
            _ => {}
        }
    }
    Ok(raw)
}

/// The vertex number of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, and as it is written: from 1,
/// or negative, which counts back from the last vertex so far.
fn vertex_index(word: &str, line: usize, so_far: usize) -> Result<(i64, i64), MeshProblem> {
    let written = word
        .split('/')
        .next()
        .and_then(|index| index.parse::<i64>().ok())
        .ok_or_else(|| malformed_line(line, format!("corner `{word}` is not an index")))?;
    let base = if written < 0 { i64::try_from(so_far).unwrap_or(i64::MAX) } else { -1 };
    Ok((base.saturating_add(written), written))
}
