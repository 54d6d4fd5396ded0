//! `docs/ADDING-A-METHOD.md` and `docs/ADDING-A-STUDY.md`, followed to the letter in a copy of the
//! workspace: one copy, as each takes minutes to compile.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use trisect_catalog::Entry;

const NAME: &str = "affine-map";

/// The study of the other page.
const STUDY: &str = "clock";

/// The crates of the catalogue that the copy keeps, since all of them take minutes to compile: the one
/// that the program measures against, the one that it waives a promise of, and the one that is exact.
const KEPT: [&str; 3] = ["moller-trumbore", "watertight", "exact"];

/// A fenced block of the page: what its info string says beside the language, and its text.
struct Block {
    mark: String,
    text: String,
}

/// The blocks whose info string marks them with `key=`.
fn blocks(page: &str, key: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let fence: String = line.chars().take_while(|&c| c == '`').collect();
        if fence.len() < 3 {
            continue;
        }
        let text: String = lines
            .by_ref()
            .take_while(|line| *line != fence)
            .flat_map(|line| [line, "\n"])
            .collect();
        if let Some((_, mark)) = line.split_once(&format!(" {key}=")) {
            blocks.push(Block { mark: mark.to_owned(), text });
        }
    }
    blocks
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A copy of the workspace that keeps the times of files that have not changed, so that what was
/// built before stays built.
struct Copy {
    root: PathBuf,
    /// What belongs there; everything else of an earlier copy is removed.
    files: BTreeSet<PathBuf>,
}

impl Copy {
    fn new(root: PathBuf) -> Self {
        Self { root, files: BTreeSet::new() }
    }

    fn write(&mut self, path: &Path, content: &[u8]) {
        let to = self.root.join(path);
        if fs::read(&to).ok().as_deref() != Some(content) {
            fs::create_dir_all(to.parent().expect("a file lies in a folder"))
                .and_then(|()| fs::write(&to, content))
                .expect("the target folder can be written");
        }
        self.files.insert(path.to_owned());
    }

    /// Copies the folder `path`, without what is built, recorded or hidden.
    fn copy(&mut self, from: &Path, path: &Path) {
        for entry in fs::read_dir(from.join(path)).expect("the workspace can be read") {
            let entry = entry.expect("the workspace can be read");
            let name = entry.file_name();
            let hidden = name.to_string_lossy().starts_with('.');
            let skipped = path == Path::new("")
                && ["target", "reports", "shared"].iter().any(|skipped| name == *skipped);
            let path = path.join(&name);
            let kind = entry.file_type().expect("the workspace can be read");
            if hidden || skipped {
                continue;
            }
            if kind.is_dir() {
                self.copy(from, &path);
            } else if kind.is_file() {
                let content = fs::read(entry.path()).expect("the workspace can be read");
                self.write(&path, &content);
            }
        }
    }

    fn remove_others(&self, path: &Path) {
        for entry in fs::read_dir(self.root.join(path)).expect("just written") {
            let entry = entry.expect("just written");
            let path = path.join(entry.file_name());
            if entry.path().is_dir() {
                self.remove_others(&path);
            } else if !self.files.contains(&path) {
                fs::remove_file(entry.path()).expect("the target folder can be written");
            }
        }
    }

