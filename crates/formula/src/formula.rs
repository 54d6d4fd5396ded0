//! A method as graphs.

use core::cell::Cell;
use core::ops::Range;

use trisect_core::{FloatFormat, Ray, Triangle, Vec3};
use trisect_method::{
    Alpha as _, Culling, DecisionOnly, Deferred, Division, Early, Form, Homogeneous, Interval,
    Method, MethodInfo, Of, Record, TrueDivision,
};

use crate::graph::{Graph, Node, Tree};
use crate::symbol::{self, Path, Recorded, Symbol, Truth, input};

/// The inputs of a preparation: the corners.
const CORNERS: [&str; 9] = ["a_x", "a_y", "a_z", "b_x", "b_y", "b_z", "c_x", "c_y", "c_z"];

/// The first inputs of a test: the ray.
pub(crate) const RAY: [&str; 8] = ["o_x", "o_y", "o_z", "d_x", "d_y", "d_z", "tmin", "tmax"];

/// Which axis a formula wants to be the last, and who says so. Its graphs are of triangles and rays whose axes have been
/// renamed so, see [`Vec3::with_axis_last`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// None: axes stay as they are.
    Any,
    /// The one that [`Formula::axis`] gives of a triangle: triangles of different axes are of different kinds.
    OfTriangle,
    /// The one that [`Formula::axis`] gives of a ray, that its direction is longest along.
    OfRay,
    /// Kinds of triangles that are not axes.
    Kinds,
}

/// The test of one form of a method.
#[derive(Clone, Debug)]
pub struct Test {
    /// When it divides.
    pub form: Form,
    /// From the ray's numbers and what is stored to `hit` and the values. Outputs: `hit`; the ends of the interval, `tmin`
    /// and `tmax`; `open`, where what is neither a
    /// hit nor a miss goes beyond the formula; `t`, `beta`, `gamma`; the point and the normal; and where no test comes
    /// after this one the numerators, `det`, `det_t`, `det_alpha`, `det_beta` and `det_gamma`. What a method does not give
    /// is not there.
    pub graph: Graph,
    /// The places of the operations that prepare a ray; those before are of the interval.
    pub ray: Range<usize>,
}

/// A method as graphs, for numbers of one format.
#[derive(Clone, Debug)]
pub struct Formula {
    /// Facts about the method.
    pub info: MethodInfo,
    /// The format of its numbers.
    pub format: FloatFormat,
    /// Which axis is the last.
    pub turned: Axis,
    /// That axis, of the corners or of the direction; where there is one.
    pub axis: Option<Graph>,
    /// From the corners to what is stored of a triangle.
    pub prepare: Graph,
    /// The tests: the early form, then the deferred one, where the method has them.
    pub tests: Vec<Test>,
    /// Numbers kept per ray.
    pub ray_numbers: usize,
}

impl Formula {
    /// Records the method `M`.
    pub fn of<M: Method>(format: FloatFormat) -> Self {
        // Of kinds that are axes, the one of the last axis renames nothing.
        let group = M::GROUPS - 1;
        let turned = match (M::GROUPS, M::TURNS) {
            (1, false) => Axis::Any,
            (3, false) => Axis::OfTriangle,
            (1, true) => Axis::OfRay,
            _ => Axis::Kinds,
        };
        let names = M::Prepared::names();
        let prepare = graph(
            format,
            &CORNERS,
            &names,
            || M::prepare(&corners(), group),
            |prepared| numbers::<M::Prepared, _>(&prepared),
        );
        let index = |axis: usize| vec![symbol::index(axis)];
        let axis = match turned {
            Axis::Any => None,
            Axis::OfRay => {
                let largest = || recorded_vector(0).largest_axis();
                Some(graph(format, &RAY[3..6], &["axis".to_owned()], largest, index))
            }
            Axis::OfTriangle | Axis::Kinds => {
                let of_corners = || M::group(&corners());
                Some(graph(format, &CORNERS, &["axis".to_owned()], of_corners, index))
            }
        };
        let mut tests = Vec::new();
        if const { M::INFO.forms.early() && M::INFO.forms.deferred() } {
            tests.push(test::<M, Early<TrueDivision, false>, false>(format, group, &names));
        } else if const { M::INFO.forms.early() } {
            tests.push(test::<M, Early<TrueDivision, false>, true>(format, group, &names));
        }
        if const { M::INFO.claims.exact } {
            // Values are computed apart, beyond any formula.
            type Apart = DecisionOnly<Deferred<TrueDivision, false>>;
            tests.push(test::<M, Apart, true>(format, group, &names));
        } else if const { M::INFO.forms.deferred() } {
            tests.push(test::<M, Deferred<TrueDivision, false>, true>(format, group, &names));
        }
        let ray_numbers = size_of::<M::PreparedRay<f32>>() / size_of::<f32>();
        Self { info: M::INFO, format, turned, axis, prepare, tests, ray_numbers }
    }

    /// The test of a form, where the method has it.
    pub fn test(&self, form: Form) -> Option<&Test> {
        self.tests.iter().find(|test| test.form == form)
    }

    /// The numerators, from the coordinates of ray and corners, unless the preparation branches: `det`, `det_t`,
    /// `det_alpha`, `det_beta` and `det_gamma`.
    pub fn numerators(&self) -> Option<Graph> {
        let Tree::Leaf(_) = self.prepare.tree else { return None };
        Some(self.tests.last()?.graph.after(&self.prepare))
    }
}

/// A vector of three inputs.
fn recorded_vector(first: usize) -> Vec3<Recorded> {
    Vec3::from([0, 1, 2].map(|axis| Recorded(input(first + axis))))
}

