//! A folder to run `trisect` in.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use tempfile::TempDir;
use trisect_testkit::process;

/// Two triangles at right angles.
pub(crate) const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n";

/// A hit and a miss.
pub(crate) const CSV: &str = "ox,oy,oz,dx,dy,dz\n0.25,0.5,-3,0,0,1\n5,5,-3,0,0,1\n";

/// A folder with `mesh.obj` and `rays.csv`, gone at the end of the test.
pub(crate) struct Folder(TempDir);

/// What a run of `trisect` left behind.
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Folder {
    pub(crate) fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("the system has a folder for temporaries"));
        folder.write("mesh.obj", OBJ.as_bytes());
        folder.write("rays.csv", CSV.as_bytes());
        folder
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn write(&self, name: &str, content: &[u8]) {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().expect("a file lies in a folder"))
            .and_then(|()| fs::write(path, content))
            .expect("a temporary folder can be written");
    }

    /// Every file and folder, by its path.
    pub(crate) fn listing(&self) -> BTreeSet<String> {
        let mut listing = BTreeSet::new();
        let mut folders = vec![self.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("a temporary folder can be read") {
                let path = entry.expect("a temporary folder can be read").path();
                let name = path.strip_prefix(self.path()).expect("it lies in the folder");
                listing.insert(name.to_string_lossy().into_owned());
                if path.is_dir() {
                    folders.push(path);
                }
            }
        }
        listing
    }

    /// The command with these arguments, separated by spaces.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_trisect"));
        command
            .args(arguments.split_whitespace())
            .current_dir(self.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Runs `trisect` with these arguments, separated by spaces, and this input.
    pub(crate) fn trisect(&self, arguments: &str, stdin: &[u8]) -> Run {
        self.run(self.command(arguments), stdin)
    }

    #[allow(clippy::unused_self, reason = "the folder must outlive the command")]
    pub(crate) fn run(&self, mut command: Command, stdin: &[u8]) -> Run {
        let output = process::output(&mut command, stdin);
        let text = |bytes| String::from_utf8(bytes).expect("trisect prints UTF-8");
        Run { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}
