//! A formula as data: what is computed, number by number.

use trisect_core::{Float, FloatFormat, Scalar};

use crate::builder::{self, Builder, joined};
use crate::ops::Ops;

/// A number or a truth value of a [`Graph`]: the place of what computes it. Operands come before what uses them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node(pub(crate) u32);

impl Node {
    /// The place as an index.
    pub(crate) fn place(self) -> usize {
        self.0 as usize
    }
}

/// A constant: a number of the graph's format. Constants are one where their bits are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Constant(u64);

impl Constant {
    /// The constant of that value.
    pub fn new(value: f64) -> Self {
        Self(value.to_bits())
    }

    /// Its value.
    pub fn value(self) -> f64 {
        f64::from_bits(self.0)
    }
}

/// An operation, or what it starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    /// A number that is known before.
    Const(Constant),
    /// A truth value that is known before.
    Truth(bool),
    /// An input, by its place among [`Graph::inputs`].
    In(u32),
    /// `a + b`
    Add(Node, Node),
    /// `a − b`
    Sub(Node, Node),
    /// `a · b`
    Mul(Node, Node),
    /// `a / b`
    Div(Node, Node),
    /// `a · b + c`, rounded twice in plain arithmetic, once in fused.
    MulAdd(Node, Node, Node),
    /// `a · b − c`, likewise.
    MulSub(Node, Node, Node),
    /// `−a`
    Neg(Node),
    /// `|a|`
    Abs(Node),
    /// `a`, its sign flipped where the sign bit of `b` is set.
    XorSign(Node, Node),
    /// The smaller of two; `b` where either is NaN.
    Min(Node, Node),
    /// The larger of two; `b` where either is NaN.
    Max(Node, Node),
    /// `a` where the truth value, which comes first, holds, else `b`.
    Select(Node, Node, Node),
    /// `a < b`
    Lt(Node, Node),
    /// `a ≤ b`
    Le(Node, Node),
    /// Both.
    And(Node, Node),
    /// Either, or both.
    Or(Node, Node),
    /// The other truth value.
    Not(Node),
}

impl Op {
    /// The operands, in order.
    pub fn operands(self) -> impl DoubleEndedIterator<Item = Node> {
        let (all, count) = match self {
            Self::Const(_) | Self::Truth(_) | Self::In(_) => ([Node(0); 3], 0),
            Self::Neg(a) | Self::Abs(a) | Self::Not(a) => ([a; 3], 1),
            Self::Add(a, b)
            | Self::Sub(a, b)
            | Self::Mul(a, b)
            | Self::Div(a, b)
            | Self::XorSign(a, b)
            | Self::Min(a, b)
            | Self::Max(a, b)
            | Self::Lt(a, b)
            | Self::Le(a, b)
            | Self::And(a, b)
            | Self::Or(a, b) => ([a, b, b], 2),
            Self::MulAdd(a, b, c) | Self::MulSub(a, b, c) | Self::Select(a, b, c) => ([a, b, c], 3),
        };
        all.into_iter().take(count)
    }

    /// Whether it gives a truth value.
    pub(crate) fn is_truth(self) -> bool {
        matches!(
            self,
            Self::Truth(_)
                | Self::Lt(..)
                | Self::Le(..)
                | Self::And(..)
                | Self::Or(..)
                | Self::Not(_)
        )
    }

    /// The same operation on other operands.
    pub(crate) fn map(self, mut f: impl FnMut(Node) -> Node) -> Self {
        match self {
            Self::Const(_) | Self::Truth(_) | Self::In(_) => self,
            Self::Add(a, b) => Self::Add(f(a), f(b)),
            Self::Sub(a, b) => Self::Sub(f(a), f(b)),
            Self::Mul(a, b) => Self::Mul(f(a), f(b)),
            Self::Div(a, b) => Self::Div(f(a), f(b)),
            Self::MulAdd(a, b, c) => Self::MulAdd(f(a), f(b), f(c)),
            Self::MulSub(a, b, c) => Self::MulSub(f(a), f(b), f(c)),
            Self::Neg(a) => Self::Neg(f(a)),
            Self::Abs(a) => Self::Abs(f(a)),
            Self::XorSign(a, b) => Self::XorSign(f(a), f(b)),
            Self::Min(a, b) => Self::Min(f(a), f(b)),
            Self::Max(a, b) => Self::Max(f(a), f(b)),
            Self::Select(a, b, c) => Self::Select(f(a), f(b), f(c)),
            Self::Lt(a, b) => Self::Lt(f(a), f(b)),
            Self::Le(a, b) => Self::Le(f(a), f(b)),
            Self::And(a, b) => Self::And(f(a), f(b)),
            Self::Or(a, b) => Self::Or(f(a), f(b)),
            Self::Not(a) => Self::Not(f(a)),
        }
    }
}

