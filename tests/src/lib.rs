//! Holds nothing: the tests in `tests/` are about all methods and crates together.
#![forbid(unsafe_code)]
