//! The lines of Rust that use a kernel.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use trisect_catalog::Variant;
use trisect_core::{InstructionSet, MultiplyAdd};
use trisect_kernels::Arrangement;
use trisect_method::{Form, Output, ReciprocalKind};

use crate::output::COLUMNS;

/// A kernel as a program names it.
struct Names {
    lanes: String,
    division: String,
    kernel: &'static str,
    /// What the rays of packets share, as one more argument.
    shared: &'static str,
    /// The instruction set, and the module it is in; none for scalars.
    token: Option<(&'static str, &'static str)>,
    /// All that is used, whatever crate it is of.
    imports: Vec<&'static str>,
}

impl Names {
    fn of(variant: &Variant) -> Self {
        let Variant { precision, width, early_out, .. } = variant;
        let token = match variant.instruction_set {
            InstructionSet::Scalar => None,
            InstructionSet::Sse2 => Some(("x86", "Sse2")),
            InstructionSet::Sse42 => Some(("x86", "Sse4_2")),
            InstructionSet::Avx2 => Some(("x86", "Avx2")),
            InstructionSet::Avx512 => Some(("x86", "Avx512")),
            InstructionSet::Neon => Some(("aarch64", "Neon")),
        };
        let arithmetic = match variant.arithmetic {
            MultiplyAdd::Plain => "Plain",
            MultiplyAdd::Fused => "Fused",
        };
        let lanes = token.map_or_else(
            || precision.to_string(),
            |(_, token)| format!("Vector<{token}, {precision}x{width}<{token}>, {arithmetic}>"),
        );
        let form = match variant.division {
            Form::Early => "Early",
            Form::Deferred => "Deferred",
        };
        let reciprocal = match variant.reciprocal {
            ReciprocalKind::True => "TrueDivision",
            ReciprocalKind::Newton => "Newton",
        };
        let mut division = format!("{form}<{reciprocal}, {early_out}>");
        if variant.needs == Output::Occlusion {
            division = format!("DecisionOnly<{division}>");
        }
        let (kernel, shared) = match variant.arrangement {
            Arrangement::OneRay => ("one_ray", ""),
            Arrangement::OneTriangle => ("one_triangle", ""),
            Arrangement::CommonOrigin => ("shared_packets", ", CommonOrigin"),
            Arrangement::CommonDirection => ("shared_packets", ", CommonDirection"),
        };
        let rays = if kernel == "one_ray" { "Ray" } else { "Packets" };
        let mut imports = vec![form, reciprocal];
        imports.extend(["Culling", kernel, "Hit", "Lanes", "PreparedTriangles", rays, "Tested"]);
        imports.extend(["Token", "Triangle", "UnsuitableMesh"]);
        imports.extend(token.iter().flat_map(|_| ["Vector", arithmetic]));
        imports.extend(shared.strip_prefix(", "));
        imports.extend((variant.needs == Output::Occlusion).then_some("DecisionOnly"));
        Self { lanes, division, kernel, shared, token, imports }
    }
}

/// The crate that a name is of which every program uses.
fn crate_of(name: &str) -> &'static str {
    match name {
        "Fused" | "Hit" | "Lanes" | "Plain" | "Ray" | "Token" | "Triangle" | "Vector" => {
            "trisect_core"
        }
        "CommonDirection" | "CommonOrigin" | "Packets" | "PreparedTriangles" | "Tested"
        | "one_ray" | "one_triangle" | "shared_packets" => "trisect_kernels",
        _ => "trisect_method",
    }
}

/// The lines that import names of a crate.
fn import(krate: &str, mut names: Vec<&str>) -> String {
    names.sort_by_key(|name| name.to_lowercase());
    if let [name] = names[..] {
        return format!("use {krate}::{name};\n");
    }
    let mut out = String::new();
    let mut line = format!("use {krate}::{{");
    for name in names {
        if line.len() + name.len() > COLUMNS - 3 {
            let _ = writeln!(out, "{}", line.trim_end());
            "    ".clone_into(&mut line);
        }
        let _ = write!(line, "{name}, ");
    }
    let _ = writeln!(out, "{}}};", line.trim_end_matches(", "));
    out
}

