//! Commands with what they print.

/// Rewrite what is printed with `TRYCMD=overwrite cargo test -p trisect-cli`, then read the
/// difference.
#[test]
fn commands_print_what_is_written_down() {
    trycmd::TestCases::new()
        .register_bin("trisect", std::path::Path::new(env!("CARGO_BIN_EXE_trisect")))
        .env("COLUMNS", "80")
        .timeout(trisect_testkit::process::STUCK)
        .case("tests/cmd/*.md")
        .case("tests/cmd/*.toml");
}