    /// Runs cargo there; offline, as the workspace that this test is part of is built already.
    fn cargo(&self, arguments: &[&str]) -> Output {
        let (verb, rest) = arguments.split_first().expect("cargo is told what to do");
        let output = Command::new(env!("CARGO"))
            .arg(verb)
            .args(["--offline", "--quiet"])
            .args(rest)
            .current_dir(&self.root)
            .env("CARGO_TARGET_DIR", self.root.with_file_name("target"))
            // What is compiled here runs for seconds: compiling it well would take minutes.
            .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0")
            .env("CARGO_PROFILE_DEV_DEBUG", "0")
            .env_remove("TRISECT_BLESS")
            .output()
            .expect("cargo runs this test, and so can be run");
        assert!(
            output.status.success(),
            "cargo {}: {}\n{}{}",
            arguments.join(" "),
            output.status,
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
        output
    }
}

/// Adds the study of the page: a folder, and what the page inserts after lines that are there.
fn add_study(copy: &mut Copy) {
    let page = fs::read_to_string(root().join("docs/ADDING-A-STUDY.md")).expect("the page");
    let files = blocks(&page, "file");
    for file in &files {
        let folder = format!("crates/studies/src/{STUDY}/");
        assert!(file.mark.starts_with(&folder), "{}: a study is one folder", file.mark);
        copy.write(Path::new(&file.mark), file.text.as_bytes());
    }
    assert_eq!(files.len(), 5, "record, settings, measure, document, and the study itself");
    let inserted = blocks(&page, "after");
    assert_eq!(inserted.len(), 2, "a module, and a line of the registry");
    for block in inserted {
        let (anchor, _) = block.text.split_once('\n').expect("a line that is there");
        let before = fs::read_to_string(root().join(&block.mark)).expect("it is there");
        assert_eq!(before.matches(anchor).count(), 1, "{}: {anchor}", block.mark);
        let after = before.replace(anchor, block.text.trim_end());
        copy.write(Path::new(&block.mark), after.as_bytes());
    }
}

/// The study is taken, published, and drawn again from its record.
fn take_study(copy: &Copy) {
    let folder = copy.root.with_file_name("report");
    let _ = fs::remove_dir_all(&folder);
    let folder = folder.to_str().expect("a path in UTF-8");
    let program = ["run", "-p", "trisect-cli", "--"];
    let run = |arguments: &[&str]| copy.cargo(&[&program[..], arguments].concat()).stdout;

    let help = String::from_utf8(run(&[STUDY, "--help"])).expect("UTF-8");
    assert!(help.contains("Study how fine the steps") && help.contains("--rounds"), "{help}");
    let summary = run(&[STUDY, "--rounds", "3", "--output", folder, "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&summary).expect("JSON");
    let rounds = summary.as_array().expect("one of each round");
    assert!(rounds.len() == 3 && rounds[0]["median_ns"].is_f64(), "{summary}");

    let record = Path::new(folder).join("clock.jsonl");
    let page = Path::new(folder).join("clock.html");
    let first = fs::read_to_string(&page).expect("the page was published");
    assert!(first.contains("The shortest step"), "{first}");
    fs::remove_file(&page).expect("it is there");
    let record = record.to_str().expect("a path in UTF-8");
    let text = String::from_utf8(run(&["report", record, "--output", folder])).expect("UTF-8");
    assert!(text.contains("shortest, ns"), "{text}");
    assert_eq!(fs::read_to_string(&page).expect("drawn again"), first);
}

#[test]
fn the_pages_add_a_method_and_a_study() {
    let page = fs::read_to_string(root().join("docs/ADDING-A-METHOD.md")).expect("the page");
    let mut copy =
        Copy::new(Path::new(env!("CARGO_TARGET_TMPDIR")).join("adding-a-method/workspace"));
    copy.copy(&root(), Path::new(""));

    let files = blocks(&page, "file");
    for file in &files {
        assert!(
            file.mark.starts_with(&format!("crates/methods/{NAME}/")),
            "{}: a method is one crate",
            file.mark
        );
        copy.write(Path::new(&file.mark), file.text.as_bytes());
    }
    assert_eq!(files.len(), 4, "manifest, method, conformance tests, README");
    let lines = blocks(&page, "line");
    let [line] = lines.as_slice() else { panic!("a method is one line") };
    assert_eq!(line.text.lines().count(), 1, "a method is one line");
    let manifest = fs::read_to_string(root().join(&line.mark)).expect("the catalogue's manifest");
    let is_left_out = |line: &&str| {
        line.contains("\"../methods/")
            && !KEPT.iter().any(|kept| line.contains(&format!("/{kept}\"")))
    };
    let manifest: String =
        manifest.lines().filter(|line| !is_left_out(line)).flat_map(|line| [line, "\n"]).collect();
    let (head, tail) = manifest.split_once("\n[lints]").expect("a section after the methods");
    copy.write(
        Path::new(&line.mark),
        format!("{}\n{}\n[lints]{tail}", head.trim_end(), line.text).as_bytes(),
    );
    add_study(&mut copy);
    copy.remove_others(Path::new(""));

    let crate_name = format!("trisect-{NAME}");
    // The golden cases alone are worth compiling well: in kernels that are not they take minutes.
    let well = ["core", "testkit", "workloads", NAME]
        .map(|name| format!("--config=profile.dev.package.trisect-{name}.opt-level=2"));
    let [core, testkit, workloads, method] = &well;
    let tests = copy.cargo(&["test", core, testkit, workloads, method, "-p", &crate_name]);
    let tests = String::from_utf8_lossy(&tests.stdout);
    assert!(tests.contains("test result: ok. 16 passed"), "not all properties ran:\n{tests}");

    let list = copy.cargo(&["run", "-p", "trisect-cli", "--", "list", "--json"]);
    let list: serde_json::Value = serde_json::from_slice(&list.stdout).expect("JSON");
    let names: Vec<_> =
        list["methods"].as_array().expect("a list").iter().map(|m| &m["name"]).collect();
    let is_kept = |entry: &&Entry| {
        let krate = |kept: &str| format!("trisect_{}::", kept.replace('-', "_"));
        KEPT.iter().any(|kept| entry.type_name.starts_with(&krate(kept)))
    };
    let before = trisect_catalog::entries().iter().filter(is_kept).count();
    assert_eq!(names.len(), before + 1, "{names:?}");
    assert_eq!(names[before], NAME);

    copy_and_query(&copy);
    take_study(&copy);
}

/// A ray at (0.25, 0.5) of the unit triangle, three units away.
fn copy_and_query(copy: &Copy) {
    let folder = copy.root.with_file_name("query");
    fs::create_dir_all(&folder).expect("the target folder can be written");
    let (mesh, rays) = (folder.join("unit.obj"), folder.join("rays.csv"));
    fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        .and_then(|()| fs::write(&rays, "ox,oy,oz,dx,dy,dz\n0.25,0.5,-3,0,0,1\n1,1,-3,0,0,1\n"))
        .expect("the target folder can be written");
    let [mesh, rays] = [&mesh, &rays].map(|path| path.to_str().expect("a path in UTF-8"));
    for division in ["early", "deferred"] {
        let answer = copy.cargo(&[
            "run",
            "-p",
            "trisect-cli",
            "--",
            "query",
            "--mesh",
            mesh,
            "--rays",
            rays,
            "--method",
            NAME,
            "--division",
            division,
        ]);
        assert_eq!(
            String::from_utf8_lossy(&answer.stdout),
            "{\"ray\":0,\"hit\":true,\"triangle\":0,\"t\":3.0,\"beta\":0.25,\"gamma\":0.5}\n\
             {\"ray\":1,\"hit\":false}\n",
            "{division}"
        );
    }
}
