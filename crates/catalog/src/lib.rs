//! The one list of methods; every loop over methods goes through it.
//!
//! [`each_method`] visits the methods as types; [`entries`] lists them with their compiled kernels
//! behind one type, so that measuring, answering queries and testing need no code per method.
#![forbid(unsafe_code)]

mod kernel;
mod matrix;
mod variant;
mod yardsticks;

use std::sync::OnceLock;

use trisect_core::{FloatFormat, Hit, Precision, Ray, Triangle};
use trisect_formula::{Cost, Formula};
use trisect_method::{Form, Method, MethodInfo, MethodVisitor, UnsuitableMesh};

use kernel::Instances as _;
pub use kernel::{Find, Finder, Kernel, Scene, Tally};
pub use variant::{Lane, Variant};
pub use yardsticks::{every_triangle, scalar_tree, waived_watertight};

pub use trisect_all_methods::each_method;

pub use trisect::trees::{BuildTree, NAMES as TREES_F64};

pub use trisect_tracer::{Builder, Leaves, Statistics, Tracing, Tree, TriangleHit, fast_lanes};

/// A method with its compiled kernels.
pub struct Entry {
    /// Facts about the method.
    pub info: MethodInfo,
    /// Its type, as a program names it.
    pub type_name: String,
    /// Records its formula, for numbers of a format.
    pub formula: fn(FloatFormat) -> Formula,
    /// What it costs, counted from its formula.
    pub cost: Cost,
    /// Its f32 kernels.
    pub f32: Kernels<f32>,
    /// Its f64 kernels.
    pub f64: Kernels<f64>,
    /// Its f32 tests as a processor runs them that flushes subnormal numbers to zero, by the division.
    pub flushing: Vec<(Form, FlushingTest)>,
    /// The stages of which one decides a pair, the cheapest first; none where all pairs go one way.
    pub stages: &'static [&'static str],
    /// Builds a tree that calls the method's test for each leaf. The traversal is compiled once for all
    /// methods, so that in these trees methods differ in their tests alone.
    pub erased_tree: BuildTree,
    /// Builds a tree with the method's test inside the traversal loop, for the methods of
    /// [`INLINE_IN_TREES`].
    pub inline_tree: Option<BuildTree>,
}

impl Entry {
    /// Builds the fastest tree that is compiled for the method: the inline one where there is one.
    ///
    /// # Errors
    /// When the method does not take these triangles.
    pub fn tree(
        &self,
        triangles: &[Triangle<f32>],
        builder: Builder,
    ) -> Result<Box<dyn Tree>, UnsuitableMesh> {
        self.tree_with(triangles, builder, Leaves::default())
    }

    /// As [`tree`](Entry::tree), with leaves of a size of choice.
    ///
    /// # Errors
    /// When the method does not take these triangles.
    pub fn tree_with(
        &self,
        triangles: &[Triangle<f32>],
        builder: Builder,
        leaves: Leaves,
    ) -> Result<Box<dyn Tree>, UnsuitableMesh> {
        self.inline_tree.unwrap_or(self.erased_tree)(triangles, builder, leaves)
    }

    /// Builds a tree of f64, where the method is one of those that [`trisect::trees`] has one of.
    ///
    /// # Errors
    /// When the method does not take these triangles.
    pub fn tree_f64(
        &self,
        triangles: &[Triangle<f64>],
        builder: Builder,
    ) -> Option<Result<Box<dyn Tree<f64>>, UnsuitableMesh>> {
        let build = trisect::trees::find::<f64>(self.info.name)?;
        Some(build(triangles, builder, Leaves::default()))
    }
}

/// The methods whose test is compiled into the traversal loop as well: the reference, the fastest, and those
/// that promise something. The loop costs several seconds of compilation per method, and what it gains over
/// a call is shown by the study of the tracer. Those of [`trisect::trees`] are compiled there, the others here.
pub const INLINE_IN_TREES: [&str; 5] =
    ["moller-trumbore", "baldwin-weber-12", "watertight", "watertight-one-precision", "exact"];

/// Whether a name is one of some; for constants, where `==` on text is not available.
const fn is_one_of(name: &str, names: &[&str]) -> bool {
    let mut place = 0;
    while place < names.len() {
        let (ours, theirs) = (names[place].as_bytes(), name.as_bytes());
        let mut length = 0;
        while length < ours.len() && length < theirs.len() && ours[length] == theirs[length] {
            length += 1;
        }
        if length == ours.len() && length == theirs.len() {
            return true;
        }
        place += 1;
    }
    false
}

/// A test of one ray against one triangle in [`Flushing`](trisect_formula::Flushing) arithmetic.
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
                formula: Formula::of::<M>,
                cost: Formula::of::<M>(FloatFormat::F32).cost(),
                f32: matrix::kernels::<M, f32>(),
                f64: matrix::kernels::<M, f64>(),
                flushing: matrix::flushing::<M>(),
                stages: M::STAGES,
                erased_tree: T::erased_tree,
                inline_tree: if const { is_one_of(M::INFO.name, &trisect::trees::NAMES) } {
                    trisect::trees::find(M::INFO.name)
                } else if const { is_one_of(M::INFO.name, &INLINE_IN_TREES) } {
                    Some(T::inline_tree)
                } else {
                    None
                },
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
    /// The finder that [answers for](Variant::answered_by) a kernel of these.
    ///
    /// # Panics
    /// When the kernel is another's.
    pub fn finder_of(&self, kernel: &Kernel) -> &Finder {
        kernel
            .variant
            .answered_by(self.finders.iter().chain(&self.deciders), |finder| &finder.variant)
            .expect("every timed variant has a finder")
    }

    /// The timed kernels that a finder answers for.
    pub fn answered_by(&self, finder: &Finder) -> impl Iterator<Item = &Kernel> {
        self.timed.iter().filter(move |kernel| std::ptr::eq(self.finder_of(kernel), finder))
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
