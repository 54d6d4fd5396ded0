//! Numbers that record what is done to them.

use core::cell::RefCell;
use core::cmp::Ordering;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

use trisect_core::{FloatFormat, Lanes, Number, Scalar};

use crate::builder::{self, Builder};
use crate::graph::{Node, Op, Tree};

/// What is being recorded on this thread.
struct Recorder {
    builder: Builder,
    /// The first answers to give.
    script: Vec<bool>,
    /// What was asked on this path, and answered.
    asked: Vec<(Node, bool)>,
    /// Whether a number was looked at, which a formula does not: what follows is not recorded.
    has_left: bool,
}

thread_local! {
    static RECORDER: RefCell<Recorder> = RefCell::new(Recorder {
        builder: Builder::new(FloatFormat::F32),
        script: Vec::new(),
        asked: Vec::new(),
        has_left: false,
    });
}

fn recorder<R>(f: impl FnOnce(&mut Recorder) -> R) -> R {
    RECORDER.with_borrow_mut(f)
}

/// Records an operation. Out of line: formulas are inlined whole.
#[inline(never)]
fn push(op: Op) -> Node {
    recorder(|recorder| recorder.builder.push(op))
}

#[inline(never)]
fn constant(value: f64) -> Node {
    recorder(|recorder| recorder.builder.number(value))
}

/// The answer to a question that decides which operations follow: that of the script, and then no.
#[inline(never)]
fn decide(test: Node) -> bool {
    recorder(|recorder| {
        if let Some(holds) = recorder.builder.truth(test) {
            return holds;
        }
        if let Some(&(_, answer)) = recorder.asked.iter().find(|(asked, _)| *asked == test) {
            return answer;
        }
        let answer = recorder.script.get(recorder.asked.len()).copied().unwrap_or(false);
        recorder.asked.push((test, answer));
        answer
    })
}

/// What a path through a formula ends with.
pub(crate) struct Path {
    /// What was asked and answered.
    pub(crate) asked: Vec<(Node, bool)>,
    /// Whether it goes on where nothing is recorded.
    pub(crate) has_left: bool,
}

/// Records all paths through `run` over numbers of a format, whose outputs are those of `outputs`.
pub(crate) fn record<R>(
    format: FloatFormat,
    mut run: impl FnMut() -> R,
    mut outputs: impl FnMut(R, &Path) -> Vec<Node>,
) -> (Builder, Tree) {
    recorder(|recorder| recorder.builder = Builder::new(format));
    let tree = explore(&[], &mut run, &mut outputs);
    let builder = recorder(|recorder| recorder.builder.clone());
    (builder, tree)
}

fn explore<R>(
    script: &[bool],
    run: &mut impl FnMut() -> R,
    outputs: &mut impl FnMut(R, &Path) -> Vec<Node>,
) -> Tree {
    recorder(|recorder| {
        recorder.script = script.to_vec();
        recorder.asked.clear();
        recorder.has_left = false;
    });
    let result = run();
    let path = recorder(|recorder| Path {
        asked: core::mem::take(&mut recorder.asked),
        has_left: recorder.has_left,
    });
    let mut tree = Tree::Leaf(outputs(result, &path));
    let answers: Vec<bool> = path.asked.iter().map(|(_, answer)| *answer).collect();
    for place in (script.len()..answers.len()).rev() {
        let mut other = answers[..place].to_vec();
        other.push(true);
        let yes = Box::new(explore(&other, run, outputs));
        tree = Tree::If { test: path.asked[place].0, yes, no: Box::new(tree) };
    }
    tree
}

/// How many operations have been recorded.
pub(crate) fn recorded() -> usize {
    recorder(|recorder| recorder.builder.ops.len())
}

/// A truth value of lanes that record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth(pub(crate) Node);

impl BitAnd for Truth {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        Self(push(Op::And(self.0, other.0)))
    }
}

impl BitOr for Truth {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(push(Op::Or(self.0, other.0)))
    }
}

/// Lanes that record: comparisons give truth values that are recorded as well.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Symbol(pub(crate) Node);

/// A scalar that records. A comparison is a question: each answer is a path of its own, and all are recorded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorded(pub(crate) Node);

/// An input of the formula, by its place.
pub(crate) fn input(place: usize) -> Node {
    push(builder::input(place))
}

macro_rules! number {
    ($number:ident: $($trait:ident $method:ident),+) => {
        $(impl $trait for $number {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(push(Op::$trait(self.0, other.0)))
            }
        })+

        impl Neg for $number {
            type Output = Self;
            fn neg(self) -> Self {
                Self(push(Op::Neg(self.0)))
            }
        }

        impl Number for $number {
            fn mul_add(self, b: Self, c: Self) -> Self {
                Self(push(Op::MulAdd(self.0, b.0, c.0)))
            }
            fn mul_sub(self, b: Self, c: Self) -> Self {
                Self(push(Op::MulSub(self.0, b.0, c.0)))
            }
        }
    };
}
number!(Symbol: Add add, Sub sub, Mul mul, Div div);
number!(Recorded: Add add, Sub sub, Mul mul, Div div);

