//! A scene as Python holds it: shared between its copies until one of them is moved.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use numpy::ndarray::ArrayView2;
use numpy::{
    PyArray1, PyArray2, PyArrayDescr, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyReadwriteArray1, PyUntypedArrayMethods, dtype,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trisect::{Culling, NotExact, Place, Scene, SceneError, SceneOptions, Transform, UpdateError};

use crate::ask::{Borrowed, PyHow, PyRays, Rays, Sight, crossings, culling};
use crate::queries::{self, FEW, Found, Number};
use crate::run::{self, Task, Watch};

/// How a scene is made: whether again and again, as its vertices move.
#[derive(Clone)]
struct How {
    method: String,
    is_moving: bool,
    threads: Option<usize>,
}

/// A scene in one precision, and the mesh that it is made of; none where it is made of instances.
struct Built<X: Number> {
    /// Shared with scenes that it is placed in.
    scene: Arc<Scene<X>>,
    vertices: Vec<[X; 3]>,
    faces: Arc<[[u32; 3]]>,
    triangles: usize,
}

enum State {
    F32(Built<f32>),
    F64(Built<f64>),
}

/// The same for either precision.
macro_rules! either {
    ($state:expr, $built:ident => $what:expr) => {
        match $state {
            State::F32($built) => $what,
            State::F64($built) => $what,
        }
    };
}

/// The compiled half of `trisect.Scene`: arrays of the scene's precision and of matching lengths, which the other half
/// sees to.
#[pyclass(frozen, name = "Scene", module = "trisect._trisect")]
pub(crate) struct RawScene {
    state: RwLock<Arc<State>>,
    how: How,
}

/// Where first hits go: `triangle`, `t`, `u`, `v`.
type FirstOut<'py> =
    (PyReadwriteArray1<'py, i32>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Where the hits of each ray begin, and all that they are.
type AllOut<'py> =
    (Py<PyArray1<i64>>, Py<PyArray1<i32>>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

#[pymethods]
impl RawScene {
    #[new]
    fn new(
        py: Python,
        vertices: Bound<PyAny>,
        faces: PyReadonlyArray2<u32>,
        method: String,
        moving: bool,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let how = How { method, is_moving: moving, threads };
        let faces = triples(&faces)?.into();
        let state = if let Ok(vertices) = vertices.extract::<PyReadonlyArray2<f32>>() {
            State::F32(Built::new(py, &how, triples(&vertices)?, faces)?)
        } else {
            let vertices = vertices.extract::<PyReadonlyArray2<f64>>()?;
            State::F64(Built::new(py, &how, triples(&vertices)?, faces)?)
        };
        Ok(Self { state: RwLock::new(Arc::new(state)), how })
    }

    /// A scene of scenes, each placed by the rows of a matrix: as many of either.
    #[staticmethod]
    fn instances(
        py: Python,
        scenes: Vec<Py<Self>>,
        transforms: PyReadonlyArray3<f32>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let transforms = rows_of(&transforms)?;
        same(scenes.len(), &[transforms.len()])?;
        let mut placed = vec![];
        for (scene, transform) in scenes.iter().zip(transforms) {
            match &*scene.get().state() {
                State::F32(built) => placed.push((Arc::clone(&built.scene), transform)),
                State::F64(_) => return Err(PyValueError::new_err("instances are in float32")),
            }
        }
        let triangles = scenes.iter().map(|scene| scene.get().triangles()).sum();
        let mut methods = scenes.iter().map(|scene| scene.get().method());
        let method = methods.next().unwrap_or("exact");
        let method = if methods.all(|other| other == method) { method } else { "mixed" };
        let how = How { method: method.to_owned(), is_moving: false, threads };
        let scene = run::within(py, threads, || Scene::instances(&placed))?.map_err(amiss)?;
        let (scene, faces) = (Arc::new(scene), Arc::from([[0; 3]; 0]));
        let state = State::F32(Built { scene, vertices: vec![], faces, triangles });
        Ok(Self { state: RwLock::new(Arc::new(state)), how })
    }

    /// Moves the instances; whether that can be: not where another scene shares them.
    fn set_transforms(&self, py: Python, transforms: PyReadonlyArray3<f32>) -> PyResult<bool> {
        let transforms = rows_of(&transforms)?;
        let set = || {
            let mut state = self.state.write().unwrap_or_else(PoisonError::into_inner);
            let scene = match Arc::get_mut(&mut state) {
                Some(State::F32(built)) => Arc::get_mut(&mut built.scene),
                _ => None,
            };
            scene.map(|scene| scene.set_transforms(&transforms)).transpose()
        };
        Ok(run::within(py, self.how.threads, set)?.map_err(amiss)?.is_some())
    }

    /// A copy, which answers as this one does until either is moved.
    fn copy(&self) -> Self {
        Self { state: RwLock::new(self.state()), how: self.how.clone() }
    }

    fn update(&self, py: Python, vertices: Bound<PyAny>) -> PyResult<()> {
        // Held no longer than it takes to ask: what is shared cannot be fitted.
        let is_f32 = matches!(&*self.state(), State::F32(_));
        if is_f32 {
            self.moved(py, &vertices, State::F32, |state| match state {
                State::F32(built) => Some(built),
                State::F64(_) => None,
            })
        } else {
            self.moved(py, &vertices, State::F64, |state| match state {
                State::F64(built) => Some(built),
                State::F32(_) => None,
            })
        }
    }

    #[getter]
    fn dtype<'py>(&self, py: Python<'py>) -> Bound<'py, PyArrayDescr> {
        match &*self.state() {
            State::F32(_) => dtype::<f32>(py),
            State::F64(_) => dtype::<f64>(py),
        }
    }

    #[getter]
    fn method(&self) -> &str {
        &self.how.method
    }

    #[getter]
    fn moving(&self) -> bool {
        self.how.is_moving
    }

    #[getter]
    fn threads(&self) -> Option<usize> {
        self.how.threads
    }

    #[getter]
    fn triangles(&self) -> usize {
        either!(&*self.state(), built => built.triangles)
    }

    #[getter]
    fn count_of_vertices(&self) -> usize {
        either!(&*self.state(), built => built.vertices.len())
    }

    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        either!(&*self.state(), built => Ok(rows(py, &built.vertices)?.into_any()))
    }

    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        either!(&*self.state(), built => rows(py, &built.faces))
    }

    /// The points of hits, in rows of three; NaN for none.
    fn points<'py>(
        &self,
        py: Python<'py>,
        triangle: PyReadonlyArray1<'py, i32>,
        u: Bound<'py, PyAny>,
        v: Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, &either!(&*self.state(), built => built.points(&triangle, &u, &v)?))
    }

    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let facts = either!(&*self.state(), built => built.scene.statistics());
        let dict = PyDict::new(py);
        dict.set_item("builder", facts.builder.to_string())?;
        dict.set_item("nodes", facts.nodes)?;
        dict.set_item("blocks", facts.blocks)?;
        dict.set_item("references", facts.references)?;
        dict.set_item("depth", facts.depth)?;
        dict.set_item("bytes", facts.bytes)?;
        dict.set_item("cost", facts.cost)?;
        Ok(dict)
    }

    fn first(&self, py: Python, rays: PyRays, how: PyHow, out: FirstOut) -> PyResult<()> {
        either!(&*self.state(), built => built.first(&self.watch(py, &how)?, rays, &how, out))
    }

    fn any<'py>(
        &self,
        py: Python<'py>,
        rays: PyRays<'py>,
        how: PyHow<'py>,
        mut out: PyReadwriteArray1<'py, bool>,
    ) -> PyResult<()> {
        either!(&*self.state(), built => {
            built.any(&self.watch(py, &how)?, rays, &how, out.as_slice_mut()?)
        })
    }

    fn all<'py>(
        &self,
        py: Python<'py>,
        rays: PyRays<'py>,
        how: PyHow<'py>,
        crossings: &str,
    ) -> PyResult<AllOut<'py>> {
        either!(&*self.state(), built => built.all(&self.watch(py, &how)?, rays, &how, crossings))
    }

    fn count<'py>(
        &self,
        py: Python<'py>,
        rays: PyRays<'py>,
        how: PyHow<'py>,
        crossings: &str,
        mut out: PyReadwriteArray1<'py, i32>,
    ) -> PyResult<()> {
        either!(&*self.state(), built => {
            built.count(&self.watch(py, &how)?, rays, &how, crossings, out.as_slice_mut()?)
        })
    }

    fn places<'py>(
        &self,
        py: Python<'py>,
        points: Bound<'py, PyAny>,
        how: PyHow<'py>,
        mut out: PyReadwriteArray1<'py, i8>,
    ) -> PyResult<()> {
        either!(&*self.state(), built => {
            built.places(&self.watch(py, &how)?, &points, &how, out.as_slice_mut()?)
        })
    }
}

