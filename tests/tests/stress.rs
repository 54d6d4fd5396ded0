//! The stability study, small: what it finds of every method must not change unseen.

use trisect_catalog::{entries, find};
use trisect_core::{FloatFormat, Hit, MultiplyAdd, Ray, Scalar as _, Triangle, Vec3};
use trisect_formula::Flushing;
use trisect_method::Form;
use trisect_studies::record::Records;
use trisect_studies::stress::{
    ByCondition, Clause, Contract, Limits, SpecialValues, Stability, Stages, StressFamily,
    SurfaceCracks,
};
use trisect_studies::{Shard, Silent, Study as _, merge};

/// Tests of hostile input, of which CI has time for so many.
const FUZZ: u64 = 20_000_000;

/// Nothing, to be filled in.
fn nothing(names: &[&str]) -> Stability {
    let methods = if names.is_empty() {
        entries().iter().collect()
    } else {
        names.iter().map(|name| find(name).expect("it is in the catalogue")).collect()
    };
    Stability::nothing(1, methods)
}

fn study(settings: Stability) -> Records {
    settings.record(String::new(), &mut Silent).expect("nothing is timed")
}

fn pairs(method: &str) -> Records {
    study(Stability { pairs: 64, ..nothing(&[method]) })
}

fn families(records: &Records, precision: FloatFormat) -> impl Iterator<Item = &StressFamily> {
    records.all().filter(move |family: &&StressFamily| family.variant.precision == precision)
}

#[test]
fn no_kernel_breaks_the_contract() {
    let records = study(Stability { fuzz: FUZZ, ..nothing(&[]) });
    let mut tests = 0;
    let mut broken = Vec::new();
    for contract in records.all::<Contract>() {
        for (clause, [tested, violations]) in &contract.clauses {
            if matches!(clause, Clause::FiniteHits | Clause::SameDecisions) {
                tests += tested;
            }
            if *violations > 0 {
                broken.push((contract.variant.clone(), *clause, *violations));
            }
        }
        assert!(contract.clauses.len() >= 5, "{:?} is not held to all clauses", contract.variant);
    }
    assert!(broken.is_empty(), "{broken:?}");
    assert!(tests >= FUZZ, "{tests}");
}

/// Special values in the place of a number of a clear hit: what is not finite is a miss always.
#[test]
fn nothing_that_is_not_finite_is_hit() {
    for values in study(Stability { fuzz: 1, ..nothing(&[]) }).all::<SpecialValues>() {
        for outcome in &values.outcomes {
            let infinite_end = outcome.value.ends_with("inf") && outcome.place.starts_with('t');
            if (outcome.value == "NaN" || outcome.value.ends_with("inf")) && !infinite_end {
                assert_eq!(outcome.hits, 0, "{:?} {outcome:?}", values.variant);
            }
        }
    }
}

#[test]
fn watertight_methods_have_no_cracks_and_others_have_some() {
    let methods = [
        "watertight",
        "watertight-one-precision",
        "watertight-packet",
        "moller-trumbore",
        "plucker-translated",
        "wald",
    ];
    let rays = Stability { crack_rays: 1, watertight_rays: 30_000, ..nothing(&methods) };
    let records = study(rays);
    let through = |cracks: &SurfaceCracks| {
        let sites = cracks.sites.iter().filter(|site| site.scale == 1.0);
        sites.map(|site| site.no_hit).sum::<usize>()
    };
    let mut tight = Vec::new();
    for cracks in records.all::<SurfaceCracks>() {
        let claims = find(&cracks.variant.method).expect("it is measured").info.claims.watertight;
        let claimed = claims
            && cracks.variant.arithmetic == MultiplyAdd::Plain
            && cracks.variant.division == Form::Deferred;
        if claimed {
            assert_eq!(through(cracks), 0, "{cracks:?}");
            tight.push(cracks.variant.method.as_ref());
        } else if cracks.variant.precision == FloatFormat::F32 && !claims {
            assert!(through(cracks) > 0, "{} claims less than it keeps", cracks.variant.method);
        }
    }
    assert_eq!(tight.len(), 6, "three methods, two precisions: {tight:?}");
}

#[test]
fn every_family_is_easy_for_a_plain_method_at_its_first_level() {
    let records = pairs("moller-trumbore");
    let hard_at_once = ["subnormal", "near-collinear", "random-bits"];
    let mut seen = 0;
    for family in families(&records, FloatFormat::F32).filter(|family| !family.flush_to_zero) {
        seen += 1;
        let first = &family.levels[0];
        if !hard_at_once.contains(&family.family.as_str()) {
            assert_eq!(first.wrong, 0, "{}: {first:?}", family.family);
        }
    }
    // Sixteen families in each of the two forms.
    assert_eq!(seen, 32);
}

#[test]
fn errors_of_a_backward_stable_method_grow_with_the_condition_alone() {
    let records = pairs("moller-trumbore");
    let factor = find("moller-trumbore").expect("it is in the catalogue").info.error_factor;
    let mut bins = 0;
    for line in records.all::<ByCondition>() {
        for bin in &line.decades {
            bins += 1;
            assert!(f64::from(bin.over_condition.1) <= factor, "{line:?}");
        }
    }
    assert!(bins > 100, "{bins}");
}

