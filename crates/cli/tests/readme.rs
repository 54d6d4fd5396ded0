//! The commands of the documents.

use std::path::Path;

/// Runs the `console` blocks of the documents from the root of the workspace, where a reader
/// types them. Blocks marked `console,ignore` and commands of cargo are not run: they take
/// minutes.
#[test]
fn documents_show_what_trisect_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    std::env::set_current_dir(root).expect("the workspace is where this was compiled");
    trycmd::TestCases::new()
        .register_bin("trisect", Path::new(env!("CARGO_BIN_EXE_trisect")))
        .register_bin("cargo", trycmd::schema::Bin::Ignore)
        .env("COLUMNS", "80")
        .timeout(trisect_testkit::process::STUCK)
        .case("*.md")
        .case("docs/*.md")
        .case("benches/*.md")
        .case("crates/*/*.md")
        .case("data/*.md")
        .case("fuzz/*.md")
        .case("reports/*.md");
}

/// What documents take from a record is what `trisect report --splice` makes of it.
#[test]
fn documents_are_spliced_from_their_record() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (record, documents) in [
        ("2026-11-28-zen5/record", &["docs/METHODS.md", "docs/HAVEL.md"][..]),
        ("2026-11-28-zen5/stress", &["docs/STABILITY.md", "docs/CONTRACT.md"]),
        ("2026-11-28-zen5/study", &["docs/TRACER.md"]),
        ("2026-12-01-sapphire-rapids/pictures", &["docs/PICTURES.md"]),
        ("2026-11-28-zen5/omissions", &["docs/NEEDS.md"]),
        ("2026-12-01-sapphire-rapids/forms", &["docs/HAVEL.md", "docs/PICTURES.md"]),
    ] {
        let file = std::fs::File::open(root.join(format!("reports/{record}.jsonl.gz")))
            .expect("the documents name it");
        let records = trisect_studies::read(std::io::BufReader::new(file)).expect("a sound record");
        for &document in documents {
            let text = std::fs::read_to_string(root.join(document)).expect("a document");
            let spliced = trisect_studies::splice(&text, &records).expect("there are markers");
            assert!(
                spliced == text,
                "{document} is out of date: splice it anew with the command that it names"
            );
        }
    }
}
