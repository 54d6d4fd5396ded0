//! The format of records on disk.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;
use trisect_studies::record::SCHEMA;

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
        // Older schemas lack fields that are written now.
        if records.header.schema < SCHEMA {
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