impl RawScene {
    fn state(&self) -> Arc<State> {
        Arc::clone(&self.state.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Moves the vertices: fits the tree to them where no other scene shares it and it can be, or makes it anew.
    fn moved<X: Number>(
        &self,
        py: Python,
        vertices: &Bound<PyAny>,
        of: fn(Built<X>) -> State,
        built: fn(&mut State) -> Option<&mut Built<X>>,
    ) -> PyResult<()> {
        let vertices = triples(&vertices.extract::<PyReadonlyArray2<X>>()?)?;
        let fit = || {
            let mut state = self.state.write().unwrap_or_else(PoisonError::into_inner);
            match Arc::get_mut(&mut state).and_then(built) {
                Some(built) => built.fit(&vertices),
                None => Ok(false),
            }
        };
        // Nobody who holds the lock waits for Python.
        if run::within(py, self.how.threads, fit)?.map_err(amiss)? {
            return Ok(());
        }
        let faces = either!(&*self.state(), built => Arc::clone(&built.faces));
        let state = of(Built::new(py, &self.how, vertices, faces)?);
        *self.state.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(state);
        Ok(())
    }

    fn watch<'py>(&self, py: Python<'py>, how: &PyHow) -> PyResult<Watch<'py>> {
        let (_, _, threads, progress) = how;
        let threads = threads.or(self.how.threads);
        run::number(threads)?;
        let progress = progress.as_ref().map(|progress| progress.clone_ref(py));
        Ok(Watch { py, threads, progress, is_stopped: AtomicBool::new(false) })
    }
}

