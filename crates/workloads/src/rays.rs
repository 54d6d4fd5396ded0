//! Rays from and to files: CSV with a header, and a binary format of eight f32 per ray.
//!
//! CSV: the header `ox,oy,oz,dx,dy,dz`, optionally followed by `tmin`, `tmax` or both in this
//! order; one ray a line, and comments on lines that begin with `#`. Left out, `tmin` is 0 and `tmax`
//! infinite (`inf`). Lines end with LF, CR LF or CR; a byte order mark is passed over. Binary (`.rays`),
//! all little-endian: the number of rays as u32, then for each ray
//! `ox oy oz tmin dx dy dz tmax` as f32.
//!
//! Origins and directions must be finite in f32; a direction of zero is accepted (it never
//! hits). `tmin` and `tmax` may be infinite. No file may hold NaN. No rays at all are accepted.

use std::borrow::Cow;
use std::io::{Read, Write};
use std::path::Path;

use trisect_core::{Ray, Vec3};
use trisect_mesh::{ReadOptions, ReadProblem, Reading, cut, quoted, unquoted};

/// Rays in both precisions, each rounded once from what the file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RaysFile {
    /// The rays in f64.
    pub rays: Vec<Ray<f64>>,
    /// The same rays in f32. From CSV they are parsed from the text, not rounded from f64: two
    /// roundings may differ from one in the last bit.
    pub rays_f32: Vec<Ray<f32>>,
}

/// What is wrong with a file of rays, and with which.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {problem}")]
pub struct RaysError {
    /// The file as it was named by the caller.
    pub file: String,
    /// What is wrong, where, and what mends it. Not a `source`: the message holds it already.
    pub problem: RaysProblem,
}

/// What is wrong with a file of rays. The text of each says where, and what mends it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RaysProblem {
    /// The file, or something in it, is not read.
    #[error("{0}")]
    Unread(#[from] ReadProblem),
    /// The file could not be written.
    #[error("cannot be written ({0}); check the path")]
    Unwritable(#[from] std::io::Error),
    /// The ending of the file's name is not known.
    #[error("unknown file type; known are .csv and .rays")]
    UnknownType,
    /// A line is not CSV.
    #[error("line {line}: {what}; write one {item} of comma-separated numbers a line")]
    Malformed {
        /// What a line is.
        item: &'static str,
        /// The line, from 1.
        line: u64,
        /// What is wrong there.
        what: String,
    },
    /// The first line does not name the columns.
    #[error("line 1: the header is `{found}`; write {wanted}")]
    Header {
        /// The header of the file.
        found: String,
        /// What it may be.
        wanted: &'static str,
    },
    /// A line has too few or too many fields.
    #[error("line {line}: {found} fields, the header names {expected}; write one for each column")]
    Fields {
        /// The line, from 1.
        line: u64,
        /// Fields in this line.
        found: usize,
        /// Columns in the header.
        expected: usize,
    },
    /// A field is not a number, or not one that is allowed there.
    #[error("{place}, {field}: {what}; write a {wanted}")]
    Value {
        /// The line (from 1) of text, the ray (from 0) of a binary file.
        place: String,
        /// The column.
        field: &'static str,
        /// What stands there, with its verb.
        what: String,
        /// What may stand there.
        wanted: &'static str,
    },
    /// A binary file is shorter or longer than its count of rays says.
    #[error(
        "{rays} rays need {expected} bytes, the file has {actual}; copy or write the file again"
    )]
    Length {
        /// The count at the head of the file; 0 where even that is cut off.
        rays: u32,
        /// Bytes that this takes.
        expected: u64,
        /// Bytes of the file.
        actual: u64,
    },
    /// More rays than the binary format can count.
    #[error("{0} rays are more than the format's 4,294,967,295; write several files")]
    TooMany(usize),
}

/// A table of numbers.
pub(crate) struct Table {
    /// What a line is.
    pub(crate) item: &'static str,
    /// The columns, in the order of the CSV.
    pub(crate) columns: &'static [&'static str],
    /// So many of them must be there, and their numbers be finite.
    pub(crate) finite: usize,
    /// What the header may be.
    pub(crate) header: &'static str,
    /// Bytes of an item in memory.
    pub(crate) bytes: u64,
}

/// The table of rays.
const RAYS: Table = Table {
    item: "ray",
    columns: &["ox", "oy", "oz", "dx", "dy", "dz", "tmin", "tmax"],
    finite: 6,
    header: "`ox,oy,oz,dx,dy,dz`, and `tmin`, `tmax` after it where they are wanted",
    bytes: (size_of::<Ray<f64>>() + size_of::<Ray<f32>>()) as u64,
};
/// The most columns of a table.
const MOST: usize = 8;
/// The columns' numbers, in the order of the binary format.
const BINARY_ORDER: [usize; 8] = [0, 1, 2, 6, 3, 4, 5, 7];
/// Bytes of a ray in the binary format.
const RECORD: usize = 32;

