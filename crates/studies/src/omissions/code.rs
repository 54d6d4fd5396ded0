//! How often the renderer is compiled, and how much code that is: read from the program itself.

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionKind, SymbolKind};

use super::record::Code;

/// The functions of which every instance of the renderer has one.
const OF_EACH: [&str; 2] = [
    "trisect_render::render::<impl trisect_render::stage::Stage>::draw",
    "trisect_render::render::<impl trisect_render::stage::Stage>::draw_paths",
];

/// What is compiled for each instance, or for some of them.
const OF_SOME: [&str; 5] = [
    "trisect_render::paths::",
    "trisect_render::render::",
    "trisect_render::surface::",
    "trisect_render::wave::",
    "trisect_render::whitted::",
];

/// The renderer's code in this program; none where the program does not say what its code is, as where it
/// was stripped.
pub(crate) fn of_renderer() -> Option<Code> {
    let program = std::env::current_exe().and_then(std::fs::read).ok()?;
    let object = object::File::parse(&*program).ok()?;
    let code = object.sections().filter(|section| section.kind() == SectionKind::Text);
    let of_bytes = code.map(|section| section.size()).sum();
    let (mut instances, mut bytes) = (0, 0);
    for symbol in object.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text) {
        let Ok(name) = symbol.name() else { continue };
        // Without the hash that tells instances apart.
        let name = format!("{:#}", rustc_demangle::demangle(name));
        if OF_SOME.iter().any(|start| name.starts_with(start)) {
            instances += usize::from(OF_EACH.contains(&name.as_str()));
            bytes += symbol.size();
        }
    }
    let of = "renderer".to_owned();
    (instances > 0 && bytes > 0).then_some(Code { of, instances, bytes, of_bytes })
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// One for each set of parts, and one that traces paths: more would be compiled for nothing.
    #[test]
    fn the_renderer_is_compiled_once_for_each_set_of_needs() {
        // So that it is linked.
        std::hint::black_box(trisect_render::Renderer::render as *const ());
        let code = of_renderer().expect("a test has its symbols");
        assert_eq!(code.instances, (1 << trisect_render::Part::COMPILED.len()) + 1);
        assert!(code.bytes < code.of_bytes && code.bytes < 1 << 20, "{code:?}");
    }
}
