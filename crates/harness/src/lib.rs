//! Measures time and error of every method and writes records; never draws.
#![forbid(unsafe_code)]

pub mod record;
