//! The statements of a function.

use std::collections::{HashMap, HashSet};

use super::language::Language;
use crate::graph::{Graph, Node, Op};

/// How tightly an expression holds together: the least tightly first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Choice,
    Or,
    And,
    Compare,
    Sum,
    Product,
    Atom,
}

/// Longer expressions get a name.
const LONGEST: usize = 68;
/// Longer names are replaced.
const LONGEST_NAME: usize = 22;

/// The statements that compute some nodes of a graph.
pub(super) struct Body<'a> {
    language: Language,
    graph: &'a Graph,
    prefix: &'a str,
    /// How the nodes that are there are written.
    written: Vec<Option<(String, Level)>>,
    /// How often each is used.
    uses: Vec<u32>,
    rare: Vec<bool>,
    /// Nodes that have a name of their own.
    labels: HashMap<Node, String>,
    taken: HashSet<String>,
    /// Short names for long ones.
    short: HashMap<String, String>,
    /// The components of vectors by their names: name and axis.
    components: HashMap<Node, (String, usize)>,
    lines: Vec<String>,
    indent: usize,
}

/// The axis that a name ends with, and what is before.
fn component(name: &str) -> Option<(String, usize)> {
    let (base, axis) = name.rsplit_once('_')?;
    let axis = ["x", "y", "z"].iter().position(|&letter| letter == axis)?;
    Some((base.to_owned(), axis))
}

impl<'a> Body<'a> {
    /// The statements of a function that computes `roots`, its inputs and what it is given written by `given`.
    pub(super) fn new(
        language: Language,
        prefix: &'a str,
        graph: &'a Graph,
        roots: &[Node],
        given: impl Fn(Node, Op) -> Option<String>,
    ) -> Self {
        let rare = graph.rare();
        let reached = graph.reached(roots.iter().copied(), &vec![false; graph.ops.len()]);
        let mut written = vec![None; graph.ops.len()];
        let mut components = HashMap::new();
        let mut uses = vec![0_u32; graph.ops.len()];
        for &root in roots {
            uses[root.place()] += 1;
        }
        for (place, &op) in (0..).zip(&graph.ops) {
            let node = Node(place);
            if let Op::In(input) = op
                && let Some(component) = component(&graph.inputs[input as usize])
            {
                components.insert(node, component);
            }
            if let Some(text) = given(node, op) {
                written[node.place()] = Some((text, Level::Atom));
            } else if reached[node.place()] {
                for operand in op.operands() {
                    uses[operand.place()] += 1;
                }
                if language == Language::Glsl && !is_arithmetic(op) {
                    // What is compared is computed precisely where it has a name.
                    for operand in op.operands().filter(|&node| is_arithmetic(graph.op(node))) {
                        uses[operand.place()] += 2;
                    }
                }
            }
        }
        if language == Language::Glsl {
            for &root in roots {
                uses[root.place()] += 2;
            }
        }
        Self {
            language,
            graph,
            prefix,
            written,
            uses,
            rare,
            labels: HashMap::new(),
            // Names of parameters and of what is returned, and words of the languages.
            taken: [
                "ray", "triangle", "result", "a", "b", "c", "o", "d", "u", "v", "axis", "t_min",
                "t_max", "point", "normal",
            ]
            .map(str::to_owned)
            .into(),
            short: HashMap::new(),
            components,
            lines: Vec::new(),
            indent: 1,
        }
    }

    /// Gives a node a name, unless it has one or is given.
    pub(super) fn label(&mut self, node: Node, name: &str) {
        if self.written[node.place()].is_none()
            && !matches!(self.graph.op(node), Op::Const(_) | Op::Truth(_))
        {
            let name = self.labels.entry(node).or_insert_with(|| name.to_owned());
            self.taken.insert(name.clone());
            if let Some(component) = component(name) {
                self.components.entry(node).or_insert(component);
            }
        }
    }

