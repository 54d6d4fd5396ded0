//! What the documents of studies share.

use trisect_report::document::Source;
use trisect_report::format::number;

use crate::record::Header;

/// What some have in common, each once, in the order in which they come.
pub(crate) fn distinct<T: PartialEq>(all: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut names = Vec::new();
    for name in all {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Where the numbers of a record come from.
pub(crate) fn source(header: &Header) -> Source {
    let m = &header.machine;
    let ghz = number(m.core_ghz);
    let widest = m.instruction_sets.last().map_or("scalar", |set| set.name());
    let facts = vec![
        ("Processor", format!("{}, {} logical, {ghz} GHz while measuring", m.cpu, m.logical_cpus)),
        (
            "Instruction sets",
            m.instruction_sets.iter().map(|set| set.name()).collect::<Vec<_>>().join(", "),
        ),
        ("Platform", m.platform.clone()),
        ("Compiler", format!("{}; {}", m.compiler, m.build)),
        (
            "Measured",
            format!(
                "{}, trisect {}, seed {}, {} rounds",
                header.started, header.trisect, header.seed, header.rounds
            ),
        ),
        ("Command", format!("`{}`", header.command)),
    ];
    let noise = header.noise.map_or_else(String::new, |noise| format!(" · {}", noise.says()));
    Source {
        line: format!("trisect {} on {}, {ghz} GHz, {}{noise}", header.trisect, m.cpu, m.compiler),
        measured: format!(
            "Measured on {} at {ghz} GHz ({widest}), {}, by `{}`.",
            m.cpu, m.compiler, header.command
        ),
        generator: format!("trisect {}", header.trisect),
        steadiness: header.noise.map(|noise| format!("The machine was {}.", noise.says())),
        facts,
    }
}
