//! Graphs as they are built.

use std::collections::HashMap;

use trisect_core::FloatFormat;

use crate::graph::{Constant, Node, Op, Tree};

/// Operations as they are built: each once, and none that gives what is there already, to the bit.
#[derive(Clone, Debug)]
pub(crate) struct Builder {
    pub(crate) format: FloatFormat,
    pub(crate) ops: Vec<Op>,
    nodes: HashMap<Op, Node>,
}

impl Builder {
    pub(crate) fn new(format: FloatFormat) -> Self {
        Self { format, ops: Vec::new(), nodes: HashMap::new() }
    }

    /// The operation at a node.
    pub(crate) fn op(&self, node: Node) -> Op {
        self.ops[node.place()]
    }

    /// The number, where it is known.
    pub(crate) fn value(&self, node: Node) -> Option<f64> {
        if let Op::Const(constant) = self.op(node) { Some(constant.value()) } else { None }
    }

    /// What is there already, to be added to.
    pub(crate) fn of(format: FloatFormat, ops: Vec<Op>) -> Self {
        let nodes = (0..).zip(&ops).map(|(place, &op)| (op, Node(place))).collect();
        Self { format, ops, nodes }
    }

    /// Whether a node is a truth value.
    fn is_truth(&self, node: Node) -> bool {
        self.op(node).is_truth()
    }

    /// The truth value, where it is known.
    pub(crate) fn truth(&self, node: Node) -> Option<bool> {
        if let Op::Truth(holds) = self.op(node) { Some(holds) } else { None }
    }

    /// The node of a number.
    pub(crate) fn number(&mut self, value: f64) -> Node {
        let value = rounded(self.format, value);
        self.add(Op::Const(Constant::new(value)))
    }

    /// The node of an operation.
    pub(crate) fn push(&mut self, op: Op) -> Node {
        if let Some(known) = self.known(op) {
            return self.add(known);
        }
        match op {
            // A product with 1 rounds nothing.
            Op::Mul(a, b) if self.value(a) == Some(1.0) => b,
            Op::Mul(a, b) if self.value(b) == Some(1.0) => a,
            Op::MulAdd(a, b, c) if self.value(a) == Some(1.0) => self.push(Op::Add(b, c)),
            Op::MulAdd(a, b, c) if self.value(b) == Some(1.0) => self.push(Op::Add(a, c)),
            Op::MulSub(a, b, c) if self.value(a) == Some(1.0) => self.push(Op::Sub(b, c)),
            Op::MulSub(a, b, c) if self.value(b) == Some(1.0) => self.push(Op::Sub(a, c)),
            Op::XorSign(a, b) if a == b => self.push(Op::Abs(a)),
            Op::Select(_, a, b) | Op::And(a, b) | Op::Or(a, b) if a == b => a,
            Op::Neg(a) => match self.op(a) {
                Op::Neg(x) => x,
                _ => self.add(op),
            },
            Op::Not(a) => match self.op(a) {
                Op::Not(x) => x,
                _ => self.add(op),
            },
            Op::Abs(a) if matches!(self.op(a), Op::Abs(_)) => a,
            Op::XorSign(a, b) => match self.value(b) {
                Some(sign) if sign.is_sign_negative() => self.push(Op::Neg(a)),
                Some(_) => a,
                None => self.add(op),
            },
            Op::Select(mask, a, b) => match self.truth(mask) {
                Some(true) => a,
                Some(false) => b,
                None => self.add(op),
            },
            Op::And(a, b) => match (self.truth(a), self.truth(b)) {
                (Some(true), _) | (_, Some(false)) => b,
                (Some(false), _) | (_, Some(true)) => a,
                _ => self.add(op),
            },
            Op::Or(a, b) => match (self.truth(a), self.truth(b)) {
                (Some(true), _) | (_, Some(false)) => a,
                (Some(false), _) | (_, Some(true)) => b,
                _ => self.add(op),
            },
            op => self.add(op),
        }
    }

    /// What an operation on known values gives; f64 holds what f32 gives until it is rounded.
    fn known(&self, op: Op) -> Option<Op> {
        let x = |node| self.value(node);
        let value = match op {
            Op::Add(a, b) => x(a)? + x(b)?,
            Op::Sub(a, b) => x(a)? - x(b)?,
            Op::Mul(a, b) => x(a)? * x(b)?,
            Op::Div(a, b) => x(a)? / x(b)?,
            Op::MulAdd(a, b, c) => rounded(self.format, x(a)? * x(b)?) + x(c)?,
            Op::MulSub(a, b, c) => rounded(self.format, x(a)? * x(b)?) - x(c)?,
            Op::Neg(a) => -x(a)?,
            Op::Abs(a) => x(a)?.abs(),
            Op::Lt(a, b) => return Some(Op::Truth(x(a)? < x(b)?)),
            Op::Le(a, b) => return Some(Op::Truth(x(a)? <= x(b)?)),
            Op::Not(a) => return Some(Op::Truth(!self.truth(a)?)),
            _ => return None,
        };
        Some(Op::Const(Constant::new(rounded(self.format, value))))
    }

    fn add(&mut self, op: Op) -> Node {
        let next = Node(u32::try_from(self.ops.len()).expect("a formula is not that long"));
        *self.nodes.entry(op).or_insert_with(|| {
            self.ops.push(op);
            next
        })
    }
}

/// The nearest number of a format.
pub(crate) fn rounded(format: FloatFormat, value: f64) -> f64 {
    #[allow(clippy::cast_possible_truncation, reason = "rounding to f32 is what is asked")]
    match format {
        FloatFormat::F32 => f64::from(value as f32),
        FloatFormat::F64 => value,
    }
}

/// An input, by its place.
pub(crate) fn input(place: usize) -> Op {
    Op::In(u32::try_from(place).expect("inputs are few"))
}

/// The leaves of a tree as one, its truth values by logic and its numbers by choices.
pub(crate) fn joined(builder: &mut Builder, tree: &Tree) -> Vec<Node> {
    let (test, yes, no) = match tree {
        Tree::Leaf(outputs) => return outputs.clone(),
        Tree::If { test, yes, no } => (*test, joined(builder, yes), joined(builder, no)),
    };
    let not = builder.push(Op::Not(test));
    let mut join = |(yes, no): (Node, Node)| {
        if yes == no {
            yes
        } else if builder.is_truth(yes) {
            let (yes, no) = (builder.push(Op::And(test, yes)), builder.push(Op::And(not, no)));
            builder.push(Op::Or(yes, no))
        } else {
            builder.push(Op::Select(test, yes, no))
        }
    };
    yes.into_iter().zip(no).map(&mut join).collect()
}