/// What both have as lanes; `$truth` makes a truth value of a recorded one, `$holds` the recorded one of it.
macro_rules! lanes {
    ($number:ident, $mask:ident, |$node:ident| $truth:expr) => {
        impl Lanes for $number {
            type Elem = Recorded;
            type Mask = $mask;
            type Token = ();
            const FUSED: bool = false;
            const N: usize = 1;

            fn splat((): (), x: Recorded) -> Self {
                Self(x.0)
            }
            fn load((): (), xs: &[Recorded]) -> Self {
                Self(xs[0].0)
            }
            fn store(self, xs: &mut [Recorded]) {
                xs[0] = Recorded(self.0);
            }
            fn token(self) {}
            fn reciprocal_estimate(self) -> Self {
                Self(push(Op::Div(constant(1.0), self.0)))
            }
            fn lt(self, b: Self) -> $mask {
                let $node = push(Op::Lt(self.0, b.0));
                $truth
            }
            fn le(self, b: Self) -> $mask {
                let $node = push(Op::Le(self.0, b.0));
                $truth
            }
            fn xor_sign(self, s: Self) -> Self {
                Self(push(Op::XorSign(self.0, s.0)))
            }
            fn min(self, b: Self) -> Self {
                Self(push(Op::Min(self.0, b.0)))
            }
            fn max(self, b: Self) -> Self {
                Self(push(Op::Max(self.0, b.0)))
            }
            fn interleave(self, b: Self) -> (Self, Self) {
                (self, b)
            }
            lanes!(@masks $mask);
        }
    };
    (@masks Truth) => {
        fn select(m: Truth, a: Self, b: Self) -> Self {
            Self(push(Op::Select(m.0, a.0, b.0)))
        }
        // What is done where any lane holds changes nothing where none does: it is recorded for all.
        fn any(m: Truth) -> bool {
            recorder(|recorder| recorder.builder.truth(m.0)).unwrap_or(true)
        }
        fn bits(m: Truth) -> u64 {
            u64::from(decide(m.0))
        }
    };
    (@masks bool) => {
        fn select(m: bool, a: Self, b: Self) -> Self {
            if m { a } else { b }
        }
        fn any(m: bool) -> bool {
            m
        }
        fn bits(m: bool) -> u64 {
            u64::from(m)
        }
    };
}
lanes!(Symbol, Truth, |node| Truth(node));
lanes!(Recorded, bool, |node| decide(node));

impl PartialEq for Recorded {
    fn eq(&self, other: &Self) -> bool {
        Lanes::le(*self, *other) && Lanes::le(*other, *self)
    }
}

impl PartialOrd for Recorded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        if self == other {
            Some(Ordering::Equal)
        } else if Lanes::lt(*self, *other) {
            Some(Ordering::Less)
        } else {
            Lanes::lt(*other, *self).then_some(Ordering::Greater)
        }
    }
    fn lt(&self, other: &Self) -> bool {
        Lanes::lt(*self, *other)
    }
    fn le(&self, other: &Self) -> bool {
        Lanes::le(*self, *other)
    }
    fn gt(&self, other: &Self) -> bool {
        Lanes::lt(*other, *self)
    }
    fn ge(&self, other: &Self) -> bool {
        Lanes::le(*other, *self)
    }
}

/// A number of the format that is recorded.
fn of_format(of_f32: f32, of_f64: f64) -> Recorded {
    let format = recorder(|recorder| recorder.builder.format);
    Recorded(constant(if format == FloatFormat::F32 { f64::from(of_f32) } else { of_f64 }))
}

impl Scalar for Recorded {
    fn from_f64(value: f64) -> Self {
        Self(constant(value))
    }
    /// The number where it is known; NaN where not, and then nothing that follows is recorded.
    fn to_f64(self) -> f64 {
        recorder(|recorder| {
            let value = recorder.builder.value(self.0);
            recorder.has_left |= value.is_none();
            value.unwrap_or(f64::NAN)
        })
    }
    fn largest_t() -> Self {
        of_format(f32::largest_t(), f64::largest_t())
    }
    fn smallest_det() -> Self {
        of_format(f32::smallest_det(), f64::smallest_det())
    }
    fn unit_roundoff() -> Self {
        of_format(f32::unit_roundoff(), f64::unit_roundoff())
    }
    fn splitter() -> Self {
        of_format(f32::splitter(), f64::splitter())
    }
    fn abs(self) -> Self {
        Self(push(Op::Abs(self.0)))
    }
}

/// A whole number, as a number of the formula.
pub(crate) fn index(value: usize) -> Node {
    constant(f64::from(u32::try_from(value).expect("indices are few")))
}

/// A truth value that is known.
pub(crate) fn truth(holds: bool) -> Node {
    push(Op::Truth(holds))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(of: impl FnMut() -> Vec<Node>) -> (Builder, Tree) {
        record(FloatFormat::F32, of, |nodes, _| nodes)
    }

    #[test]
    fn equal_operations_are_one_and_products_with_one_none() {
        let (builder, tree) = numbers(|| {
            let (x, y) = (Symbol(input(0)), Symbol(input(1)));
            let one = Symbol(constant(1.0));
            vec![(x * y).0, (x * y * one).0, (one.mul_add(x, y)).0]
        });
        let [product, again, sum] = tree.usual() else { panic!("three outputs") };
        assert_eq!(product, again);
        assert!(matches!(builder.op(*sum), Op::Add(..)));
    }

    #[test]
    fn each_answer_to_a_question_is_a_path() {
        let (_, tree) = numbers(|| {
            let (x, y) = (Recorded(input(0)), Recorded(input(1)));
            // The same question again is no other one.
            let first = if x < y { x } else { y };
            vec![first.0, if x < y { first.0 } else { x.0 }]
        });
        let Tree::If { yes, no, .. } = &tree else { panic!("one question") };
        assert_eq!(yes.usual(), [Node(0), Node(0)]);
        assert_eq!(no.usual(), [Node(1), Node(0)]);
    }

    #[test]
    fn constants_are_of_the_format_that_is_recorded() {
        let value = |format| {
            let (builder, tree) = record(format, || Recorded::largest_t().0, |node, _| vec![node]);
            builder.value(tree.usual()[0])
        };
        assert_eq!(value(FloatFormat::F32), Some(f64::from(f32::MAX / 2.0)));
        assert_eq!(value(FloatFormat::F64), Some(f64::MAX / 2.0));
    }
}
