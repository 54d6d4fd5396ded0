//! Points from files: CSV with the header `x,y,z`, and otherwise as that of [rays](crate::rays).

use std::path::Path;

use trisect_core::Vec3;
use trisect_mesh::{ReadOptions, Reading};

use crate::rays::{RaysError, RaysProblem, Table, parse_table};

/// The table of points.
const POINTS: Table = Table {
    item: "point",
    columns: &["x", "y", "z"],
    finite: 3,
    header: "`x,y,z`",
    bytes: size_of::<Vec3<f32>>() as u64,
};

/// Reads points as CSV, each number rounded once from what the file says; from standard input for `-`.
///
/// # Errors
/// When the file cannot be read or breaks the format's rules; the message names the file, the place in it and
/// what mends it.
pub fn read_points(path: &Path, options: &ReadOptions) -> Result<Vec<Vec3<f32>>, RaysError> {
    let mut reading = Reading::new(options);
    let is_input = path.as_os_str() == "-";
    let bytes = if is_input { reading.stream(std::io::stdin().lock()) } else { reading.file(path) };
    let mut points = vec![];
    let done = bytes.map_err(RaysProblem::from).and_then(|bytes| {
        parse_table(&POINTS, &bytes, &mut reading, &mut |_, [x, y, z, ..], _| {
            points.push(Vec3::new(x, y, z));
        })
    });
    let name = || if is_input { "standard input".into() } else { path.display().to_string() };
    done.map(|()| points).map_err(|problem| RaysError { file: name(), problem })
}
