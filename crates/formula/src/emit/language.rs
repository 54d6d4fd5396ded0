//! How the languages write the same thing.

use trisect_core::{FloatFormat, named};

named! {
    /// A language that kernels are written in.
    pub enum Language {
        /// C99, and C++.
        C = "c",
        /// The shading language of WebGPU.
        Wgsl = "wgsl",
        /// The shading language of OpenGL and Vulkan, 4.00 on.
        Glsl = "glsl",
        /// Rust, without a dependency.
        Rust = "rust",
    }
}

impl Language {
    /// The type of numbers.
    pub(super) fn number(self, format: FloatFormat) -> &'static str {
        match (self, format) {
            (Self::C | Self::Glsl, FloatFormat::F32) => "float",
            (Self::C | Self::Glsl, FloatFormat::F64) => "double",
            (_, FloatFormat::F32) => "f32",
            (_, FloatFormat::F64) => "f64",
        }
    }

    /// The type of truth values.
    pub(super) fn truth(self) -> &'static str {
        if self == Self::C { "int" } else { "bool" }
    }

    /// The type of axes and outcomes.
    pub(super) fn index(self) -> &'static str {
        match self {
            Self::C | Self::Glsl => "int",
            Self::Wgsl => "u32",
            Self::Rust => "usize",
        }
    }

    /// A truth value that is known.
    pub(super) fn known(self, holds: bool) -> &'static str {
        match (self, holds) {
            (Self::C, true) => "1",
            (Self::C, false) => "0",
            (_, true) => "true",
            (_, false) => "false",
        }
    }

    /// A whole number.
    pub(super) fn whole(self, value: usize) -> String {
        if self == Self::Wgsl { format!("{value}u") } else { value.to_string() }
    }

    /// A number.
    pub(super) fn literal(self, format: FloatFormat, value: f64) -> String {
        debug_assert!(value.is_finite(), "no language has literals of others");
        // The shortest digits that are read as the same number.
        #[allow(clippy::cast_possible_truncation, reason = "it is a number of the format")]
        let digits = match format {
            FloatFormat::F32 => format!("{:?}", value as f32),
            FloatFormat::F64 => format!("{value:?}"),
        };
        match (self, format) {
            (Self::C | Self::Wgsl, FloatFormat::F32) => digits + "f",
            _ => digits,
        }
    }

    /// `yes` where `test` holds, else `no`.
    pub(super) fn choice(self, test: &str, yes: &str, no: &str) -> String {
        match self {
            Self::C | Self::Glsl => format!("{test} ? {yes} : {no}"),
            Self::Wgsl => format!("select({no}, {yes}, {test})"),
            Self::Rust => format!("if {test} {{ {yes} }} else {{ {no} }}"),
        }
    }

    /// Begins a block that is done where `test` holds.
    pub(super) fn begin_if(self, test: &str) -> String {
        match self {
            Self::C | Self::Glsl => format!("if ({test}) {{"),
            Self::Wgsl | Self::Rust => format!("if {test} {{"),
        }
    }

    /// Names a value of a type, to be changed or not.
    pub(super) fn declare(self, kind: &str, name: &str, value: &str, changes: bool) -> String {
        match (self, changes) {
            (Self::C, false) => format!("const {kind} {name} = {value};"),
            // Neither contracted nor factored.
            (Self::Glsl, _) if kind == "float" || kind == "double" => {
                format!("precise {kind} {name} = {value};")
            }
            (Self::Glsl, _) | (Self::C, true) => format!("{kind} {name} = {value};"),
            (Self::Wgsl | Self::Rust, false) => format!("let {name} = {value};"),
            (Self::Wgsl, true) => format!("var {name} = {value};"),
            (Self::Rust, true) => format!("let mut {name} = {value};"),
        }
    }

    /// The coordinate of a vector along one of its axes, the first, the second or the third.
    pub(super) fn coordinate(self, vector: &str, axis: usize) -> String {
        match self {
            Self::C | Self::Rust => format!("{vector}[{axis}]"),
            Self::Wgsl | Self::Glsl => format!("{vector}.{}", ["x", "y", "z"][axis]),
        }
    }

    /// The head of a function: its name, its parameters by name and type, and what it returns.
    pub(super) fn function(self, name: &str, parameters: &[(&str, &str)], returns: &str) -> String {
        let list = |each: &dyn Fn(&str, &str) -> String| {
            parameters.iter().map(|(name, kind)| each(name, kind)).collect::<Vec<_>>().join(", ")
        };
        match self {
            Self::C => {
                let each = |name: &str, kind: &str| match kind.strip_suffix("[3]") {
                    Some(number) => format!("const {number} {name}[3]"),
                    None => format!("{kind} {name}"),
                };
                format!("static inline {returns} {name}({}) {{", list(&each))
            }
            Self::Glsl => {
                let each = |name: &str, kind: &str| format!("{kind} {name}");
                format!("{returns} {name}({}) {{", list(&each))
            }
            Self::Wgsl => {
                let each = |name: &str, kind: &str| format!("{name}: {kind}");
                format!("fn {name}({}) -> {returns} {{", list(&each))
            }
            Self::Rust => {
                let each = |name: &str, kind: &str| format!("{name}: {kind}");
                format!("pub fn {name}({}) -> {returns} {{", list(&each))
            }
        }
    }

    /// The type of three numbers.
    pub(super) fn vector(self, format: FloatFormat) -> &'static str {
        match (self, format) {
            (Self::C, FloatFormat::F32) => "float[3]",
            (Self::C, FloatFormat::F64) => "double[3]",
            (Self::Glsl, FloatFormat::F32) => "vec3",
            (Self::Glsl, FloatFormat::F64) => "dvec3",
            (Self::Wgsl, _) => "vec3f",
            (Self::Rust, FloatFormat::F32) => "[f32; 3]",
            (Self::Rust, FloatFormat::F64) => "[f64; 3]",
        }
    }

    /// A structure of fields by name and type.
    pub(super) fn structure(self, name: &str, fields: &[(String, &str)]) -> String {
        let mut text = match self {
            Self::C => "typedef struct {\n".to_owned(),
            Self::Rust => {
                format!("#[derive(Clone, Copy, Debug)]\npub struct {name} {{\n")
            }
            _ => format!("struct {name} {{\n"),
        };
        for (field, kind) in fields {
            let member = match (self, kind.strip_suffix("[3]")) {
                (Self::C, Some(number)) => format!("{number} {field}[3];"),
                (Self::C | Self::Glsl, _) => format!("{kind} {field};"),
                (Self::Wgsl, _) => format!("{field}: {kind},"),
                (Self::Rust, _) => format!("pub {field}: {kind},"),
            };
            text.extend(["    ", &member, "\n"]);
        }
        text += "}";
        match self {
            Self::C => text.extend([" ", name, ";"]),
            Self::Glsl => text += ";",
            Self::Wgsl | Self::Rust => {}
        }
        text.push('\n');
        text
    }

    /// Returns a structure whose fields have these values, in order.
    pub(super) fn construct(self, name: &str, fields: &[(String, String)]) -> String {
        let values = fields.iter().map(|(_, value)| value.as_str());
        match self {
            Self::C => {
                let values: Vec<_> = values.collect();
                format!("const {name} result = {{ {} }};\nreturn result;", values.join(", "))
            }
            Self::Wgsl | Self::Glsl => {
                let values: Vec<_> = values.collect();
                format!("return {name}({});", values.join(", "))
            }
            Self::Rust => {
                let field = |(field, value): &(String, String)| {
                    if field == value { field.clone() } else { format!("{field}: {value}") }
                };
                let fields: Vec<_> = fields.iter().map(field).collect();
                format!("{name} {{ {} }}", fields.join(", "))
            }
        }
    }

    /// A name of a type: `name` after the prefix of all.
    pub(super) fn type_name(self, prefix: &str, name: &str) -> String {
        if self == Self::C {
            return format!("{prefix}_{name}");
        }
        let mut camel = String::new();
        for word in prefix.split('_').chain([name]) {
            let mut letters = word.chars();
            camel.extend(letters.next().map(|first| first.to_ascii_uppercase()));
            camel.extend(letters);
        }
        camel
    }
}