/// Reads rays; the ending of the file's name (`.csv` or `.rays`) says in which format.
///
/// # Errors
/// When the file cannot be read or breaks the format's rules; the message names the file, the
/// place in it and what mends it.
pub fn read_rays(path: impl AsRef<Path>) -> Result<RaysFile, RaysError> {
    read_rays_with(path, &ReadOptions::default())
}

/// The same, read as the options say.
///
/// # Errors
/// As [`read_rays`], and for what the options refuse.
pub fn read_rays_with(
    path: impl AsRef<Path>,
    options: &ReadOptions,
) -> Result<RaysFile, RaysError> {
    let path = path.as_ref();
    let fail = |problem| RaysError { file: path.display().to_string(), problem };
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let parse = match ending.to_ascii_lowercase().as_str() {
        "csv" => parse_csv,
        "rays" => parse_binary,
        _ => return Err(fail(RaysProblem::UnknownType)),
    };
    let mut reading = Reading::new(options);
    let bytes = reading.file(path).map_err(|problem| fail(problem.into()))?;
    parse(&bytes, &mut reading).map_err(fail)
}

/// Reads rays as CSV, from standard input too. `name` stands for the file in messages.
///
/// # Errors
/// As [`read_rays`].
pub fn read_rays_csv(name: &str, reader: impl Read) -> Result<RaysFile, RaysError> {
    read_rays_csv_with(name, reader, &ReadOptions::default())
}

/// The same, read as the options say.
///
/// # Errors
/// As [`read_rays_with`].
pub fn read_rays_csv_with(
    name: &str,
    reader: impl Read,
    options: &ReadOptions,
) -> Result<RaysFile, RaysError> {
    let mut reading = Reading::new(options);
    let bytes = reading.stream(reader).map_err(RaysProblem::from);
    bytes
        .and_then(|bytes| parse_csv(&bytes, &mut reading))
        .map_err(|problem| RaysError { file: name.to_owned(), problem })
}

fn parse_csv(bytes: &[u8], reading: &mut Reading) -> Result<RaysFile, RaysProblem> {
    let mut file = RaysFile::default();
    parse_table(&RAYS, bytes, reading, &mut |mut wide, mut narrow, named| {
        // Left out.
        if !named.contains(&7) {
            (wide[7], narrow[7]) = (f64::INFINITY, f32::INFINITY);
        }
        file.rays.push(ray(wide));
        file.rays_f32.push(ray(narrow));
    })?;
    Ok(file)
}

/// Takes the numbers of a line in both precisions, and the columns that are named: the others are zero.
type Row<'a> = &'a mut dyn FnMut([f64; MOST], [f32; MOST], &[usize]);

pub(crate) fn parse_table(
    table: &Table,
    bytes: &[u8],
    reading: &mut Reading,
    row: Row<'_>,
) -> Result<(), RaysProblem> {
    let mut text = reading.decode(bytes)?;
    // The lines that the library counts end with LF.
    if text.contains('\r') && !text.contains('\n') {
        text = Cow::Owned(text.replace('\r', "\n"));
    }
    let mut csv = csv::ReaderBuilder::new()
        .has_headers(false)
        // The lengths are checked here, so that the message can count.
        .flexible(true)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let mut record = csv::StringRecord::new();
    let csv_problem = |error| csv_problem(table.item, error);
    // The library leaves quotation marks that follow a space.
    let header = if csv.read_record(&mut record).map_err(csv_problem)? {
        record.iter().map(|name| unquoted(name).to_owned()).collect()
    } else {
        Vec::new()
    };
    let slots: Vec<usize> = header
        .iter()
        .filter_map(|name| table.columns.iter().position(|column| column == name))
        .collect();
    let ordered = slots.len() == header.len() && slots.windows(2).all(|pair| pair[0] < pair[1]);
    if !ordered || !(0..table.finite).all(|column| slots.contains(&column)) {
        return Err(RaysProblem::Header { found: quoted(&header.join(",")), wanted: table.header });
    }
    while csv.read_record(&mut record).map_err(csv_problem)? {
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() != slots.len() {
            let (found, expected) = (record.len(), slots.len());
            return Err(RaysProblem::Fields { line, found, expected });
        }
        let (mut wide, mut narrow) = ([0.0; MOST], [0.0; MOST]);
        for (&slot, text) in slots.iter().zip(record.iter().map(unquoted)) {
            let place = || format!("line {line}");
            (wide[slot], narrow[slot]) =
                text.parse().ok().zip(text.parse().ok()).ok_or_else(|| {
                    table.problem(place(), slot, format!("`{}` is not a number", quoted(text)))
                })?;
            table.check(slot, narrow[slot], place, || format!("`{}`", quoted(text)))?;
        }
        reading.claim(table.bytes)?;
        row(wide, narrow, &slots);
    }
    Ok(())
}

