//! A kernel as the text of a program: self-contained, and as readable as what a person would write.

mod body;
mod functions;
mod language;
mod notes;

use core::fmt::Write as _;

use thiserror::Error;
use trisect_core::FloatFormat;
use trisect_method::{Form, Output};

use self::body::Body;
pub use self::language::Language;
use crate::formula::{Axis, Formula, RAY, Test};
use crate::graph::{Graph, Node, Op, Tree};

/// What is to be written.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// In which language.
    pub language: Language,
    /// When to divide; deferred where the method has that and nothing is said, else early.
    pub division: Option<Form>,
    /// What is asked of a hit; where nothing is said, the most that the method gives of `t` and weights.
    pub needs: Option<Output>,
    /// What all names begin with; the method's name where nothing is said.
    pub prefix: Option<&'a str>,
}

/// Why a kernel cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum EmitError {
    /// The method has the other form alone.
    #[error("{method} has no {form} division: leave out --division, or ask for {other}")]
    Form {
        /// The method's name.
        method: &'static str,
        /// What was asked.
        form: Form,
        /// What it has.
        other: Form,
    },
    /// The method does not give that.
    #[error("{method} does not give {needs}: ask for one of {given}")]
    Needs {
        /// The method's name.
        method: &'static str,
        /// What was asked.
        needs: Output,
        /// What it gives.
        given: String,
    },
    /// Values of the exact method are no formula.
    #[error(
        "{method} decides by a formula, but its values are computed beyond it: ask for {}, and for values use \
         the library",
        Output::Occlusion
    )]
    Apart {
        /// The method's name.
        method: &'static str,
    },
    /// Shaders compute in f32.
    #[error("{language} has no f64 that is sure to be there: ask for f32")]
    Precision {
        /// The language.
        language: Language,
    },
    /// Triangles are of kinds that are no axes, or are prepared before they are turned.
    #[error("{method} tells kinds of triangles apart that cannot be written yet")]
    Kinds {
        /// The method's name.
        method: &'static str,
    },
}

/// The text of a kernel of a method.
///
/// # Errors
/// When the method does not have what is asked, or the language does not.
pub fn emit(formula: &Formula, request: Request<'_>) -> Result<String, EmitError> {
    let writer = Writer::new(formula, request)?;
    Ok(writer.file())
}

struct Writer<'a> {
    formula: &'a Formula,
    test: &'a Test,
    language: Language,
    needs: Output,
    prefix: String,
}

/// A value of a hit: a number, or a vector.
struct Field {
    name: &'static str,
    nodes: Vec<Node>,
}

impl<'a> Writer<'a> {
    fn new(formula: &'a Formula, request: Request<'_>) -> Result<Self, EmitError> {
        let info = &formula.info;
        let (method, language) = (info.name, request.language);
        let form = request.division.unwrap_or_else(|| info.forms.preferred());
        let other = info.forms.preferred();
        let test = formula.test(form).ok_or(EmitError::Form { method, form, other })?;
        let fullest = if info.claims.exact { Output::Occlusion } else { info.fullest() };
        let needs = request.needs.unwrap_or(fullest);
        if info.claims.exact && needs != Output::Occlusion {
            return Err(EmitError::Apart { method });
        }
        if !info.gives(needs) {
            let given: Vec<_> = info.outputs.iter().map(|output| output.name()).collect();
            return Err(EmitError::Needs { method, needs, given: given.join(", ") });
        }
        if formula.format == FloatFormat::F64 && matches!(language, Language::Wgsl | Language::Glsl)
        {
            return Err(EmitError::Precision { language });
        }
        let is_stored_as_given = || {
            let inputs = |node: &Node| matches!(formula.prepare.op(*node), Op::In(_));
            formula.prepare.tree.usual().iter().all(inputs)
        };
        if formula.turned == Axis::Kinds || formula.turned == Axis::OfRay && !is_stored_as_given() {
            return Err(EmitError::Kinds { method });
        }
        let prefix = request.prefix.map_or_else(|| method.replace('-', "_"), str::to_owned);
        Ok(Self { formula, test, language, needs, prefix })
    }

