//! Streams that are closed or full, and disks that are: no panic, the right exit code, and files that are
//! there whole or not at all.
#![cfg(target_os = "linux")]

mod common;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use common::{Folder, Run};

/// A stream that never has room.
fn full() -> File {
    File::options().write(true).open("/dev/full").expect("Linux has it")
}

/// Something of every verb that ends at once, the record `r.jsonl` being there.
const ANSWERS: [&str; 13] = [
    "--help",
    "render --help",
    "--version",
    "list",
    "list --json",
    "completions bash",
    "man",
    "man render",
    "emit --method wald --language rust",
    "query --mesh mesh.obj --rays rays.csv --method wald",
    "trace --mesh mesh.obj --rays rays.csv --repeat 1",
    "verify --mesh mesh.obj --rays rays.csv --methods wald",
    "cmp r.jsonl r.jsonl",
];

/// Something of every verb that is refused.
const REFUSED: [&str; 17] = [
    "--mesh none.obj",
    "measure --mesh none.obj",
    "rank none.jsonl",
    "cmp none.jsonl none.jsonl",
    "report none.jsonl",
    "verify --mesh none.obj",
    "stress --methods none",
    "study --mesh none.obj",
    "trace --mesh none.obj --rays rays.csv",
    "query --mesh none.obj --rays rays.csv --method wald",
    "render none.toml -o p.png",
    "recommend --mesh none.obj",
    "explain none.toml",
    "emit --method none --language c",
    "pictures --methods none",
    "intersect",
    "man intersect",
];

fn folder() -> Folder {
    let folder = Folder::new();
    let record = folder.trisect("verify --mesh mesh.obj --methods wald --json", b"");
    assert_eq!(record.code, Some(0), "{}", record.stderr);
    folder.write("r.jsonl", record.stdout.as_bytes());
    folder
}

#[test]
fn standard_output_that_is_full_is_an_error() {
    let folder = folder();
    for arguments in ANSWERS {
        let mut command = folder.command(arguments);
        command.stdout(full());
        let Run { code, stderr, .. } = folder.run(command, b"");
        let says =
            "trisect: standard output: cannot be written: No space left on device (os error 28)\n";
        assert_eq!((code, stderr.as_str()), (Some(2), says), "{arguments}");
        let mut command = folder.command(arguments);
        command.stdout(full()).stderr(full());
        assert_eq!(folder.run(command, b"").code, Some(2), "{arguments}");
    }
}

#[test]
fn standard_output_that_is_closed_is_no_error() {
    let folder = folder();
    for arguments in ANSWERS {
        let (reader, writer) = std::io::pipe().expect("the system has pipes");
        drop(reader);
        let mut command = folder.command(arguments);
        command.stdout(writer);
        let Run { code, stderr, .. } = folder.run(command, b"");
        assert_eq!((code, stderr.as_str()), (Some(0), ""), "{arguments}");
    }
}

/// A command run by a shell, which can close streams and bound files.
fn by_shell(folder: &Folder, before: &str, arguments: &str) -> Run {
    let command = folder.command(arguments);
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(before).arg(command.get_program()).args(command.get_args());
    shell.current_dir(folder.path());
    folder.run(piped(shell), b"")
}

fn piped(mut command: Command) -> Command {
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    command
}

#[test]
fn standard_error_that_is_full_or_closed_changes_no_exit_code() {
    let folder = folder();
    folder.write("flat.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n");
    let before = folder.listing();
    for arguments in REFUSED {
        let mut command = folder.command(arguments);
        command.stderr(full());
        let Run { code, stdout, .. } = folder.run(command, b"");
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{arguments}");
        let run = by_shell(&folder, r#"exec "$0" "$@" 2>&-"#, arguments);
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{arguments}");
        assert_eq!(folder.listing(), before, "{arguments}");
    }
    // What is said beside an answer is lost, the answer is not.
    let talks = "query --mesh flat.obj --rays rays.csv --method wald";
    let said = folder.trisect(talks, b"");
    assert!(said.stderr.contains("degenerate"), "{}", said.stderr);
    let mut command = folder.command(talks);
    command.stderr(full());
    let Run { code, stdout, .. } = folder.run(command, b"");
    assert_eq!((code, stdout), (Some(0), said.stdout));
    let mut command = folder.command("report r.jsonl --output page");
    command.stderr(full());
    assert_eq!(folder.run(command, b"").code, Some(0));
    assert!(folder.path().join("page/index.html").exists());
}

/// Files of more than 64 KiB cannot be written, as on a disk that has no more room.
const BOUNDED: &str = r#"trap '' XFSZ; ulimit -f 128; exec "$0" "$@""#;

/// A record whose figures are below that, and whose page is above.
fn record() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reports/2026-11-22-zen3/record.jsonl.gz")
}

