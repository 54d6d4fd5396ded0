//! Which instances are compiled.
//!
//! A width stands for the instruction set that it is native to. Timed kernels are compiled for
//! the scalar and for each instruction set with fused multiply-add where there is one; in plain
//! arithmetic beside it only what shows the difference. What is asked for less than a whole hit is
//! timed in f32 alone. Finders are compiled for every native lane type, plain and fused.

use std::marker::PhantomData;

use trisect_core::{
    Barycentrics, Deferred, Distance, Division, Early, InstructionSet, Lanes, LanesVisitor, Method,
    Needs, Newton, Occlusion, Precision, Token, TrueDivision,
};

use crate::Kernels;
use crate::kernel::{Arrangement, Finder, Kernel, Scene};

/// The compiled kernels of a method in one precision.
pub(crate) fn kernels<M: Method, E: Precision>() -> Kernels<E> {
    let mut collect = Collect::<M> { timed: Vec::new(), finders: Vec::new(), method: PhantomData };
    E::visit_native(&mut collect);
    Kernels { prepare: Scene::prepare::<M, E>, timed: collect.timed, finders: collect.finders }
}

struct Collect<M> {
    timed: Vec<Kernel>,
    finders: Vec<Finder>,
    method: PhantomData<M>,
}

impl<M: Method> LanesVisitor for Collect<M> {
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        self.finder::<L, Early<TrueDivision, true>>();
        self.finder::<L, Deferred<TrueDivision, true>>();
        self.divisions::<L, Barycentrics>(Arrangement::OneRay);
        // Inline constants, so that what is left out is not compiled either.
        if const { newton_differs::<L>() } {
            self.finder::<L, Deferred<Newton, true>>();
            self.timed::<L, Deferred<Newton, true>, Barycentrics>(Arrangement::OneRay);
            self.timed::<L, Deferred<Newton, false>, Barycentrics>(Arrangement::OneRay);
        }
        if const { !has_fused_twin::<L>() } {
            self.divisions::<L, Barycentrics>(Arrangement::OneTriangle);
            if const { size_of::<L::Elem>() == 4 } {
                self.divisions::<L, Distance>(Arrangement::OneRay);
                self.divisions::<L, Occlusion>(Arrangement::OneRay);
            }
        }
    }
}

impl<M: Method> Collect<M> {
    fn divisions<L: Lanes<Elem: Precision>, N: Needs>(&mut self, arrangement: Arrangement) {
        self.timed::<L, Early<TrueDivision, true>, N>(arrangement);
        self.timed::<L, Early<TrueDivision, false>, N>(arrangement);
        self.timed::<L, Deferred<TrueDivision, true>, N>(arrangement);
        self.timed::<L, Deferred<TrueDivision, false>, N>(arrangement);
    }

    fn timed<L: Lanes<Elem: Precision>, D: Division, N: Needs>(
        &mut self,
        arrangement: Arrangement,
    ) {
        self.timed.push(Kernel::new::<M, L, D, N>(arrangement));
    }

    fn finder<L: Lanes<Elem: Precision>, D: Division>(&mut self) {
        self.finders.push(Finder::new::<M, L, D>());
    }
}

/// Whether the processor has a reciprocal estimate for these lanes: without one, Newton steps
/// are not what is measured.
const fn newton_differs<L: Lanes>() -> bool {
    L::N > 1 && size_of::<L::Elem>() == 4
}

/// Whether these are plain lanes of an instruction set with fused multiply-add.
const fn has_fused_twin<L: Lanes>() -> bool {
    let fuses = matches!(
        L::Token::INSTRUCTION_SET,
        InstructionSet::Avx2 | InstructionSet::Avx512 | InstructionSet::Neon
    );
    fuses && !L::FUSED
}