    fn graph(&self) -> &'a Graph {
        &self.test.graph
    }

    fn number(&self) -> &'static str {
        self.language.number(self.formula.format)
    }

    fn vector(&self) -> &'static str {
        self.language.vector(self.formula.format)
    }

    fn type_name(&self, name: &str) -> String {
        self.language.type_name(&self.prefix, name)
    }

    fn is_turned(&self) -> bool {
        self.formula.turned != Axis::Any
    }

    /// Whether the test itself has to know the axis: for vectors that it gives.
    fn tests_turned(&self) -> bool {
        self.is_turned() && matches!(self.needs, Output::Point | Output::Normal)
    }

    /// The values of a hit.
    fn fields(&self) -> Vec<Field> {
        let output = |name: &str| self.graph().output(name);
        let number = |name| Field { name, nodes: output(name).into_iter().collect() };
        let vector = |name| {
            let nodes = ["x", "y", "z"].iter().filter_map(|axis| output(&format!("{name}_{axis}")));
            Field { name, nodes: nodes.collect() }
        };
        match self.needs {
            Output::Occlusion => Vec::new(),
            Output::T => vec![number("t")],
            Output::Barycentrics => vec![number("t"), number("beta"), number("gamma")],
            Output::Point => vec![number("t"), vector("point")],
            Output::Normal => vec![number("t"), vector("normal")],
        }
    }

    /// The decisions: whether it hits, and whether that is open.
    fn decisions(&self) -> (Option<Node>, Option<Node>) {
        (self.graph().output("hit"), self.graph().output("open"))
    }

    /// All outputs that are asked for.
    fn roots(&self) -> Vec<Node> {
        let (hit, open) = self.decisions();
        let fields = self.fields().into_iter().flat_map(|field| field.nodes);
        hit.into_iter().chain(open).chain(fields).collect()
    }

    /// What the test reads of the ray, by its names: what is computed before, and what it starts from.
    fn ray_fields(&self) -> Vec<(Node, String)> {
        let graph = self.graph();
        let roots = self.roots();
        let reached = graph.reached(roots.iter().copied(), &vec![false; graph.ops.len()]);
        let is_of_ray = |node: Node| match graph.op(node) {
            Op::In(input) => (input as usize) < RAY.len(),
            Op::Const(_) | Op::Truth(_) => false,
            _ => node.place() < self.test.ray.end,
        };
        let mut fields = Vec::new();
        let mut read = vec![false; graph.ops.len()];
        for (place, &op) in graph.ops.iter().enumerate().skip(self.test.ray.end) {
            if reached[place] {
                op.operands().for_each(|node| read[node.place()] = true);
            }
        }
        for node in roots {
            read[node.place()] = true;
        }
        let mut body = Body::new(self.language, &self.prefix, graph, &[], |_, _| None);
        for (place, read) in (0..).zip(read) {
            let node = Node(place);
            if !read || !is_of_ray(node) {
                continue;
            }
            let ends = ["tmin", "tmax"].into_iter().find(|end| graph.output(end) == Some(node));
            let name = match (graph.op(node), ends) {
                (_, Some(end)) => end.to_owned(),
                (Op::In(input), _) => graph.inputs[input as usize].clone(),
                _ => body.name(node),
            };
            fields.push((node, name));
        }
        fields
    }

    /// The coordinate of a vector along an axis: of turned space where it is turned.
    fn coordinate(&self, vector: &str, axis: usize, is_turned: bool) -> String {
        if is_turned {
            format!("{vector}[{}]", ["u", "v", "axis"][axis])
        } else {
            self.language.coordinate(vector, axis)
        }
    }

    /// How an input that is a coordinate is written: `a_x` is the first coordinate of the vector `a`.
    fn input(&self, name: &str, is_turned: bool) -> String {
        match (name, name.rsplit_once('_')) {
            ("tmin", _) => "t_min".to_owned(),
            ("tmax", _) => "t_max".to_owned(),
            (_, Some((vector, "x"))) => self.coordinate(vector, 0, is_turned),
            (_, Some((vector, "y"))) => self.coordinate(vector, 1, is_turned),
            (_, Some((vector, "z"))) => self.coordinate(vector, 2, is_turned),
            _ => name.to_owned(),
        }
    }

    /// A function's body over the inputs of a graph as parameters.
    fn body<'b>(&'b self, graph: &'b Graph, roots: &[Node], is_turned: bool) -> Body<'b> {
        let mut body = Body::new(self.language, &self.prefix, graph, roots, |_, op| match op {
            Op::In(input) => Some(self.input(&graph.inputs[input as usize], is_turned)),
            _ => None,
        });
        if is_turned {
            self.name_axes(&mut body);
        }
        body
    }

    /// Names the two axes beside the last one.
    fn name_axes(&self, body: &mut Body<'_>) {
        for (name, step) in [("u", 1), ("v", 2)] {
            let language = self.language;
            let value = format!("(axis + {}) % {}", language.whole(step), language.whole(3));
            body.line(&language.declare(language.index(), name, &value, false));
        }
    }

    fn file(&self) -> String {
        let parts = [
            self.structures(),
            self.axis(),
            self.prepare(),
            self.prepare_ray(),
            self.test(),
            self.intersect(),
        ];
        let mut functions = String::new();
        for part in parts.iter().filter(|part| !part.is_empty()) {
            functions.push('\n');
            functions += part;
        }
        self.notes() + &self.helpers(&functions) + &functions
    }

    fn structures(&self) -> String {
        let number = self.number();
        let comment = |text: &str| self.comment(text);
        let triangle: Vec<_> =
            self.formula.prepare.outputs.iter().map(|name| (name.clone(), number)).collect();
        let ray: Vec<_> = self.ray_fields().into_iter().map(|(_, name)| (name, number)).collect();
        let mut text = comment("What is stored for a triangle.");
        text += &self.language.structure(&self.type_name("triangle"), &triangle);
        text += "\n";
        text += &comment("What is computed once per ray.");
        text += &self.language.structure(&self.type_name("ray"), &ray);
        let fields = self.fields();
        if !fields.is_empty() {
            let mut members = Vec::new();
            if self.language != Language::Rust {
                members.push(("hit".to_owned(), self.language.truth()));
            }
            members.extend(fields.iter().map(|field| {
                let kind = if field.nodes.len() == 3 { self.vector() } else { number };
                (field.name.to_owned(), kind)
            }));
            text += "\n";
            text += &comment(if self.language == Language::Rust {
                "A hit."
            } else {
                "Whether it hits, and if so where."
            });
            text += &self.language.structure(&self.type_name("hit"), &members);
        }
        text
    }

    /// The function that says which axis is to be the last.
    fn axis(&self) -> String {
        let Some(axis) = &self.formula.axis else { return String::new() };
        let (parameters, comment): (&[&str], _) = if self.formula.turned == Axis::OfRay {
            (
                &["d"],
                "The axis that the direction is longest along: 0, 1 or 2. Rays of one axis may share triangles.",
            )
        } else {
            (
                &["a", "b", "c"],
                "The axis that the triangle is projected along: 0, 1 or 2. Triangles of one axis share rays.",
            )
        };
        let questions = axis.tree.questions();
        let mut body = self.body(axis, &questions, false);
        body.compute(&questions);
        let value = |leaf: &[Node]| {
            let axis = leaf.first().and_then(|&node| axis.constant(node)).unwrap_or_default();
            // It is 0, 1 or 2.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "so small")]
            self.language.whole(axis as usize)
        };
        let chosen = choose(self.language, &axis.tree, &body, &value);
        body.line(&self.returned(&chosen));
        let vector = self.vector();
        let parameters: Vec<_> = parameters.iter().map(|&name| (name, vector)).collect();
        let name = format!("{}_axis", self.prefix);
        self.function(comment, &name, &parameters, self.language.index(), body)
    }

    fn returned(&self, value: &str) -> String {
        if self.language == Language::Rust { value.to_owned() } else { format!("return {value};") }
    }

    fn prepare(&self) -> String {
        let graph = &self.formula.prepare;
        let is_turned = self.is_turned();
        let (questions, leaves) = (graph.tree.questions(), graph.tree.leaves());
        let mut roots = questions.clone();
        roots.extend(leaves.concat());
        let mut body = self.body(graph, &roots, is_turned);
        body.compute(&questions);
        let kind = self.type_name("triangle");
        let construct = |body: &Body<'_>, leaf: &[Node]| {
            let values = graph.outputs.iter().zip(leaf);
            let values: Vec<_> =
                values.map(|(name, &node)| (name.clone(), body.text(node))).collect();
            self.language.construct(&kind, &values)
        };
        if leaves.len() > 1 {
            let number = |leaf: &[Node]| {
                let place = leaves.iter().position(|other| *other == leaf);
                self.language.whole(place.unwrap_or_default())
            };
            let chosen = choose(self.language, &graph.tree, &body, &number);
            body.line(&self.language.declare(self.language.index(), "way", &chosen, false));
        }
        for (place, leaf) in leaves.iter().enumerate() {
            let is_last = place + 1 == leaves.len();
            if !is_last {
                body.begin(&format!("way == {}", self.language.whole(place)));
            }
            body.in_block(|body| {
                for (name, &node) in graph.outputs.iter().zip(*leaf) {
                    body.label(node, name);
                }
                body.compute(leaf);
                let mut returned = construct(body, leaf);
                if !is_last && self.language == Language::Rust {
                    returned = format!("return {returned};");
                }
                body.line(&returned);
            });
            if !is_last {
                body.end();
            }
        }
        let mut parameters = vec![("a", self.vector()), ("b", self.vector()), ("c", self.vector())];
        if is_turned {
            parameters.push(("axis", self.language.index()));
        }
        let comment = match self.formula.turned {
            Axis::OfTriangle => "Prepares a triangle, its axes renamed so that `axis` is the last.",
            Axis::OfRay => {
                "Renames a triangle's axes as those of the rays are that it is tested against."
            }
            _ => "Prepares a triangle.",
        };
        let name = format!("{}_prepare", self.prefix);
        self.function(comment, &name, &parameters, &kind, body)
    }

    fn function(
        &self,
        comment: &str,
        name: &str,
        parameters: &[(&str, &str)],
        returns: &str,
        body: Body<'_>,
    ) -> String {
        let mut text = self.comment(comment);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", self.language.function(name, parameters, returns));
        text += &body.finish();
        text += "}\n";
        text
    }
}

/// The choice among the leaves of a tree, each written by `leaf`.
fn choose(
    language: Language,
    tree: &Tree,
    body: &Body<'_>,
    leaf: &impl Fn(&[Node]) -> String,
) -> String {
    match tree {
        Tree::Leaf(outputs) => leaf(outputs),
        Tree::If { test, yes, no } => {
            let (yes, no) = (choose(language, yes, body, leaf), choose(language, no, body, leaf));
            if yes == no {
                return yes;
            }
            let text = language.choice(&body.text(*test), &yes, &no);
            if matches!(language, Language::C | Language::Glsl) {
                format!("({text})")
            } else {
                text
            }
        }
    }
}
