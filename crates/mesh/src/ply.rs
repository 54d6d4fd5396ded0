//! PLY, ascii and binary of either byte order.
//!
//! Read here, not by a library: the one at hand, ply-rs-bw, has a grammar for names and numbers that
//! refuses what common programs write (`1.`, `nan`, names with brackets, CR as the end of a line), and
//! spends most of its time on the names of properties.

use std::ops::Range;

use crate::error::MeshProblem;
use crate::faces::{Raw, Vertex};
use crate::ply_header::{Element, Encoding, Header, Property, Scalar};
use crate::quote::quoted;
use crate::reading::Source;
use crate::text::malformed_line;

/// Lists of more entries are counted before they are read.
const LONG: usize = 1 << 12;

/// The two names that exporters give to the list of a face's vertices.
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

pub(crate) fn parse(bytes: &[u8], source: &mut Source<'_>) -> Result<Raw, MeshProblem> {
    let (header, rest) = Header::read(bytes, source)?;
    check(&header, rest.len())?;
    let count = |name| header.element(name).map_or(0, |element| element.count);
    // A triangle takes four bytes at least.
    let faces = count("face").min(rest.len() / 4);
    let mut raw = Raw::with_capacity(count("vertex"), faces, source.reading)?;
    let rest = match header.encoding {
        Encoding::Ascii => {
            let mut body = Ascii { rest, line: header.lines, words: &[], odd: None };
            read_elements(&header, &mut body, &mut raw, source)?;
            if let Some(line) = body.odd {
                source.reading.tolerate(format!("line {line}"), "an index with a decimal point")?;
            }
            body.rest
        }
        Encoding::LittleEndian => {
            let mut body = Binary::<false> { rest };
            read_elements(&header, &mut body, &mut raw, source)?;
            body.rest
        }
        Encoding::BigEndian => {
            let mut body = Binary::<true> { rest };
            read_elements(&header, &mut body, &mut raw, source)?;
            body.rest
        }
    };
    // More than padding says that the header is wrong, or that bytes were added on the way, as where
    // a binary file was sent as text: what was read before may be wrong too.
    if rest.iter().all(|byte| byte.is_ascii_whitespace() || *byte == 0) {
        Ok(raw)
    } else {
        Err(MeshProblem::Trailing { what: format!("{} bytes", rest.len()) })
    }
}

/// The header must promise a mesh, and no more elements than the file has bytes for.
fn check(header: &Header, bytes: usize) -> Result<(), MeshProblem> {
    let missing = |what: String| MeshProblem::Missing { what };
    let malformed = |what| MeshProblem::Malformed { place: "header".to_owned(), what };
    let element = |name: &str| {
        header.element(name).ok_or_else(|| missing(format!("element `{name}` in the header")))
    };
    let vertex = element("vertex")?;
    for axis in ["x", "y", "z"] {
        match vertex.property(axis) {
            Some(Property { count: None, .. }) => {}
            Some(_) => {
                let what = format!("property `{axis}` of element `vertex` is a list");
                return Err(malformed(what));
            }
            None => {
                let what = format!("property `{axis}` of element `vertex` in the header");
                return Err(missing(what));
            }
        }
    }
    let faces = element("face").or_else(|missing| element("tristrips").map_err(|_| missing))?;
    let indices = indices(faces).ok_or_else(|| {
        missing(format!(
            "property `vertex_indices` or `vertex_index` of element `{}` in the header",
            faces.name
        ))
    })?;
    if indices.count.is_none_or(Scalar::is_float) || indices.scalar.is_float() {
        return Err(malformed(format!("property `{}` is not a list of integers", indices.name)));
    }
    for element in &header.elements {
        if element.properties.is_empty() && element.count > 0 {
            return Err(missing(format!("property of element `{}` in the header", element.name)));
        }
        let least = element.properties.iter().map(|property| header.least(property)).sum();
        if element.count.saturating_mul(least) > bytes.saturating_add(1) {
            return Err(MeshProblem::Truncated {
                what: format!(
                    "the header promises {} of element `{}`, but {bytes} bytes follow",
                    element.count, element.name
                ),
            });
        }
    }
    Ok(())
}

