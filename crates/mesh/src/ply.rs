//! PLY, ascii and binary of either byte order.

use std::io::BufRead;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    DefaultElement, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult,
    PropertyType, ScalarType,
};

use crate::error::MeshProblem;
use crate::faces::{Raw, Vertex};
use crate::text::malformed_line;

/// The two names that exporters give to the list of a face's vertices.
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

pub(crate) fn parse(bytes: &[u8]) -> Result<Raw, MeshProblem> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<DefaultElement>::new()
        .read_header(&mut reader)
        .map_err(|error| header_problem(&error))?;
    check_header(&header, reader.get_ref().len())?;
    let mut payload = Payload {
        encoding: header.encoding,
        line: bytes[..bytes.len() - reader.get_ref().len()].split(|&byte| byte == b'\n').count()
            - 1,
        rest: reader.into_inner(),
    };
    let mut raw = Raw::default();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => payload.read(element, |vertex: PlyVertex, line| {
                raw.vertices.push(Vertex { at: vertex.at, line });
            })?,
            "face" => payload.read(element, |face: PlyFace, line| {
                raw.push(&face.indices, line);
            })?,
            _ => payload.read(element, |_: Skipped, _| {})?,
        }
    }
    if payload.rest.trim_ascii().is_empty() {
        Ok(raw)
    } else {
        Err(MeshProblem::Trailing { what: format!("{} bytes", payload.rest.len()) })
    }
}

fn header_problem(error: &ParseError) -> MeshProblem {
    if error.kind() == std::io::ErrorKind::UnexpectedEof {
        return MeshProblem::Truncated { what: "the header has no `end_header`".to_owned() };
    }
    // The library goes on with the line and its grammar; its first line says what is wrong.
    let what = error.to_string();
    let what = what.lines().next().unwrap_or_default().trim_end_matches('.').to_owned();
    MeshProblem::Malformed { place: "header".to_owned(), what }
}

/// The header must promise a mesh, and no more elements than the file has bytes.
fn check_header(header: &Header, bytes: usize) -> Result<(), MeshProblem> {
    let element = |name: &str| {
        header
            .elements
            .get(name)
            .ok_or_else(|| MeshProblem::Missing { what: format!("element `{name}` in the header") })
    };
    let vertex = element("vertex")?;
    for axis in ["x", "y", "z"] {
        match vertex.properties.get(axis).map(|property| &property.data_type) {
            Some(PropertyType::Scalar(_)) => {}
            Some(PropertyType::List(..)) => {
                return Err(MeshProblem::Malformed {
                    place: "header".to_owned(),
                    what: format!("property `{axis}` of element `vertex` is a list"),
                });
            }
            None => {
                return Err(MeshProblem::Missing {
                    what: format!("property `{axis}` of element `vertex` in the header"),
                });
            }
        }
    }
    let face = element("face")?;
    let indices = INDICES.iter().find_map(|&name| face.properties.get(name)).ok_or_else(|| {
        MeshProblem::Missing {
            what: "property `vertex_indices` or `vertex_index` of element `face` in the header"
                .to_owned(),
        }
    })?;
    let floats = [ScalarType::Float, ScalarType::Double];
    match &indices.data_type {
        PropertyType::List(count, index) if !floats.contains(count) && !floats.contains(index) => {}
        _ => {
            return Err(MeshProblem::Malformed {
                place: "header".to_owned(),
                what: format!("property `{}` is not a list of integers", indices.name),
            });
        }
    }
    for (name, element) in &header.elements {
        if element.properties.is_empty() && element.count > 0 {
            return Err(MeshProblem::Missing {
                what: format!("property of element `{name}` in the header"),
            });
        }
        if element.count > bytes {
            return Err(MeshProblem::Truncated {
                what: format!(
                    "the header promises {} of element `{name}`, but {bytes} bytes follow",
                    element.count
                ),
            });
        }
    }
    Ok(())
}

/// What follows the header.
struct Payload<'a> {
    encoding: Encoding,
    rest: &'a [u8],
    line: usize,
}

