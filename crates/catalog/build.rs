//! Writes the list of methods from the manifest's dependencies under `../methods/`, so that a
//! method is added by one line; and how the kernels are compiled, for the records of what they are measured to do.

use std::process::Command;
use std::{env, fs, path::Path};

fn main() {
    println!("cargo::rerun-if-changed=Cargo.toml");
    println!("cargo::rerun-if-changed=build.rs");
    list_methods();
    let rustc = env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = Command::new(rustc)
        .arg("--version")
        .output()
        .ok()
        .and_then(|output| String::from_utf8(output.stdout).ok())
        .unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=TRISECT_COMPILER={}", version.trim());
    let variable = |name| env::var(name).unwrap_or_default();
    let flags = variable("CARGO_ENCODED_RUSTFLAGS").replace('\u{1f}', " ");
    println!(
        "cargo::rustc-env=TRISECT_BUILD={} opt-level {} target {}{}{}",
        variable("PROFILE"),
        variable("OPT_LEVEL"),
        variable("TARGET"),
        if flags.is_empty() { "" } else { " flags " },
        flags
    );
}

fn list_methods() {
    let manifest =
        fs::read_to_string("Cargo.toml").expect("a build script runs beside its manifest");
    let mut list = String::from(
        "/// Visits every method of the catalogue, in the order of the manifest.\n\
         pub fn each_method(visitor: &mut impl MethodVisitor) {\n",
    );
    for line in manifest.lines().filter(|line| line.contains("\"../methods/")) {
        if let Some((name, _)) = line.split_once('=') {
            list += "    ";
            list += &name.trim().replace('-', "_");
            list += "::methods(visitor);\n";
        }
    }
    list += "}\n";
    let out = env::var_os("OUT_DIR").expect("cargo names the output folder");
    fs::write(Path::new(&out).join("methods.rs"), list).expect("the output folder is writable");
}
