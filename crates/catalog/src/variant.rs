//! Which compiled variant of which method.

use std::borrow::Cow;
use std::cmp::Ordering;

use serde::{Deserialize, Serialize};
use trisect_core::{FloatFormat, InstructionSet, Lanes, MultiplyAdd, Precision, Token};
use trisect_kernels::Arrangement;
use trisect_method::{Division, Form, Method, Output, Reciprocal, ReciprocalKind};

/// A lane type, as a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lane {
    /// The format of each number.
    pub precision: FloatFormat,
    /// How many lanes; 1 is the scalar.
    pub width: usize,
    /// The instructions it is compiled for.
    pub instruction_set: InstructionSet,
    /// How `a·b + c` is rounded.
    pub arithmetic: MultiplyAdd,
}

impl Lane {
    /// The value that stands for `L`.
    pub fn of<L: Lanes<Elem: Precision>>() -> Self {
        Self {
            precision: <L::Elem as trisect_core::Float>::FORMAT,
            width: L::N,
            instruction_set: L::Token::INSTRUCTION_SET,
            arithmetic: if L::FUSED { MultiplyAdd::Fused } else { MultiplyAdd::Plain },
        }
    }
}

/// A compiled variant of a method: as the catalogue lists it, and as records hold it. Ordered by names.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Variant {
    /// Name of the method. Records may name methods that this build lacks.
    pub method: Cow<'static, str>,
    /// The format of each number.
    pub precision: FloatFormat,
    /// Lanes; 1 is the scalar.
    pub width: usize,
    /// The instructions it is compiled for.
    pub instruction_set: InstructionSet,
    /// How `a·b + c` is rounded.
    pub arithmetic: MultiplyAdd,
    /// What the lanes hold.
    pub arrangement: Arrangement,
    /// When it divides.
    pub division: Form,
    /// How it divides.
    pub reciprocal: ReciprocalKind,
    /// Whether a test ends as soon as no lane can hit.
    pub early_out: bool,
    /// What is asked of a hit.
    pub needs: Output,
}

impl Variant {
    /// The value that stands for a kernel.
    pub(crate) fn of<M: Method, L: Lanes<Elem: Precision>, D: Division>(
        arrangement: Arrangement,
        needs: Output,
    ) -> Self {
        let Lane { precision, width, instruction_set, arithmetic } = Lane::of::<L>();
        Self {
            method: Cow::Borrowed(M::INFO.name),
            precision,
            width,
            instruction_set,
            arithmetic,
            arrangement,
            division: D::FORM,
            reciprocal: D::Reciprocal::KIND,
            early_out: D::EARLY_OUT,
            needs,
        }
    }

    /// Its lane type.
    pub fn lane(&self) -> Lane {
        let Self { precision, width, instruction_set, arithmetic, .. } = *self;
        Lane { precision, width, instruction_set, arithmetic }
    }

    /// Whether this processor has the instructions.
    pub fn is_available(&self) -> bool {
        self.instruction_set.is_available()
    }

    /// Whether it rounds every operation once and alone: the same bits on every machine.
    pub fn is_plain(&self) -> bool {
        self.arithmetic == MultiplyAdd::Plain && self.reciprocal == ReciprocalKind::True
    }

    /// Whether both round alike, operation by operation: variants of one method that do so give the same
    /// values on every width, but for what an instruction set's own estimate adds.
    pub fn rounds_like(&self, other: &Self) -> bool {
        let key = |v: &Self| (v.precision, v.arithmetic, v.division, v.reciprocal);
        self.method == other.method && key(self) == key(other)
    }

    /// Whether both round alike on lanes of the same type: they decide alike, whatever is asked and in
    /// whatever arrangement.
    pub fn computes_like(&self, other: &Self) -> bool {
        self.rounds_like(other) && self.lane() == other.lane()
    }

    /// The one among some variants that answers for this one: the one on its lanes, or else one that rounds as it
    /// does.
    pub fn answered_by<'a, T>(
        &self,
        mut among: impl Iterator<Item = &'a T> + Clone,
        variant: impl Fn(&T) -> &Self,
    ) -> Option<&'a T> {
        among
            .clone()
            .find(|one| variant(one).computes_like(self))
            .or_else(|| among.find(|one| variant(one).rounds_like(self)))
    }

    /// Whether it does what a tracer does at a leaf: one ray against f32 lanes, as fused as the processor
    /// has them, and no more than the eight triangles of a block.
    pub fn is_as_in_a_tracer(&self) -> bool {
        self.precision == FloatFormat::F32
            && self.arrangement == Arrangement::OneRay
            && self.arithmetic == MultiplyAdd::Fused
            && (2..=8).contains(&self.width)
    }

    /// What it is ordered by.
    fn key(&self) -> impl Ord + '_ {
        (
            (&self.method, self.precision.name(), self.width, self.instruction_set.name()),
            (self.arithmetic.name(), self.arrangement.name(), self.division.name()),
            (self.reciprocal.name(), self.early_out, self.needs.name()),
        )
    }
}

impl PartialOrd for Variant {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Variant {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}
