//! `trisect-viewer` without a window: what it writes, and what it refuses.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;
use trisect_testkit::process;

const SCENE: &str = "[[camera]]\nkind = \"pinhole\"\neye = [1, 1, 2]\nlook_at = [0, 0.4, 0]\n\
                     field_of_view = 40\n[material.red]\ndiffuse = [0.8, 0.1, 0.1]\n\
                     [mesh.chair]\nmodel = \"chair\"\n\
                     [[instance]]\nmesh = \"chair\"\nmaterial = \"red\"\n";

/// A folder with `scene.toml`, and the same at fault.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("the system has a folder for temporaries");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("a temporary folder can be written");
    };
    write("scene.toml", SCENE);
    write("faulty.toml", &SCENE.replace("field_of_view = 40", "field_of_view = 400"));
    folder
}

fn run(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trisect-viewer"));
    command.current_dir(folder).args(arguments.split_whitespace());
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    process::output(command.stdout(Stdio::piped()).stderr(Stdio::piped()), b"")
}

/// Width and height of a PNG, from its header.
fn size_of(png: &[u8]) -> [u32; 2] {
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    [16, 20].map(|at| u32::from_be_bytes(png[at..at + 4].try_into().expect("four bytes")))
}

#[test]
fn a_screenshot_of_every_view_is_the_same_for_any_threads() {
    let folder = folder();
    let mut seen: Vec<Vec<u8>> = Vec::new();
    for view in ["picture", "paths", "triangles", "nodes", "error"] {
        let shots = [1, 3].map(|threads| {
            let options = format!(
                "scene.toml --view {view} --width 200 --height 150 --samples 2 --threads {threads} \
                 --screenshot {threads}.png"
            );
            let output = run(folder.path(), &options);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!((output.status.code(), said.as_str()), (Some(0), ""), "{view}");
            std::fs::read(folder.path().join(format!("{threads}.png"))).expect("it is written")
        });
        assert!(shots[0] == shots[1], "{view}");
        assert_eq!(size_of(&shots[0]), [200, 150]);
        assert!(!seen.contains(&shots[0]), "{view}");
        seen.push(shots[0].clone());
    }
}

#[test]
fn what_cannot_be_shown_is_refused() {
    for (arguments, says) in [
        ("none.toml", "none.toml: cannot be read ("),
        ("faulty.toml", "faulty.toml: line 5: field_of_view: is 400"),
        ("scene.toml --camera side", "scene.toml: no camera `side`; give a number from 1 to 1"),
        ("scene.toml --method embree", "unknown method `embree`; `trisect list` shows"),
        ("scene.toml --screenshot a.jpg", "a.jpg: unknown type of picture; name a .png"),
        ("scene.toml --screenshot no/a.png", "no/a.png: cannot be written; name a file in"),
    ] {
        let folder = folder();
        let output = run(folder.path(), arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        let expected = format!("trisect-viewer: {says}");
        assert!(said.starts_with(&expected) && said.lines().count() == 1, "{arguments}: {said}");
        let files = std::fs::read_dir(folder.path()).expect("it is there").count();
        assert_eq!(files, 2, "{arguments}");
    }
    for (arguments, names) in [
        ("", "<SCENE>"),
        ("scene.toml --view heat", "[possible values: picture, paths, triangles, nodes, error]"),
        ("scene.toml --samples 3", "--screenshot <FILE>"),
        ("scene.toml --samples 0 --screenshot a.png", "'--samples <N>'"),
        ("scene.toml --width 0", "'--width <N>'"),
        ("scene.toml --threads 0", "'--threads <N>'"),
    ] {
        let output = run(folder().path(), arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        assert!(said.starts_with("error: ") && said.contains(names), "{arguments}: {said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_display_it_says_so() {
    let output = run(folder().path(), "scene.toml");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.starts_with("trisect-viewer: no window can be opened ("), "{said}");
    assert!(said.contains("--screenshot") && said.lines().count() == 1, "{said}");
}
