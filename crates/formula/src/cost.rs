//! What a method costs, counted from the very formula that runs.

use trisect_core::FloatFormat;
use trisect_method::{Form, Method};

use crate::formula::{Axis, Formula, Test};
use crate::graph::{Graph, Node};
use crate::ops::Ops;

/// Operations of each part of a method. What is the same twice is counted once, and what nothing reads, or only a
/// pair in a million, not at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Finding a triangle's kind and preparing it.
    pub prepare: Ops,
    /// Preparing a ray for triangles of one kind.
    pub per_ray: Ops,
    /// The test that divides first, to the hit; where the method has it.
    pub test_early: Option<Ops>,
    /// The test that divides last, to the decision; where the method has it.
    pub test_deferred: Option<Ops>,
    /// From the deferred decision to the hit.
    pub finish_deferred: Option<Ops>,
    /// Numbers stored per triangle.
    pub stored_numbers: usize,
    /// Numbers kept per ray.
    pub ray_numbers: usize,
}

/// What method `M` costs with the true division and without culling.
pub fn cost<M: Method>() -> Cost {
    Formula::of::<M>(FloatFormat::F32).cost()
}

impl Formula {
    /// What its parts cost.
    pub fn cost(&self) -> Cost {
        let of_kind = match (&self.axis, self.turned) {
            (Some(axis), Axis::OfTriangle | Axis::Kinds) => axis.usual_ops(),
            _ => Ops::default(),
        };
        let early = self.test(Form::Early);
        let deferred = self.test(Form::Deferred);
        let per_ray = self.tests.last().map(Test::per_ray);
        Cost {
            prepare: of_kind + self.prepare.usual_ops(),
            per_ray: per_ray.unwrap_or_default(),
            test_early: early.map(|test| test.decision() + test.finish()),
            test_deferred: deferred.map(Test::decision),
            finish_deferred: deferred.map(Test::finish),
            stored_numbers: self.prepare.outputs.len(),
            ray_numbers: self.ray_numbers,
        }
    }
}

impl Graph {
    /// The operations of a triangle that nothing special is true of.
    fn usual_ops(&self) -> Ops {
        let mut nodes = self.tree.usual_questions();
        nodes.extend(self.tree.usual());
        self.count(&self.needed(nodes), 0..self.ops.len())
    }
}

impl Test {
    /// The outputs that a hit is made of.
    fn of_hit(&self) -> Vec<Node> {
        ["hit", "open", "t", "beta", "gamma"]
            .iter()
            .filter_map(|name| self.graph.output(name))
            .collect()
    }

    /// The place after the decision.
    fn decided(&self) -> usize {
        let decisions = ["hit", "open"].iter().filter_map(|name| self.graph.output(name));
        decisions.map(|node| node.place() + 1).max().unwrap_or(0)
    }

    /// Preparing a ray.
    pub fn per_ray(&self) -> Ops {
        self.graph.count(&self.graph.needed(self.of_hit()), self.ray.clone())
    }

    /// The test, until it is decided.
    pub fn decision(&self) -> Ops {
        self.graph.count(&self.graph.needed(self.of_hit()), self.ray.end..self.decided())
    }

    /// From the decision to the hit.
    pub fn finish(&self) -> Ops {
        let places = self.decided()..self.graph.ops.len();
        self.graph.count(&self.graph.needed(self.of_hit()), places)
    }

    /// The test of one pair, to the decision or to the hit, where what depends on some inputs alone was computed before.
    pub fn shared(&self, outputs: &[&str], is_shared: impl Fn(&str) -> bool) -> Ops {
        let nodes = outputs.iter().filter_map(|name| self.graph.output(name));
        let mut needed = self.graph.needed(nodes);
        for (needed, hoisted) in needed.iter_mut().zip(self.graph.hoistable(is_shared)) {
            *needed &= !hoisted;
        }
        self.graph.count(&needed, 0..self.graph.ops.len())
    }
}

impl Cost {
    /// The parts that the method has, by name.
    pub fn parts(&self) -> impl Iterator<Item = (&'static str, Ops)> {
        [
            ("prepare a triangle", Some(self.prepare)),
            ("prepare a ray", Some(self.per_ray)),
            ("test, early division", self.test_early),
            ("test, deferred division", self.test_deferred),
            ("finish a hit, deferred division", self.finish_deferred),
        ]
        .into_iter()
        .filter_map(|(part, ops)| Some((part, ops?)))
    }
}