    /// A line of its own.
    pub(super) fn line(&mut self, text: &str) {
        for line in text.lines() {
            self.lines.push(format!("{}{line}", "    ".repeat(self.indent)));
        }
    }

    /// Begins a block.
    pub(super) fn begin(&mut self, test: &str) {
        let line = self.language.begin_if(test);
        self.line(&line);
        self.indent += 1;
    }

    /// Ends it.
    pub(super) fn end(&mut self) {
        self.indent -= 1;
        self.line("}");
    }

    /// Writes what is unknown after it.
    pub(super) fn in_block(&mut self, write: impl FnOnce(&mut Self)) {
        let written = self.written.clone();
        let (taken, components) = (self.taken.clone(), self.components.clone());
        write(self);
        (self.written, self.taken, self.components) = (written, taken, components);
    }

    /// Says by what name a node is given.
    pub(super) fn mark(&mut self, node: Node, name: &str) {
        if let Some(component) = component(name) {
            self.components.insert(node, component);
        }
    }

    /// The lines.
    pub(super) fn finish(self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// Writes what `roots` need, and is not there yet.
    pub(super) fn compute(&mut self, roots: &[Node]) {
        // What is given needs nothing.
        let mut wanted = vec![false; self.graph.ops.len()];
        for &root in roots {
            wanted[root.place()] = true;
        }
        for place in (0..wanted.len()).rev() {
            if !wanted[place] || self.written[place].is_some() {
                continue;
            }
            match self.graph.ops[place] {
                Op::Select(mask, _, usual) if self.rare[place] => {
                    wanted[mask.place()] = true;
                    wanted[usual.place()] = true;
                }
                op => op.operands().for_each(|node| wanted[node.place()] = true),
            }
        }
        for (place, wanted) in (0..).zip(wanted) {
            if wanted && self.written[place as usize].is_none() {
                self.write(Node(place));
            }
        }
    }

    /// How a node is written.
    pub(super) fn text(&self, node: Node) -> String {
        self.operand(node, Level::Choice)
    }

    fn operand(&self, node: Node, least: Level) -> String {
        match &self.written[node.place()] {
            Some((text, level)) if *level >= least => text.clone(),
            Some((text, _)) => format!("({text})"),
            None => unreachable!("operands are written first"),
        }
    }

    fn write(&mut self, node: Node) {
        let op = self.graph.op(node);
        if let (Op::Select(mask, value, usual), true) = (op, self.rare[node.place()]) {
            self.write_branch(node, mask, value, usual);
            return;
        }
        let (text, level) = self.expression(op);
        let is_named = !matches!(op, Op::Const(_) | Op::Truth(_) | Op::In(_))
            && (self.labels.contains_key(&node)
                || self.uses[node.place()] > 1
                || text.len() > LONGEST);
        if is_named {
            let name = self.name(node);
            let line = self.language.declare(self.kind(node), &name, &text, false);
            self.line(&line);
            self.written[node.place()] = Some((name, Level::Atom));
        } else {
            self.written[node.place()] = Some((text, level));
        }
    }

    fn kind(&self, node: Node) -> &'static str {
        if self.graph.is_truth(node) {
            self.language.truth()
        } else {
            self.language.number(self.graph.format)
        }
    }

    /// A choice whose first value is computed where it is chosen.
    fn write_branch(&mut self, node: Node, mask: Node, value: Node, usual: Node) {
        let name = self.name(node);
        let line = self.language.declare(self.kind(node), &name, &self.text(usual), true);
        self.line(&line);
        let test = self.text(mask);
        self.begin(&test);
        self.in_block(|body| {
            body.compute(&[value]);
            let line = format!("{name} = {};", body.text(value));
            body.line(&line);
        });
        self.end();
        self.written[node.place()] = Some((name, Level::Atom));
    }

