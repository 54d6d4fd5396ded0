//! The catalogue takes minutes to compile, and Cargo compiles it anew for each set of features below it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// The features of every package below the catalogue, by name and version, as Cargo resolves them.
fn features(arguments: &[&str]) -> BTreeMap<String, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let tree = |arguments: &[&str]| -> BTreeMap<String, String> {
        let output = Command::new(env!("CARGO"))
            .args(["tree", "--quiet", "--locked", "--prefix", "none", "--format", "{p}\t{f}"])
            .args(arguments)
            .current_dir(&root)
            .output()
            .expect("cargo runs this test");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).expect("cargo writes UTF-8");
        let packages = text.lines().filter_map(|line| line.split_once('\t'));
        let named = packages.map(|(package, features)| {
            (package.to_owned(), features.trim_end_matches(" (*)").to_owned())
        });
        named.collect()
    };
    let below: BTreeSet<String> =
        tree(&["--package", "trisect-catalog", "--edges", "normal"]).into_keys().collect();
    assert!(below.len() > 30, "{below:?}");
    tree(arguments).into_iter().filter(|(package, _)| below.contains(package)).collect()
}

#[test]
fn builds_tests_and_benches_share_a_catalogue() {
    let build = features(&["--edges", "normal,build"]);
    let test = features(&["--edges", "normal,build,dev"]);
    assert_eq!(build, test, "a test or a bench asks for a feature that no build has");
    let all =
        ["--workspace", "--features", "trisect-benches/embree", "--edges", "normal,build,dev"];
    assert_eq!(test, features(&all), "a package that is no default member asks for one");
}