/// How triangles are prepared for a kernel, and what calls it.
pub(crate) fn of(variant: &Variant) -> String {
    let method = trisect_catalog::find(&variant.method).expect("what was measured is there");
    let Variant { precision, width, .. } = variant;
    let Names { lanes, division, kernel, shared, token, imports } = Names::of(variant);
    // The method's type without its paths, whose names are imported.
    let mut short = method.type_name.clone();
    let mut crates: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for path in method.type_name.split(|c: char| !(c.is_alphanumeric() || "_:".contains(c))) {
        let Some((root, name)) = path.split_once("::") else { continue };
        short = short.replace(path, name);
        crates.entry(root).or_default().push(name);
    }
    for name in imports {
        crates.entry(crate_of(name)).or_default().push(name);
    }
    let rays = if kernel == "one_ray" { "ray" } else { "packets" };
    let bound = if kernel == "one_ray" { "Ray" } else { "Packets" };

    let mut names: Vec<String> = crates.keys().map(|krate| krate.replace('_', "-")).collect();
    names.extend(token.map(|_| "fearless_simd".to_owned()));
    let mut out = format!("// Crates: {}.\n", names.join(", "));
    if let Some((module, token)) = token {
        let _ = writeln!(out, "use fearless_simd::{{{precision}x{width}, {module}::{token}}};");
    }
    for (krate, names) in crates {
        out += &import(krate, names);
    }
    out.push('\n');
    let _ = write!(
        out,
        "type Method = {};
type L = {lanes};
type Division = {division};

fn prepare(
    triangles: &[Triangle<{precision}>],
) -> Result<PreparedTriangles<Method, {precision}>, UnsuitableMesh> {{
    PreparedTriangles::new(triangles)
}}

/// Calls `found` with the lanes that hit, and where{}
fn trace(
    {rays}: &{bound}<{precision}>,
    triangles: &PreparedTriangles<Method, {precision}>,
    mut found: impl FnMut(Tested<'_, Method, L>, <L as Lanes>::Mask, Hit<L>),
) -> Option<()> {{
    let token = <L as Lanes>::Token::detect()?;
    token.run(
        #[inline(always)]
        || {{
            {kernel}::<Method, L, Division{shared}>(
                token,
                {rays},
                triangles,
                Culling::None,
                #[inline(always)]
                |tested, mask, hit| found(tested, mask, hit),
            );
        }},
    );
    Some(())
}}
",
        short,
        token.map_or_else(
            || ".".to_owned(),
            |_| format!("; none without {}.", variant.instruction_set)
        ),
    );
    out
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;
    use std::process::Command;

    use trisect_catalog::entries;

    use super::*;

    /// Whatever is recommended: one kernel of every method, and every kernel of one.
    #[test]
    fn the_lines_compile() {
        let mut programs = BTreeMap::new();
        for (number, entry) in entries().iter().enumerate() {
            let kernels = entry.f32.timed.iter().chain(&entry.f64.timed);
            let count = if number == 0 { usize::MAX } else { 1 };
            for kernel in kernels.take(count) {
                programs.insert(format!("p{}", programs.len()), of(&kernel.variant));
            }
        }
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let manifest =
            fs::read_to_string(root.join("crates/catalog/Cargo.toml")).expect("it is there");
        let folder = tempfile::tempdir().expect("the system has a folder for temporaries");
        let path = folder.path();
        let mut own = String::from(
            "[package]\nname = \"lines\"\nversion = \"0.0.0\"\nedition = \"2024\"\n[workspace]\n\
             [dependencies]\nfearless_simd = \"1.2\"\n",
        );
        for krate in ["core", "kernels", "method"] {
            let path = root.join("crates").join(krate);
            let _ = writeln!(own, "trisect-{krate} = {{ path = \"{}\" }}", path.display());
        }
        for line in manifest.lines().filter(|line| line.contains("\"../methods/")) {
            let methods = format!("\"{}/", root.join("crates/methods").display());
            let _ = writeln!(own, "{}", line.replace("\"../methods/", &methods));
        }
        fs::create_dir(path.join("src")).expect("a folder");
        fs::write(path.join("Cargo.toml"), own).expect("a file");
        fs::copy(root.join("Cargo.lock"), path.join("Cargo.lock")).expect("a file");
        let mut modules = "#![allow(dead_code)]\n".to_owned();
        for name in programs.keys() {
            let _ = writeln!(modules, "mod {name};");
        }
        fs::write(path.join("src/lib.rs"), modules).expect("a file");
        for (name, program) in &programs {
            fs::write(path.join(format!("src/{name}.rs")), program).expect("a file");
        }
        let check = Command::new(env!("CARGO"))
            .args(["check", "--offline", "--quiet"])
            .current_dir(path)
            .env("CARGO_TARGET_DIR", root.join("target/recommended"))
            .env("RUSTFLAGS", "--deny warnings")
            .output()
            .expect("cargo runs this test");
        assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stderr));
    }
}
