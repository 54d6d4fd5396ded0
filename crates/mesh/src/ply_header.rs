//! The header of a PLY file: which elements follow, of which properties, in which encoding.

use crate::error::MeshProblem;
use crate::quote::quoted;
use crate::reading::Source;
use crate::text::utf8_mark;

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

pub(crate) struct Header {
    pub(crate) encoding: Encoding,
    pub(crate) elements: Vec<Element>,
    /// How many lines it has.
    pub(crate) lines: usize,
}

pub(crate) struct Element {
    /// As messages quote it.
    pub(crate) name: String,
    pub(crate) count: usize,
    pub(crate) properties: Vec<Property>,
}

#[derive(PartialEq)]
pub(crate) struct Property {
    /// As messages quote it.
    pub(crate) name: String,
    /// Where it is a list, the type of the number that says how long it is.
    pub(crate) count: Option<Scalar>,
    /// The type of the value, or of those in the list.
    pub(crate) scalar: Scalar,
}

#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// The elements that are read.
const READ_ELEMENTS: [&str; 3] = ["vertex", "face", "tristrips"];
/// The properties of them that are read.
const READ_PROPERTIES: [&str; 5] = ["x", "y", "z", "vertex_indices", "vertex_index"];

fn is_one_of(name: &str, names: &[&str]) -> bool {
    names.iter().any(|known| known.eq_ignore_ascii_case(name))
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(crate) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

impl Property {
    pub(crate) fn is_named(&self, name: &str) -> bool {
        self.name.eq_ignore_ascii_case(name)
    }
}

impl Element {
    /// The property of that name, in either case.
    pub(crate) fn property(&self, name: &str) -> Option<&Property> {
        self.properties.iter().find(|property| property.is_named(name))
    }
}

impl Header {
    /// The element of that name, in either case.
    pub(crate) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name.eq_ignore_ascii_case(name))
    }

    /// The fewest bytes that a value of a property takes: a list may be empty, and a word is followed by
    /// white space.
    pub(crate) fn least(&self, property: &Property) -> usize {
        match self.encoding {
            Encoding::Ascii => 2,
            _ => property.count.unwrap_or(property.scalar).size(),
        }
    }

    /// Reads a header, and returns it with what follows it.
    pub(crate) fn read<'a>(
        bytes: &'a [u8],
        source: &mut Source<'_>,
    ) -> Result<(Self, &'a [u8]), MeshProblem> {
        let mark = utf8_mark(bytes);
        if mark > 0 {
            source.reading.tolerate("header", "a byte order mark")?;
        }
        let mut rest = &bytes[mark..];
        let mut ends_with_cr = false;
        let mut encoding = None;
        let mut header = Self { encoding: Encoding::Ascii, elements: Vec::new(), lines: 0 };
        let truncated =
            || MeshProblem::Truncated { what: "the header has no `end_header`".to_owned() };
        loop {
            let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let (line, after) = rest.split_at(end.unwrap_or(rest.len()));
            if header.lines == 0 {
                ends_with_cr = after.starts_with(b"\r") && !after.starts_with(b"\r\n");
            }
            // Where lines end with CR alone, LF is the first byte of what follows.
            let ending = if after.starts_with(b"\r\n") && !ends_with_cr { 2 } else { 1 };
            rest = after.get(ending..).unwrap_or_default();
            header.lines += 1;
            let line = String::from_utf8_lossy(line);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let keyword = words.first().copied().unwrap_or_default();
            let place = format!("line {}", header.lines);
            let fault = |what: String| MeshProblem::Malformed { place: place.clone(), what };
            if header.lines == 1 {
                match keyword {
                    "ply" if words.len() == 1 => {}
                    _ if end.is_none() && bytes.is_empty() => return Err(truncated()),
                    _ if keyword.eq_ignore_ascii_case("ply") && words.len() == 1 => {
                        source.reading.tolerate(&place, "`ply` in upper case")?;
                    }
                    _ => {
                        return Err(fault(
                            "it is not `ply`, with which a PLY file begins".to_owned(),
                        ));
                    }
                }
                continue;
            }
            let lower = keyword.to_ascii_lowercase();
            match (lower.as_str(), &words[1.min(words.len())..]) {
                ("end_header", _) => break,
                ("comment" | "obj_info", _) => {}
                ("", _) if after.is_empty() => return Err(truncated()),
                ("", _) => source.reading.tolerate(&place, "a blank line in the header")?,
                ("format", [name, version @ ..]) if encoding.is_none() => {
                    encoding = Some(match name.to_ascii_lowercase().as_str() {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => {
                            return Err(fault(format!("`{}` is no encoding of PLY", quoted(name))));
                        }
                    });
                    if *version != ["1.0"] {
                        source.reading.tolerate(&place, "a version other than 1.0")?;
                    }
                }
                ("element", [name, count]) => {
                    let count = count.parse();
                    let count = count
                        .map_err(|_| fault(format!("`{}` has no sound count", quoted(&line))))?;
                    let name = quoted(name);
                    // Of those that nobody reads any number may be there.
                    if is_one_of(&name, &READ_ELEMENTS) && header.element(&name).is_some() {
                        return Err(fault(format!("element `{name}` is there twice")));
                    }
                    header.elements.push(Element { name, count, properties: Vec::new() });
                }
                ("property", words) => {
                    let property = property(words).ok_or_else(|| {
                        fault(format!("`{}` is no sound property", quoted(&line)))
                    })?;
                    let element = header.elements.last_mut();
                    let element =
                        element.ok_or_else(|| fault("a property before any element".to_owned()))?;
                    let name = &property.name;
                    if is_one_of(name, &READ_PROPERTIES) && element.property(name).is_some() {
                        return Err(fault(format!("property `{name}` is there twice")));
                    }
                    element.properties.push(property);
                }
                // A statement that is misspelt must not pass for a remark: what follows would be read
                // wrongly.
                (_, words) if is_declaration(&lower, words) => {
                    return Err(fault(format!("`{}` is no sound statement", quoted(&line))));
                }
                _ => {
                    let what = "a line of the header that is no statement is taken as a comment";
                    source.reading.note(source.file, &place, what)?;
                }
            }
            if lower != keyword {
                source.reading.tolerate(&place, "a keyword in upper case")?;
            }
        }
        header.encoding = encoding
            .ok_or_else(|| MeshProblem::Missing { what: "format in the header".to_owned() })?;
        Ok((header, rest))
    }
}

/// What follows `property`: a type and a name, which some programs write with spaces.
fn property(words: &[&str]) -> Option<Property> {
    let (count, words) = match words {
        [list, count, words @ ..] if list.eq_ignore_ascii_case("list") => {
            (Some(Scalar::named(count)?), words)
        }
        words => (None, words),
    };
    let [scalar, name @ ..] = words else { return None };
    let property =
        Property { name: quoted(&name.join(" ")), count, scalar: Scalar::named(scalar)? };
    (!name.is_empty() && count.is_none_or(|count| !count.is_float())).then_some(property)
}

fn is_declaration(keyword: &str, words: &[&str]) -> bool {
    let is_type = |word: &&str| Scalar::named(word).is_some() || word.eq_ignore_ascii_case("list");
    let has_count = words.len() == 2 && words[1].parse::<i64>().is_ok();
    matches!(keyword, "element" | "property" | "format")
        || words.first().is_some_and(is_type)
        || has_count
}