#[test]
fn limits_are_where_the_numbers_end() {
    let records = study(Stability { probes: 32, ..nothing(&["moller-trumbore"]) });
    let limits = records.all::<Limits>();
    let scale: Vec<_> = limits.filter(|limits| limits.family == "scale").collect();
    assert_eq!(scale.len(), 4, "two precisions, two forms");
    for limits in scale {
        // The numerator of t is of third degree in the size: it underflows to less than the ten bits
        // that a thousandth takes, or overflows.
        let (smallest, largest) = match limits.variant.precision {
            FloatFormat::F32 => (f64::from(f32::from_bits(1 << 10)), f64::from(f32::MAX)),
            FloatFormat::F64 => (f64::from_bits(1 << 10), f64::MAX),
        };
        let near = |x: f64, end: f64| (0.1..10.0).contains(&(x / end));
        assert!(near(limits.smallest, smallest.cbrt()), "{limits:?}");
        assert!(near(limits.largest, largest.cbrt()), "{limits:?}");
    }
}

#[test]
fn the_study_does_not_depend_on_the_number_of_threads() {
    let of_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let few = || Stability {
            pairs: 16,
            probes: 4,
            crack_rays: 100,
            watertight_rays: 1_000,
            fuzz: 1_000_000,
            ..nothing(&["wald", "watertight"])
        };
        pool.install(|| study(few()).lines)
    };
    assert_eq!(of_threads(1), of_threads(3));
}

/// Of any part, and of lines that several shards make together.
#[test]
fn shards_are_the_whole_study() {
    let few = || Stability {
        pairs: 8,
        probes: 4,
        crack_rays: 100,
        watertight_rays: 1_000,
        fuzz: 300_000,
        exact: 200_000,
        ..nothing(&["wald", "watertight", "exact"])
    };
    let shard = |index| {
        let shard = Some(Shard { index, count: 3 });
        let records = few().record_shard(String::new(), shard, &mut Silent);
        (index.to_string(), records.expect("nothing is timed"))
    };
    let merged = merge([3, 1, 2].map(shard).into()).expect("they are all shards of one study");
    assert_eq!(merged.lines, study(few()).lines);
}

/// The scalar kernels over a number that flushes, against themselves where nothing is subnormal.
#[test]
fn flushing_changes_nothing_that_is_not_subnormal() {
    let ray = Ray::<f32>::new([0.25, 0.25, -1.0], [0.0, 0.0, 1.0]);
    let triangle = Triangle::<f32>::new([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let small = |x: f32| x * 1e-39;
    let tiny =
        Triangle { a: triangle.a.map(small), b: triangle.b.map(small), c: triangle.c.map(small) };
    assert!(!tiny.is_degenerate(), "corners are subnormal, and a triangle");
    for entry in entries() {
        for (division, test) in &entry.flushing {
            let place = format!("{} {division}", entry.info.name);
            let Hit { t, .. } = test(&ray, &triangle).unwrap_or_else(|| panic!("{place} misses"));
            assert!((t - 1.0).abs() < 1e-6, "{place}: {t}");
            assert_eq!(test(&Ray { o: Vec3::new(0.0, 0.0, -1.0), ..ray }, &tiny), None, "{place}");
        }
    }
    assert_eq!(Flushing::from_f64(1e-40).to_f64(), f64::from(1e-40_f32));
}

/// Every kind of scene, on every lane type and in both arrangements, and first hits in every way.
#[test]
fn what_claims_to_be_exact_is() {
    let records = study(Stability { exact: 1_500_000, ..nothing(&["exact"]) });
    let summary = trisect_studies::stress::exactness_summary(&records);
    let total = summary.total();
    assert_eq!(total.all_wrong(), 0, "{:?}", summary.first_wrong);
    assert!(total.tests >= 1_500_000);
    for row in &summary.rows {
        assert!(row.counts.tests > 0 && row.counts.rays > 0, "{row:?}");
    }
    assert!(summary.rows.iter().any(|row| row.precision == FloatFormat::F64));
}

/// Each stage decides something somewhere, and the cheapest nearly all of a scene.
#[test]
fn the_cheapest_stage_decides_nearly_all() {
    let records = study(Stability { pairs: 16, ..nothing(&["exact"]) });
    let mut sums = vec![0; 4];
    for stages in records.all::<Stages>() {
        assert_eq!(stages.stages.len(), 4);
        for (sum, pairs) in sums.iter_mut().zip(&stages.pairs) {
            *sum += pairs;
        }
        if stages.source.starts_with("bunny/") {
            let all: u64 = stages.pairs.iter().sum();
            assert!(stages.pairs[0] as f64 > 0.999 * all as f64, "{stages:?}");
        }
    }
    assert!(sums.iter().all(|&sum| sum > 0), "{sums:?}");
}
