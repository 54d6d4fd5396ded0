//! One file given to the program, in a process of its own, and what must hold of it.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Read as _, Seek as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

use crate::format::{Format, corpus, files};

/// How long a process may take.
pub const TIME: Duration = Duration::from_secs(10);

/// How long an ordinary file may take, which may be a large one.
const ORDINARY_TIME: Duration = Duration::from_mins(1);

/// Bytes of memory that a process may ask for.
pub const MEMORY: u64 = 2 << 30;

/// Bytes of the longest file that a process may write, what it prints included.
const WRITTEN: u64 = 64 << 20;

/// Bytes of the longest message: what it quotes of a file must be cut.
const MESSAGE: usize = 1000;

/// Notes before the message, or of a file that is accepted.
const NOTES: usize = 20;

/// Puts limits on the memory of this process and of all that it starts from now on.
///
/// # Errors
/// When the system knows no such limits, or refuses them.
pub fn limit_memory() -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        let limits = [(Resource::Data, MEMORY), (Resource::Fsize, WRITTEN), (Resource::Core, 0)];
        for (resource, most) in limits {
            setrlimit(resource, Rlimit { current: Some(most), maximum: Some(most) })?;
        }
        Ok(())
    }
    #[cfg(not(target_os = "linux"))]
    Err(io::Error::new(io::ErrorKind::Unsupported, "limits on memory are known on Linux alone"))
}

/// Waits, but not for ever; none where the process had to be ended.
fn wait(child: &mut Child, most: Duration) -> io::Result<Option<ExitStatus>> {
    #[cfg(target_os = "linux")]
    {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        use rustix::process::{Pid, PidfdFlags, pidfd_open};
        let process = pidfd_open(Pid::from_child(child), PidfdFlags::empty())?;
        let most = Timespec::try_from(most).map_err(io::Error::other)?;
        let mut ends = [PollFd::new(&process, PollFlags::IN)];
        if poll(&mut ends, Some(&most))? == 0 {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = most;
    child.wait().map(Some)
}

/// What a command came to.
struct Run {
    /// None where it had to be ended.
    status: Option<ExitStatus>,
    stdout: Vec<u8>,
    stderr: String,
}

/// Starts the program in a folder, again and again.
struct Runner {
    program: PathBuf,
    stdout: File,
    stderr: File,
}

impl Runner {
    fn new(program: &Path) -> io::Result<Self> {
        let (stdout, stderr) =
            (tempfile::tempfile_in(quick_folder())?, tempfile::tempfile_in(quick_folder())?);
        Ok(Self { program: program.to_owned(), stdout, stderr })
    }

    fn run(&mut self, folder: &Path, arguments: &[String], most: Duration) -> io::Result<Run> {
        for file in [&mut self.stdout, &mut self.stderr] {
            file.set_len(0)?;
            file.rewind()?;
        }
        let mut child = Command::new(&self.program)
            .args(arguments)
            .current_dir(folder)
            // Threads take longer to start than these files to read.
            .env("RAYON_NUM_THREADS", "1")
            .env_remove("RUST_BACKTRACE")
            .stdin(Stdio::null())
            .stdout(self.stdout.try_clone()?)
            .stderr(self.stderr.try_clone()?)
            .spawn()?;
        let status = wait(&mut child, most)?;
        let mut streams = [Vec::new(), Vec::new()];
        for (file, stream) in [&mut self.stdout, &mut self.stderr].into_iter().zip(&mut streams) {
            file.rewind()?;
            file.read_to_end(stream)?;
        }
        let [stdout, stderr] = streams;
        Ok(Run { status, stdout, stderr: String::from_utf8_lossy(&stderr).into_owned() })
    }
}

/// Where files are quick to write: memory, where the system shows it as a folder.
pub fn quick_folder() -> PathBuf {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() }
}

/// What the program made of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Every command ended well.
    Accepted,
    /// A command refused it, with this message.
    Refused(String),
    /// Something that must not be.
    Faulty(Fault),
}

/// What must not be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Of which kind.
    pub kind: Kind,
    /// The command.
    pub command: String,
    /// What was seen.
    pub what: String,
}

/// Kinds of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A panic, an abort, a signal, or an exit code other than 0 and 2. Memory beyond the limit ends in an
    /// abort.
    Crash,
    /// More time than there is.
    Time,
    /// Something other than one message that names the file.
    Message,
    /// Something on standard output of what is refused, or of what is accepted not what was asked for.
    Output,
    /// A file that is there afterwards, and should not, or the other way round.
    Files,
    /// A mesh that `query` and `render` do not both accept or both refuse.
    Disagreement,
}

