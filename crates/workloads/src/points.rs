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
    bytes: (size_of::<Vec3<f64>>() + size_of::<Vec3<f32>>()) as u64,
};

/// Points in both precisions, each rounded once from what the file says.
#[derive(Clone, Debug, Default)]
pub struct PointsFile {
    /// The points in f64.
    pub points: Vec<Vec3<f64>>,
    /// The same points in f32.
    pub points_f32: Vec<Vec3<f32>>,
}

/// Reads points as CSV; from standard input for `-`.
///
/// # Errors
/// When the file cannot be read or breaks the format's rules; the message names the file, the place in it and
/// what mends it.
pub fn read_points(path: &Path, options: &ReadOptions) -> Result<PointsFile, RaysError> {
    let mut reading = Reading::new(options);
    let is_input = path.as_os_str() == "-";
    let bytes = if is_input { reading.stream(std::io::stdin().lock()) } else { reading.file(path) };
    let mut file = PointsFile::default();
    let done = bytes.map_err(RaysProblem::from).and_then(|bytes| {
        parse_table(&POINTS, &bytes, &mut reading, &mut |wide, narrow, _| {
            let [x, y, z, ..] = wide;
            file.points.push(Vec3::new(x, y, z));
            let [x, y, z, ..] = narrow;
            file.points_f32.push(Vec3::new(x, y, z));
        })
    });
    let name = || if is_input { "standard input".into() } else { path.display().to_string() };
    done.map(|()| file).map_err(|problem| RaysError { file: name(), problem })
}
