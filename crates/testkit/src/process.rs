//! Programs that a test runs: one that hangs is killed, and the test says so.

use std::io::{Read, Write as _};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use wait_timeout::ChildExt as _;

/// What takes longer hangs: no program that a test runs takes a tenth of this on a slow machine.
pub const STUCK: Duration = Duration::from_mins(10);

/// Waits for a process to end.
///
/// # Panics
/// When it does not within [`STUCK`]; it is killed then.
pub fn ended(child: &mut Child) -> ExitStatus {
    if let Some(status) = child.wait_timeout(STUCK).expect("it can be waited for") {
        return status;
    }
    // It may have ended in between.
    let _ = child.kill();
    let _ = child.wait();
    panic!("process {} hangs: it was killed after {STUCK:?}", child.id());
}

/// Runs a command with some input, and gathers what it prints, as far as that is not sent elsewhere.
///
/// # Panics
/// When it cannot be started, or as [`ended`].
pub fn output(command: &mut Command, stdin: &[u8]) -> Output {
    let mut child = command.stdin(Stdio::piped()).spawn().expect("it can be started");
    let mut input = child.stdin.take().expect("it is piped");
    let (stdout, stderr) = (child.stdout.take().map(in_full), child.stderr.take().map(in_full));
    // A program that refuses its arguments need not read.
    let _ = input.write_all(stdin);
    drop(input);
    let status = ended(&mut child);
    let bytes = |reads: Option<JoinHandle<Vec<u8>>>| {
        reads.map_or_else(Vec::new, |reads| reads.join().expect("it reads to the end"))
    };
    Output { status, stdout: bytes(stdout), stderr: bytes(stderr) }
}

/// Reads a stream to its end, on a thread of its own, so that no other has to wait for it.
fn in_full(mut stream: impl Read + Send + 'static) -> JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).expect("a pipe can be read");
        bytes
    })
}
