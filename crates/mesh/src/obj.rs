//! Wavefront OBJ.
//!
//! Read here, not by a library: those at hand drop or merge what they do not like, renumber the
//! vertices and keep no line numbers, so that no message could name the place of a mistake.

use std::borrow::Cow;
use std::collections::HashMap;
use std::iter::Peekable;
use std::num::NonZeroU32;

use crate::error::MeshProblem;
use crate::faces::{Corner, Raw, Vertex};
use crate::quote::quoted;
use crate::reading::Reading;
use crate::reading::Source;
use crate::text::{coordinates, lines, malformed_line, unquoted, without_comment};

/// An OBJ file: its polygons with all that their corners have, and which material each is of.
#[derive(Default)]
pub struct ObjFile {
    raw: Raw,
    coordinates: Vec<Option<[f32; 2]>>,
    normals: Vec<Option<[f32; 3]>>,
    /// The texture coordinates and the normal of each of the raw corners, by their numbers from 1.
    attributes: Vec<[Option<NonZeroU32>; 2]>,
    materials: Vec<ObjLine>,
    /// The faces from which on another material counts.
    material_from: Vec<(usize, usize)>,
    libraries: Vec<ObjLine>,
    /// The places of the materials and of the libraries by their names.
    names: [HashMap<String, usize>; 2],
}

/// What follows the keyword of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjLine {
    /// Its number, from 1.
    pub number: usize,
    /// The text.
    pub text: String,
}

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjCorner {
    /// Where it is.
    pub position: [f64; 3],
    /// Its texture coordinates.
    pub coordinates: Option<[f32; 2]>,
    /// Its normal, of any length.
    pub normal: Option<[f32; 3]>,
}

/// A triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjTriangle {
    /// Its corners.
    pub corners: [ObjCorner; 3],
    /// The place of its material in [`materials`](ObjFile::materials).
    pub material: Option<usize>,
}

pub(crate) fn parse(bytes: &[u8], source: &mut Source<'_>) -> Result<Raw, MeshProblem> {
    let text = source.reading.decode(bytes)?;
    Ok(ObjFile::read(&text, source)?.raw)
}

impl ObjFile {
    /// Reads a file's text; `file` stands for it in messages.
    ///
    /// # Errors
    /// When a vertex or a corner is malformed, and for what the reading refuses.
    pub fn parse(text: &str, file: &str, reading: &mut Reading) -> Result<Self, MeshProblem> {
        Self::read(text, &mut Source { file, folder: None, reading })
    }

    fn read(text: &str, source: &mut Source<'_>) -> Result<Self, MeshProblem> {
        let mut file = Self::default();
        let mut physical = lines(text).peekable();
        while let Some((line, content)) = logical_line(&mut physical) {
            let (keyword, rest) = content.split_once(char::is_whitespace).unwrap_or((&content, ""));
            let keyword = if keyword.bytes().any(|byte| byte.is_ascii_uppercase()) {
                source.reading.tolerate(format!("line {line}"), "a keyword in upper case")?;
                Cow::Owned(keyword.to_ascii_lowercase())
            } else {
                Cow::Borrowed(keyword)
            };
            file.statement(&keyword, rest, line, source)?;
            if line.is_multiple_of(1 << 12) {
                file.raw.claim(source.reading)?;
            }
        }
        file.raw.claim(source.reading)?;
        file.drop_attributes_that_are_not_there(source)?;
        Ok(file)
    }