fn indices(element: &Element) -> Option<&Property> {
    INDICES.iter().find_map(|name| element.property(name))
}

/// What is done with the next values of an element.
enum Step<'a> {
    /// These scalars are passed over.
    Skip(&'a [Property]),
    /// A list is passed over.
    SkipList(&'a Property, Scalar),
    /// The coordinate along an axis.
    Axis(usize, &'a Property),
    /// The numbers of vertices.
    Indices(&'a Property, Scalar),
}

fn steps<'a>(element: &'a Element, is_vertex: bool, indices: Option<&Property>) -> Vec<Step<'a>> {
    let mut steps = Vec::new();
    let mut skipped: Range<usize> = 0..0;
    for (number, property) in element.properties.iter().enumerate() {
        let axis = ["x", "y", "z"].iter().position(|axis| is_vertex && property.is_named(axis));
        let step = match (property.count, axis) {
            (Some(count), _) if indices == Some(property) => Step::Indices(property, count),
            (Some(count), _) => Step::SkipList(property, count),
            (None, Some(axis)) => Step::Axis(axis, property),
            (None, None) => {
                skipped.end = number + 1;
                continue;
            }
        };
        steps.extend(Some(Step::Skip(&element.properties[skipped])).filter(Step::is_something));
        steps.push(step);
        skipped = number + 1..number + 1;
    }
    steps.extend(Some(Step::Skip(&element.properties[skipped])).filter(Step::is_something));
    steps
}

impl Step<'_> {
    fn is_something(&self) -> bool {
        !matches!(self, Step::Skip([]))
    }
}

fn read_elements(
    header: &Header,
    body: &mut impl Body,
    raw: &mut Raw,
    source: &mut Source<'_>,
) -> Result<(), MeshProblem> {
    let mut list = Vec::new();
    for element in &header.elements {
        let [is_vertex, is_face, is_strip] =
            ["vertex", "face", "tristrips"].map(|name| element.name.eq_ignore_ascii_case(name));
        let indices = indices(element).filter(|_| is_face || is_strip);
        let steps = steps(element, is_vertex, indices);
        for number in 0..element.count {
            let mut at = [0.0; 3];
            let read = read_one(&steps, body, &mut at, &mut list, source);
            let line = read.map_err(|fault| match fault {
                Fault::End => MeshProblem::Truncated {
                    what: format!(
                        "the header promises {} of element `{}`, the file ends at {number}",
                        element.count, element.name
                    ),
                },
                Fault::Count(name, count) => MeshProblem::Malformed {
                    place: format!("{} {number}", element.name),
                    what: format!("`{name}` has {count} entries"),
                },
                Fault::Is(problem) => problem,
            })?;
            if is_vertex {
                raw.vertices.push(Vertex { at, line });
            } else if is_face {
                raw.push(list.iter().copied(), line);
            } else if is_strip {
                push_strips(raw, &list, line);
            }
            if number.is_multiple_of(1 << 12) {
                raw.claim(source.reading)?;
            }
        }
        raw.claim(source.reading)?;
    }
    Ok(())
}

