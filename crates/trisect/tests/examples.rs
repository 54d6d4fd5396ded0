//! Every example runs, and prints what it answers.

use std::path::Path;
use std::process::Command;

/// What an example prints, run from the root of the workspace.
fn printed(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let test = std::env::current_exe().expect("this runs");
    let built = test.parent().and_then(Path::parent).expect("tests are in a folder of their own");
    let example = built.join("examples").join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let output = Command::new(example)
        .current_dir(root)
        .output()
        .expect("`cargo test -p trisect` builds the examples as well");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn first_hit() {
    let expected = "\
Hit { triangle: 1, t: 8.5, alpha: 0.5, beta: 0.25, gamma: 0.25 }
Hit { triangle: 0, t: 8.5, alpha: 0.25, beta: 0.25, gamma: 0.5 }
nothing
";
    assert_eq!(printed("first_hit"), expected);
}

/// The pages show the program that is tested here.
#[test]
fn first_hit_is_on_the_pages() {
    let program = include_str!("../examples/first_hit.rs");
    let (_, program) = program.split_once('\n').expect("the first line says what it answers");
    for page in [include_str!("../README.md"), include_str!("../../../README.md")] {
        assert!(page.contains(program), "the page shows another program");
    }
}

#[test]
fn shadow_ray() {
    let expected = "\
(-3, 0, 0) is lit
(0, 0, 0) is in shadow
(0.5, 0, 0) is in shadow
(3, 0, 0) is lit
";
    assert_eq!(printed("shadow_ray"), expected);
}

#[test]
fn all_hits() {
    let expected = "\
x = -0.25: 2 crossings, 1 of the ray inside
x = 0.25: 2 crossings, 1 of the ray inside
x = 2.5: 0 crossings, 0 of the ray inside
";
    assert_eq!(printed("all_hits"), expected);
}

#[test]
fn inside() {
    let expected = "\
(0, 0.5, 0): Inside
(0, 1, 0): On
(0, 1.5, 0): Outside
";
    assert_eq!(printed("inside"), expected);
}

#[test]
fn moving_mesh() {
    let text = printed("moving_mesh");
    let heights: Vec<&str> = text.lines().filter_map(|line| line.split(' ').next_back()).collect();
    assert_eq!(heights.len(), 3);
    assert!(heights[0] != heights[1] && heights[1] != heights[2], "{text}");
}

#[test]
fn instances() {
    let expected = "\
[0, 0], triangle 0 at 29.50, normal [0.0, 0.0, 1.0]
[0, 1], triangle 0 at 29.50, normal [0.0, 0.0, 1.0]
[0, 2], triangle 0 at 29.50, normal [0.0, 0.0, 1.0]
[0, 0], triangle 2 at 27.94, normal [-0.9, 0.0, 0.5]
[0, 1], triangle 0 at 31.62, normal [0.5, 0.0, 0.9]
[0, 2], triangle 0 at 35.99, normal [0.5, 0.0, 0.9]
";
    assert_eq!(printed("instances"), expected);
}

#[test]
fn terrain() {
    let text = printed("terrain");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "{text}");
    // Within half a centimeter of the height that the corners are put at.
    for (line, [x, y]) in lines.iter().zip([[12.3, 45.6], [78.9, 10.1]]) {
        let expected = 320.0 + 12.0 * f64::sin(x / 37.0) * f64::cos(y / 29.0);
        let height = line.split(' ').rev().nth(2).and_then(|height| height.parse::<f64>().ok());
        assert!(height.is_some_and(|height| (height - expected).abs() < 5e-3), "{text}");
    }
    assert!(lines[2].ends_with("beyond the terrain"), "{text}");
}

#[test]
fn own_method() {
    let expected = "Some(Hit { triangle: 0, t: 1.0, alpha: 0.5, beta: 0.25, gamma: 0.25 })\n";
    assert_eq!(printed("own_method"), expected);
}
