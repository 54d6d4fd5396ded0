//! `trisect emit`: a kernel as a program of its own.

use anyhow::{Result, bail};
use trisect_formula::{Request, emit};
use trisect_studies::input;

use crate::arguments::Emit;
use crate::output;

pub(crate) fn run(arguments: &Emit) -> Result<()> {
    let &Emit { language, division, needs, .. } = arguments;
    let entry = input::method(&arguments.method)?;
    let prefix = arguments.prefix.as_deref();
    if let Some(prefix) = prefix.filter(|prefix| !is_a_name(prefix)) {
        bail!(
            "--prefix {prefix}: no name in every language: use letters, digits and single underscores, a letter first"
        );
    }
    let request = Request { language, division, needs, prefix };
    let text = emit(&(entry.formula)(arguments.precision), request)?;
    output::print(|out| out.write_all(text.as_bytes()))
}

/// Whether all names may begin with it; GLSL keeps two underscores for itself.
fn is_a_name(prefix: &str) -> bool {
    prefix.starts_with(|c: char| c.is_ascii_alphabetic())
        && prefix.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !prefix.contains("__")
        && !prefix.ends_with('_')
}
