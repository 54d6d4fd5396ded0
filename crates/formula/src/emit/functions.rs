//! The functions of a kernel that see rays.

use trisect_method::Output;

use super::body::Body;
use super::language::Language;
use super::{Field, Writer};
use crate::formula::Axis;
use crate::graph::{Node, Op};

impl Writer<'_> {
    pub(super) fn prepare_ray(&self) -> String {
        let graph = self.graph();
        let fields = self.ray_fields();
        let nodes: Vec<_> = fields.iter().map(|(node, _)| *node).collect();
        let is_turned = self.is_turned();
        let mut body = self.body(graph, &nodes, is_turned);
        for (node, name) in &fields {
            body.label(*node, name);
        }
        body.compute(&nodes);
        let values: Vec<_> =
            fields.iter().map(|(node, name)| (name.clone(), body.text(*node))).collect();
        let kind = self.type_name("ray");
        body.line(&self.language.construct(&kind, &values));
        let (number, vector) = (self.number(), self.vector());
        let mut parameters =
            vec![("o", vector), ("d", vector), ("t_min", number), ("t_max", number)];
        if is_turned {
            parameters.push(("axis", self.language.index()));
        }
        let comment = match self.formula.turned {
            Axis::OfTriangle => {
                "Prepares the ray o + t d, t_min <= t <= t_max, for triangles whose axis is `axis`."
            }
            _ => "Prepares the ray o + t d, t_min <= t <= t_max.",
        };
        self.function(comment, &format!("{}_prepare_ray", self.prefix), &parameters, &kind, body)
    }

    pub(super) fn test(&self) -> String {
        let graph = self.graph();
        let roots = self.roots();
        let of_ray = self.ray_fields();
        let mut body = Body::new(self.language, &self.prefix, graph, &roots, |node, op| {
            match (of_ray.iter().find(|(field, _)| *field == node), op) {
                (Some((_, name)), _) => Some(format!("ray.{name}")),
                (None, Op::In(input)) => Some(format!("triangle.{}", graph.inputs[input as usize])),
                _ => None,
            }
        });
        if self.tests_turned() {
            self.name_axes(&mut body);
        }
        for (node, name) in &of_ray {
            body.mark(*node, name);
        }
        let (hit, open) = self.decisions();
        for field in self.fields() {
            if let [node] = field.nodes[..] {
                body.label(node, field.name);
            }
        }
        for name in ["det", "det_t", "det_alpha", "det_beta", "det_gamma"] {
            if let Some(node) = graph.output(name) {
                body.label(node, name);
            }
        }
        let decisions: Vec<Node> = hit.into_iter().chain(open).collect();
        for (node, name) in [(hit, "is_hit"), (open, "is_open")] {
            if let Some(node) = node {
                body.label(node, name);
            }
        }
        body.compute(&decisions);
        let returns = self.decide(&mut body, hit, open);
        let mut parameters = vec![
            ("ray".to_owned(), self.type_name("ray")),
            ("triangle".to_owned(), self.type_name("triangle")),
        ];
        if self.tests_turned() {
            parameters.push(("axis".to_owned(), self.language.index().to_owned()));
        }
        let parameters: Vec<_> =
            parameters.iter().map(|(name, kind)| (name.as_str(), kind.as_str())).collect();
        let comment = if open.is_some() {
            "Tests a ray against a triangle: 0 for a miss, 1 for a hit, 2 where this is open."
        } else {
            "Tests a ray against a triangle."
        };
        self.function(comment, &format!("{}_test", self.prefix), &parameters, &returns, body)
    }

    /// Ends a test: what it returns.
    fn decide(&self, body: &mut Body<'_>, hit: Option<Node>, open: Option<Node>) -> String {
        let language = self.language;
        let is_hit = hit.map_or_else(|| language.known(false).to_owned(), |hit| body.text(hit));
        if let Some(open) = open {
            let [miss, hit, open_] = [0, 1, 2].map(|value| language.whole(value));
            let settled = language.choice(&is_hit, &hit, &miss);
            let settled = if matches!(language, Language::C | Language::Glsl) {
                format!("({settled})")
            } else {
                settled
            };
            let outcome = language.choice(&body.text(open), &open_, &settled);
            body.line(&self.returned(&outcome));
            return language.index().to_owned();
        }
        let fields = self.fields();
        if fields.is_empty() {
            body.line(&self.returned(&is_hit));
            return language.truth().to_owned();
        }
        let kind = self.type_name("hit");
        let nodes: Vec<Node> = fields.iter().flat_map(|field| field.nodes.clone()).collect();
        self.leave(body, &kind, &is_hit, &fields);
        body.compute(&nodes);
        if language == Language::Rust {
            return self.some(body, &kind, &fields);
        }
        body.line(&format!("result.hit = {};", language.known(true)));
        for Field { name, nodes } in &fields {
            for (axis, &node) in nodes.iter().enumerate() {
                let to = format!("result.{name}");
                let to = if nodes.len() == 3 {
                    self.coordinate(&to, axis, self.tests_turned())
                } else {
                    to
                };
                let line = format!("{to} = {};", body.text(node));
                body.line(&line);
            }
        }
        body.line("return result;");
        kind
    }

    /// Leaves a test without a hit.
    fn leave(&self, body: &mut Body<'_>, kind: &str, is_hit: &str, fields: &[Field]) {
        match self.language {
            Language::C => body.line(&format!("{kind} result = {{ 0 }};")),
            Language::Wgsl => body.line(&format!("var result: {kind};")),
            Language::Glsl => {
                body.line(&format!("{kind} result;\nresult.hit = false;"));
                for Field { name, nodes } in fields {
                    let zero = if nodes.len() == 3 { "vec3(0.0)" } else { "0.0" };
                    body.line(&format!("result.{name} = {zero};"));
                }
            }
            Language::Rust => {}
        }
        body.begin(&format!("!{is_hit}"));
        body.line(if self.language == Language::Rust { "return None;" } else { "return result;" });
        body.end();
    }

    /// The hit as Rust has it.
    fn some(&self, body: &mut Body<'_>, kind: &str, fields: &[Field]) -> String {
        let mut values = Vec::new();
        for Field { name, nodes } in fields {
            let texts: Vec<_> = nodes.iter().map(|&node| body.text(node)).collect();
            if let [text] = &texts[..] {
                values.push(((*name).to_owned(), text.clone()));
            } else if self.tests_turned() {
                let zero = self.language.literal(self.formula.format, 0.0);
                body.line(&format!("let mut {name} = [{zero}; 3];"));
                for (axis, text) in texts.iter().enumerate() {
                    let line = format!("{} = {text};", self.coordinate(name, axis, true));
                    body.line(&line);
                }
                values.push(((*name).to_owned(), (*name).to_owned()));
            } else {
                values.push(((*name).to_owned(), format!("[{}]", texts.join(", "))));
            }
        }
        body.line(&format!("Some({})", self.language.construct(kind, &values)));
        format!("Option<{kind}>")
    }

    /// The function that does it all for one pair.
    pub(super) fn intersect(&self) -> String {
        let (prefix, language) = (&self.prefix, self.language);
        let mut body = Body::new(language, prefix, self.graph(), &[], |_, _| None);
        let of_axis = match self.formula.turned {
            Axis::OfTriangle => Some("a, b, c"),
            Axis::OfRay => Some("d"),
            _ => None,
        };
        if let Some(of) = of_axis {
            let value = format!("{prefix}_axis({of})");
            body.line(&language.declare(language.index(), "axis", &value, false));
        }
        let axis = if of_axis.is_some() { ", axis" } else { "" };
        let of_test = if self.tests_turned() { ", axis" } else { "" };
        let ray = format!("{prefix}_prepare_ray(o, d, t_min, t_max{axis})");
        let triangle = format!("{prefix}_prepare(a, b, c{axis})");
        for (kind, name, value) in [("ray", "ray", ray), ("triangle", "triangle", triangle)] {
            body.line(&language.declare(&self.type_name(kind), name, &value, false));
        }
        body.line(&self.returned(&format!("{prefix}_test(ray, triangle{of_test})")));
        let (number, vector) = (self.number(), self.vector());
        let parameters = [
            ("o", vector),
            ("d", vector),
            ("t_min", number),
            ("t_max", number),
            ("a", vector),
            ("b", vector),
            ("c", vector),
        ];
        let returns = match (self.graph().output("open"), self.needs, language) {
            (Some(_), ..) => language.index().to_owned(),
            (None, Output::Occlusion, _) => language.truth().to_owned(),
            (None, _, Language::Rust) => format!("Option<{}>", self.type_name("hit")),
            _ => self.type_name("hit"),
        };
        let comment = "Prepares and tests one pair.";
        self.function(comment, &format!("{prefix}_intersect"), &parameters, &returns, body)
    }
}
