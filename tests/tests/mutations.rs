//! No input, however damaged, makes the readers panic or speak in more than a line.

use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use trisect_harness::record::Records;
use trisect_mesh::{Mesh, MeshFormat};
use trisect_workloads::{read_rays_binary, read_rays_csv};

const MUTATIONS: u64 = 400;

/// A small generator, so that the cases are the same everywhere.
struct Draw(u64);

impl Draw {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(self.0 >> 33).expect("31 bits") % end.max(1)
    }

    /// A few bytes changed, cut out, doubled, or the end cut off.
    fn mutated(&mut self, sound: &[u8]) -> Vec<u8> {
        const WORDS: [&[u8]; 8] =
            [b"nan", b"-1", b"1e999", b"\xff", b"\0\0\0\0", b"\n", b"99999999999999999999", b"\""];
        let mut bytes = sound.to_vec();
        for _ in 0..=self.below(3) {
            let at = self.below(bytes.len());
            let end = bytes.len().min(at + 1 + self.below(8));
            match self.below(5) {
                0 => bytes.truncate(at),
                1 => drop(bytes.drain(at..end)),
                2 => {
                    let word = WORDS[self.below(WORDS.len())];
                    bytes.splice(at..end, word.iter().copied());
                }
                3 => {
                    let doubled = bytes[at..end].to_vec();
                    bytes.splice(at..at, doubled);
                }
                _ => {
                    if let Some(byte) = bytes.get_mut(at) {
                        *byte ^= 1 << self.below(8);
                    }
                }
            }
        }
        bytes
    }
}

/// Reads many mutations of `sound`; `read` gives the message of what it refuses. Both must come
/// up, or the mutations show nothing.
fn survives(name: &str, sound: &[u8], read: fn(&[u8]) -> Result<(), String>) {
    assert_eq!(read(sound), Ok(()), "{name}: what is mutated must be sound");
    let mut refused = 0;
    for seed in 0..MUTATIONS {
        let bytes = Draw(seed).mutated(sound);
        let result = catch_unwind(|| read(&bytes)).unwrap_or_else(|_| {
            panic!("{name}, mutation {seed}: {:?}", String::from_utf8_lossy(&bytes))
        });
        if let Err(message) = result {
            refused += 1;
            assert!(
                !message.is_empty() && !message.contains('\n'),
                "{name}, mutation {seed}: {message:?}"
            );
        }
    }
    assert!(refused > MUTATIONS / 10, "{name}: {refused} refused");
}

fn data(name: &str) -> Vec<u8> {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/mesh/tests");
    std::fs::read(folder.join("data").join(name)).expect("the files of the workloads' tests")
}

fn mesh(format: MeshFormat, bytes: &[u8]) -> Result<(), String> {
    Mesh::from_bytes("mesh", format, bytes).map(drop).map_err(|error| error.to_string())
}

#[test]
fn meshes() {
    for file in ["box.ascii.ply", "box.little.ply", "box.big.ply"] {
        survives(file, &data(file), |bytes| mesh(MeshFormat::Ply, bytes));
    }
    survives("box.obj", &data("box.obj"), |bytes| mesh(MeshFormat::Obj, bytes));
    for file in ["box.ascii.stl", "box.binary.stl"] {
        survives(file, &data(file), |bytes| mesh(MeshFormat::Stl, bytes));
    }
    survives("box.glb", &data("box.glb"), |bytes| mesh(MeshFormat::Gltf, bytes));
}

#[test]
fn rays() {
    let csv = b"ox,oy,oz,dx,dy,dz,tmin,tmax\n0.25,0.5,-3,0,0,1,0,inf\n1,2,3,4,5,6,7,8\n";
    survives("CSV", csv, |bytes| {
        read_rays_csv("rays", bytes).map(drop).map_err(|error| error.to_string())
    });
    let rays = read_rays_csv("rays", csv.as_slice()).expect("sound").rays_f32;
    let mut binary = Vec::new();
    trisect_workloads::write_rays_binary(&mut binary, &rays).expect("memory can be written");
    survives("binary rays", &binary, |bytes| {
        read_rays_binary("rays", bytes).map(drop).map_err(|error| error.to_string())
    });
}

#[test]
fn records() {
    let record = concat!(
        r#"{"kind":"header","schema":1,"trisect":"0.1.0","command":"trisect","started":"now","#,
        r#""seed":1,"rounds":5,"machine":{"cpu":"a","logical_cpus":2,"instruction_sets":[],"#,
        r#""platform":"b","compiler":"c","build":"d","core_ghz":3.5}}"#,
        "\n",
        r#"{"kind":"preparation","method":"wald","precision":"f32","workload":"random","#,
        r#""triangles":3,"samples_ns":[1,2,3]}"#,
        "\n",
    );
    survives("a record", record.as_bytes(), |bytes| {
        let records = Records::read(bytes).map_err(|error| error.to_string())?;
        // What is read can be drawn, whatever the numbers are.
        let filter = trisect_report::Filter::default();
        drop(trisect_report::rank(&records, &filter).to_text(80));
        drop(trisect_report::compare(&records, &records).to_text(80));
        drop(trisect_report::summary(&records).to_text(80));
        Ok(())
    });
}
