//! Which instances are compiled.
//!
//! A width stands for the instruction set that it is native to. Finders are compiled for each form of the
//! division that the method has on scalars and on lanes of 256 bits, plain and fused: those of others give the same
//! bits, which the methods' own tests hold them to. An exact method, whose promise is held to on every width, has them on all. Timed
//! kernels are compiled for what the tables show: in f32 the scalar in all needs, each instruction set
//! with fused multiply-add in all needs and arrangements; all others, and f64, with the fullest hit
//! alone. With the feature `full` everything is compiled for everything.

use std::marker::PhantomData;

use trisect_core::{Lanes, LanesVisitor, Precision, Token};
use trisect_kernels::{CommonDirection, CommonOrigin};
use trisect_method::{
    Barycentrics, DecisionOnly, Deferred, Distance, Division, Early, ExactMethod, Form, Method,
    Needs, Newton, Normal, Occlusion, Output, Point, Refine, TrueDivision,
};

use crate::kernel::{Arrange, Finder, Instances as _, Kernel, OneRay, OneTriangle, Scene};
use crate::{FlushingTest, Kernels};

/// Whether everything is compiled.
const FULL: bool = cfg!(feature = "full");

/// The compiled kernels of a method in one precision.
pub(crate) fn kernels<M: Method, E: Precision>() -> Kernels<E> {
    let mut collect = Collect::<M> {
        timed: Vec::new(),
        finders: Vec::new(),
        deciders: Vec::new(),
        method: PhantomData,
    };
    E::visit_native(&mut collect);
    let Collect { timed, finders, deciders, .. } = collect;
    Kernels { prepare: Scene::prepare::<M, E>, stage: M::stage::<E>, timed, finders, deciders }
}

/// The tests of a method in flushing arithmetic.
pub(crate) fn flushing<M: Method>() -> Vec<(Form, FlushingTest)> {
    let mut tests: Vec<(_, FlushingTest)> = Vec::new();
    if const { M::INFO.forms.early() } {
        tests.push((Form::Early, M::flushing::<Early<TrueDivision, true>>));
    }
    if const { M::INFO.forms.deferred() } {
        tests.push((Form::Deferred, M::flushing::<Deferred<TrueDivision, true>>));
    }
    tests
}

struct Collect<M> {
    timed: Vec<Kernel>,
    finders: Vec<Finder>,
    deciders: Vec<Finder>,
    method: PhantomData<M>,
}

impl<M: Method> LanesVisitor for Collect<M> {
    // Inline constants, so that what is left out is not compiled either.
    fn visit<L: Lanes<Elem: Precision>>(&mut self) {
        self.finders.extend(if const { FULL || answers::<L>() } {
            finders::<M, L>()
        } else {
            M::refine(ExactFinders::<L>(PhantomData))
        });
        if const { FULL && newton_differs::<L>() && M::INFO.forms.deferred() } {
            self.finders.push(Finder::new::<M, L, Deferred<Newton, true>>());
            self.fullest::<L, Deferred<Newton, true>, OneRay>();
            self.fullest::<L, Deferred<Newton, false>, OneRay>();
        }
        // A scalar gains by leaving early where lanes lose, as a rule: in f32 both are shown.
        if const { FULL || L::N == 1 || (is_single::<L>() && is_best::<L>()) } {
            self.each_form::<L, true, OneRay>();
        }
        if const { FULL || (is_single::<L>() && is_shown::<L>()) || is_best::<L>() } {
            self.each_form::<L, false, OneRay>();
        }
        if const { FULL || (is_single::<L>() && L::N == 1) } {
            self.occlusion::<L, true>();
            self.need::<L, Distance, true>();
        }
        if const { FULL || (is_single::<L>() && is_best::<L>()) } {
            self.occlusion::<L, false>();
            self.need::<L, Distance, false>();
            self.one_form::<L, OneTriangle>();
            self.one_form::<L, CommonOrigin>();
            self.one_form::<L, CommonDirection>();
            self.need::<L, Point, false>();
            self.need::<L, Normal, false>();
        }
        if const { M::INFO.decides_apart() && is_single::<L>() && (FULL || answers::<L>()) } {
            self.deciders.push(Finder::new::<M, L, DecisionOnly<Deferred<TrueDivision, true>>>());
        }
        if const { FULL } {
            self.each_form::<L, true, OneTriangle>();
        }
    }
}

impl<M: Method> Collect<M> {
    /// The fullest hit that the method gives, in each form that it has.
    fn each_form<L: Lanes<Elem: Precision>, const EARLY_OUT: bool, A: Arrange>(&mut self) {
        if const { M::INFO.forms.early() } {
            self.fullest::<L, Early<TrueDivision, EARLY_OUT>, A>();
        }
        if const { M::INFO.forms.deferred() } {
            self.fullest::<L, Deferred<TrueDivision, EARLY_OUT>, A>();
        }
    }