/// Which outputs hold: those of one leaf, which truth values lead to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tree {
    /// The outputs.
    Leaf(Vec<Node>),
    /// A choice.
    If {
        /// What is asked.
        test: Node,
        /// Where it holds.
        yes: Box<Tree>,
        /// Where it does not.
        no: Box<Tree>,
    },
}

impl Tree {
    /// The leaf of a pair that nothing special is true of: no question is answered with yes. It is the only one of
    /// a formula without branches.
    pub fn usual(&self) -> &[Node] {
        match self {
            Self::Leaf(outputs) => outputs,
            Self::If { no, .. } => no.usual(),
        }
    }

    /// The questions on the way to that leaf.
    pub(crate) fn usual_questions(&self) -> Vec<Node> {
        match self {
            Self::Leaf(_) => Vec::new(),
            Self::If { test, no, .. } => {
                let mut tests = no.usual_questions();
                tests.push(*test);
                tests
            }
        }
    }

    /// All questions.
    pub(crate) fn questions(&self) -> Vec<Node> {
        match self {
            Self::Leaf(_) => Vec::new(),
            Self::If { test, yes, no } => {
                let mut tests = vec![*test];
                tests.extend(yes.questions());
                tests.extend(no.questions());
                tests
            }
        }
    }

    /// The leaves, each once.
    pub(crate) fn leaves(&self) -> Vec<&[Node]> {
        match self {
            Self::Leaf(outputs) => vec![outputs],
            Self::If { yes, no, .. } => {
                let mut leaves = yes.leaves();
                for leaf in no.leaves() {
                    if !leaves.contains(&leaf) {
                        leaves.push(leaf);
                    }
                }
                leaves
            }
        }
    }

    pub(crate) fn map(&self, f: &mut impl FnMut(Node) -> Node) -> Self {
        match self {
            Self::Leaf(outputs) => Self::Leaf(outputs.iter().map(|&node| f(node)).collect()),
            Self::If { test, yes, no } => {
                Self::If { test: f(*test), yes: Box::new(yes.map(f)), no: Box::new(no.map(f)) }
            }
        }
    }
}

/// A formula as a graph of operations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Graph {
    /// The format that constants are of.
    pub format: FloatFormat,
    /// The names of the inputs.
    pub inputs: Vec<String>,
    /// The operations, operands first.
    pub ops: Vec<Op>,
    /// The names of the outputs.
    pub outputs: Vec<String>,
    /// The outputs.
    pub tree: Tree,
}

/// What a graph gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<E> {
    /// A number.
    Number(E),
    /// A truth value.
    Truth(bool),
}

impl<E: Copy> Value<E> {
    /// The number.
    pub fn number(self) -> Option<E> {
        if let Self::Number(x) = self { Some(x) } else { None }
    }

    /// Whether it is a truth value that holds.
    pub fn holds(self) -> bool {
        matches!(self, Self::Truth(true))
    }
}

/// How many operations a rare branch must have to be one: fewer are done and thrown away.
const RARE: usize = 8;

/// What operations take from their operands to their result, in cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latencies {
    /// A sum, a product, or both in one.
    pub arithmetic: u32,
    /// Whether a sum of a product is one operation.
    pub fused: bool,
    /// A quotient.
    pub division: u32,
    /// A comparison, the smaller or the larger of two.
    pub comparison: u32,
    /// An operation on bits or truth values, or a choice.
    pub bits: u32,
}

impl Latencies {
    /// f32 on Intel's cores since Ice Lake: A. Fog, Instruction tables, 2022.
    pub const ICE_LAKE: Self =
        Self { arithmetic: 4, fused: true, division: 11, comparison: 4, bits: 1 };
}

impl Graph {
    /// The operation at a node.
    pub fn op(&self, node: Node) -> Op {
        self.ops[node.place()]
    }

    /// The value of a constant.
    pub(crate) fn constant(&self, node: Node) -> Option<f64> {
        if let Op::Const(constant) = self.op(node) { Some(constant.value()) } else { None }
    }

    /// The output of that name, of the [usual](Tree::usual) leaf.
    pub fn output(&self, name: &str) -> Option<Node> {
        let place = self.outputs.iter().position(|output| output == name)?;
        self.tree.usual().get(place).copied()
    }

