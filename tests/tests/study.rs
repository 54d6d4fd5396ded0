//! The study of the tracer, small: it says the same of every method but for times.

use trisect_catalog::find;
use trisect_studies::record::{Line, Records};
use trisect_studies::tracer::{Contest, Traced, Tracer, TreeBuilt};
use trisect_studies::{Silent, Study as _};
use trisect_workloads::bunny;

const METHODS: [&str; 2] = ["moller-trumbore", "watertight"];

fn of_threads(threads: usize) -> Records {
    let study = Tracer {
        seed: 1,
        methods: METHODS.map(|name| find(name).expect("it is in the catalogue")).into(),
        scenes: vec![bunny()],
        pixels: 24,
        rounds: 2,
        threads,
    };
    study.record(String::new(), &mut Silent).expect("every sample is right")
}

/// The lines about trees, without what is measured, or says on how many threads.
fn without_times(records: &Records) -> Vec<Line> {
    let kept = records.lines.iter().filter_map(|line| {
        if let Some(tree) = line.get::<TreeBuilt>() {
            let tree = TreeBuilt { samples_ns: Vec::new(), threads: 0, ..tree.clone() };
            (tree.contest != Contest::Threads).then(|| tree.into())
        } else {
            let (samples_ns, baseline_ns) = (Vec::new(), Vec::new());
            let traced = Traced { samples_ns, baseline_ns, ..line.get::<Traced>()?.clone() };
            (traced.contest != Contest::Threads).then(|| traced.into())
        }
    });
    kept.collect()
}

#[test]
fn the_records_are_all_there_and_the_same_but_for_times() {
    let records = of_threads(2);
    let traced: Vec<&Traced> = records.all().collect();
    let trees: Vec<&TreeBuilt> = records.all().collect();
    let count = |contest| {
        let lines = traced.iter().filter(|traced| traced.contest == contest).count();
        (trees.iter().filter(|tree| tree.contest == contest).count(), lines)
    };
    // Two methods, four classes, two ways of tracing.
    assert_eq!(count(Contest::Methods), (2, 16));
    // Both have their test inside the traversal loop as well.
    assert_eq!(count(Contest::Inline), (0, 16));
    // Three builders, and two more sizes of leaves; plain lanes, and a call for each ray.
    assert_eq!(count(Contest::Trees), (5, 28));
    // Three builders on one thread and on two, and tracing on those.
    assert_eq!(count(Contest::Threads), (6, 8));
    for traced in &traced {
        assert_eq!(traced.samples_ns.len(), 2, "{traced:?}");
        let is_paired = matches!(traced.contest, Contest::Methods | Contest::Inline);
        assert_eq!(traced.baseline_ns.len(), if is_paired { 2 } else { 0 }, "{traced:?}");
        assert!(traced.hits > 0 && traced.hits <= traced.rays, "{traced:?}");
        assert!(traced.tracing != "plain" || traced.differ == 0, "{traced:?}");
        assert_eq!(traced.any, traced.class == "occlusion", "{traced:?}");
    }
    for tree in &trees {
        assert_eq!(tree.samples_ns.len(), 2, "{tree:?}");
    }
    let lines = without_times(&records);
    assert_eq!(lines, without_times(&of_threads(2)), "the seed decides");
    assert_eq!(lines, without_times(&of_threads(1)), "whatever the number of threads");
}
