//! Writes the list of methods from the manifest's dependencies under `../methods/`, so that a
//! method is added by one line.

use std::{env, fs, path::Path};

fn main() {
    println!("cargo::rerun-if-changed=Cargo.toml");
    println!("cargo::rerun-if-changed=build.rs");
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
