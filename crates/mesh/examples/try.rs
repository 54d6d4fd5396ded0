use trisect_mesh::*;
fn main() {
    for f in std::env::args().skip(1) {
        match Mesh::load(&f) {
            Ok(m) => { println!("{f}: {} triangles, bounds {:?}, {} degenerate", m.triangles.len(), m.bounds, m.degenerate); for n in &m.notes { println!("   note {n}"); } }
            Err(e) => println!("ERR {e}"),
        }
        let strict = ReadOptions { strict: true, ..Default::default() };
        if let Err(e) = Mesh::load_with(&f, &strict) { println!("  STRICT {e}"); }
    }
}
