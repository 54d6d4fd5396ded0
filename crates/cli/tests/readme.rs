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
        .case("*.md")
        .case("docs/*.md");
}