    fn statement(
        &mut self,
        keyword: &str,
        rest: &str,
        line: usize,
        source: &mut Source<'_>,
    ) -> Result<(), MeshProblem> {
        let place = || format!("line {line}");
        // A number ends where a comment begins, with white space between or not.
        let numbers = rest.split('#').next().unwrap_or_default();
        let name = || ObjLine { number: line, text: unquoted(without_comment(rest)).to_owned() };
        match keyword {
            "v" => {
                let mut words = numbers.split_ascii_whitespace();
                let at = coordinates(&mut words, line)?;
                self.raw.vertices.push(Vertex { at, line: Some(line) });
                if !at.iter().all(|x| x.is_finite()) {
                    // Where no face uses it, it is nothing; where one does, it is an error.
                    source.reading.tolerate(place(), "a coordinate that is not finite")?;
                }
                if let Some(word) = words.next() {
                    after_coordinates(word, words.count(), line, source)?;
                }
            }
            "vt" => {
                let found = texture_coordinates(numbers);
                self.coordinates.push(found);
                if found.is_none() {
                    let what = "texture coordinates that are not finite numbers are left out";
                    source.reading.note(source.file, &place(), what)?;
                }
            }
            "vn" => {
                self.normals.push(finite(numbers));
                if self.normals.last() == Some(&None) {
                    let what = "a normal that is not three finite numbers is left out";
                    source.reading.note(source.file, &place(), what)?;
                }
            }
            "f" | "fo" => self.face(numbers, line, source)?,
            "usemtl" => {
                let material = first_use(&mut self.materials, &mut self.names[0], name());
                self.material_from.push((self.raw.faces.len(), material));
            }
            "mtllib" => {
                first_use(&mut self.libraries, &mut self.names[1], name());
            }
            "" | "#" | "g" | "o" | "s" | "mg" | "vp" | "bevel" | "c_interp" | "d_interp"
            | "lod" | "usemap" | "maplib" | "shadow_obj" | "trace_obj" | "parm" | "trim"
            | "hole" | "scrv" | "sp" | "end" | "con" | "deg" | "cstype" | "bmat" | "step"
            | "ctech" | "stech" | "res" => {}
            _ if keyword.starts_with('#') => {}
            "p" | "l" => {
                let what = "points and lines are left out: no ray can hit them";
                source.reading.remark(source.file, &place(), what);
            }
            "curv" | "curv2" | "surf" | "bsp" | "bzp" | "cdc" | "cdp" => {
                let what = "free-form curves and surfaces are left out; export them as polygons";
                source.reading.remark(source.file, &place(), what);
            }
            "call" | "csh" => {
                let what = "`call` and `csh` are not followed; what they bring is left out";
                source.reading.remark(source.file, &place(), what);
            }
            _ => {
                let what = "a statement that OBJ does not have is left out";
                source.reading.note(
                    source.file,
                    &format!("line {line}: `{}`", quoted(keyword)),
                    what,
                )?;
            }
        }
        Ok(())
    }

    fn face(
        &mut self,
        words: &str,
        line: usize,
        source: &mut Source<'_>,
    ) -> Result<(), MeshProblem> {
        let so_far = [self.raw.vertices.len(), self.coordinates.len(), self.normals.len()];
        let first = self.raw.corners.len();
        for word in words.split_ascii_whitespace() {
            let mut parts = word.split('/');
            let vertex = parts.next().unwrap_or_default().parse();
            let written: i64 = vertex.map_err(|_| {
                malformed_line(line, format!("corner `{}` is not an index", quoted(word)))
            })?;
            let vertex = from_one(written, so_far[0]).saturating_sub(1);
            self.raw.corners.push(Corner { vertex, written });
            let mut attribute = |so_far| match parts.next().unwrap_or_default() {
                "" => None,
                part => {
                    let number = part.parse().map_or(0, |written| from_one(written, so_far));
                    // What is out of range lies beyond the end, and is dropped there.
                    let number = u32::try_from(number).ok().and_then(NonZeroU32::new);
                    Some(number.unwrap_or(NonZeroU32::MAX))
                }
            };
            self.attributes.push([attribute(so_far[1]), attribute(so_far[2])]);
            if parts.next().is_some() {
                let what = "what a corner has after its third number is left out";
                source.reading.note(source.file, &format!("line {line}"), what)?;
            } else if word.ends_with('/') {
                source.reading.tolerate(format!("line {line}"), "a corner that ends with `/`")?;
            }
        }
        self.raw.close_face(first, Some(line));
        Ok(())
    }