    /// Computes the outputs in plain arithmetic.
    ///
    /// # Panics
    /// When there are fewer numbers than inputs.
    pub fn run<E: Float>(&self, inputs: &[E]) -> Vec<Value<E>> {
        let mut numbers = vec![E::from_f64(0.0); self.ops.len()];
        let mut truths = vec![false; self.ops.len()];
        for (place, &op) in self.ops.iter().enumerate() {
            let (x, is) = (|node: Node| numbers[node.place()], |node: Node| truths[node.place()]);
            let value = match op {
                Op::Const(constant) => Value::Number(E::from_f64(constant.value())),
                Op::In(input) => Value::Number(inputs[input as usize]),
                Op::Add(a, b) => Value::Number(x(a) + x(b)),
                Op::Sub(a, b) => Value::Number(x(a) - x(b)),
                Op::Mul(a, b) => Value::Number(x(a) * x(b)),
                Op::Div(a, b) => Value::Number(x(a) / x(b)),
                Op::MulAdd(a, b, c) => Value::Number(x(a) * x(b) + x(c)),
                Op::MulSub(a, b, c) => Value::Number(x(a) * x(b) - x(c)),
                Op::Neg(a) => Value::Number(-x(a)),
                Op::Abs(a) => Value::Number(Scalar::abs(x(a))),
                Op::XorSign(a, b) => Value::Number(x(a).xor_sign(x(b))),
                Op::Min(a, b) => Value::Number(x(a).min(x(b))),
                Op::Max(a, b) => Value::Number(x(a).max(x(b))),
                Op::Select(m, a, b) => Value::Number(if is(m) { x(a) } else { x(b) }),
                Op::Truth(holds) => Value::Truth(holds),
                Op::Lt(a, b) => Value::Truth(x(a) < x(b)),
                Op::Le(a, b) => Value::Truth(x(a) <= x(b)),
                Op::And(a, b) => Value::Truth(is(a) && is(b)),
                Op::Or(a, b) => Value::Truth(is(a) || is(b)),
                Op::Not(a) => Value::Truth(!is(a)),
            };
            match value {
                Value::Number(x) => numbers[place] = x,
                Value::Truth(holds) => truths[place] = holds,
            }
        }
        let mut tree = &self.tree;
        loop {
            match tree {
                Tree::If { test, yes, no } => tree = if truths[test.place()] { yes } else { no },
                Tree::Leaf(outputs) => {
                    let value = |node: &Node| {
                        if self.is_truth(*node) {
                            Value::Truth(truths[node.place()])
                        } else {
                            Value::Number(numbers[node.place()])
                        }
                    };
                    return outputs.iter().map(value).collect();
                }
            }
        }
    }

    /// Whether a node is a truth value.
    pub(crate) fn is_truth(&self, node: Node) -> bool {
        self.op(node).is_truth()
    }

    /// Which nodes are choices whose first value is worth a branch: it takes many operations that nothing else needs.
    pub(crate) fn rare(&self) -> Vec<bool> {
        let all = vec![true; self.ops.len()];
        let mut roots = self.tree.leaves().concat();
        roots.extend(self.tree.questions());
        let usual = self.reached(roots, &all);
        let is_rare = |op: &Op| {
            let Op::Select(_, rare, _) = *op else { return false };
            let of_branch = self.reached([rare], &all);
            of_branch.iter().zip(&usual).filter(|&(&rare, &usual)| rare && !usual).count() >= RARE
        };
        self.ops.iter().map(is_rare).collect()
    }

    /// Which operations some nodes need, those of rare branches left out.
    pub(crate) fn needed(&self, nodes: impl IntoIterator<Item = Node>) -> Vec<bool> {
        self.reached(nodes, &self.rare())
    }

    /// Which operations some nodes need, but for the first values of some choices.
    pub(crate) fn reached(
        &self,
        nodes: impl IntoIterator<Item = Node>,
        rare: &[bool],
    ) -> Vec<bool> {
        let mut reached = vec![false; self.ops.len()];
        let mut waiting: Vec<Node> = nodes.into_iter().collect();
        while let Some(node) = waiting.pop() {
            if core::mem::replace(&mut reached[node.place()], true) {
                continue;
            }
            match self.op(node) {
                Op::Select(mask, _, usual) if rare[node.place()] => waiting.extend([mask, usual]),
                op => waiting.extend(op.operands()),
            }
        }
        reached
    }

