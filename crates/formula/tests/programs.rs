//! Kernels that are written give the bits of those that are compiled here: in C at several levels of optimisation, and in
//! Rust. Where there is no C compiler that is skipped, and said.

mod common;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use common::{FORMAT, HIT, MISS, OPEN, Subject, numbers, pairs, subjects};
use tempfile::TempDir;
use trisect_core::{Ray, Triangle};
use trisect_formula::{Formula, Language, Request, emit};
use trisect_method::{Form, Output as Needs};

/// Pairs of each level of a family: some thousands in all.
const EACH: usize = 8;
/// The same for the test that takes minutes: more than a million.
const MANY: usize = 4600;

/// Pairs whose answers are held in memory at a time.
const PART: usize = 20_000;

fn kernels(subjects: &[Subject<f32>], language: Language) -> Vec<(String, String)> {
    let kernel = |subject: &Subject<f32>| {
        let name = subject.name();
        let division = Some(subject.form);
        let request = Request { language, division, needs: None, prefix: Some(&name) };
        (emit(&subject.formula, request).expect("every form can be written"), name)
    };
    subjects.iter().map(kernel).map(|(text, name)| (name, text)).collect()
}

/// How a program names what the kernel gives.
fn has(subject: &Subject<f32>, needs: Needs) -> bool {
    !subject.formula.info.claims.exact && subject.formula.info.gives(needs)
}

fn program_in_c(subjects: &[Subject<f32>]) -> String {
    let mut text = "#include <stdio.h>\n#include <stdlib.h>\n".to_owned();
    let mut calls = String::new();
    for ((name, kernel), subject) in kernels(subjects, Language::C).iter().zip(subjects) {
        text += kernel;
        let pair = "p, p + 3, p[6], p[7], p + 8, p + 11, p + 14";
        let _ = writeln!(text, "static void run_{name}(const float *p, float *to) {{");
        if subject.formula.info.claims.exact {
            let _ = writeln!(text, "to[0] = (float){name}_intersect({pair});\n}}");
        } else {
            let _ = writeln!(text, "{name}_hit h = {name}_intersect({pair});");
            text += "to[0] = (float)h.hit;\nif (h.hit) {\nto[1] = h.t;\n";
            if has(subject, Needs::Barycentrics) {
                text += "to[2] = h.beta;\nto[3] = h.gamma;\n";
            }
            text += "}\n}\n";
        }
        let _ = writeln!(calls, "run_all(run_{name}, pairs, count, out);");
    }
    text += "static void run_all(void (*run)(const float *, float *), const float *pairs, size_t count, FILE *out) {\n\
             for (size_t i = 0; i < count; i++) {\n\
             float to[4] = { 0.0f, 0.0f, 0.0f, 0.0f };\n\
             run(pairs + 17 * i, to);\n\
             fwrite(to, sizeof to, 1, out);\n}\n}\n\
             int main(int argc, char **argv) {\n\
             if (argc != 4) return 2;\n\
             size_t count = (size_t)atol(argv[1]);\n\
             float *pairs = malloc(count * 17 * sizeof(float));\n\
             FILE *in = fopen(argv[2], \"rb\"), *out = fopen(argv[3], \"wb\");\n\
             if (!pairs || !in || !out || fread(pairs, 17 * sizeof(float), count, in) != count) return 2;\n";
    text + &calls + "free(pairs);\nfclose(in);\nreturn fclose(out);\n}\n"
}

fn program_in_rust(subjects: &[Subject<f32>]) -> String {
    let mut text = "#![allow(dead_code, unused_variables)]\n".to_owned();
    let mut calls = String::new();
    for ((name, kernel), subject) in kernels(subjects, Language::Rust).iter().zip(subjects) {
        let _ = writeln!(text, "mod m_{name} {{\n{kernel}}}");
        let pair = "v(0), v(3), p[6], p[7], v(8), v(11), v(14)";
        let _ =
            writeln!(calls, "for p in &pairs {{\nlet v = |i: usize| [p[i], p[i + 1], p[i + 2]];");
        let _ = writeln!(calls, "let h = m_{name}::{name}_intersect({pair});");
        if subject.formula.info.claims.exact {
            calls += "let to = [h as f32, 0.0, 0.0, 0.0];\n";
        } else {
            let weights =
                if has(subject, Needs::Barycentrics) { "h.beta, h.gamma" } else { "0.0, 0.0" };
            let _ = writeln!(calls, "let to = h.map_or([0.0; 4], |h| [1.0, h.t, {weights}]);");
        }
        calls += "for x in to { out.extend(x.to_ne_bytes()); }\n}\n";
    }
    text += "fn main() {\nlet args: Vec<String> = std::env::args().collect();\n\
             let bytes = std::fs::read(&args[2]).unwrap();\n\
             let numbers: Vec<f32> = bytes.chunks(4).map(|b| f32::from_ne_bytes(b.try_into().unwrap())).collect();\n\
             let pairs: Vec<&[f32]> = numbers.chunks(17).collect();\n\
             let mut out: Vec<u8> = Vec::new();\n";
    text + &calls + "std::fs::write(&args[3], out).unwrap();\n}\n"
}