impl Payload<'_> {
    fn read<E: PropertyAccess>(
        &mut self,
        element: &ElementDef,
        mut take: impl FnMut(E, Option<usize>),
    ) -> Result<(), MeshProblem> {
        let parser = Parser::<E>::new();
        for number in 0..element.count {
            let place = || format!("{} {number}", element.name);
            let truncated = || MeshProblem::Truncated {
                what: format!(
                    "the header promises {} of element `{}`, the file ends at {number}",
                    element.count, element.name
                ),
            };
            match self.encoding {
                Encoding::Ascii => {
                    let content = self.next_line()?.ok_or_else(truncated)?;
                    check_words(element, &content, self.line)?;
                    let value = parser.read_ascii_element(&content, element).map_err(|error| {
                        let what = error.to_string();
                        malformed_line(
                            self.line,
                            format!("{}: {}", place(), what.lines().next().unwrap_or_default()),
                        )
                    })?;
                    take(value, Some(self.line));
                }
                encoding => {
                    let value = if encoding == Encoding::BinaryBigEndian {
                        parser.read_big_endian_element(&mut self.rest, element)
                    } else {
                        parser.read_little_endian_element(&mut self.rest, element)
                    };
                    let value = value.map_err(|error| match error.kind() {
                        std::io::ErrorKind::UnexpectedEof => truncated(),
                        _ => MeshProblem::Malformed { place: place(), what: error.to_string() },
                    })?;
                    take(value, None);
                }
            }
        }
        Ok(())
    }

    /// The next line that is not blank; `None` at the end of the file.
    fn next_line(&mut self) -> Result<Option<String>, MeshProblem> {
        loop {
            let mut content = String::new();
            let read = self
                .rest
                .read_line(&mut content)
                .map_err(|_| malformed_line(self.line + 1, "not text (UTF-8)"))?;
            if read == 0 {
                return Ok(None);
            }
            self.line += 1;
            if !content.trim().is_empty() {
                return Ok(Some(content.trim().to_owned()));
            }
        }
    }
}

/// The library passes over words that nothing asks for, and has no NaN or infinity in its
/// grammar: both are said here, in words of ours.
fn check_words(element: &ElementDef, content: &str, line: usize) -> Result<(), MeshProblem> {
    let mut words = content.split_whitespace();
    let mut next = |name: &str| {
        let word =
            words.next().ok_or_else(|| malformed_line(line, format!("`{name}` is incomplete")))?;
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(word),
            Ok(_) => Err(malformed_line(line, format!("`{name}` is {word}, not finite"))),
            Err(_) => Err(malformed_line(line, format!("`{name}` is `{word}`, not a number"))),
        }
    };
    for (name, property) in &element.properties {
        let count = match property.data_type {
            PropertyType::Scalar(_) => next(name).map(|_| 0)?,
            PropertyType::List(..) => {
                let word = next(name)?;
                word.parse::<usize>().map_err(|_| {
                    malformed_line(line, format!("`{name}` has {word} entries, not a count"))
                })?
            }
        };
        for _ in 0..count {
            next(name)?;
        }
    }
    match words.next() {
        Some(word) => Err(malformed_line(line, format!("`{word}` after the last property"))),
        None => Ok(()),
    }
}

struct PlyVertex {
    at: [f64; 3],
}

impl PropertyAccess for PlyVertex {
    fn new() -> Self {
        Self { at: [0.0; 3] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(axis) = ["x", "y", "z"].iter().position(|&axis| axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        let value = match property {
            Property::Float(x) => x.into(),
            Property::Double(x) => x,
            Property::Char(x) => x.into(),
            Property::UChar(x) => x.into(),
            Property::Short(x) => x.into(),
            Property::UShort(x) => x.into(),
            Property::Int(x) => x.into(),
            Property::UInt(x) => x.into(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        self.at[axis] = value;
        PropertyAccessResult::Set
    }
}

struct PlyFace {
    indices: Vec<i64>,
}

impl PropertyAccess for PlyFace {
    fn new() -> Self {
        Self { indices: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !INDICES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.indices = match property {
            Property::ListChar(list) => widen(list),
            Property::ListUChar(list) => widen(list),
            Property::ListShort(list) => widen(list),
            Property::ListUShort(list) => widen(list),
            Property::ListInt(list) => widen(list),
            Property::ListUInt(list) => widen(list),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

fn widen<T: Into<i64>>(list: Vec<T>) -> Vec<i64> {
    list.into_iter().map(Into::into).collect()
}

/// An element that a mesh has no use for.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