/// Every file with its content.
fn content(folder: &Folder) -> Vec<(String, Vec<u8>)> {
    let files = folder.listing().into_iter();
    let files = files.filter(|name| folder.path().join(name).is_file());
    files
        .map(|name| {
            let bytes = fs::read(folder.path().join(&name)).expect("it is there");
            (name, bytes)
        })
        .collect()
}

#[test]
fn a_report_comes_whole_or_not_at_all() {
    let folder = Folder::new();
    let record = record();
    let report = |output: &str| format!("report {} --output {output}", record.display());
    // Where there was none, in folders that do not exist.
    let before = folder.listing();
    let run = by_shell(&folder, BOUNDED, &report("a/b"));
    assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{}", run.stderr);
    assert_eq!(
        run.stderr,
        "trisect: a/b/index.html: cannot be written (File too large (os error 27)); nothing was \
         changed\n"
    );
    assert_eq!(folder.listing(), before);

    // Where there was another, with other files beside it.
    for output in ["page", "./page/../page", "."] {
        let folder = Folder::new();
        let page = |name: &str| format!("{output}/{name}");
        let mine = [page("figures/mine.svg"), page("notes.txt")];
        let old = [page("figures/division.svg"), page("index.html")];
        folder.write("page/notes.txt", b"");
        mine.iter().chain(&old).for_each(|name| folder.write(name, b"of before"));
        let before = (folder.listing(), content(&folder));
        let run = by_shell(&folder, BOUNDED, &report(output));
        assert_eq!(run.code, Some(2), "{output}: {}", run.stderr);
        assert_eq!((folder.listing(), content(&folder)), before, "{output}");
        // With room it takes its place, and all others keep theirs.
        let run = folder.trisect(&report(output), b"");
        assert_eq!(run.code, Some(0), "{output}: {}", run.stderr);
        let read = |name: &String| fs::read(folder.path().join(name)).expect("it is there");
        assert!(mine.iter().all(|name| read(name) == b"of before"), "{output}");
        assert!(old.iter().all(|name| read(name).len() > 1000), "{output}");
        assert!(read(&page("figures/early-out.svg")).len() > 1000, "{output}");
        assert!(folder.listing().iter().all(|name| !name.contains(".trisect-")), "{output}");
    }
}

#[test]
fn documents_are_spliced_together_or_not_at_all() {
    let folder = folder();
    let marked = "<!-- trisect:methods -->\nold\n<!-- end of trisect:methods -->\n";
    folder.write("small.md", marked.as_bytes());
    folder.write("large.md", format!("{marked}{}", "text\n".repeat(20_000)).as_bytes());
    let before = content(&folder);
    let splice = "report r.jsonl --splice small.md --splice large.md";
    let run = by_shell(&folder, BOUNDED, splice);
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    assert!(run.stderr.starts_with("trisect: large.md: cannot be written ("), "{}", run.stderr);
    assert_eq!(content(&folder), before);
    let run = folder.trisect(splice, b"");
    assert_eq!((run.code, run.stderr.lines().count()), (Some(0), 2), "{}", run.stderr);
    let small = fs::read_to_string(folder.path().join("small.md")).expect("it is there");
    assert!(!small.contains("\nold\n"), "{small}");
}

#[test]
fn pictures_and_hits_come_whole_or_not_at_all() {
    let folder = Folder::new();
    let rays = format!("ox,oy,oz,dx,dy,dz\n{}", "0.25,0.5,-3,0,0,1\n".repeat(20_000));
    folder.write("many.csv", rays.as_bytes());
    folder.write("p.exr", b"of before");
    folder.write("hits", b"of before");
    let before = content(&folder);
    let commands = [
        ("p.exr", "render mesh.obj -o p.exr --width 400 --height 300"),
        ("new/p.exr", "render mesh.obj -o new/p.exr --width 400 --height 300"),
        ("hits", "trace --mesh mesh.obj --rays many.csv --repeat 1 --out hits"),
    ];
    for (file, arguments) in commands {
        let run = by_shell(&folder, BOUNDED, arguments);
        assert_eq!((run.code, run.stdout.as_str()), (Some(2), ""), "{arguments}: {}", run.stderr);
        let says = format!("trisect: {file}: cannot be written (File too large (os error 27)); ");
        assert!(run.stderr.starts_with(&says), "{arguments}: {}", run.stderr);
        assert_eq!(content(&folder), before, "{arguments}");
        assert!(!folder.path().join("new").exists());
    }
    for (file, arguments) in commands {
        assert_eq!(folder.trisect(arguments, b"").code, Some(0), "{arguments}");
        assert!(fs::read(folder.path().join(file)).expect("it is there").len() > 10_000);
    }
}
