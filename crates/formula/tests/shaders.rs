//! Kernels in the languages of shaders are valid, in every form and for everything that can be asked.

mod common;

use common::subjects;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use trisect_core::FloatFormat;
use trisect_formula::{EmitError, Formula, Language, Request, emit};
use trisect_method::{Form, Output};

fn validate(module: &Module, name: &str, text: &str) {
    let valid = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(module);
    assert!(valid.is_ok(), "{name}: {valid:?}\n{text}");
}

/// All that each form of each method can be asked for, by name.
fn texts(language: Language) -> Vec<(String, String)> {
    let mut texts = Vec::new();
    for subject in subjects::<f32>() {
        for &needs in subject.formula.info.outputs {
            if subject.formula.info.claims.exact && needs != Output::Occlusion {
                continue;
            }
            let division = Some(subject.form);
            let request = Request { language, division, needs: Some(needs), prefix: None };
            let text = emit(&subject.formula, request).expect("it is listed");
            texts.push((format!("{} {needs}", subject.name()), text));
        }
    }
    assert!(texts.len() > 200, "{}", texts.len());
    texts
}

#[test]
fn wgsl_is_valid() {
    for (name, text) in texts(Language::Wgsl) {
        let module = naga::front::wgsl::parse_str(&text);
        let module =
            module.unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&text)));
        validate(&module, &name, &text);
    }
}

#[test]
fn glsl_is_valid() {
    for (name, text) in texts(Language::Glsl) {
        // The validator does not know the qualifier, as old compilers do not.
        let text = format!("#version 450\n#define precise\n{text}\nvoid main() {{}}\n");
        let options = naga::front::glsl::Options::from(ShaderStage::Compute);
        let module = naga::front::glsl::Frontend::default().parse(&options, &text);
        let module = module.unwrap_or_else(|errors| panic!("{name}: {errors:?}\n{text}"));
        validate(&module, &name, &text);
    }
}

#[test]
fn products_are_guarded_where_compilers_may_fuse_them() {
    for (name, text) in texts(Language::Wgsl) {
        let code: Vec<_> = text.lines().filter(|line| !line.starts_with("//")).collect();
        for line in code {
            let products = line.matches(" * ").count();
            assert_eq!(line.matches("_rounded(").count().min(products), products, "{name}: {line}");
        }
    }
}

#[test]
fn what_cannot_be_written_is_refused_with_a_way_out() {
    let subjects = subjects::<f32>();
    let of = |name: &str| {
        &subjects.iter().find(|subject| subject.formula.info.name == name).expect("listed").formula
    };
    let refused = |formula: &Formula, division, needs| {
        let request = Request { language: Language::C, division, needs, prefix: None };
        emit(formula, request).expect_err("it cannot be").to_string()
    };
    let said = refused(of("havel-herout"), Some(Form::Early), None);
    assert_eq!(
        said,
        "havel-herout has no early division: leave out --division, or ask for deferred"
    );
    let said = refused(of("wald"), None, Some(Output::Normal));
    assert_eq!(said, "wald does not give normal: ask for one of occlusion, t, barycentrics, point");
    assert!(refused(of("exact"), None, Some(Output::T)).contains("ask for occlusion"));
    let request = Request { language: Language::Wgsl, division: None, needs: None, prefix: None };
    let doubles = Formula { format: FloatFormat::F64, ..of("wald").clone() };
    let error = emit(&doubles, request).expect_err("shaders have no f64");
    assert_eq!(error, EmitError::Precision { language: Language::Wgsl });
}
