//! What is asked: rays, as arrays of any layout have them, and how they see the scene.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use trisect::core::{Ray, Vec3};
use trisect::{Crossings, Culling, Verdict};

use crate::queries::Number;

/// Origins, directions, and where their intervals begin and end: 0 and infinity where there is nothing.
pub(crate) type PyRays<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Option<Bound<'py, PyAny>>, Option<Bound<'py, PyAny>>);

/// Which faces are seen, which triangles, on how many threads, and whom to tell of progress.
pub(crate) type PyHow<'py> =
    (String, Option<PyReadonlyArray1<'py, bool>>, Option<usize>, Option<Py<PyAny>>);

/// Arrays of rays, kept as long as they are read.
pub(crate) struct Borrowed<'py, X: Number> {
    origins: PyReadonlyArray2<'py, X>,
    directions: PyReadonlyArray2<'py, X>,
    tmin: Option<PyReadonlyArray1<'py, X>>,
    tmax: Option<PyReadonlyArray1<'py, X>>,
}

/// Rays in arrays.
#[derive(Clone, Copy)]
pub(crate) struct Rays<'a, X> {
    origins: ArrayView2<'a, X>,
    directions: ArrayView2<'a, X>,
    tmin: Option<ArrayView1<'a, X>>,
    tmax: Option<ArrayView1<'a, X>>,
}

impl<'py, X: Number> Borrowed<'py, X> {
    pub(crate) fn of((origins, directions, tmin, tmax): PyRays<'py>) -> PyResult<Self> {
        let rays = Self {
            origins: origins.extract()?,
            directions: directions.extract()?,
            tmin: tmin.map(|tmin| tmin.extract()).transpose()?,
            tmax: tmax.map(|tmax| tmax.extract()).transpose()?,
        };
        let Rays { origins, directions, tmin, tmax } = rays.rays();
        let rows = origins.nrows();
        let is_sound = origins.ncols() == 3
            && directions.dim() == (rows, 3)
            && [tmin, tmax].into_iter().flatten().all(|interval| interval.len() == rows);
        if is_sound { Ok(rays) } else { Err(PyValueError::new_err("rays of several lengths")) }
    }

    pub(crate) fn rays(&self) -> Rays<'_, X> {
        Rays {
            origins: self.origins.as_array(),
            directions: self.directions.as_array(),
            tmin: self.tmin.as_ref().map(|tmin| tmin.as_array()),
            tmax: self.tmax.as_ref().map(|tmax| tmax.as_array()),
        }
    }
}

/// The rows of an array that has them one after another.
fn in_rows<'a, X: Number>(array: &ArrayView2<'a, X>) -> Option<&'a [[X; 3]]> {
    Some(array.to_slice()?.as_chunks().0)
}

impl<X: Number> Rays<'_, X> {
    pub(crate) fn len(&self) -> usize {
        self.origins.nrows()
    }

    /// Some of the rays.
    pub(crate) fn gather(&self, range: Range<usize>) -> Vec<Ray<X>> {
        // As most are: row by row, one after another.
        if let (Some(o), Some(d), None, None) =
            (in_rows(&self.origins), in_rows(&self.directions), self.tmin, self.tmax)
        {
            let rays = o[range.clone()].iter().zip(&d[range]);
            return rays.map(|(&o, &d)| Ray::new(o, d)).collect();
        }
        let row =
            |array: &ArrayView2<X>, at| Vec3::new(array[[at, 0]], array[[at, 1]], array[[at, 2]]);
        let ray = |at| Ray {
            o: row(&self.origins, at),
            d: row(&self.directions, at),
            tmin: self.tmin.map_or(X::ZERO, |tmin| tmin[at]),
            tmax: self.tmax.map_or(X::INFINITY, |tmax| tmax[at]),
        };
        range.map(ray).collect()
    }
}

/// How rays see a scene.
#[derive(Clone, Copy)]
pub(crate) struct Sight<'a> {
    pub(crate) culling: Culling,
    pub(crate) crossings: Crossings,
    /// Which triangles are seen; all where there is nothing.
    pub(crate) mask: Option<&'a [bool]>,
    /// Whether nobody waits for the answers any more.
    pub(crate) is_stopped: &'a AtomicBool,
}

impl Sight<'_> {
    /// Whether the answers are waited for.
    pub(crate) fn lasts(&self) -> bool {
        !self.is_stopped.load(Ordering::Relaxed)
    }

    pub(crate) fn sees(&self, triangle: u32) -> bool {
        self.mask.is_none_or(|mask| mask[triangle as usize])
    }

    pub(crate) fn verdict(&self, triangle: u32) -> Verdict {
        if self.sees(triangle) { Verdict::Accept } else { Verdict::Ignore }
    }
}

/// Which faces are not seen.
pub(crate) fn culling(name: &str) -> PyResult<Culling> {
    match name {
        "none" => Ok(Culling::None),
        "back" => Ok(Culling::Back),
        "front" => Ok(Culling::Front),
        _ => {
            let message = format!("cull must be \"none\", \"back\" or \"front\", not {name:?}");
            Err(PyValueError::new_err(message))
        }
    }
}

/// What counts at shared edges.
pub(crate) fn crossings(name: &str) -> PyResult<Crossings> {
    match name {
        "every" => Ok(Crossings::Every),
        "owned" => Ok(Crossings::Owned),
        _ => {
            let message = format!("crossings must be \"every\" or \"owned\", not {name:?}");
            Err(PyValueError::new_err(message))
        }
    }
}