    fn product(&self, a: Node, b: Node) -> (String, Level) {
        let text =
            format!("{} * {}", self.operand(a, Level::Product), self.operand(b, Level::Atom));
        if self.language == Language::Wgsl {
            (format!("{}_rounded({text})", self.prefix), Level::Atom)
        } else {
            (text, Level::Product)
        }
    }

    fn expression(&self, op: Op) -> (String, Level) {
        let call = |name: &str, a, b| {
            let (a, b) = (self.text(a), self.text(b));
            (format!("{}_{name}({a}, {b})", self.prefix), Level::Atom)
        };
        let sum = |a: String, sign: &str, b| {
            (format!("{a} {sign} {}", self.operand(b, Level::Product)), Level::Sum)
        };
        let compare = |a, b, signs: [&str; 2]| {
            let (text, other) = (self.operand(a, Level::Sum), self.operand(b, Level::Sum));
            // A constant comes last.
            if self.graph.constant(a).is_some() {
                (format!("{other} {} {text}", signs[1]), Level::Compare)
            } else {
                (format!("{text} {} {other}", signs[0]), Level::Compare)
            }
        };
        let language = self.language;
        match op {
            Op::Const(constant) => {
                let value = constant.value();
                let text = language.literal(self.graph.format, value);
                (text, if value.is_sign_negative() { Level::Sum } else { Level::Atom })
            }
            Op::Truth(holds) => (language.known(holds).to_owned(), Level::Atom),
            Op::In(input) => (self.graph.inputs[input as usize].clone(), Level::Atom),
            Op::Add(a, b) => sum(self.operand(a, Level::Sum), "+", b),
            Op::Sub(a, b) => sum(self.operand(a, Level::Sum), "-", b),
            Op::Mul(a, b) => self.product(a, b),
            Op::MulAdd(a, b, c) => sum(self.product(a, b).0, "+", c),
            Op::MulSub(a, b, c) => sum(self.product(a, b).0, "-", c),
            Op::Div(a, b) => {
                let (a, b) = (self.operand(a, Level::Product), self.operand(b, Level::Atom));
                (format!("{a} / {b}"), Level::Product)
            }
            Op::Neg(a) => (format!("-{}", self.operand(a, Level::Atom)), Level::Sum),
            Op::Abs(a) => match (language, language.number(self.graph.format)) {
                (Language::Rust, _) => {
                    (format!("{}.abs()", self.operand(a, Level::Atom)), Level::Atom)
                }
                (Language::C, "float") => (format!("fabsf({})", self.text(a)), Level::Atom),
                (Language::C, _) => (format!("fabs({})", self.text(a)), Level::Atom),
                _ => (format!("abs({})", self.text(a)), Level::Atom),
            },
            Op::XorSign(a, b) => call("xor_sign", a, b),
            Op::Min(a, b) => call("least", a, b),
            Op::Max(a, b) => call("most", a, b),
            Op::Select(mask, a, b) => {
                let level = if language == Language::Wgsl { Level::Atom } else { Level::Choice };
                let mask = self.operand(mask, Level::Or);
                let values = [a, b].map(|node| self.operand(node, Level::Or));
                (language.choice(&mask, &values[0], &values[1]), level)
            }
            Op::Lt(a, b) => compare(a, b, ["<", ">"]),
            Op::Le(a, b) => compare(a, b, ["<=", ">="]),
            Op::And(a, b) => {
                let (a, b) = (self.operand(a, Level::And), self.operand(b, Level::Compare));
                (format!("{a} && {b}"), Level::And)
            }
            Op::Or(a, b) => {
                let (a, b) = (self.operand(a, Level::Compare), self.operand(b, Level::Compare));
                (format!("{a} || {b}"), Level::Or)
            }
            Op::Not(a) => (format!("!{}", self.operand(a, Level::Atom)), Level::Atom),
        }
    }

