//! Graphs as terms that Coq reasons about.

use core::fmt::Write as _;

use crate::graph::{Graph, Node, Op};

/// The inputs of [`Graph::coq`], in the order of their numbers: origin, direction, corners.
const COQ_INPUTS: [&str; 15] = [
    "o_x", "o_y", "o_z", "d_x", "d_y", "d_z", "a_x", "a_y", "a_z", "b_x", "b_y", "b_z", "c_x",
    "c_y", "c_z",
];

impl Graph {
    /// Its numerators as definitions of Coq, `NAME_det`, `NAME_t`, `NAME_alpha`, `NAME_beta` and `NAME_gamma`, each in
    /// plain arithmetic and, with `_fused` behind its name, in fused: terms of the type `expr` with the constructors
    /// `In`, `Diff`, `Neg`, `Add`, `Sub`, `Mul`, `MulAdd`, `MulSub`, `Fma` and `Fms`. Inputs are numbered: `o`, `d`,
    /// `a`, `b`, `c`, their three coordinates each. None where a numerator is made of more than sums and products of
    /// inputs.
    pub fn coq(&self, name: &str) -> Option<String> {
        let mut text = String::new();
        for part in ["det", "t", "alpha", "beta", "gamma"] {
            let output =
                if part == "det" { self.output(part) } else { self.output(&format!("det_{part}")) };
            for (fused, suffix) in [(false, ""), (true, "_fused")] {
                let term = self.term(output?, fused)?;
                // Writing to a string cannot fail.
                let _ = writeln!(text, "Definition {name}_{part}{suffix} : expr :=\n  {term}.");
            }
        }
        Some(text)
    }

    fn term(&self, node: Node, fused: bool) -> Option<String> {
        let input = |node: Node| match self.op(node) {
            Op::In(input) => {
                COQ_INPUTS.iter().position(|name| *name == self.inputs[input as usize])
            }
            _ => None,
        };
        let apply = |name: &str, operands: &[Node]| {
            let mut term = name.to_owned();
            for &operand in operands {
                let _ = write!(term, " ({})", self.term(operand, fused)?);
            }
            Some(term)
        };
        match self.op(node) {
            Op::In(_) => Some(format!("In {}", input(node)?)),
            Op::Sub(a, b) => match (input(a), input(b)) {
                (Some(a), Some(b)) => Some(format!("Diff {a} {b}")),
                _ => apply("Sub", &[a, b]),
            },
            Op::Add(a, b) => apply("Add", &[a, b]),
            Op::Mul(a, b) => apply("Mul", &[a, b]),
            Op::Neg(a) => apply("Neg", &[a]),
            Op::MulAdd(a, b, c) => apply(if fused { "Fma" } else { "MulAdd" }, &[a, b, c]),
            Op::MulSub(a, b, c) => apply(if fused { "Fms" } else { "MulSub" }, &[a, b, c]),
            _ => None,
        }
    }
}
