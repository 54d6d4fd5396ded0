//! The one list of methods; every loop over methods goes through it.
//!
//! [`each_method`] visits the methods as types; [`entries`] lists them with their compiled kernels
//! behind one type, so that measuring, answering queries and testing need no code per method.
#![forbid(unsafe_code)]

mod kernel;
mod matrix;

use std::sync::OnceLock;

use trisect_core::{Method, MethodInfo, MethodVisitor, Precision, Record};

pub use kernel::{Arrangement, Find, Finder, Kernel, Lane, Scene, Tally, Variant};

include!(concat!(env!("OUT_DIR"), "/methods.rs"));

/// A method with its compiled kernels.
pub struct Entry {
    /// Facts about the method.
    pub info: MethodInfo,
    /// Numbers stored per triangle.
    pub stored_numbers: usize,
    /// Its f32 kernels.
    pub f32: Kernels<f32>,
    /// Its f64 kernels.
    pub f64: Kernels<f64>,
}

/// The compiled kernels of a method in one precision.
pub struct Kernels<E: Precision> {
    /// Prepares triangles and rays for these kernels.
    pub prepare: fn(&[trisect_core::Triangle<E>], &[trisect_core::Ray<E>]) -> Scene,
    /// Kernels that count, for measuring time.
    pub timed: Vec<Kernel>,
    /// Kernels that hand out every hit, for answers and errors.
    pub finders: Vec<Finder>,
}

/// The methods with their compiled kernels, in the order of the catalogue.
pub fn entries() -> &'static [Entry] {
    struct Collect(Vec<Entry>);
    impl MethodVisitor for Collect {
        fn visit<M: Method>(&mut self) {
            self.0.push(Entry {
                info: M::INFO,
                stored_numbers: M::Prepared::NUMBERS,
                f32: matrix::kernels::<M, f32>(),
                f64: matrix::kernels::<M, f64>(),
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

/// The method of that name.
pub fn find(name: &str) -> Option<&'static Entry> {
    entries().iter().find(|entry| entry.info.name == name)
}
