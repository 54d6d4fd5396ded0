//! Wavefront OBJ.
//!
//! Read here, not by a library: those at hand drop or merge what they do not like, renumber the
//! vertices and keep no line numbers, so that no message could name the place of a mistake.

use std::ops::Range;

use crate::error::{MeshProblem, Place};
use crate::faces::{self, Raw, Vertex, all_finite, vertex_at};
use crate::mesh::Source;
use crate::text::{coordinates, lines, malformed_line, without_comment};

/// An OBJ file: vertices, faces, and which material each is of. Texture coordinates and normals are not
/// looked at before they are asked for, by [`triangles`](ObjFile::triangles).
#[derive(Default)]
pub struct ObjFile<'a> {
    vertices: Vec<Vertex>,
    coordinates: Vec<ObjLine<'a>>,
    normals: Vec<ObjLine<'a>>,
    corners: Vec<Corner<'a>>,
    faces: Vec<ObjFace>,
    materials: Vec<ObjLine<'a>>,
    libraries: Vec<&'a str>,
}

/// What follows the keyword of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjLine<'a> {
    /// Its number, from 1.
    pub number: usize,
    /// The text.
    pub text: &'a str,
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

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
struct Corner<'a> {
    vertex: faces::Corner,
    /// What follows the first slash.
    rest: &'a str,
}

struct ObjFace {
    corners: Range<usize>,
    material: Option<usize>,
    line: usize,
    /// Texture coordinates and normals before it: negative numbers count back from there.
    so_far: [usize; 2],
}

pub(crate) fn parse(bytes: &[u8], source: &mut Source<'_>) -> Result<Raw, MeshProblem> {
    let text = source.reading.decode(bytes)?;
    let file = ObjFile::parse(&text)?;
    let mut raw = Raw { vertices: file.vertices, ..Raw::default() };
    for face in &file.faces {
        let corners = &file.corners[face.corners.clone()];
        raw.push_corners(corners.iter().map(|corner| corner.vertex), Some(face.line));
    }
    Ok(raw)
}

impl<'a> ObjFile<'a> {
    /// Reads a file.
    ///
    /// # Errors
    /// When a vertex or a corner is malformed.
    pub fn parse(text: &'a str) -> Result<Self, MeshProblem> {
        let mut file = Self::default();
        let mut material = None;
        for (line, content) in lines(text) {
            let content = without_comment(content).trim();
            if content.ends_with('\\') {
                return Err(MeshProblem::Unsupported {
                    what: format!("line {line}: continued lines (\\) are"),
                    mend: "re-export the mesh",
                });
            }
            let (keyword, rest) = content.split_once(char::is_whitespace).unwrap_or((content, ""));
            let rest = ObjLine { number: line, text: rest.trim() };
            let mut words = rest.text.split_whitespace();
            match keyword {
                "v" => {
                    let at = coordinates(&mut words, line)?;
                    file.vertices.push(Vertex { at, line: Some(line) });
                }
                "vt" => file.coordinates.push(rest),
                "vn" => file.normals.push(rest),
                "f" => {
                    let first = file.corners.len();
                    for word in words {
                        file.corners.push(corner(word, line, file.vertices.len())?);
                    }
                    let so_far = [file.coordinates.len(), file.normals.len()];
                    let corners = first..file.corners.len();
                    file.faces.push(ObjFace { corners, material, line, so_far });
                }
                "usemtl" => {
                    let is_same = |known: &ObjLine<'_>| known.text == rest.text;
                    material = Some(file.materials.iter().position(is_same).unwrap_or_else(|| {
                        file.materials.push(rest);
                        file.materials.len() - 1
                    }));
                }
                "mtllib" if !file.libraries.contains(&rest.text) => file.libraries.push(rest.text),
                _ => {}
            }
        }
        Ok(file)
    }

    /// The materials in use (`usemtl`), with the line that names each first.
    pub fn materials(&self) -> &[ObjLine<'a>] {
        &self.materials
    }

    /// The material libraries (`mtllib`).
    pub fn libraries(&self) -> &[&'a str] {
        &self.libraries
    }

    /// The triangles with all that their corners have; a face of more corners is a fan of triangles.
    ///
    /// # Errors
    /// When there are none, a face has fewer than three corners or names what there is not, or a number
    /// is not finite.
    pub fn triangles(&self) -> Result<Vec<ObjTriangle>, MeshProblem> {
        all_finite(&self.vertices)?;
        let coordinates: Vec<[f32; 2]> = finite("vt", &self.coordinates)?;
        let normals: Vec<[f32; 3]> = finite("vn", &self.normals)?;
        let mut triangles = Vec::with_capacity(self.faces.len());
        for (number, face) in self.faces.iter().enumerate() {
            let place = Place { number, line: Some(face.line) };
            let corners = &self.corners[face.corners.clone()];
            let read = |corner: &Corner<'_>| -> Result<ObjCorner, MeshProblem> {
                let mut rest = corner.rest.split('/');
                let mut next = |kind| number_in(rest.next().unwrap_or_default(), kind, face.line);
                let (at, normal) = (next("texture coordinates")?, next("normal")?);
                Ok(ObjCorner {
                    position: vertex_at(&self.vertices, corner.vertex, place)?,
                    coordinates: found(&coordinates, at, face.so_far[0], "vt", face.line)?,
                    normal: found(&normals, normal, face.so_far[1], "vn", face.line)?,
                })
            };
            let corners = corners.iter().map(read).collect::<Result<Vec<_>, _>>()?;
            if corners.len() < 3 {
                return Err(MeshProblem::NotATriangle { face: place, corners: corners.len() });
            }
            let material = face.material;
            triangles.extend(
                corners[1..]
                    .windows(2)
                    .map(|pair| ObjTriangle { corners: [corners[0], pair[0], pair[1]], material }),
            );
        }
        if triangles.is_empty() { Err(MeshProblem::Empty) } else { Ok(triangles) }
    }
}

