//! The format of records on disk.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;
use trisect_studies::record::SCHEMA;

/// The schema from which on all that must be written was there.
const COMPLETE: u32 = 7;
const _: () = assert!(COMPLETE <= SCHEMA);

/// The records that the project ships, in a folder or in folders of it.
fn shipped(folder: &Path) -> Vec<PathBuf> {
    let paths = fs::read_dir(folder).expect("the project ships it");
    let paths = paths.map(|entry| entry.expect("it can be listed").path());
    let of = |path: PathBuf| if path.is_dir() { shipped(&path) } else { vec![path] };
    paths.flat_map(of).filter(|path| path.extension().is_some_and(|e| e == "gz")).collect()
}

/// What is read and written again holds the same bytes.
#[test]
fn records_are_written_as_they_were_read() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut compared = 0;
    for path in shipped(&root.join("reports")) {
        let compressed = fs::read(&path).expect("it was listed");
        let mut text = Vec::new();
        let mut decoder = MultiGzDecoder::new(compressed.as_slice());
        decoder.read_to_end(&mut text).expect("it is compressed");
        let records = trisect_studies::read(text.as_slice()).expect("it is a record");
        let of_file = trisect_studies::load(&path).expect("it is a record");
        assert!(of_file == records, "{}: compressed or not", path.display());
        // Older schemas lack fields that are written now; what came later may be missing.
        if records.header.schema < COMPLETE {
            continue;
        }
        compared += 1;
        let mut written = Vec::new();
        records.write(&mut written).expect("memory does not fail");
        // Line by line: the whole would take minutes to print.
        let (old, new) = (text.split(|&b| b == b'\n'), written.split(|&b| b == b'\n'));
        for (line, (old, new)) in old.zip(new).enumerate() {
            assert!(old == new, "{}, line {}", path.display(), line + 1);
        }
        assert_eq!(text.len(), written.len(), "{}", path.display());
    }
    assert!(compared > 0, "none is of this schema");
}

/// A record is of the study that its header names; an older one of the study whose lines it holds.
#[test]
fn a_record_says_which_study_took_it() {
    let header = r#"{"kind":"header","schema":7,"trisect":"0.1.0","command":"","started":"","seed":1,"rounds":1,"machine":{"cpu":"","logical_cpus":1,"instruction_sets":["sse4.2"],"platform":"","compiler":"","build":"","core_ghz":1.0}}"#;
    let code = r#"{"kind":"code","of":"renderer","instances":1,"bytes":2,"of_bytes":3}"#;
    let of = |text: &str| {
        let records = trisect_studies::read(text.as_bytes()).expect("it is a record");
        trisect_studies::chapter_of(&records).about.name
    };
    let named = header.replace(r#""schema":7"#, r#""schema":7,"study":"pictures""#);
    assert_eq!(of(&named), "pictures");
    assert_eq!(of(&format!("{named}\n{code}")), "pictures");
    assert_eq!(of(header), "comparison");
    assert_eq!(of(&format!("{header}\n{code}")), "omissions");
    let unknown = trisect_studies::read(format!("{header}\n{{\"kind\":\"codes\"}}").as_bytes());
    let error = unknown.expect_err("no study has such lines").to_string();
    assert!(error.starts_with("line 2: no line is of the kind `codes`"), "{error}");
}