    /// A name for a node: its own, or what it is of vectors with names, or a letter and a number.
    pub(super) fn name(&mut self, node: Node) -> String {
        if let Some(label) = self.labels.get(&node) {
            return label.clone();
        }
        let described = self.describe(node);
        let (wanted, axis) = match &described {
            Some((base, axis)) if base.len() <= LONGEST_NAME => (base.clone(), *axis),
            Some((base, axis)) => {
                let count = self.short.len() + 1;
                (
                    self.short.entry(base.clone()).or_insert_with(|| format!("v{count}")).clone(),
                    *axis,
                )
            }
            None if self.graph.is_truth(node) => ("is".to_owned(), None),
            None => ("s".to_owned(), None),
        };
        let axis_name = axis.map(|axis| ["_x", "_y", "_z"][axis]).unwrap_or_default();
        let mut name = format!("{wanted}{axis_name}");
        if described.is_none() || self.taken.contains(&name) {
            let mut count = 0;
            while count == 0 || self.taken.contains(&name) {
                count += 1;
                name = format!("{wanted}{count}{axis_name}");
            }
        }
        self.taken.insert(name.clone());
        if let (Some((base, _)), Some(axis)) = (&described, axis) {
            let base = self.short.get(base).unwrap_or(base).clone();
            self.components.insert(node, (base, axis));
        }
        name
    }

    /// What a node is: a difference or a product of vectors, a quotient, or what has a name with its sign changed.
    fn describe(&self, node: Node) -> Option<(String, Option<usize>)> {
        let of = |node: Node| self.components.get(&node);
        match self.graph.op(node) {
            Op::Abs(a) => Some((format!("abs_{}", self.labels.get(&a)?), None)),
            Op::XorSign(a, _) => Some((format!("signed_{}", self.labels.get(&a)?), None)),
            Op::Div(a, b) => {
                let axes = ["x", "y", "z"];
                let over = of(b).map(|(b, k)| format!("over_{b}_{}", axes[*k]));
                match (self.graph.constant(a), of(a), over) {
                    (Some(1.0), _, Some(over)) => Some((format!("one_{over}"), None)),
                    (Some(1.0), _, None) => Some(("reciprocal".to_owned(), None)),
                    (_, Some((a, j)), Some(over)) => {
                        Some((format!("{a}_{}_{over}", axes[*j]), None))
                    }
                    _ => None,
                }
            }
            Op::Sub(a, b) => {
                let ((a, axis), (b, other)) = (of(a)?, of(b)?);
                (axis == other).then(|| (format!("{a}_minus_{b}"), Some(*axis)))
            }
            Op::MulSub(p, q, rest) => {
                let Op::Mul(r, s) = self.graph.op(rest) else { return None };
                let ((a, j), (b, k)) = (of(p)?, of(q)?);
                let axis = (j + 2) % 3;
                let is_cross = of(r)? == &(a.clone(), *k) && of(s)? == &(b.clone(), *j);
                (is_cross && (j + 1) % 3 == *k).then(|| (format!("{a}_cross_{b}"), Some(axis)))
            }
            Op::MulAdd(p, q, rest) => {
                let Op::MulAdd(r, s, last) = self.graph.op(rest) else { return None };
                let Op::Mul(t, u) = self.graph.op(last) else { return None };
                let (a, b) = (&of(p)?.0, &of(q)?.0);
                let all = [(p, q), (r, s), (t, u)];
                let is_dot = (0..3).zip(all).all(|(axis, (x, y))| {
                    of(x) == Some(&(a.clone(), axis)) && of(y) == Some(&(b.clone(), axis))
                });
                is_dot.then(|| (format!("{a}_dot_{b}"), None))
            }
            _ => None,
        }
    }
}

fn is_arithmetic(op: Op) -> bool {
    matches!(
        op,
        Op::Add(..)
            | Op::Sub(..)
            | Op::Mul(..)
            | Op::Div(..)
            | Op::MulAdd(..)
            | Op::MulSub(..)
            | Op::Neg(_)
    )
}
