//! `trisect render`: what it writes, and what it leaves behind where it does not end.

mod common;

#[cfg(unix)]
use std::io::Write as _;
#[cfg(unix)]
use std::process::{Child, Command, Stdio};
#[cfg(unix)]
use std::time::Duration;

use common::Folder;
#[cfg(unix)]
use trisect_testkit::process;

const SCENE: &str = "[[camera]]\nkind = \"pinhole\"\neye = [0, 1, 5]\nlook_at = [0, 1, 0]\n\
                     field_of_view = 40\n[picture]\nwidth = 32\nheight = 24\nbackground = [1, 1, 1]\n\
                     [material.red]\ndiffuse = [0.8, 0.1, 0.1]\nemission = [0.1, 0.1, 0.1]\n\
                     [[sphere]]\ncenter = [0, 1, 0]\nradius = 1\nmaterial = \"red\"\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE.as_bytes());
    folder
}

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.path().join(name)).expect("it was written")
}

#[test]
fn a_scene_becomes_a_png_and_an_exr() {
    let folder = folder();
    let run = folder.trisect("render scene.toml -o picture.png --json", b"");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let report: serde_json::Value = serde_json::from_str(&run.stdout).expect("it is JSON");
    assert_eq!((&report["width"], &report["height"]), (&32.into(), &24.into()));
    // Two by two samples of each pixel at least.
    assert!(report["primary_rays"].as_u64().expect("a number") >= 4 * 32 * 24);
    assert!(read(&folder, "picture.png").starts_with(b"\x89PNG\r\n"));
    let run = folder.trisect("render scene.toml -o picture.EXR --width 8", b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(read(&folder, "picture.EXR").starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    assert!(run.stdout.contains("8 by 24 pixels"), "{}", run.stdout);
}

#[test]
fn what_the_camera_sees_may_be_rasterised() {
    let folder = folder();
    folder.write("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    let render = |options: &str| {
        let run = folder.trisect(&format!("render {options} --method exact --width 64"), b"");
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{options}");
    };
    for (scene, name) in [("scene.toml", "scene"), ("mesh.obj", "mesh")] {
        render(&format!("{scene} -o {name}-a.exr --primary raster"));
        render(&format!("{scene} -o {name}-b.exr --sampling grid:1"));
        let [a, b] = ["a", "b"].map(|which| read(&folder, &format!("{name}-{which}.exr")));
        assert_eq!(a, b, "{name}");
    }
    for (name, options) in [("a", ""), ("b", "--shade id --textures none"), ("c", "--threads 2")] {
        let command = format!("render mesh.obj -o {name}.png --raster {options}");
        let run = folder.trisect(&command, b"");
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
        assert!(run.stdout.contains("2 triangles"), "{}", run.stdout);
    }
    assert!(read(&folder, "a.png") != read(&folder, "b.png"));
    assert_eq!(read(&folder, "a.png"), read(&folder, "c.png"));
    let run = folder.trisect("render mesh.obj -o d.png --primary raster --sampling grid:2", b"");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("leave out --primary raster"), "{}", run.stderr);
}

#[test]
fn no_pixel_differs_between_the_rasteriser_and_the_exact_caster() {
    let folder = Folder::new();
    let run = folder.trisect("raster --check --shrink 12 --json", b"");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let found: serde_json::Value = serde_json::from_str(&run.stdout).expect("it is JSON");
    assert_eq!(found["different"], 0);
    let scenes = found["scenes"].as_array().expect("a list");
    assert!(scenes.len() > 15 && scenes.iter().all(|scene| scene["pictures"].as_u64() >= Some(5)));
}

#[test]
fn a_picture_is_the_same_for_any_threads_and_tiles() {
    let folder = folder();
    for (name, options) in [("a.png", "--threads 1"), ("b.png", "--threads 3 --tile 5")] {
        for mode in ["whitted", "paths"] {
            let command = format!("render scene.toml -o {mode}-{name} --mode {mode} {options}");
            assert_eq!(folder.trisect(&command, b"").code, Some(0));
        }
    }
    assert_eq!(read(&folder, "whitted-a.png"), read(&folder, "whitted-b.png"));
    assert_eq!(read(&folder, "paths-a.png"), read(&folder, "paths-b.png"));
}

#[test]
fn a_mesh_alone_is_a_scene_and_every_method_renders_it() {
    let folder = folder();
    let mut sizes = Vec::new();
    for method in ["moller-trumbore", "watertight", "chirkov", "wald"] {
        let command =
            format!("render mesh.obj -o {method}.png --width 40 --height 30 --method {method}");
        let run = folder.trisect(&command, b"");
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        sizes.push(read(&folder, &format!("{method}.png")).len());
    }
    assert!(sizes.iter().all(|&size| size > 200), "not empty: {sizes:?}");
}

/// A render that takes hours, and that an interrupt ends even where whoever runs this test ignores them,
/// as a shell does for its jobs in the background: programs inherit that. None where the system has no
/// command that undoes it.
#[cfg(unix)]
fn long(folder: &Folder) -> Option<Child> {
    let undo = "--default-signal=INT,TERM";
    let knows = Command::new("env").args([undo, "true"]).stderr(Stdio::null()).status();
    if !knows.is_ok_and(|status| status.success()) {
        return None;
    }
    let command = "render scene.toml -o picture.png --width 4000 --height 4000 --sampling grid:64";
    let command = folder.command(command);
    let mut undone = Command::new("env");
    undone.arg(undo).arg(command.get_program()).args(command.get_args());
    undone.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::null());
    let child = undone.spawn().expect("it starts");
    std::thread::sleep(Duration::from_millis(500));
    Some(child)
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_it_and_leaves_nothing_behind() {
    for signal in ["-INT", "-TERM", "-KILL"] {
        let folder = folder();
        folder.write("picture.png", b"the one before");
        let before = folder.listing();
        let Some(mut child) = long(&folder) else {
            // Not captured, unlike what `eprintln!` says.
            let says =
                "skipped: `env` has no --default-signal here, so that interrupts may be ignored";
            writeln!(std::io::stderr(), "{says}").expect("somebody listens");
            return;
        };
        assert!(child.try_wait().expect("it can be asked").is_none(), "it is under way");
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(sent.expect("there is such a command").success());
        let status = process::ended(&mut child);
        assert!(!status.success(), "{signal}");
        assert_eq!(folder.listing(), before, "{signal}");
        assert_eq!(read(&folder, "picture.png"), b"the one before", "{signal}");
    }
}

#[test]
fn what_cannot_be_rendered_is_refused_before_it_begins() {
    for (arguments, says) in [
        ("render none.toml -o p.png", "none.toml: cannot be read ("),
        ("render scene.toml -o p.jpg", "p.jpg: unknown type of picture; known are .png and .exr"),
        ("render scene.toml -o rays.csv/p.png", "rays.csv: cannot write to this folder ("),
        ("render scene.toml -o . ", ".: unknown type of picture"),
        (
            "render faulty.toml -o p.png",
            "faulty.toml: line 15: radius: is -1; write a finite number",
        ),
        ("render scene.toml -o p.png --camera side", "scene.toml: no camera `side`; give a number"),
        (
            "render scene.toml -o p.png --camera 2",
            "scene.toml: no camera `2`; give a number from 1 to 1, or a",
        ),
        ("render scene.toml -o p.png --method embree", "unknown method `embree`; `trisect list`"),
        (
            "render scene.toml -o p.png --mode paths --sampling adaptive:3",
            "paths are not sampled adaptively; give grid, jittered or circle with --sampling",
        ),
        (
            "render scene.toml -o p.png --width 65536 --height 65536",
            "a picture of 65536 by 65536 pixels is too large; give at most 67108864 pixels",
        ),
    ] {
        let folder = folder();
        folder.write("faulty.toml", SCENE.replace("radius = 1", "radius = -1").as_bytes());
        let before = folder.listing();
        let run = folder.trisect(arguments, b"");
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{arguments}: {}", run.stderr);
        let expected = format!("trisect: {says}");
        assert!(
            run.stderr.starts_with(&expected) && run.stderr.lines().count() == 1,
            "{}",
            run.stderr
        );
        assert_eq!(folder.listing(), before, "{arguments}");
    }
}