fn corners() -> Triangle<Recorded> {
    Triangle { a: recorded_vector(0), b: recorded_vector(3), c: recorded_vector(6) }
}

/// The nodes of a record, in order.
fn numbers<R: Record, X: Copy + Send + Sync + Into<Node>>(record: &R::Of<X>) -> Vec<Node> {
    let nodes = std::cell::RefCell::new(Vec::new());
    R::map(record, |&number| nodes.borrow_mut().push(number.into()));
    nodes.into_inner()
}

fn graph<R, S: AsRef<str>>(
    format: FloatFormat,
    inputs: &[S],
    outputs: &[String],
    run: impl FnMut() -> R,
    mut of: impl FnMut(R) -> Vec<Node>,
) -> Graph {
    let (builder, tree) = symbol::record(format, run, |result, _| of(result));
    let inputs = inputs.iter().map(|name| name.as_ref().to_owned()).collect();
    Graph { format, inputs, ops: builder.ops, outputs: outputs.to_vec(), tree }
}

/// What a test gives, recorded.
struct Outcome {
    hit: Option<(Truth, [Symbol; 3])>,
    point: Vec3<Symbol>,
    normal: Option<Vec3<Symbol>>,
    numerators: Option<[Symbol; 5]>,
    interval: Interval<Symbol>,
    ray: Range<usize>,
}

fn test<M: Method, D: Division, const NUMERATORS: bool>(
    format: FloatFormat,
    group: usize,
    stored: &[String],
) -> Test {
    let mut outputs = Vec::new();
    let mut ray = None;
    let (builder, tree) = symbol::record(
        format,
        || outcome::<M, D, NUMERATORS>(group),
        |outcome, path| {
            // Of the first path: later ones find what they share recorded.
            ray.get_or_insert_with(|| outcome.ray.clone());
            let named = named(&outcome, path, M::INFO.claims.exact);
            outputs = named.iter().map(|(name, _)| (*name).to_owned()).collect();
            named.into_iter().map(|(_, node)| node).collect()
        },
    );
    let inputs = RAY.iter().map(|&name| name.to_owned()).chain(stored.iter().cloned()).collect();
    let mut graph = Graph { format, inputs, ops: builder.ops, outputs, tree };
    graph.join();
    Test { form: D::FORM, graph, ray: ray.unwrap_or_default() }
}

fn outcome<M: Method, D: Division, const NUMERATORS: bool>(group: usize) -> Outcome {
    let number = |place| Symbol(input(place));
    let vector = |place| Vec3::new(number(place), number(place + 1), number(place + 2));
    let ray = Ray { o: vector(0), d: vector(3), tmin: number(6), tmax: number(7) };
    let interval = Interval::of(&ray);
    let start = symbol::recorded();
    let prepared_ray = M::prepare_ray(&ray, group);
    let end = symbol::recorded();
    let stored = stored::<M>(group);
    let mut hit = None;
    M::test::<Symbol, D>(&prepared_ray, &stored, interval, Culling::None, |mask, values| {
        hit = Some((mask, values));
    });
    let t = hit.map_or(number(6), |(_, values)| values.t);
    let numerators = if const { NUMERATORS } {
        let Homogeneous { det, t, alpha, beta, gamma } = M::intersect(&prepared_ray, &stored);
        Some([det, t, alpha.weight(beta, gamma, det), beta, gamma])
    } else {
        None
    };
    Outcome {
        hit: hit.map(|(mask, values)| (mask, [values.t, values.beta, values.gamma])),
        point: ray.at(t),
        normal: M::normal(&stored, group),
        numerators,
        interval,
        ray: start..end,
    }
}

/// What is stored of a triangle, as inputs.
fn stored<M: Method>(group: usize) -> Of<M::Prepared, Symbol> {
    let shape = M::prepare::<Recorded>(&Triangle::nothing(), group);
    let place = Cell::new(RAY.len());
    M::Prepared::map(&shape, |_| Symbol(input(place.replace(place.get() + 1))))
}

/// The outputs of a path by their names.
fn named(outcome: &Outcome, path: &Path, is_exact: bool) -> Vec<(&'static str, Node)> {
    let answered = |mask: Node| path.asked.iter().find(|(asked, _)| *asked == mask);
    let hit = match outcome.hit {
        Some((mask, _)) if !path.has_left => match answered(mask.0) {
            Some(&(_, answer)) => symbol::truth(answer),
            None => mask.0,
        },
        _ => symbol::truth(false),
    };
    let Interval { tmin, tmax } = outcome.interval;
    let mut named = vec![("hit", hit), ("tmin", tmin.0), ("tmax", tmax.0)];
    if is_exact {
        named.push(("open", symbol::truth(path.has_left)));
    } else if let Some((_, [t, beta, gamma])) = outcome.hit {
        named.extend([("t", t.0), ("beta", beta.0), ("gamma", gamma.0)]);
        let Vec3 { x, y, z } = outcome.point;
        named.extend([("point_x", x.0), ("point_y", y.0), ("point_z", z.0)]);
        if let Some(Vec3 { x, y, z }) = outcome.normal {
            named.extend([("normal_x", x.0), ("normal_y", y.0), ("normal_z", z.0)]);
        }
    }
    if let Some([det, t, alpha, beta, gamma]) = outcome.numerators {
        named.extend([("det", det.0), ("det_t", t.0), ("det_alpha", alpha.0)]);
        named.extend([("det_beta", beta.0), ("det_gamma", gamma.0)]);
    }
    named
}

impl From<Recorded> for Node {
    fn from(number: Recorded) -> Self {
        number.0
    }
}
