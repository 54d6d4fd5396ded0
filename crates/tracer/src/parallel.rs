//! Work shared between the threads of the pool that it is called in. What is to be done stands behind
//! pointers, so that sharing it out is compiled once, not for every method.

use rayon::prelude::*;

/// A part of the work.
pub(crate) type Task<'a> = Box<dyn FnOnce() + Send + 'a>;

/// Does all parts of the work, in no order; one alone on the calling thread.
pub(crate) fn all<'a>(tasks: impl Iterator<Item = Task<'a>>) {
    let mut tasks: Vec<Task<'a>> = tasks.collect();
    if tasks.len() == 1 {
        tasks.drain(..).for_each(|task| task());
    } else {
        tasks.into_par_iter().for_each(|task| task());
    }
}

/// What is made of so many at least is shared out.
const PART: usize = 1024;

/// What is made of each, in order.
pub(crate) fn each<T: Sync, X: Copy + Send>(
    inputs: &[T],
    nothing: X,
    of: impl Fn(&T) -> X + Sync,
) -> Vec<X> {
    let mut outputs = vec![nothing; inputs.len()];
    let of = &of;
    let parts = inputs.chunks(PART).zip(outputs.chunks_mut(PART));
    all(parts.map(|(inputs, outputs)| -> Task<'_> {
        Box::new(move || {
            for (input, output) in inputs.iter().zip(outputs) {
                *output = of(input);
            }
        })
    }));
    outputs
}
