//! Where casting becomes quicker than rasterising.

use serde::Serialize;
use trisect_report::stats::median_interval;

use super::record::{Built, Seen, Series};
use crate::record::Records;
use crate::timing::middle;

/// The pictures that a tree is built for.
const PICTURES: [u32; 3] = [1, 10, 100];

/// Where the times of the two roads are the same, for pictures of one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Crossing {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Pictures that share a tree; none where it is there already.
    pub pictures: Option<u32>,
    /// What is cast through.
    pub way: String,
    /// Below so many triangles rasterising is quicker, above casting is: the number and its interval, in which
    /// the 95 % intervals of both times overlap. None where one road is quicker at all sizes of meshes.
    pub triangles: Option<[f64; 3]>,
    /// Casting's time over the rasteriser's, for the smallest and the largest mesh.
    pub ratios: [f64; 2],
}

/// The times of a mesh's pictures, low, middle and high.
struct Times {
    triangles: f64,
    cast: [f64; 3],
    raster: [f64; 3],
}

impl Times {
    /// The logarithm of casting's time over the rasteriser's: at least, in the middle, at most.
    fn logarithms(&self) -> [f64; 3] {
        let of = |cast: usize, raster: usize| (self.cast[cast] / self.raster[raster]).ln();
        [of(0, 2), of(1, 1), of(2, 0)]
    }
}

fn interval(samples_ns: &[u64]) -> Option<[f64; 3]> {
    let samples: Vec<f64> = samples_ns.iter().map(|&ns| ns as f64).collect();
    median_interval(&samples)
}

/// Where lines between points of logarithms pass zero, from above; at the ends of the meshes if they do not.
fn passes(points: &[(f64, f64)]) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        (y0 > 0.0 && y1 <= 0.0).then(|| (x0.ln() + (x1 / x0).ln() * y0 / (y0 - y1)).exp())
    })
}

/// All crossings of a record, size by size.
pub(super) fn crossings(records: &Records) -> Vec<Crossing> {
    let seen: Vec<&Seen> =
        records.all().filter(|seen: &&Seen| seen.series == Series::Visibility).collect();
    let mut sizes: Vec<[u32; 2]> = Vec::new();
    for size in seen.iter().map(|seen| [seen.width, seen.height]) {
        if !sizes.contains(&size) {
            sizes.push(size);
        }
    }
    let mut all = Vec::new();
    for size in sizes {
        let choices = [None].into_iter().chain(PICTURES.map(Some));
        all.extend(choices.filter_map(|pictures| crossing(records, &seen, size, pictures)));
    }
    all
}

fn crossing(
    records: &Records,
    seen: &[&Seen],
    size: [u32; 2],
    pictures: Option<u32>,
) -> Option<Crossing> {
    // For one picture the tree that is built most quickly.
    let (way, tree) =
        if pictures == Some(1) { ("cast, linear", "linear") } else { ("cast, packets", "spatial") };
    let mine = |way: &str, of: &Seen| of.way == way && [of.width, of.height] == size;
    let mut times: Vec<Times> = seen
        .iter()
        .filter(|of| mine(way, of))
        .filter_map(|cast| {
            let raster = seen.iter().find(|of| {
                mine("rasterised, filtered", of)
                    && of.scene == cast.scene
                    && of.triangles == cast.triangles
            })?;
            let built = |what: &str| {
                records
                    .all()
                    .find(|built: &&Built| built.what == what && built.triangles == cast.triangles)
                    .map_or(0.0, |built| middle(&built.samples_ns))
            };
            let share = pictures.map_or(0.0, |pictures| 1.0 / f64::from(pictures));
            let with = |samples: [f64; 3], what: &str| samples.map(|ns| ns + share * built(what));
            Some(Times {
                triangles: cast.triangles as f64,
                cast: with(interval(&cast.samples_ns)?, tree),
                raster: with(interval(&raster.samples_ns)?, "blocks"),
            })
        })
        .collect();
    times.sort_by(|a, b| a.triangles.total_cmp(&b.triangles));
    let ratio = |times: &Times| times.cast[1] / times.raster[1];
    let (first, last) = (times.first()?, times.last()?);
    let line = |which: usize| -> Vec<(f64, f64)> {
        times.iter().map(|of| (of.triangles, of.logarithms()[which])).collect()
    };
    // The line from above zero to below.
    let triangles = passes(&line(1)).map(|at| {
        [
            passes(&line(0)).unwrap_or(first.triangles).min(at),
            at,
            passes(&line(2)).unwrap_or(last.triangles).max(at),
        ]
    });
    Some(Crossing {
        size,
        pictures,
        way: way.to_owned(),
        triangles,
        ratios: [ratio(first), ratio(last)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_pass_zero_between_points() {
        assert_eq!(passes(&[(10.0, 1.0), (1000.0, -1.0)]).map(f64::round), Some(100.0));
        assert_eq!(passes(&[(10.0, 1.0), (100.0, 0.5)]), None);
        assert_eq!(passes(&[(10.0, -1.0), (100.0, -0.5)]), None);
    }
}