/// What the kernels here answer, as the programs write it.
fn expected(subject: &Subject<f32>, pair: &(Ray<f32>, Triangle<f32>)) -> [f32; 4] {
    let Some(hit) = (subject.kernel)(&pair.0, &pair.1) else { return [MISS, 0.0, 0.0, 0.0] };
    if subject.formula.info.claims.exact {
        return [HIT, 0.0, 0.0, 0.0];
    }
    let weigh = |weight| if has(subject, Needs::Barycentrics) { weight } else { 0.0 };
    [HIT, hit.t, weigh(hit.beta), weigh(hit.gamma)]
}

/// Runs a program over pairs and counts what differs from the kernels here.
fn differences(
    program: &Path,
    folder: &Path,
    subjects: &[Subject<f32>],
    pairs: &[(Ray<f32>, Triangle<f32>)],
) -> Vec<String> {
    let (given, answered) = (folder.join("pairs"), folder.join("answers"));
    let bytes: Vec<u8> = pairs.iter().flat_map(numbers).flat_map(f32::to_ne_bytes).collect();
    fs::write(&given, bytes).expect("a temporary folder can be written");
    let output = Command::new(program)
        .arg(pairs.len().to_string())
        .args([&given, &answered])
        .output()
        .expect("what was compiled runs");
    assert!(output.status.success(), "{output:?}");
    let bytes = fs::read(&answered).expect("it wrote its answers");
    let answers: Vec<f32> =
        bytes.chunks(4).map(|b| f32::from_ne_bytes(b.try_into().expect("four"))).collect();
    assert_eq!(answers.len(), 4 * subjects.len() * pairs.len());
    let mut all = Vec::new();
    for (subject, answers) in subjects.iter().zip(answers.chunks(4 * pairs.len())) {
        for (pair, answer) in pairs.iter().zip(answers.chunks(4)) {
            let expected = expected(subject, pair);
            if answer[0] != OPEN
                && expected.map(f32::to_bits) != [0, 1, 2, 3].map(|i| answer[i].to_bits())
            {
                all.push(format!("{}: {answer:?}, not {expected:?}, of {pair:?}", subject.name()));
            }
        }
    }
    all
}

fn compiler() -> Option<String> {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    Command::new(&compiler).arg("--version").output().ok()?.status.success().then_some(compiler)
}

fn compile(compiler: &str, options: &[&str], source: &Path, program: &Path) -> Output {
    Command::new(compiler)
        .args(options)
        .arg(source)
        .arg("-o")
        .arg(program)
        .arg("-lm")
        .output()
        .expect("it ran before")
}

fn compiled(compiler: &str, options: &[&str], source: &Path, program: &Path) {
    let output = compile(compiler, options, source, program);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{options:?}: {}",
        said.chars().take(4000).collect::<String>()
    );
}