/// Reads the number of a corner's vertex, which counts from 1, or back from the last vertex so far.
fn corner(word: &str, line: usize, so_far: usize) -> Result<Corner<'_>, MeshProblem> {
    let (first, rest) = word.split_once('/').unwrap_or((word, ""));
    let written = first
        .parse()
        .map_err(|_| malformed_line(line, format!("corner `{word}` is not an index")))?;
    let vertex = faces::Corner { vertex: from_zero(written, so_far), written };
    Ok(Corner { vertex, rest })
}

/// A number that counts from 1, or back from the last so far, as one that counts from 0.
fn from_zero(written: i64, so_far: usize) -> i64 {
    let base = if written < 0 { i64::try_from(so_far).unwrap_or(i64::MAX) } else { -1 };
    base.saturating_add(written)
}

/// The number of a corner's texture coordinates or normal, where it has one.
fn number_in(word: &str, kind: &str, line: usize) -> Result<Option<i64>, MeshProblem> {
    if word.is_empty() {
        return Ok(None);
    }
    let number = word.parse();
    number.map(Some).map_err(|_| malformed_line(line, format!("{kind} `{word}` is not an index")))
}

/// What a corner names.
fn found<T: Copy>(
    all: &[T],
    written: Option<i64>,
    so_far: usize,
    keyword: &str,
    line: usize,
) -> Result<Option<T>, MeshProblem> {
    let Some(written) = written else { return Ok(None) };
    let place = usize::try_from(from_zero(written, so_far)).ok();
    let found = place.and_then(|place| all.get(place));
    found.copied().map(Some).ok_or_else(|| {
        let count = all.len();
        malformed_line(line, format!("{keyword} {written} is not there, the file has {count}"))
    })
}

/// The first numbers of each line.
fn finite<const N: usize>(
    keyword: &str,
    lines: &[ObjLine<'_>],
) -> Result<Vec<[f32; N]>, MeshProblem> {
    let numbers = |line: &ObjLine<'_>| {
        let words = line.text.split_whitespace().take(N);
        let numbers: Vec<f32> = words.map_while(|word| word.parse().ok()).collect();
        let numbers = <[f32; N]>::try_from(numbers).ok();
        numbers.filter(|numbers| numbers.iter().all(|x| x.is_finite())).ok_or_else(|| {
            let ObjLine { number, text } = line;
            malformed_line(*number, format!("{keyword}: `{text}` is not {N} finite numbers"))
        })
    };
    lines.iter().map(numbers).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "mtllib a.mtl\nmtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
                        vt 0 0 9\nvt 0.5 1\nvn 0 0 2\nf 1 2 3\nusemtl red glass\n\
                        f 1/1/1 2/-1/1 3//1 -1\nusemtl blue # late\nf 1 2 4\nusemtl red glass\nf 1 3 4\n";

    #[test]
    fn all_that_corners_have_is_read() {
        let file = ObjFile::parse(FILE).expect("it is sound");
        assert_eq!(file.libraries(), ["a.mtl"]);
        let materials =
            [(11, "red glass"), (13, "blue")].map(|(number, text)| ObjLine { number, text });
        assert_eq!(file.materials(), materials);
        let triangles = file.triangles().expect("it is sound");
        let of: Vec<Option<usize>> = triangles.iter().map(|triangle| triangle.material).collect();
        assert_eq!(of, [None, Some(0), Some(0), Some(1), Some(0)]);
        let [a, b, c] = triangles[1].corners;
        assert_eq!((a.position, c.position), ([0.0; 3], [1.0, 1.0, 0.0]));
        assert_eq!((a.coordinates, b.coordinates), (Some([0.0, 0.0]), Some([0.5, 1.0])));
        assert_eq!((c.coordinates, c.normal), (None, Some([0.0, 0.0, 2.0])));
        // The fan goes on from the first corner.
        assert_eq!(triangles[2].corners[..2], [a, c]);
        assert_eq!(triangles[2].corners[2].position, [0.0, 1.0, 0.0]);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (from, to, expected) in [
            ("vt 0.5 1", "vt 0.5", "line 8: vt: `0.5` is not 2 finite numbers; "),
            ("vn 0 0 2", "vn 0 inf 2", "line 9: vn: `0 inf 2` is not 3 finite numbers; "),
            ("2/-1/1", "2/-3/1", "line 12: vt -3 is not there, the file has 2; "),
            ("2/-1/1", "2/0/1", "line 12: vt 0 is not there, the file has 2; "),
            ("2/-1/1", "2/x/1", "line 12: texture coordinates `x` is not an index; "),
            ("3//1", "3//2", "line 12: vn 2 is not there, the file has 1; "),
            ("f 1 2 4", "f 1 2", "face 2 (line 14) has 2 corners; "),
            ("f 1 2 4", "f 1 2 5", "face 2 (line 14): index 5 is out of range, "),
            ("v 1 1 0", "v 1 nan 0", "vertex 2 (line 5): y is NaN; "),
        ] {
            let text = FILE.replacen(from, to, 1);
            assert!(text != FILE, "{from}");
            let file = ObjFile::parse(&text).expect("it is seen later");
            let problem = file.triangles().expect_err(to).to_string();
            assert!(problem.starts_with(expected), "{problem}");
        }
        let empty = ObjFile::parse("v 1 2 3\n").expect("it is sound");
        assert!(matches!(empty.triangles(), Err(MeshProblem::Empty)));
    }
}