fn csv_problem(item: &'static str, error: csv::Error) -> RaysProblem {
    let line = error.position().map_or(0, csv::Position::line);
    let what = cut(&error.to_string(), 200);
    match error.into_kind() {
        csv::ErrorKind::Io(error) => ReadProblem::Unreadable(error).into(),
        _ => RaysProblem::Malformed { item, line, what },
    }
}

/// Reads rays in the binary format from memory. `name` stands for the file in messages. The f64
/// rays are exactly the f32 ones.
///
/// # Errors
/// As [`read_rays`].
pub fn read_rays_binary(name: &str, bytes: &[u8]) -> Result<RaysFile, RaysError> {
    let mut reading = Reading::new(&ReadOptions::default());
    parse_binary(bytes, &mut reading)
        .map_err(|problem| RaysError { file: name.to_owned(), problem })
}

fn parse_binary(bytes: &[u8], reading: &mut Reading) -> Result<RaysFile, RaysProblem> {
    let (rays, body) = bytes
        .split_first_chunk()
        .map_or((0, &[][..]), |(count, body)| (u32::from_le_bytes(*count), body));
    let expected = 4 + RECORD as u64 * u64::from(rays);
    let actual = bytes.len() as u64;
    if expected != actual {
        return Err(RaysProblem::Length { rays, expected, actual });
    }
    reading.claim(RAYS.bytes * u64::from(rays))?;
    let mut file = RaysFile::default();
    for (number, record) in body.chunks_exact(RECORD).enumerate() {
        let mut values = [0.0; 8];
        for (word, slot) in record.chunks_exact(4).zip(BINARY_ORDER) {
            let value = f32::from_le_bytes([word[0], word[1], word[2], word[3]]);
            RAYS.check(slot, value, || format!("ray {number}"), || value.to_string())?;
            values[slot] = value;
        }
        file.rays_f32.push(ray(values));
    }
    file.rays = file.rays_f32.iter().map(|&ray| ray.into()).collect();
    Ok(file)
}

fn ray<X>([ox, oy, oz, dx, dy, dz, tmin, tmax]: [X; 8]) -> Ray<X> {
    Ray { o: Vec3::new(ox, oy, oz), d: Vec3::new(dx, dy, dz), tmin, tmax }
}

impl Table {
    /// What may stand in a column: a finite f32, or anything but NaN where it need not be finite.
    fn check(
        &self,
        slot: usize,
        value: f32,
        place: impl Fn() -> String,
        shown: impl Fn() -> String,
    ) -> Result<(), RaysProblem> {
        let allowed = if slot < self.finite { value.is_finite() } else { !value.is_nan() };
        if allowed {
            return Ok(());
        }
        let what = if value.is_nan() { "is not a number" } else { "is not finite in f32" };
        Err(self.problem(place(), slot, format!("{} {what}", shown())))
    }

    fn problem(&self, place: String, slot: usize, what: String) -> RaysProblem {
        let is_finite = slot < self.finite;
        let wanted = if is_finite { "finite decimal number" } else { "decimal number or `inf`" };
        RaysProblem::Value { place, field: self.columns[slot], what, wanted }
    }
}

fn values<X: Copy>(ray: &Ray<X>) -> [X; 8] {
    [ray.o.x, ray.o.y, ray.o.z, ray.d.x, ray.d.y, ray.d.z, ray.tmin, ray.tmax]
}

/// Writes rays as CSV with all eight columns, in the shortest decimals that read back as the
/// same f64 bits (and, where the rays came from f32, as the same f32 bits).
///
/// # Errors
/// When the writer fails.
pub fn write_rays_csv(mut writer: impl Write, rays: &[Ray<f64>]) -> std::io::Result<()> {
    writeln!(writer, "{}", RAYS.columns.join(","))?;
    for ray in rays {
        let row = values(ray).map(|value| format!("{value:?}"));
        writeln!(writer, "{}", row.join(","))?;
    }
    writer.flush()
}

/// Writes rays in the binary format.
///
/// # Errors
/// When the writer fails, or there are more than `u32::MAX` rays.
pub fn write_rays_binary(mut writer: impl Write, rays: &[Ray<f32>]) -> Result<(), RaysProblem> {
    let count = u32::try_from(rays.len()).map_err(|_| RaysProblem::TooMany(rays.len()))?;
    writer.write_all(&count.to_le_bytes())?;
    for ray in rays {
        let values = values(ray);
        for slot in BINARY_ORDER {
            writer.write_all(&values[slot].to_le_bytes())?;
        }
    }
    writer.flush()?;
    Ok(())
}