    fn drop_attributes_that_are_not_there(
        &mut self,
        source: &mut Source<'_>,
    ) -> Result<(), MeshProblem> {
        let counts = [self.coordinates.len(), self.normals.len()];
        for face in &self.raw.faces {
            for attributes in &mut self.attributes[face.corners.clone()] {
                for (attribute, count) in attributes.iter_mut().zip(counts) {
                    if attribute.is_some_and(|number| number.get() as usize > count) {
                        *attribute = None;
                        let place = format!("line {}", face.line.unwrap_or_default());
                        let what = "texture coordinates and normals that the file does not have are \
                                    left out";
                        source.reading.note(source.file, &place, what)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The materials in use (`usemtl`), with the line that names each first.
    pub fn materials(&self) -> &[ObjLine] {
        &self.materials
    }

    /// The material libraries (`mtllib`), as the lines have them.
    pub fn libraries(&self) -> &[ObjLine] {
        &self.libraries
    }

    /// The triangles with all that their corners have, in the order of the faces.
    ///
    /// # Errors
    /// When there are none, or a face names a vertex that there is not or that is not finite.
    pub fn triangles(
        &self,
        file: &str,
        reading: &mut Reading,
    ) -> Result<Vec<ObjTriangle>, MeshProblem> {
        let count = self.raw.corners.len().saturating_sub(2 * self.raw.faces.len());
        reading.claim((count * size_of::<ObjTriangle>()) as u64)?;
        let mut triangles = Vec::with_capacity(count);
        let mut materials = self.material_from.iter().peekable();
        let mut material = None;
        let mut source = Source { file, folder: None, reading };
        self.raw.each_triangle(&mut source, |face, positions, places| {
            while let Some((_, next)) = materials.next_if(|(from, _)| *from <= face) {
                material = Some(*next);
            }
            let corner = |i: usize| {
                let [coordinates, normal] = self.attributes[places[i]];
                let place = |number: NonZeroU32| number.get() as usize - 1;
                ObjCorner {
                    position: positions[i],
                    coordinates: coordinates.and_then(|number| self.coordinates[place(number)]),
                    normal: normal.and_then(|number| self.normals[place(number)]),
                }
            };
            triangles.push(ObjTriangle { corners: [corner(0), corner(1), corner(2)], material });
        })?;
        if triangles.is_empty() { Err(MeshProblem::Empty) } else { Ok(triangles) }
    }
}

/// The next line, with those that continue it: a line that ends with `\`, and not in a comment, goes on
/// with the next. A name may end with it (a folder of Windows): after a name white space must precede.
fn logical_line<'a>(
    lines: &mut Peekable<impl Iterator<Item = (usize, &'a str)>>,
) -> Option<(usize, Cow<'a, str>)> {
    let (number, line) = lines.next()?;
    let line = line.trim();
    let Some(head) = continued(line) else { return Some((number, Cow::Borrowed(line))) };
    let is_name = ["o", "g", "usemtl", "mtllib", "usemap", "maplib"]
        .contains(&line.split_whitespace().next().unwrap_or_default());
    if is_name && !head.ends_with(char::is_whitespace) {
        return Some((number, Cow::Borrowed(line)));
    }
    let mut whole = head.to_owned();
    for (_, next) in lines.by_ref() {
        let next = next.trim_end();
        // A break stands between words, or beside a slash inside of a corner.
        if !whole.ends_with('/') && !next.starts_with('/') {
            whole.push(' ');
        }
        let head = continued(next);
        whole.push_str(head.unwrap_or(next));
        if head.is_none() {
            break;
        }
    }
    Some((number, Cow::Owned(whole)))
}

fn continued(line: &str) -> Option<&str> {
    let head = line.strip_suffix('\\')?;
    (without_comment(head).len() == head.len()).then_some(head)
}

/// The place of a name among those that were used before; a new one becomes the last.
fn first_use(used: &mut Vec<ObjLine>, places: &mut HashMap<String, usize>, name: ObjLine) -> usize {
    *places.entry(name.text.clone()).or_insert_with(|| {
        used.push(name);
        used.len() - 1
    })
}

/// What stands after a vertex's coordinates: a weight, or a colour.
fn after_coordinates(
    word: &str,
    more: usize,
    line: usize,
    source: &mut Source<'_>,
) -> Result<(), MeshProblem> {
    let place = format!("line {line}");
    match (word.parse::<f64>(), more) {
        (Ok(1.0), 0) => {}
        (Ok(_), 0) => {
            let what = "a vertex's weight is left out: it is for free-form curves and surfaces";
            source.reading.remark(source.file, &place, what);
        }
        (Ok(_), 2 | 3) => {
            source.reading.note(source.file, &place, "a vertex's colour is left out")?;
        }
        _ => {
            let what = "what a vertex has after its coordinates is left out";
            source.reading.note(source.file, &place, what)?;
        }
    }
    Ok(())
}

/// A number that counts from 1, or back from the last so far, as one that counts from 1; 0 and less where
/// there is none.
fn from_one(written: i64, so_far: usize) -> i64 {
    let base = i64::try_from(so_far).unwrap_or(i64::MAX);
    if written < 0 { base.saturating_add(written).saturating_add(1) } else { written }
}

/// With one number alone the texture is a line, and v is 0; a third is for textures in space.
fn texture_coordinates(words: &str) -> Option<[f32; 2]> {
    let [u] = finite(words)?;
    let has_v = words.split_ascii_whitespace().nth(1).is_some();
    if has_v { finite(words) } else { Some([u, 0.0]) }
}

/// The first numbers, where there are so many and they are finite.
fn finite<const N: usize>(words: &str) -> Option<[f32; N]> {
    let mut words = words.split_ascii_whitespace();
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|x: &f32| x.is_finite())?;
    }
    Some(numbers)
}