impl How {
    fn options<X: Number>(&self) -> PyResult<SceneOptions<X>> {
        let options = SceneOptions::default();
        let options = match self.method.as_str() {
            "exact" => options.exact(),
            "fast" => options.fast(),
            "watertight" => options.watertight(),
            other => {
                let message =
                    format!("method must be \"exact\", \"fast\" or \"watertight\", not {other:?}");
                return Err(PyValueError::new_err(message));
            }
        };
        Ok(if self.is_moving { options.moving() } else { options })
    }
}

impl<X: Number> Built<X> {
    fn new(py: Python, how: &How, vertices: Vec<[X; 3]>, faces: Arc<[[u32; 3]]>) -> PyResult<Self> {
        let options = how.options()?;
        let build = move || -> Result<Self, SceneError> {
            let scene = Arc::new(options.build(&vertices, &faces)?);
            let triangles = faces.len();
            Ok(Self { scene, vertices, faces, triangles })
        };
        run::apart(py, how.threads, build)?.map_err(amiss)
    }

    /// Fits the tree to vertices that have moved, or builds it anew where it is worn; whether that can be: not where it is
    /// placed in another scene.
    fn fit(&mut self, vertices: &[[X; 3]]) -> Result<bool, UpdateError> {
        let Some(scene) = Arc::get_mut(&mut self.scene) else { return Ok(false) };
        scene.update(vertices)?;
        self.vertices.copy_from_slice(vertices);
        Ok(true)
    }

    fn points(
        &self,
        triangle: &PyReadonlyArray1<i32>,
        u: &Bound<PyAny>,
        v: &Bound<PyAny>,
    ) -> PyResult<Vec<[f64; 3]>> {
        let (u, v) = (u.extract::<PyReadonlyArray1<X>>()?, v.extract::<PyReadonlyArray1<X>>()?);
        let (u, v) = (u.as_array(), v.as_array());
        let triangle = triangle.as_array();
        same(triangle.len(), &[u.len(), v.len()])?;
        let point = |((&triangle, &u), &v): ((&i32, &X), &X)| {
            let Ok(triangle) = usize::try_from(triangle) else { return Ok([f64::NAN; 3]) };
            let Some(face) = self.faces.get(triangle) else {
                let faces = self.faces.len();
                let message = format!("a hit names triangle {triangle}, but there are {faces}");
                return Err(PyValueError::new_err(message));
            };
            let corners = face.map(|vertex| self.vertices[vertex as usize].map(X::to_f64));
            let (u, v) = (u.to_f64(), v.to_f64());
            let weights = [1.0 - u - v, u, v];
            // Weights of all three corners, not steps from the first: no term is larger than its corner.
            Ok([0, 1, 2].map(|axis| (0..3).map(|k| weights[k] * corners[k][axis]).sum()))
        };
        triangle.iter().zip(u).zip(v).map(point).collect()
    }