    /// The operations that some outputs need, of the usual leaf and without rare branches, at places in a range.
    pub(crate) fn count(&self, needed: &[bool], places: core::ops::Range<usize>) -> Ops {
        let places = places.start..places.end.min(self.ops.len());
        places.filter(|&place| needed[place]).map(|place| Ops::of(self.ops[place])).sum()
    }

    /// Joins the leaves of a tree into one, its truth values by logic and its numbers by choices.
    pub(crate) fn join(&mut self) {
        let mut builder = Builder::of(self.format, core::mem::take(&mut self.ops));
        let outputs = joined(&mut builder, &self.tree);
        self.tree = Tree::Leaf(outputs);
        self.ops = builder.ops;
    }

    /// How many cycles the longest chain of operations to an output takes.
    pub fn latency(&self, output: Node, cpu: &Latencies) -> u32 {
        let mut ready = vec![0; self.ops.len()];
        for (place, &op) in self.ops.iter().enumerate().take(output.place() + 1) {
            let start = op.operands().map(|node| ready[node.place()]).max().unwrap_or(0);
            let takes = match op {
                Op::Const(_) | Op::Truth(_) | Op::In(_) => 0,
                Op::Add(..) | Op::Sub(..) | Op::Mul(..) => cpu.arithmetic,
                Op::MulAdd(..) | Op::MulSub(..) => {
                    if cpu.fused {
                        cpu.arithmetic
                    } else {
                        2 * cpu.arithmetic
                    }
                }
                Op::Div(..) => cpu.division,
                Op::Lt(..) | Op::Le(..) | Op::Min(..) | Op::Max(..) => cpu.comparison,
                _ => cpu.bits,
            };
            ready[place] = start + takes;
        }
        ready[output.place()]
    }

    /// The nodes that depend on some inputs alone: what is computed once where those are shared, by packets of a common
    /// origin or direction, or by all rays of a triangle.
    pub fn hoistable(&self, is_shared: impl Fn(&str) -> bool) -> Vec<bool> {
        let mut hoistable: Vec<bool> = Vec::with_capacity(self.ops.len());
        for &op in &self.ops {
            hoistable.push(match op {
                Op::In(input) => is_shared(&self.inputs[input as usize]),
                op => op.operands().all(|node| hoistable[node.place()]),
            });
        }
        hoistable
    }

    /// The graph with some inputs known: what follows from them is computed now, and products with 1 are gone. The
    /// inputs stay in the list.
    #[must_use]
    pub fn specialise(&self, known: impl Fn(&str) -> Option<f64>) -> Self {
        let mut builder = Builder::new(self.format);
        let mut nodes: Vec<Node> = Vec::with_capacity(self.ops.len());
        for &op in &self.ops {
            let node = match op {
                Op::In(input) => match known(&self.inputs[input as usize]) {
                    Some(value) => builder.number(value),
                    None => builder.push(op),
                },
                op => builder.push(op.map(|node| nodes[node.place()])),
            };
            nodes.push(node);
        }
        Self {
            format: self.format,
            inputs: self.inputs.clone(),
            tree: self.tree.map(&mut |node| nodes[node.place()]),
            ops: builder.ops,
            outputs: self.outputs.clone(),
        }
    }

    /// This graph with the outputs of another for its inputs of the same names: what is computed from what was
    /// prepared, from what it was prepared of. Both without branches; inputs that `first` does not give stay inputs.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        let mut builder = Builder::new(self.format);
        let mut inputs = first.inputs.clone();
        let mut of_first: Vec<Node> = Vec::new();
        for &op in &first.ops {
            let node = builder.push(op.map(|node| of_first[node.place()]));
            of_first.push(node);
        }
        let mut nodes: Vec<Node> = Vec::new();
        for &op in &self.ops {
            let node = match op {
                Op::In(input) => {
                    let name = &self.inputs[input as usize];
                    if let Some(node) = first.output(name) {
                        of_first[node.place()]
                    } else {
                        let place = inputs.iter().position(|input| input == name);
                        let place = place.unwrap_or_else(|| {
                            inputs.push(name.clone());
                            inputs.len() - 1
                        });
                        builder.push(builder::input(place))
                    }
                }
                op => builder.push(op.map(|node| nodes[node.place()])),
            };
            nodes.push(node);
        }
        Self {
            format: self.format,
            inputs,
            tree: self.tree.map(&mut |node| nodes[node.place()]),
            ops: builder.ops,
            outputs: self.outputs.clone(),
        }
    }
}
