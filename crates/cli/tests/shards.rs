//! A study in shards, as several machines take it, is that of one run.

mod common;

use std::fs;
use std::process::Command;

use common::Folder;
use serde_json::Value;

/// The lines of a record without the first, and without times.
fn lines(record: &str) -> Vec<Value> {
    fn clear(value: &mut Value) {
        match value {
            Value::Object(fields) => {
                fields.retain(|name, _| !name.ends_with("_ns"));
                fields.values_mut().for_each(clear);
            }
            Value::Array(values) => values.iter_mut().for_each(clear),
            _ => {}
        }
    }
    let parse = |line: &str| {
        let mut value = serde_json::from_str(line).expect("JSON");
        clear(&mut value);
        value
    };
    record.lines().skip(1).map(parse).collect()
}

fn header(record: &str) -> Value {
    serde_json::from_str(record.lines().next().expect("a header")).expect("JSON")
}

impl Folder {
    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).expect("it was written")
    }

    fn succeeds(&self, arguments: &str) -> String {
        let run = self.trisect(arguments, b"");
        assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
        run.stdout
    }
}

#[test]
fn shards_of_a_measurement_are_the_whole_of_it() {
    let folder = Folder::new();
    let measure = "measure --methods moller-trumbore,wald --mesh mesh.obj --rounds 1 --output";
    folder.succeeds(&format!("{measure} whole.jsonl"));
    for index in [2, 1] {
        folder.succeeds(&format!("{measure} {index}.jsonl --shard {index}/2"));
    }
    folder.succeeds("merge 2.jsonl 1.jsonl --output merged.jsonl");
    let (whole, merged) = (folder.text("whole.jsonl"), folder.text("merged.jsonl"));
    assert_eq!(lines(&merged), lines(&whole));
    let fields = |record: &str, fields: &[&str]| {
        let header = header(record);
        fields.iter().map(|&field| header[field].clone()).collect::<Vec<_>>()
    };
    let same = ["schema", "study", "trisect", "seed", "rounds", "shard"];
    assert_eq!(fields(&merged, &same), fields(&whole, &same));
    assert_eq!(
        header(&merged)["command"],
        "trisect measure --methods moller-trumbore,wald --mesh mesh.obj --rounds 1"
    );
    let shares = ["1.jsonl", "2.jsonl"].map(|shard| lines(&folder.text(shard)).len());
    assert!(shares.iter().all(|share| (2..lines(&whole).len()).contains(share)), "{shares:?}");

    // What is no set of shards is refused, and nothing is written.
    let before = folder.listing();
    for (arguments, says) in [
        ("merge 1.jsonl", "shards are missing: 2/2; take them with --shard"),
        (
            "merge 1.jsonl whole.jsonl",
            "whole.jsonl: is no shard of a record; take one with --shard",
        ),
        ("merge 1.jsonl 2.jsonl 1.jsonl", "1.jsonl: shard 1/2 is given already; name each once"),
    ] {
        let run = folder.trisect(&format!("{arguments} --output new.jsonl"), b"");
        assert_eq!((run.code, run.stderr), (Some(2), format!("trisect: {says}\n")));
    }
    assert_eq!(folder.listing(), before);
    let other = measure.replace("wald", "plucker");
    folder.succeeds(&format!("{other} 2.jsonl --shard 2/2"));
    let run = folder.trisect("merge 1.jsonl 2.jsonl", b"");
    assert!(run.stderr.contains("2.jsonl: its command is not that of 1.jsonl"), "{}", run.stderr);
}

/// Kinds of scenes of one line go to different shards. And the shards are taken by the script for Slurm, as its
/// array would take them.
#[test]
fn shards_of_exactness_are_the_whole_of_it() {
    let folder = Folder::new();
    folder.succeeds("stress --methods exact --exact 300000 --output 1 --shard 1/1");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../python/examples/shards.sbatch");
    for index in 1..=3 {
        let mut command = Command::new("bash");
        command
            .args([script, "--methods", "exact", "--exact", "300000"])
            .current_dir(folder.path())
            .env("TRISECT", env!("CARGO_BIN_EXE_trisect"))
            .env("SURVEY", "3")
            .env("SLURM_ARRAY_TASK_ID", index.to_string())
            .env("SLURM_ARRAY_TASK_COUNT", "3");
        let run = folder.run(command, b"");
        assert_eq!((run.code, run.stdout.as_str()), (Some(0), ""), "{}", run.stderr);
    }
    let shards = [1, 2, 3].map(|index| format!("3/stress-{index}-of-3.jsonl"));
    let merged = folder.succeeds(&format!("merge {}", shards.join(" ")));
    let whole = folder.succeeds("merge 1/stress-1-of-1.jsonl");
    assert_eq!(lines(&merged), lines(&whole));
    // The kinds of scenes in the first line that has any.
    let kinds = |lines: &[Value]| {
        let found = lines.iter().find_map(|line| Some(line["kinds"].as_object()?.len()));
        found.expect("a line has kinds of scenes")
    };
    let shares = shards.iter().map(|shard| kinds(&lines(&folder.text(shard)))).sum::<usize>();
    assert_eq!((shares, kinds(&lines(&merged))), (shares, shares));
    folder.write("merged.jsonl", merged.as_bytes());
    let report = folder.succeeds("report merged.jsonl --output pages");
    assert!(report.contains("0 wrong decisions, 0 wrong values"), "{report}");
}
