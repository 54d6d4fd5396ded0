//! How a program is compiled, for the records of what it measures.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
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
