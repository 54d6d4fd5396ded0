//! Work that is shared between the threads of the pool that it is called in. The parts are behind pointers, so
//! that the sharing is compiled once, not for every method.

use rayon::prelude::*;

/// A part of the work.
pub(crate) type Task<'a> = Box<dyn FnOnce() + Send + 'a>;

/// Does all parts of the work, in any order; a single part on the calling thread.
pub(crate) fn all<'a>(tasks: impl Iterator<Item = Task<'a>>) {
    let mut tasks: Vec<Task<'a>> = tasks.collect();
    if tasks.len() == 1 {
        tasks.drain(..).for_each(|task| task());
    } else {
        tasks.into_par_iter().for_each(|task| task());
    }
}

/// From so many references of a tree on, work is shared between threads: fewer are done before another thread
/// would have begun.
pub(crate) const PARALLEL: usize = 4096;

/// The results of both sides of a split of so many references; of two threads where they are many.
pub(crate) fn both<X: Send>(
    count: usize,
    left: impl FnOnce() -> X + Send,
    right: impl FnOnce() -> X + Send,
) -> (X, X) {
    if count >= PARALLEL { rayon::join(left, right) } else { (left(), right()) }
}

/// So many items at least are one part of the work.
pub(crate) const PART: usize = 1024;

/// The result for each input, in order.
pub(crate) fn each<T: Sync, X: Copy + Send>(
    inputs: &[T],
    nothing: X,
    of: impl Fn(&T) -> X + Sync,
) -> Vec<X> {
    let mut outputs = vec![nothing; inputs.len()];
    fill(inputs, &mut outputs, |_, input| of(input));
    outputs
}

/// Computes the output for each input and its index, in the same place.
pub(crate) fn fill<T: Sync, X: Send>(
    inputs: &[T],
    outputs: &mut [X],
    of: impl Fn(usize, &T) -> X + Sync,
) {
    let of = &of;
    let parts = inputs.chunks(PART).zip(outputs.chunks_mut(PART)).enumerate();
    all(parts.map(|(part, (inputs, outputs))| -> Task<'_> {
        Box::new(move || {
            for (at, (input, output)) in inputs.iter().zip(outputs).enumerate() {
                *output = of(part * PART + at, input);
            }
        })
    }));
}