/// Reads one element, and returns its line where there are lines.
fn read_one(
    steps: &[Step<'_>],
    body: &mut impl Body,
    at: &mut [f64; 3],
    list: &mut Vec<i64>,
    source: &mut Source<'_>,
) -> Result<Option<usize>, Fault> {
    let line = body.begin()?;
    for step in steps {
        match *step {
            Step::Skip(properties) => body.skip(properties)?,
            Step::SkipList(property, count) => {
                let count = body.count(property, count)?;
                body.skip_items(property, count)?;
            }
            Step::Axis(axis, property) => at[axis] = body.number(property)?,
            Step::Indices(property, count) => {
                let count = body.count(property, count)?;
                list.clear();
                if count > LONG {
                    let bytes = (count * size_of::<i64>()) as u64;
                    source.reading.claim(bytes).map_err(|problem| Fault::Is(problem.into()))?;
                }
                body.integers(property, count, list)?;
            }
        }
    }
    body.end()?;
    Ok(line)
}

/// Adds the triangles of strips, which −1 divides. Those that name a vertex twice only turn the strip.
fn push_strips(raw: &mut Raw, list: &[i64], line: Option<usize>) {
    for strip in list.split(|&index| index == -1) {
        for (number, corners) in strip.windows(3).enumerate() {
            let &[a, b, c] = corners else { continue };
            if a != b && b != c && c != a {
                // Every second triangle runs the other way round.
                raw.push(if number.is_multiple_of(2) { [a, b, c] } else { [b, a, c] }, line);
            }
        }
    }
}

/// Why an element cannot be read.
enum Fault {
    /// The file ends before it.
    End,
    /// A list that has so many entries.
    Count(String, i64),
    Is(MeshProblem),
}

/// What follows the header: the values of elements, one after another.
trait Body {
    /// Begins an element, and returns its line where there are lines.
    fn begin(&mut self) -> Result<Option<usize>, Fault>;
    /// Passes over scalars.
    fn skip(&mut self, properties: &[Property]) -> Result<(), Fault>;
    /// A scalar, rounded as its type says.
    fn number(&mut self, property: &Property) -> Result<f64, Fault>;
    /// The length of a list; no more than what follows can hold.
    fn count(&mut self, property: &Property, of: Scalar) -> Result<usize, Fault>;
    /// Passes over the entries of a list.
    fn skip_items(&mut self, property: &Property, count: usize) -> Result<(), Fault>;
    /// The entries of a list of integers.
    fn integers(
        &mut self,
        property: &Property,
        count: usize,
        list: &mut Vec<i64>,
    ) -> Result<(), Fault>;
    /// Ends an element.
    fn end(&mut self) -> Result<(), Fault>;
}

struct Binary<'a, const BIG: bool> {
    rest: &'a [u8],
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    fn take(&mut self, bytes: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self.rest.split_at_checked(bytes).ok_or(Fault::End)?;
        self.rest = rest;
        Ok(taken)
    }
}

/// The number in the bytes of a scalar.
macro_rules! number {
    ($type:ty, $bytes:expr, $big:expr) => {{
        let bytes = $bytes.try_into().unwrap_or_default();
        if $big { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) }
    }};
}

impl<const BIG: bool> Body for Binary<'_, BIG> {
    fn begin(&mut self) -> Result<Option<usize>, Fault> {
        Ok(None)
    }

    fn skip(&mut self, properties: &[Property]) -> Result<(), Fault> {
        self.take(properties.iter().map(|property| property.scalar.size()).sum()).map(drop)
    }

    fn number(&mut self, property: &Property) -> Result<f64, Fault> {
        let bytes = self.take(property.scalar.size())?;
        Ok(match property.scalar {
            Scalar::F32 => number!(f32, bytes, BIG).into(),
            Scalar::F64 => number!(f64, bytes, BIG),
            scalar => integer::<BIG>(scalar, bytes) as f64,
        })
    }

    fn count(&mut self, property: &Property, of: Scalar) -> Result<usize, Fault> {
        let count = integer::<BIG>(of, self.take(of.size())?);
        match usize::try_from(count) {
            Ok(count) if count.saturating_mul(property.scalar.size()) <= self.rest.len() => {
                Ok(count)
            }
            Ok(_) => Err(Fault::End),
            Err(_) => Err(Fault::Count(property.name.clone(), count)),
        }
    }

    fn skip_items(&mut self, property: &Property, count: usize) -> Result<(), Fault> {
        self.take(count.saturating_mul(property.scalar.size())).map(drop)
    }

    fn integers(
        &mut self,
        property: &Property,
        count: usize,
        list: &mut Vec<i64>,
    ) -> Result<(), Fault> {
        let size = property.scalar.size();
        let items = self.take(count.saturating_mul(size))?.chunks_exact(size);
        match property.scalar {
            Scalar::I32 => list.extend(items.map(|item| i64::from(number!(i32, item, BIG)))),
            scalar => list.extend(items.map(|item| integer::<BIG>(scalar, item))),
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Fault> {
        Ok(())
    }
}

/// The integer in the bytes of a scalar that is not a float.
fn integer<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> i64 {
    match scalar {
        Scalar::I8 => number!(i8, bytes, BIG).into(),
        Scalar::U8 => number!(u8, bytes, BIG).into(),
        Scalar::I16 => number!(i16, bytes, BIG).into(),
        Scalar::U16 => number!(u16, bytes, BIG).into(),
        Scalar::I32 => number!(i32, bytes, BIG).into(),
        Scalar::U32 => number!(u32, bytes, BIG).into(),
        Scalar::F32 | Scalar::F64 => 0,
    }
}

/// One element a line.
struct Ascii<'a> {
    rest: &'a [u8],
    line: usize,
    /// What is left of the line.
    words: &'a [u8],
    /// The first line that has an index like `2.0`.
    odd: Option<usize>,
}