impl Kind {
    /// The name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crash => "crash",
            Self::Time => "time",
            Self::Message => "message",
            Self::Output => "output",
            Self::Files => "files",
            Self::Disagreement => "disagreement",
        }
    }
}

/// Of one command: the message where it refuses a file.
pub type Judgement = Result<Option<String>, Fault>;

/// A folder with the sound files that a mutant may need beside it, and one to try mutants in.
pub struct Bench {
    runner: Runner,
    folder: TempDir,
    sound: BTreeSet<OsString>,
}

impl Bench {
    /// Makes the folder.
    ///
    /// # Errors
    /// When the corpus cannot be read or the folder not be written.
    pub fn new(program: &Path) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix("trisect-fuzz-").tempdir_in(quick_folder())?;
        for (path, bytes) in files(&corpus().join("company"))? {
            fs::write(folder.path().join(path.file_name().unwrap_or_default()), bytes)?;
        }
        let sound = listing(folder.path())?;
        Ok(Self { runner: Runner::new(program)?, folder, sound })
    }

    /// Gives a file to every command that reads its format; of records the number chooses some.
    ///
    /// # Errors
    /// When the program cannot be started, or the folder not be read or written: never for what the program
    /// does.
    pub fn verdict(&mut self, format: Format, bytes: &[u8], number: u64) -> io::Result<Verdict> {
        let file = format.file();
        let place = self.folder.path().join(&file);
        fs::write(&place, bytes)?;
        let verdict = self.tried(format, number);
        fs::remove_file(place)?;
        verdict
    }

    fn tried(&mut self, format: Format, number: u64) -> io::Result<Verdict> {
        let mut refused: Option<String> = None;
        let mut accepted = false;
        for arguments in format.commands(&format.main_file(), number) {
            let message = match self.judged(&arguments, &format.file(), TIME)? {
                Err(fault) => return Ok(Verdict::Faulty(fault)),
                Ok(message) => message,
            };
            if format.is_mesh() && disagree(accepted, refused.as_deref(), message.as_deref()) {
                let what = refused.or(message).unwrap_or_default();
                let (kind, command) = (Kind::Disagreement, arguments.join(" "));
                return Ok(Verdict::Faulty(Fault { kind, command, what }));
            }
            accepted |= message.is_none();
            refused = message.or(refused);
        }
        Ok(refused.map_or(Verdict::Accepted, Verdict::Refused))
    }

    /// Gives a file where it lies to every command that reads its format; each result is the message where it
    /// is refused.
    ///
    /// # Errors
    /// As [`Bench::verdict`].
    pub fn ordinary(&mut self, format: Format, file: &Path) -> io::Result<Vec<Judgement>> {
        let file = std::path::absolute(file)?;
        let commands = format.commands(&file.to_string_lossy(), 0);
        commands.iter().map(|arguments| self.judged(arguments, "", ORDINARY_TIME)).collect()
    }

    fn judged(
        &mut self,
        arguments: &[String],
        mutant: &str,
        most: Duration,
    ) -> io::Result<Judgement> {
        let run = self.runner.run(self.folder.path(), arguments, most)?;
        let made = self.clean(mutant)?;
        let fault = |(kind, what)| Fault { kind, command: arguments.join(" "), what };
        Ok(run.judged(arguments, &made).map_err(fault))
    }

    /// Removes what a command made, and gives the names.
    fn clean(&self, mutant: &str) -> io::Result<BTreeSet<OsString>> {
        let mut made = listing(self.folder.path())?;
        made.retain(|name| name != mutant && !self.sound.contains(name));
        for name in &made {
            let path = self.folder.path().join(name);
            if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }?;
        }
        Ok(made)
    }
}

fn listing(folder: &Path) -> io::Result<BTreeSet<OsString>> {
    fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.file_name())).collect()
}