    /// The same without early-out in one form, the early one where there is one.
    fn one_form<L: Lanes<Elem: Precision>, A: Arrange>(&mut self) {
        if const { M::INFO.forms.early() } {
            self.fullest::<L, Early<TrueDivision, false>, A>();
        } else {
            self.fullest::<L, Deferred<TrueDivision, false>, A>();
        }
    }

    fn fullest<L: Lanes<Elem: Precision>, D: Division, A: Arrange>(&mut self) {
        if const { M::INFO.gives(Output::Barycentrics) } {
            self.timed.push(Kernel::new::<M, L, D, Barycentrics, A>());
        } else {
            self.push_once(Kernel::new::<M, L, D, Distance, A>());
        }
    }

    /// Whether there is a hit, in each form that the method has, and without a division where it can.
    fn occlusion<L: Lanes<Elem: Precision>, const EARLY_OUT: bool>(&mut self) {
        if const { M::INFO.forms.early() } {
            let kernel = Kernel::new::<M, L, Early<TrueDivision, EARLY_OUT>, Occlusion, OneRay>();
            self.timed.push(kernel);
        }
        if const { !M::INFO.always_divides } {
            let kernel =
                Kernel::new::<M, L, Deferred<TrueDivision, EARLY_OUT>, Occlusion, OneRay>();
            self.timed.push(kernel);
        }
    }

    /// What is asked, where the method gives it, in one form, the early one where there is one.
    fn need<L: Lanes<Elem: Precision>, N: Needs, const EARLY_OUT: bool>(&mut self) {
        if const { !M::INFO.gives(N::OUTPUT) } {
            return;
        }
        if const { M::INFO.forms.early() } {
            self.push_once(Kernel::new::<M, L, Early<TrueDivision, EARLY_OUT>, N, OneRay>());
        } else {
            self.push_once(Kernel::new::<M, L, Deferred<TrueDivision, EARLY_OUT>, N, OneRay>());
        }
    }

    /// Keeps a kernel unless there is one like it: for a method without barycentrics `t` is the
    /// fullest hit, and a need as well.
    fn push_once(&mut self, kernel: Kernel) {
        if self.timed.iter().all(|other| other.variant != kernel.variant) {
            self.timed.push(kernel);
        }
    }
}

/// The finders of a method on lanes of one type.
fn finders<M: Method, L: Lanes<Elem: Precision>>() -> Vec<Finder> {
    let mut finders = Vec::new();
    if const { M::INFO.forms.early() } {
        finders.push(Finder::new::<M, L, Early<TrueDivision, true>>());
    }
    if const { M::INFO.forms.deferred() } {
        finders.push(Finder::new::<M, L, Deferred<TrueDivision, true>>());
    }
    finders
}

/// The finders of an exact method; none of others.
struct ExactFinders<L>(PhantomData<L>);

impl<M: Method, L: Lanes<Elem: Precision>> Refine<M> for ExactFinders<L> {
    type Output = Vec<Finder>;

    fn rounded(self) -> Vec<Finder> {
        Vec::new()
    }

    fn exact(self) -> Vec<Finder>
    where
        M: ExactMethod,
    {
        finders::<M, L>()
    }
}

/// Whether the finders on these lanes answer for all that round as they do: scalars, which every processor has, and
/// lanes of at most 256 bits where the processor fuses, plain ones to be fast.
const fn answers<L: Lanes>() -> bool {
    let fuses = L::Token::INSTRUCTION_SET.has_fused_multiply_add();
    L::N == 1 || fuses && L::N * size_of::<L::Elem>() <= 32
}

/// Whether these lanes are of f32.
const fn is_single<L: Lanes>() -> bool {
    size_of::<L::Elem>() == 4
}

/// Whether these lanes are the best of their instruction set: fused where there is fused
/// multiply-add.
const fn is_best<L: Lanes>() -> bool {
    L::FUSED
}

/// Whether lanes that are not the best are shown: those of instruction sets without fused
/// multiply-add, and plain ones on AVX2 to show the difference.
const fn is_shown<L: Lanes>() -> bool {
    !has_fused_twin::<L>() || L::N == 8
}

/// Whether the processor has a reciprocal estimate for these lanes: without one, Newton steps
/// are not what is measured.
const fn newton_differs<L: Lanes>() -> bool {
    L::N > 1 && is_single::<L>()
}

/// Whether these are plain lanes of an instruction set with fused multiply-add.
const fn has_fused_twin<L: Lanes>() -> bool {
    L::Token::INSTRUCTION_SET.has_fused_multiply_add() && !L::FUSED
}
