//! The study of the tracer, small: it says the same of every method but for times.

use trisect_catalog::find;
use trisect_harness::record::{Contest, Record};
use trisect_harness::{Progress, StudySettings, study};
use trisect_workloads::Mesh;

struct Silent;

impl Progress for Silent {
    fn phase(&mut self, _name: &str, _steps: u64) {}
    fn step(&mut self) {}
}

const METHODS: [&str; 2] = ["moller-trumbore", "watertight"];

fn of_threads(threads: usize) -> Vec<Record> {
    let settings = StudySettings {
        seed: 1,
        methods: METHODS.map(|name| find(name).expect("it is in the catalogue")).into(),
        scenes: vec![Mesh::bunny()],
        pixels: 24,
        rounds: 2,
        threads,
    };
    study(&settings, &mut Silent).expect("every sample is right")
}

/// Without what is measured, or says on how many threads.
fn without_times(records: Vec<Record>) -> Vec<Record> {
    let kept = records.into_iter().filter_map(|record| match record {
        Record::Tree(mut tree) => {
            tree.samples_ns.clear();
            let is_alike = tree.contest != Contest::Threads;
            tree.threads = 0;
            is_alike.then_some(Record::Tree(tree))
        }
        Record::Traced(mut traced) => {
            traced.samples_ns.clear();
            traced.baseline_ns.clear();
            (traced.contest != Contest::Threads).then_some(Record::Traced(traced))
        }
        other => Some(other),
    });
    kept.collect()
}

#[test]
fn the_records_are_all_there_and_the_same_but_for_times() {
    let records = of_threads(2);
    let traced: Vec<_> = records
        .iter()
        .filter_map(|record| match record {
            Record::Traced(traced) => Some(traced),
            _ => None,
        })
        .collect();
    let trees: Vec<_> = records
        .iter()
        .filter_map(|record| match record {
            Record::Tree(tree) => Some(tree),
            _ => None,
        })
        .collect();
    let count = |contest| {
        let lines = traced.iter().filter(|traced| traced.contest == contest).count();
        (trees.iter().filter(|tree| tree.contest == contest).count(), lines)
    };
    // Two methods, four classes, two ways of tracing.
    assert_eq!(count(Contest::Methods), (2, 16));
    // Three builders, and two more sizes of leaves; plain lanes, and a call for each ray.
    assert_eq!(count(Contest::Trees), (5, 28));
    // Three builders on one thread and on two, and tracing on those.
    assert_eq!(count(Contest::Threads), (6, 8));
    for traced in &traced {
        assert_eq!(traced.samples_ns.len(), 2, "{traced:?}");
        let is_paired = traced.contest == Contest::Methods;
        assert_eq!(traced.baseline_ns.len(), if is_paired { 2 } else { 0 }, "{traced:?}");
        assert!(traced.hits > 0 && traced.hits <= traced.rays, "{traced:?}");
        assert!(traced.tracing != "plain" || traced.differ == 0, "{traced:?}");
        assert_eq!(traced.any, traced.class == "occlusion", "{traced:?}");
    }
    for tree in &trees {
        assert_eq!(tree.samples_ns.len(), 2, "{tree:?}");
    }
    let records = without_times(records);
    assert_eq!(records, without_times(of_threads(2)), "the seed decides");
    assert_eq!(records, without_times(of_threads(1)), "whatever the number of threads");
}