impl Run {
    /// The message of what is refused; none of what is accepted.
    fn judged(
        &self,
        arguments: &[String],
        made: &BTreeSet<OsString>,
    ) -> Result<Option<String>, (Kind, String)> {
        let Some(status) = self.status else {
            return Err((Kind::Time, format!("more than {} s", TIME.as_secs())));
        };
        let lines: Vec<&str> = self.stderr.lines().collect();
        let panic = lines.iter().position(|line| line.contains("panicked at"));
        let code = status.code();
        if panic.is_some() || !matches!(code, Some(0 | 2)) {
            let says = lines.get(panic.unwrap_or_default()..).unwrap_or_default();
            let says = says.iter().take(2).map(|line| cut(line)).collect::<Vec<_>>().join(" ");
            let says = says.find("panicked at").map_or(says.as_str(), |at| &says[at..]);
            return Err((Kind::Crash, format!("{says} ({status})")));
        }
        if lines.len() > NOTES {
            return Err((Kind::Message, format!("too many lines: {}", lines.len())));
        }
        if let Some(long) = lines.iter().find(|line| line.len() > MESSAGE) {
            let what = format!("too long: {} bytes: {}", long.len(), cut(long));
            return Err((Kind::Message, what));
        }
        if let Some(line) = lines.iter().find(|line| line.contains(char::is_control)) {
            return Err((Kind::Message, format!("control characters: {}", cut(line))));
        }
        if code == Some(2) {
            self.is_one_message(arguments, &lines)?;
            if !self.stdout.is_empty() {
                let what = format!("of what is refused: {} bytes", self.stdout.len());
                return Err((Kind::Output, what));
            }
            if !made.is_empty() {
                return Err((Kind::Files, format!("left behind: {made:?}")));
            }
            return Ok(Some(lines.last().copied().unwrap_or_default().to_owned()));
        }
        // What is asked for by name.
        let output = arguments.iter().position(|word| word == "--out" || word == "--output");
        let wanted = output.and_then(|at| arguments.get(at + 1)).map(OsStr::new);
        if !made.iter().map(OsString::as_os_str).eq(wanted) {
            return Err((
                Kind::Files,
                format!("other than asked for: {made:?} instead of {wanted:?}"),
            ));
        }
        let is_json = |text: &[u8]| serde_json::from_slice::<Value>(text).is_ok();
        let has = |word: &str| arguments.iter().any(|other| other == word);
        let is_sound = match () {
            () if has("query") => answers_are_sound(&self.stdout),
            () if has("--json") => is_json(&self.stdout),
            () => !self.stdout.is_empty(),
        };
        if !is_sound {
            return Err((
                Kind::Output,
                format!("unsound: {}", cut(&String::from_utf8_lossy(&self.stdout))),
            ));
        }
        Ok(None)
    }

    /// The last line is the program's, and begins with the name of a file.
    fn is_one_message(&self, arguments: &[String], lines: &[&str]) -> Result<(), (Kind, String)> {
        let own = lines.iter().filter(|line| line.starts_with("trisect: ")).count();
        let last = lines.last().copied().unwrap_or_default();
        if own != 1 || !last.starts_with("trisect: ") || !self.stderr.ends_with('\n') {
            return Err((Kind::Message, format!("not one message: {}", cut(&self.stderr))));
        }
        // The file at fault may be one that the mutant names.
        let named = last["trisect: ".len()..].split(": ").next().unwrap_or_default();
        if !arguments.iter().any(|word| word == named) && !named.contains('.') {
            return Err((Kind::Message, format!("names no file: {}", cut(last))));
        }
        Ok(())
    }
}

/// Whether `query` and `render`, in this order, differ about a mesh. A scene may be refused for what a mesh
/// alone does not have.
fn disagree(accepted: bool, refused: Option<&str>, message: Option<&str>) -> bool {
    const OF_SCENES: [&str; 5] = ["texture", "picture", "material", "camera", "light"];
    match (accepted, refused, message) {
        (true, _, Some(message)) => !OF_SCENES.iter().any(|word| message.contains(word)),
        (_, Some(_), None) => true,
        _ => false,
    }
}

/// Whether every line is an answer, and no number of a hit is missing.
fn answers_are_sound(stdout: &[u8]) -> bool {
    let mut ray = 0_u64;
    stdout.is_empty()
        || stdout.ends_with(b"\n")
            && stdout[..stdout.len() - 1].split(|&byte| byte == b'\n').all(|line| {
                let Ok(line) = serde_json::from_slice::<Value>(line) else {
                    return false;
                };
                let is_next = line["ray"] == ray;
                ray += 1;
                let is_number = |name: &str| line[name].is_number();
                let whole = ["triangle", "t", "beta", "gamma"].into_iter().all(is_number);
                is_next && (line["hit"] == false || line["hit"] == true && whole)
            })
}

/// The head of a text, in one line.
fn cut(text: &str) -> String {
    const LONGEST: usize = 300;
    let mut line: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if text.chars().nth(LONGEST).is_some() {
        line.push('…');
    }
    line
}