impl<'a> Ascii<'a> {
    fn word(&mut self) -> Option<&'a [u8]> {
        let words = self.words.trim_ascii_start();
        let end = words.iter().position(u8::is_ascii_whitespace).unwrap_or(words.len());
        let (word, rest) = words.split_at(end);
        self.words = rest;
        (!word.is_empty()).then_some(word)
    }

    fn value<T: std::str::FromStr>(&mut self, name: &str, kind: &str) -> Result<T, Fault> {
        let word = self.need(name)?;
        let value = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        value.ok_or_else(|| {
            let word = quoted(&String::from_utf8_lossy(word));
            self.fault(&format!("`{name}` is `{word}`, not {kind}"))
        })
    }

    fn need(&mut self, name: &str) -> Result<&'a [u8], Fault> {
        self.word().ok_or_else(|| self.fault(&format!("`{name}` is incomplete")))
    }

    fn fault(&self, what: &str) -> Fault {
        Fault::Is(malformed_line(self.line, what))
    }
}

impl Body for Ascii<'_> {
    fn begin(&mut self) -> Result<Option<usize>, Fault> {
        loop {
            let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
            if line.is_empty() && rest.is_empty() {
                return Err(Fault::End);
            }
            let ending = if rest.starts_with(b"\r\n") { 2 } else { rest.len().min(1) };
            self.rest = &rest[ending..];
            self.line += 1;
            self.words = line;
            if !line.trim_ascii().is_empty() {
                return Ok(Some(self.line));
            }
        }
    }

    fn skip(&mut self, properties: &[Property]) -> Result<(), Fault> {
        properties.iter().try_for_each(|property| self.need(&property.name).map(drop))
    }

    fn number(&mut self, property: &Property) -> Result<f64, Fault> {
        match property.scalar {
            Scalar::F32 => self.value::<f32>(&property.name, "a number").map(f64::from),
            _ => self.value(&property.name, "a number"),
        }
    }

    fn count(&mut self, property: &Property, _: Scalar) -> Result<usize, Fault> {
        let word = self.need(&property.name)?;
        let count = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        // An entry takes a byte and the space before it.
        match count {
            Some(count) if count <= self.words.len() / 2 => Ok(count),
            Some(_) => Err(self.fault(&format!("`{}` is incomplete", property.name))),
            None => {
                let (name, word) = (&property.name, quoted(&String::from_utf8_lossy(word)));
                Err(self.fault(&format!("`{name}` has {word} entries, not a count")))
            }
        }
    }

    fn skip_items(&mut self, property: &Property, count: usize) -> Result<(), Fault> {
        (0..count).try_for_each(|_| self.need(&property.name).map(drop))
    }

    fn integers(
        &mut self,
        property: &Property,
        count: usize,
        list: &mut Vec<i64>,
    ) -> Result<(), Fault> {
        for _ in 0..count {
            let here = self.words;
            let index = self.value(&property.name, "an index").or_else(|fault| {
                // Some programs write integers like `2.0`.
                self.words = here;
                let number: f64 = self.value(&property.name, "a number")?;
                self.odd = self.odd.or(Some(self.line));
                #[allow(clippy::cast_possible_truncation, reason = "whole and small")]
                let whole = (number.fract() == 0.0 && number.abs() < 1e15).then_some(number as i64);
                whole.ok_or(fault)
            })?;
            list.push(index);
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Fault> {
        match self.word() {
            Some(word) => {
                let word = quoted(&String::from_utf8_lossy(word));
                Err(self.fault(&format!("`{word}` after the last property")))
            }
            None => Ok(()),
        }
    }
}