fn holds_in_c(each: usize, at_least: usize, levels: &[&[&str]]) {
    let Some(compiler) = compiler() else {
        println!("skipped: there is no C compiler");
        return;
    };
    let folder = TempDir::new().expect("a temporary folder");
    let (subjects, pairs) = (subjects::<f32>(), pairs::<f32>(each));
    assert!(pairs.len() >= at_least, "{}", pairs.len());
    let source = folder.path().join("kernels.c");
    fs::write(&source, program_in_c(&subjects)).expect("a temporary folder can be written");
    for level in levels {
        let program = folder.path().join("kernels");
        let options =
            [&["-std=c99", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"], *level].concat();
        compiled(&compiler, &options, &source, &program);
        // In parts, as their answers take a gigabyte together.
        for pairs in pairs.chunks(PART) {
            let differ = differences(&program, folder.path(), &subjects, pairs);
            assert!(differ.is_empty(), "{level:?}: {} differ, {}", differ.len(), differ[0]);
        }
    }
    println!("{} pairs, {} forms, levels {levels:?}", pairs.len(), subjects.len());
}

#[test]
fn c_gives_the_bits_of_the_kernels_at_every_level_of_optimisation() {
    holds_in_c(EACH, 1500, &[&["-O0"], &["-O1"], &["-O2"], &["-O3", "-march=native"]]);
}

#[test]
#[ignore = "a million pairs: minutes"]
fn c_gives_the_bits_of_the_kernels_on_a_million_pairs() {
    holds_in_c(MANY, 1_000_000, &[&["-O2"]]);
}

/// What the notes forbid is refused, or changes decisions: the instructions are needed.
#[test]
fn c_is_not_compiled_carelessly() {
    let Some(compiler) = compiler() else {
        println!("skipped: there is no C compiler");
        return;
    };
    let folder = TempDir::new().expect("a temporary folder");
    let source = folder.path().join("kernels.c");
    fs::write(&source, program_in_c(&subjects::<f32>())).expect("it can be written");
    let output = compile(&compiler, &["-O2", "-ffast-math"], &source, &folder.path().join("fast"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && said.contains("rounded by itself"), "{said}");
}

#[test]
fn rust_gives_the_bits_of_the_kernels() {
    let folder = TempDir::new().expect("a temporary folder");
    let (subjects, pairs) = (subjects::<f32>(), pairs::<f32>(EACH));
    let (source, program) = (folder.path().join("kernels.rs"), folder.path().join("kernels"));
    fs::write(&source, program_in_rust(&subjects)).expect("a temporary folder can be written");
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let output = Command::new(rustc)
        .args(["--edition=2024", "-Copt-level=1", "-o"])
        .args([&program, &source])
        .output()
        .expect("these tests were compiled by it");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}", said.chars().take(4000).collect::<String>());
    let differ = differences(&program, folder.path(), &subjects, &pairs);
    assert!(differ.is_empty(), "{} differ, {}", differ.len(), differ[0]);
}

/// Every value that a method gives can be asked for, in C and in Rust.
#[test]
fn every_need_is_written() {
    let folder = TempDir::new().expect("a temporary folder");
    let mut text = String::new();
    for subject in subjects::<f32>() {
        for &needs in subject.formula.info.outputs {
            if subject.formula.info.claims.exact && needs != Needs::Occlusion {
                continue;
            }
            let name = format!("{}_{needs}", subject.name());
            let request = Request {
                language: Language::C,
                division: Some(subject.form),
                needs: Some(needs),
                prefix: Some(&name),
            };
            text += &emit(&subject.formula, request).expect("it is listed");
        }
    }
    let Some(compiler) = compiler() else {
        println!("skipped: there is no C compiler");
        return;
    };
    let source = folder.path().join("needs.c");
    fs::write(&source, text + "int main(void) { return 0; }\n").expect("it can be written");
    let options = ["-std=c99", "-Wall", "-Wextra", "-Werror"];
    compiled(&compiler, &options, &source, &folder.path().join("needs"));
}

/// The program of docs/EMIT.md, compiled with the kernel that the page asks for, prints what the page says.
#[test]
fn the_program_of_the_page_runs() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/EMIT.md");
    let page = fs::read_to_string(page).expect("the page is there");
    let block = |language: &str| {
        let (_, rest) = page.split_once(&format!("```{language}\n")).expect("a block");
        rest.split_once("```").expect("it ends").0
    };
    let (program, prints) = (block("c"), block("text"));
    assert!(program.lines().count() <= 24, "about 20 lines");
    assert!(
        page.contains("trisect emit --method moller-trumbore --language c > moller_trumbore.h")
    );
    let Some(compiler) = compiler() else {
        println!("skipped: there is no C compiler");
        return;
    };
    let formula = Formula::of::<trisect_moller_trumbore::MollerTrumbore>(FORMAT);
    let language = Language::C;
    let request = Request { language, division: None, needs: None, prefix: None };
    let kernel = emit(&formula, request).expect("it can be written");
    assert_eq!(formula.info.forms.preferred(), Form::Deferred);
    let folder = TempDir::new().expect("a temporary folder");
    fs::write(folder.path().join("moller_trumbore.h"), kernel).expect("it can be written");
    let (source, output) = (folder.path().join("program.c"), folder.path().join("program"));
    fs::write(&source, program).expect("it can be written");
    let options = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-ffp-contract=off"];
    compiled(&compiler, &options, &source, &output);
    let output = Command::new(output).output().expect("what was compiled runs");
    assert_eq!(String::from_utf8_lossy(&output.stdout), prints);
}
