//! The same seed gives the same record.

use trisect_catalog::entries;
use trisect_mesh::{Mesh, MeshFormat};
use trisect_studies::comparison::{Family, Task, Timed, compare};
use trisect_studies::record::Records;
use trisect_studies::{Inputs, Silent, Taken};
use trisect_workloads::Workload;

fn task(workload: Workload, family: Family) -> Task {
    let Workload { name, description, rays, triangles } = workload;
    let inputs = Inputs::new(rays, triangles.to_vec());
    Task { name, description, family, inputs, timed_rays: 16, timed: Timed::All }
}

fn run(seed: u64) -> Records {
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    let mesh = Mesh::from_bytes("corner", MeshFormat::Obj, obj).expect("sound");
    let methods: Vec<_> = entries().iter().collect();
    let tasks = [
        task(trisect_workloads::random(seed, 64, 64), Family::Random),
        task(trisect_workloads::random_through_box(seed, &mesh, 64), Family::Mesh),
    ];
    // Nothing is timed.
    let taken = Taken { command: "trisect verify".to_owned(), seed, rounds: 0 };
    let taken = taken.record(&mut Silent, |run| compare(&methods, (seed, 0), tasks, run));
    taken.expect("answers are right")
}

#[test]
fn records_of_one_seed_differ_in_the_clock_alone() {
    let (first, mut second) = (run(5), run(5));
    second.header.started.clone_from(&first.header.started);
    second.header.machine.core_ghz = first.header.machine.core_ghz;
    assert_eq!(first, second);
    assert_ne!(first.lines, run(6).lines, "the seed plays no part");
}

#[test]
fn a_record_reads_back_as_it_was_written() {
    let records = run(5);
    let mut file = Vec::new();
    records.write(&mut file).expect("memory can be written");
    let read = trisect_studies::read(file.as_slice()).expect("just written");
    assert_eq!(read, records);
    let mut again = Vec::new();
    read.write(&mut again).expect("memory can be written");
    assert_eq!(file, again);
}
