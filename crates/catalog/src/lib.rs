//! The one list of methods; every loop over methods goes through it.
//!
//! [`each_method`] visits the methods as types; [`entries`] lists them with their compiled kernels
//! behind one type, so that measuring, answering queries and testing need no code per method.
#![forbid(unsafe_code)]

mod kernel;
mod matrix;
mod variant;

use std::sync::OnceLock;

use trisect_core::{
    Cost, Form, Hit, Method, MethodInfo, MethodVisitor, Precision, Ray, Triangle, UnsuitableMesh,
    cost,
};

use kernel::Instances as _;
pub use kernel::{Find, Finder, Kernel, Scene, Tally};
pub use variant::{Lane, Variant};

pub use trisect_tracer::{Builder, Leaves, Statistics, Tracing, Tree, TriangleHit, fast_lanes};

include!(concat!(env!("OUT_DIR"), "/methods.rs"));

/// A method with its compiled kernels.
pub struct Entry {
    /// Facts about the method.
    pub info: MethodInfo,
    /// Its type, as a program names it.
    pub type_name: String,
    /// What it costs, counted by running its formula.
    pub cost: Cost,
    /// Its f32 kernels.
    pub f32: Kernels<f32>,
    /// Its f64 kernels.
    pub f64: Kernels<f64>,
    /// Its f32 tests as a processor runs them that flushes subnormal numbers to zero, by the division.
    pub flushing: Vec<(Form, FlushingTest)>,
    /// The stages of which one decides a pair, the cheapest first; none where all pairs go one way.
    pub stages: &'static [&'static str],
    /// Puts triangles in a tree, prepared for the method, or says why it cannot take them.
    pub tree: BuildTree,
    /// The same with leaves of a size of choice.
    pub tree_with: BuildTreeWith,
}

/// Puts triangles in a tree.
pub type BuildTree = fn(&[Triangle<f32>], Builder) -> Result<Box<dyn Tree>, UnsuitableMesh>;

/// Puts triangles in a tree, its leaves of a size of choice.
pub type BuildTreeWith =
    fn(&[Triangle<f32>], Builder, Leaves) -> Result<Box<dyn Tree>, UnsuitableMesh>;

/// A test of one ray against one triangle in [`Flushing`](trisect_core::Flushing) arithmetic.
pub type FlushingTest = fn(&Ray<f32>, &Triangle<f32>) -> Option<Hit<f64>>;

/// The compiled kernels of a method in one precision.
pub struct Kernels<E: Precision> {
    /// Prepares triangles and rays for these kernels, or says why the method cannot take them.
    pub prepare: Prepare<E>,
    /// The place among the method's stages of the one that decides a pair.
    pub stage: fn(&Ray<E>, &Triangle<E>) -> usize,
    /// Kernels that count, for measuring time.
    pub timed: Vec<Kernel>,
    /// Kernels that hand out every hit, for answers and errors.
    pub finders: Vec<Finder>,
    /// The same for methods that [decide apart](MethodInfo::decides_apart): these decide by numerators,
    /// as their deferred kernels for occlusion do, and are no form of the method's to answer with.
    pub deciders: Vec<Finder>,
}

/// Prepares triangles and rays for the kernels of one method and precision.
pub type Prepare<E> = fn(&[Triangle<E>], &[Ray<E>]) -> Result<Scene, UnsuitableMesh>;

/// The methods with their compiled kernels, in the order of the catalogue.
pub fn entries() -> &'static [Entry] {
    struct Collect(Vec<Entry>);
    impl MethodVisitor for Collect {
        fn visit<M: Method>(&mut self) {
            self.visit_with_trees::<M, M>();
        }

        fn visit_with_trees<M: Method, T: Method>(&mut self) {
            self.0.push(Entry {
                info: M::INFO,
                type_name: type_name::<M>(),
                cost: cost::<M>(),
                f32: matrix::kernels::<M, f32>(),
                f64: matrix::kernels::<M, f64>(),
                flushing: matrix::flushing::<M>(),
                stages: M::STAGES,
                tree: |triangles, builder| T::tree(triangles, builder, Leaves::default()),
                tree_with: T::tree,
            });
        }
    }
    static ENTRIES: OnceLock<Vec<Entry>> = OnceLock::new();
    ENTRIES.get_or_init(|| {
        let mut collect = Collect(Vec::new());
        each_method(&mut collect);
        collect.0
    })
}

/// A type by its crate and name: what this workspace exports for others lies at a crate's root.
fn type_name<T>() -> String {
    let full = std::any::type_name::<T>();
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let mut short = String::new();
    for part in full.split_inclusive(|c: char| !word(c)) {
        let (path, rest) = part.split_at(part.find(|c: char| !word(c)).unwrap_or(part.len()));
        let (krate, name) = (path.split("::").next(), path.rsplit_once("::"));
        short.extend(krate.filter(|_| name.is_some()));
        short.extend(name.map(|_| "::"));
        short += name.map_or(path, |(_, name)| name);
        short += rest;
    }
    short
}

/// The method of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    entries().iter().find(|entry| entry.info.name == name)
}

impl<E: Precision> Kernels<E> {
    /// The finder that computes as a kernel of these does.
    ///
    /// # Panics
    /// When the kernel is another's.
    pub fn finder_of(&self, kernel: &Kernel) -> &Finder {
        self.finders
            .iter()
            .chain(&self.deciders)
            .find(|finder| finder.variant.computes_like(&kernel.variant))
            .expect("every timed variant has a finder")
    }

    /// The finder of the plain variant of that width and form: of the widest that this processor has,
    /// where no width is given, and of the form that decides without quotients, where no form is given
    /// and the method has it. Plain finders of all widths give the same bits.
    pub fn plain_finder(&self, width: Option<usize>, form: Option<Form>) -> Option<&Finder> {
        self.finders
            .iter()
            .filter(|Finder { variant, .. }| {
                variant.is_plain()
                    && form.is_none_or(|form| variant.division == form)
                    && width.map_or(variant.is_available(), |width| variant.width == width)
            })
            .max_by_key(|Finder { variant, .. }| {
                (variant.width, variant.division == Form::Deferred)
            })
    }
}