    fn first(&self, watch: &Watch, rays: PyRays, how: &PyHow, out: FirstOut) -> PyResult<()> {
        let rays = Borrowed::<X>::of(rays)?;
        let rays = rays.rays();
        let (mut triangle, t, u, v) = out;
        let mut out = [t, u, v]
            .into_iter()
            .map(|array| array.extract::<PyReadwriteArray1<X>>())
            .collect::<PyResult<Vec<_>>>()?;
        let [t, u, v] = &mut out[..] else { unreachable!("three arrays are three") };
        let (triangle, t) = (triangle.as_slice_mut()?, t.as_slice_mut()?);
        let (u, v) = (u.as_slice_mut()?, v.as_slice_mut()?);
        same(rays.len(), &[triangle.len(), t.len(), u.len(), v.len()])?;
        let (sight, size) = (sight(watch, how, "every")?, size(watch, rays.len(), BATCH)?);
        let places = triangle.chunks_mut(size).zip(t.chunks_mut(size));
        let places = places.zip(u.chunks_mut(size).zip(v.chunks_mut(size)));
        let mut tasks = vec![];
        for (part, ((triangle, t), (u, v))) in places.enumerate() {
            let (from, count) = (part * size, triangle.len());
            let work = move || {
                queries::first(&self.scene, sight, &rays.gather(from..from + count), |at, hit| {
                    let (id, hit) = match hit {
                        Some((id, along, second, third)) => (number(id), (along, second, third)),
                        None => (-1, (X::INFINITY, X::ZERO, X::ZERO)),
                    };
                    triangle[at] = id;
                    (t[at], u[at], v[at]) = hit;
                });
            };
            tasks.push(Task { rays: count, work: Box::new(work) });
        }
        run::all(watch, tasks)
    }

    fn any(&self, watch: &Watch, rays: PyRays, how: &PyHow, out: &mut [bool]) -> PyResult<()> {
        let rays = Borrowed::<X>::of(rays)?;
        let (rays, sight) = (rays.rays(), sight(watch, how, "every")?);
        in_parts(watch, rays.len(), BATCH, out, |from, out| {
            queries::any(&self.scene, sight, &rays.gather(from..from + out.len()), out);
        })
    }

    fn count(
        &self,
        watch: &Watch,
        rays: PyRays,
        how: &PyHow,
        crossings: &str,
        out: &mut [i32],
    ) -> PyResult<()> {
        let rays = Borrowed::<X>::of(rays)?;
        let (rays, sight) = (rays.rays(), sight(watch, how, crossings)?);
        in_parts(watch, rays.len(), FEWER, out, |from, out| {
            let rays = rays.gather(from..from + out.len());
            queries::count(&self.scene, sight, &rays, |at, count| out[at] = number(count));
        })
    }

    fn places(
        &self,
        watch: &Watch,
        points: &Bound<PyAny>,
        how: &PyHow,
        out: &mut [i8],
    ) -> PyResult<()> {
        let points = points.extract::<PyReadonlyArray2<X>>()?;
        let points: ArrayView2<X> = points.as_array();
        let (sight, failed) = (sight(watch, how, "every")?, Mutex::new(None::<NotExact>));
        in_parts(watch, points.nrows(), BATCH, out, |from, out| {
            let point = |at| [points[[at, 0]], points[[at, 1]], points[[at, 2]]];
            let points: Vec<_> = (from..from + out.len()).map(point).collect();
            let placed = queries::places(&self.scene, sight, &points, |at, place| {
                out[at] = match place {
                    Place::Inside => 1,
                    Place::On => 0,
                    Place::Outside => -1,
                }
            });
            if let Err(error) = placed {
                *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            }
        })?;
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(amiss(error)),
            None => Ok(()),
        }
    }

    fn all<'py>(
        &self,
        watch: &Watch<'py>,
        rays: PyRays<'py>,
        how: &PyHow<'py>,
        crossings: &str,
    ) -> PyResult<AllOut<'py>> {
        /// The hits of some rays, and how many each of them has.
        struct Part<X> {
            counts: Vec<usize>,
            hits: Vec<Found<X>>,
        }
        let rays = Borrowed::<X>::of(rays)?;
        let (rays, sight): (Rays<X>, _) = (rays.rays(), sight(watch, how, crossings)?);
        let size = size(watch, rays.len(), FEWER)?;
        let mut parts: Vec<Part<X>> = vec![];
        parts.resize_with(rays.len().div_ceil(size), || Part { counts: vec![], hits: vec![] });
        let mut tasks = vec![];
        for (part, place) in parts.iter_mut().enumerate() {
            let (from, to) = (part * size, rays.len().min((part + 1) * size));
            let work = move || {
                queries::all(&self.scene, sight, &rays.gather(from..to), |hits| {
                    place.hits.extend(hits.iter().map(queries::found));
                    place.counts.push(hits.len());
                });
            };
            tasks.push(Task { rays: to - from, work: Box::new(work) });
        }
        run::all(watch, tasks)?;
        let py = watch.py;
        let mut offsets = Vec::with_capacity(rays.len() + 1);
        let mut end = 0;
        offsets.push(0);
        for &count in parts.iter().flat_map(|part| &part.counts) {
            end += i64::try_from(count).unwrap_or(i64::MAX);
            offsets.push(end);
        }
        let hits: Vec<&[Found<X>]> = parts.iter().map(|part| &part.hits[..]).collect();
        let floats = |of: fn(&Found<X>) -> X| PyArray1::from_vec(py, column(&hits, of)).into_any();
        Ok((
            PyArray1::from_vec(py, offsets).unbind(),
            PyArray1::from_vec(py, column(&hits, |hit| number(hit.0))).unbind(),
            floats(|hit| hit.1),
            floats(|hit| hit.2),
            floats(|hit| hit.3),
        ))
    }
}

