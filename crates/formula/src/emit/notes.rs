//! What stands above the code: source, guarantees and how to compile it; and the few functions that languages lack.

use core::fmt::Write as _;

use trisect_core::FloatFormat;
use trisect_method::{Form, Output};

use super::Writer;
use super::language::Language;
use crate::ops::Ops;

/// Columns of a comment.
const COLUMNS: usize = 100;

impl Writer<'_> {
    /// A comment above something.
    pub(super) fn comment(&self, text: &str) -> String {
        wrapped(text, if self.language == Language::Rust { "/// " } else { "// " }, "")
    }

    /// What stands above all.
    pub(super) fn notes(&self) -> String {
        let info = &self.formula.info;
        let mut text = String::new();
        let paragraph = |text: &mut String, said: &str| {
            text.push_str(&wrapped(said, "// ", ""));
            text.push_str("//\n");
        };
        let form = match self.test.form {
            Form::Early => "divides before it decides",
            Form::Deferred => "decides without a division",
        };
        let gives = match self.needs {
            Output::Occlusion => "tells whether a ray hits",
            Output::T => "gives t",
            Output::Barycentrics => "gives t, beta and gamma",
            Output::Point => "gives t and the point",
            Output::Normal => "gives t and the normal (b - a) x (c - a), with its length",
        };
        paragraph(
            &mut text,
            &format!(
                "{} in {}: {form}, {gives}. Written by trisect {}.",
                info.title,
                self.formula.format.name(),
                env!("CARGO_PKG_VERSION"),
            ),
        );
        paragraph(&mut text, &format!("Source: {}.", info.source));
        paragraph(
            &mut text,
            "The ray o + t d, t_min <= t <= t_max, meets the triangle a, b, c at (1 - beta - gamma) a + beta b + \
             gamma c. Edges, corners and both ends of the interval count.",
        );
        paragraph(&mut text, &self.price());
        text += "// What it promises\n";
        for promise in self.promises() {
            text += &wrapped(&promise, "// - ", "//   ");
        }
        text += "//\n";
        text += &wrapped(&self.how_to_compile(), "// ", "");
        text
    }

    /// What a test takes.
    fn price(&self) -> String {
        let Ops { multiplies, adds, divisions, comparisons, .. } = self.test.decision();
        let after = if self.fields().is_empty() || self.test.form == Form::Early {
            String::new()
        } else {
            let Ops { multiplies, divisions, .. } = self.test.finish();
            format!(
                "; a hit takes {} and {multiplies} products more",
                counted(divisions, "division")
            )
        };
        format!(
            "A triangle is stored in {} numbers. A test takes {multiplies} products, {adds} sums and differences, \
             {} and {comparisons} comparisons{after}.",
            self.formula.prepare.outputs.len(),
            counted(divisions, "division"),
        )
    }

    fn promises(&self) -> Vec<String> {
        let info = &self.formula.info;
        let mut all = Vec::new();
        let format = self.formula.format.name();
        match self.language {
            Language::C | Language::Rust => all.push(format!(
                "Decisions and values are those of trisect's plain {format} kernels to the bit, on every processor that \
                 follows IEEE 754 and keeps subnormal numbers."
            )),
            Language::Wgsl | Language::Glsl => {
                let decisions = if self.test.form == Form::Deferred {
                    "no decision divides, so they are those of trisect's plain kernels"
                } else {
                    "decisions depend on it: use --division deferred, where the method has that, for the same ones \
                     everywhere"
                };
                all.push(format!(
                    "A GPU's division may be off by 2.5 units in the last place; {decisions}. A GPU may flush \
                     subnormal numbers to zero, and need not know NaN and infinity: give it finite numbers."
                ));
            }
        }
        if info.claims.exact {
            all.push(
                "Never wrong: a hit and a miss are those of exact arithmetic. What is open, a ray within rounding of an \
                 edge or of an end of its interval, this formula cannot tell. Settle it on the CPU by the method `exact` of trisect's library, or by exact \
                 arithmetic of your own. Without that, let open count as a hit for shadows and visibility, which \
                 closes all cracks."
                    .to_owned(),
            );
        } else if info.claims.watertight {
            all.push(
                "Watertight: no ray passes between triangles that share an edge or a corner, while nothing over- or \
                 underflows."
                    .to_owned(),
            );
        } else {
            all.push(
                "Not watertight: rays aimed at a shared edge may pass between its triangles."
                    .to_owned(),
            );
        }
        all.push(if info.claims.unit_direction {
            "d must have unit length.".to_owned()
        } else {
            "d may have any length but zero.".to_owned()
        });
        if matches!(self.language, Language::C | Language::Rust) {
            all.push("A ray with a NaN or an infinity, but for t_max, hits nothing.".to_owned());
        }
        all.push(
            "A triangle without area, or that is not finite, must be left out; where that is not possible, all its \
             coordinates must be NaN."
                .to_owned(),
        );
        all
    }

    fn how_to_compile(&self) -> String {
        match self.language {
            Language::C => {
                "Compile as C99 or C++ with -ffp-contract=off and without -ffast-math (MSVC: /fp:precise); on 32-bit x86 \
                 with -msse2 -mfpmath=sse. A sum of a product that is rounded once decides pairs at edges otherwise."
                    .to_owned()
            }
            Language::Rust => {
                "Rust rounds every operation by itself: there is nothing to set.".to_owned()
            }
            Language::Wgsl => format!(
                "Compilers of shaders may fuse, factor and reorder: products are guarded by an exclusive-or with \
                 trisect_zero, which is 0 and which no compiler knows. Bind four zero bytes to it, and declare it once \
                 for all kernels of a module. It costs one operation on bits for each of {} products; let \
                 {}_rounded return x to do without, and with other decisions at edges.",
                self.products(),
                self.prefix,
            ),
            Language::Glsl => {
                "`precise` keeps compilers from fusing, factoring and reordering. GLSL ES before 3.20 lacks it: \
                 `#define precise` above this, and decisions at edges may be others."
                    .to_owned()
            }
        }
    }

    /// Products of the test, with the values that are asked for.
    fn products(&self) -> u32 {
        let graph = self.graph();
        graph.count(&graph.needed(self.roots()), 0..graph.ops.len()).multiplies
    }

    /// What the functions use and the language lacks.
    pub(super) fn helpers(&self, functions: &str) -> String {
        let (language, prefix, number) = (self.language, &self.prefix, self.number());
        let is_used = |name: &str| functions.contains(&format!("{prefix}_{name}("));
        let mut text = String::new();
        if language == Language::C {
            text += "\n#include <float.h>\n#include <math.h>\n";
            if is_used("xor_sign") {
                text += "#include <stdint.h>\n#include <string.h>\n";
            }
            text += "\n#if defined(__FAST_MATH__) || (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0)\n\
                     #error \"every operation must be rounded by itself: see above\"\n#endif\n";
        }
        let mut function =
            |name: &str, parameters: &[(&str, &str)], lines: &[String], said: &str| {
                let name = format!("{prefix}_{name}");
                let _ = write!(text, "\n{}", self.comment(said));
                let _ = writeln!(text, "{}", language.function(&name, parameters, number));
                for line in lines {
                    let _ = writeln!(text, "    {line}");
                }
                text += "}\n";
            };
        if language == Language::Wgsl && is_used("rounded") {
            let line = "return bitcast<f32>(bitcast<u32>(x) ^ trisect_zero);".to_owned();
            function("rounded", &[("x", number)], &[line], "A product, rounded by itself.");
        }
        let pair = [("x", number), ("y", number)];
        let returned = |value: String| self.returned(&value);
        if is_used("xor_sign") {
            let lines = match (language, self.formula.format) {
                (Language::C, format) => {
                    let bits = if format == FloatFormat::F32 { "uint32_t" } else { "uint64_t" };
                    let shift = if format == FloatFormat::F32 { 31 } else { 63 };
                    vec![
                        format!("{bits} of_x, of_y;"),
                        "memcpy(&of_x, &x, sizeof x);".to_owned(),
                        "memcpy(&of_y, &y, sizeof y);".to_owned(),
                        format!("of_x ^= of_y & (({bits})1 << {shift});"),
                        "memcpy(&x, &of_x, sizeof x);".to_owned(),
                        "return x;".to_owned(),
                    ]
                }
                (Language::Rust, _) => vec![format!(
                    "{number}::from_bits(x.to_bits() ^ (y.to_bits() & (-0.0_{number}).to_bits()))"
                )],
                (Language::Wgsl, _) => vec![
                    "return bitcast<f32>(bitcast<u32>(x) ^ (bitcast<u32>(y) & 0x80000000u));".to_owned(),
                ],
                (Language::Glsl, _) => vec![
                    "return uintBitsToFloat(floatBitsToUint(x) ^ (floatBitsToUint(y) & 0x80000000u));"
                        .to_owned(),
                ],
            };
            function("xor_sign", &pair, &lines, "x, its sign flipped where y is negative.");
        }
        for (name, sign, said) in [("least", "<", "smaller"), ("most", ">", "larger")] {
            if is_used(name) {
                let value = language.choice(&format!("x {sign} y"), "x", "y");
                let said = format!("The {said} of two; y where either is NaN.");
                function(name, &pair, &[returned(value)], &said);
            }
        }
        if language == Language::Wgsl && is_used("rounded") {
            text = format!("\n@group(0) @binding(0) var<uniform> trisect_zero: u32;\n{text}");
        }
        text
    }
}

/// So many of something.
fn counted(count: u32, what: &str) -> String {
    match count {
        0 => format!("no {what}"),
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}

/// Text in lines: `first` stands before the first one, and before the others `others`, or where that is empty `first` as
/// well.
fn wrapped(text: &str, first: &str, others: &str) -> String {
    let others = if others.is_empty() { first } else { others };
    let mut lines = String::new();
    let mut line = first.to_owned();
    let mut is_empty = true;
    for word in text.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > COLUMNS {
            lines += line.trim_end();
            lines.push('\n');
            others.clone_into(&mut line);
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line += word;
        is_empty = false;
    }
    lines + line.trim_end() + "\n"
}
