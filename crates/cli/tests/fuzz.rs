//! Damaged files: no reader crashes, hangs, grows or leaves anything behind. `cargo run --release --package
//! trisect-fuzz` tries millions.

use std::path::Path;

use trisect_fuzz::{Bench, Campaign, Format, Verdict, corpus, files, limit_memory};

/// Mutants of each format.
const MUTANTS: u64 = 250;

fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_trisect"))
}

/// Whether there are limits to try anything under.
fn is_limited() -> bool {
    let limited = limit_memory();
    if let Err(error) = &limited {
        eprintln!("skipped: {error}");
    }
    limited.is_ok()
}

/// What the program makes of the files in a folder, where that is one of the verdicts `wanted`.
fn every_file_of(folder: &Path, wanted: fn(&Verdict) -> bool) {
    let mut bench = Bench::new(program()).expect("a folder for temporaries can be written");
    let files = files(folder).expect("the folder is part of the project");
    assert!(!files.is_empty(), "{}", folder.display());
    for (path, bytes) in files {
        let format = Format::of(&path).expect("its ending is one of a format");
        let verdict = bench.verdict(format, &bytes, 0).expect("the program was just built");
        assert!(wanted(&verdict), "{}: {verdict:?}", path.display());
    }
}

#[test]
fn what_is_mutated_is_sound() {
    if !is_limited() {
        return;
    }
    for format in Format::ALL {
        let wanted: fn(&Verdict) -> bool = match format {
            // Written and not read.
            Format::Exr => |verdict| matches!(verdict, Verdict::Refused(_)),
            // `rank` finds no times in most.
            Format::Records => |verdict| !matches!(verdict, Verdict::Faulty(_)),
            _ => |verdict| *verdict == Verdict::Accepted,
        };
        every_file_of(&corpus().join(format.name()), wanted);
    }
}

#[test]
fn what_was_found_stays_mended() {
    if !is_limited() {
        return;
    }
    let findings = corpus().with_file_name("findings");
    every_file_of(&findings.join("accepted"), |verdict| *verdict == Verdict::Accepted);
    every_file_of(&findings.join("refused"), |verdict| matches!(verdict, Verdict::Refused(_)));
    every_file_of(&findings.join("either"), |verdict| !matches!(verdict, Verdict::Faulty(_)));
}

#[test]
fn mutants_of_every_format() {
    if !is_limited() {
        return;
    }
    let formats = Format::ALL.to_vec();
    let campaign = Campaign {
        program: program().to_owned(),
        seed: 1,
        mutants: MUTANTS * formats.len() as u64,
        formats,
        jobs: std::thread::available_parallelism().map_or(1, usize::from),
    };
    let outcome = campaign.run(&|_| ()).expect("the program was just built");
    let found: Vec<String> = outcome
        .findings
        .iter()
        .map(|found| format!("1:{} {:?}, {} times", found.number, found.fault, found.count))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    // Mutants that are all refused, or none, show nothing.
    for (format, tally) in outcome.tallies {
        assert_eq!(tally.tried(), MUTANTS, "{format:?}");
        // A material library is refused for little: what is wrong with it is noted.
        let least_refused = if format == Format::Mtl { MUTANTS / 50 } else { MUTANTS / 10 };
        assert!(tally.refused > least_refused, "{format:?}: {tally:?}");
        let some_accepted = tally.accepted > MUTANTS / 50;
        assert!(some_accepted || format == Format::Exr, "{format:?}: {tally:?}");
    }
}