/// One number of each hit.
fn column<X, T>(parts: &[&[Found<X>]], of: fn(&Found<X>) -> T) -> Vec<T> {
    let mut column = Vec::with_capacity(parts.iter().map(|hits| hits.len()).sum());
    for hits in parts {
        column.extend(hits.iter().map(of));
    }
    column
}

/// What is amiss, in Python's way.
fn amiss(error: impl std::error::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Faces are fewer than 2²⁷, and so are hits of one ray.
fn number(id: u32) -> i32 {
    i32::try_from(id).unwrap_or(i32::MAX)
}

fn sight<'a>(watch: &'a Watch, how: &'a PyHow, crossed: &str) -> PyResult<Sight<'a>> {
    let (cull, mask, _, _) = how;
    let mask = mask.as_ref().map(|mask| mask.as_slice()).transpose()?;
    let culling: Culling = culling(cull)?;
    Ok(Sight { culling, crossings: crossings(crossed)?, mask, is_stopped: &watch.is_stopped })
}

/// Rays of one part at most, of which the tracer makes what goes down the tree together: they take some hundredths of a
/// second.
const BATCH: usize = 1 << 15;

/// The same where rays go one by one.
const FEWER: usize = 1 << 12;

/// Rays of one part: fewer than at most where threads would have nothing to do.
fn size(watch: &Watch, rays: usize, most: usize) -> PyResult<usize> {
    Ok(rays.div_ceil(4 * run::number(watch.threads)?).clamp(4 * FEW, most))
}

/// Computes the outputs, part by part: `work` gets the place of the first, and all of a part.
fn in_parts<T: Send>(
    watch: &Watch,
    count: usize,
    most: usize,
    out: &mut [T],
    work: impl Fn(usize, &mut [T]) + Sync,
) -> PyResult<()> {
    same(count, &[out.len()])?;
    let (size, work) = (size(watch, count, most)?, &work);
    let mut tasks = vec![];
    for (part, out) in out.chunks_mut(size).enumerate() {
        tasks.push(Task { rays: out.len(), work: Box::new(move || work(part * size, out)) });
    }
    run::all(watch, tasks)
}

fn same(rays: usize, places: &[usize]) -> PyResult<()> {
    if places.iter().all(|&places| places == rays) {
        Ok(())
    } else {
        Err(PyValueError::new_err("out has not one place for each ray"))
    }
}

fn triples<T: numpy::Element + Copy>(array: &PyReadonlyArray2<T>) -> PyResult<Vec<[T; 3]>> {
    match array.as_slice()?.as_chunks() {
        (triples, []) => Ok(triples.to_vec()),
        _ => Err(PyValueError::new_err("rows are not of three")),
    }
}

/// The upper three rows of matrices.
fn rows_of(array: &PyReadonlyArray3<f32>) -> PyResult<Vec<Transform>> {
    match array.as_slice()?.as_chunks() {
        (rows, []) if array.shape()[1..] == [3, 4] => Ok(rows.as_chunks().0.to_vec()),
        _ => Err(PyValueError::new_err("transforms are not of three rows of four")),
    }
}

fn rows<'py, T: numpy::Element + Copy>(
    py: Python<'py>,
    triples: &[[T; 3]],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    PyArray1::from_slice(py, triples.as_flattened()).reshape([triples.len(), 3])
}
