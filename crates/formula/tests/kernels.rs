//! A graph gives the bits of the kernels, in every form of every method.

mod common;

use common::{Subject, pairs, subjects};
use trisect_core::{Float, Hit, Ray, Triangle, Vec3};
use trisect_formula::{Axis, Graph, Latencies, Value};

/// What a graph answers: whether it is open, and the hit.
fn interpreted<E: Float>(
    subject: &Subject<E>,
    ray: &Ray<E>,
    triangle: &Triangle<E>,
) -> (bool, Option<Hit<E>>) {
    let formula = &subject.formula;
    let corners = |triangle: &Triangle<E>| triangle.corners().map(Vec3::to_array).concat();
    let axis = |inputs: &[E]| {
        let axis = formula.axis.as_ref().expect("it is turned");
        let value = axis.run(inputs)[0].number().expect("a number");
        let is_it = |&(_, w): &(usize, f64)| E::from_f64(w) == value;
        [(0, 0.0), (1, 1.0), (2, 2.0)].into_iter().find(is_it).expect("an axis").0
    };
    let w = match formula.turned {
        Axis::Any => 2,
        Axis::OfTriangle => axis(&corners(triangle)),
        Axis::OfRay => axis(&ray.d.to_array()),
        Axis::Kinds => panic!("{}: no kinds", subject.name()),
    };
    let (ray, triangle) = (ray.with_axis_last(w), triangle.or_nothing().with_axis_last(w));
    let stored = formula.prepare.run(&corners(&triangle));
    let mut inputs = [ray.o.to_array(), ray.d.to_array()].concat();
    inputs.extend([ray.tmin, ray.tmax]);
    inputs.extend(stored.into_iter().filter_map(Value::number));
    let graph = &formula.test(subject.form).expect("it has the form").graph;
    let outputs = graph.run(&inputs);
    let output = |name: &str| {
        graph.outputs.iter().position(|output| output == name).map(|place| outputs[place])
    };
    let is_open = output("open").is_some_and(Value::holds);
    let number = |name: &str| output(name).and_then(Value::number).unwrap_or(E::from_f64(0.0));
    let hit = output("hit").is_some_and(Value::holds).then(|| Hit {
        t: number("t"),
        beta: number("beta"),
        gamma: number("gamma"),
    });
    (is_open, hit)
}

fn graphs_give_the_bits_of_the_kernels<E: Float>() {
    let pairs = pairs::<E>(8);
    let (mut hits, mut open) = (0, 0);
    for subject in subjects::<E>() {
        for (ray, triangle) in &pairs {
            let (is_open, hit) = interpreted(&subject, ray, triangle);
            if is_open {
                open += 1;
                continue;
            }
            let bits = |hit: Hit<E>| [hit.t, hit.beta, hit.gamma].map(E::bits64);
            let expected = (subject.kernel)(ray, triangle);
            assert_eq!(
                hit.map(bits),
                expected.map(bits),
                "{}: {hit:?}, not {expected:?}, of {ray:?} and {triangle:?}",
                subject.name()
            );
            hits += usize::from(hit.is_some());
        }
    }
    assert!(pairs.len() > 1500 && hits > 10_000, "{} pairs, {hits} hits", pairs.len());
    // The exact method alone, whose bounds hardly tell anything of pairs as hard as these.
    assert!(open > 100 && open < pairs.len(), "{open} of {}", pairs.len());
}

#[test]
fn graphs_give_the_bits_of_f32_kernels() {
    graphs_give_the_bits_of_the_kernels::<f32>();
}

#[test]
fn graphs_give_the_bits_of_f64_kernels() {
    graphs_give_the_bits_of_the_kernels::<f64>();
}

#[test]
fn what_is_known_needs_no_operation() {
    let subjects = subjects::<f32>();
    let wald = subjects.iter().find(|subject| subject.name() == "wald_deferred").expect("listed");
    let graph = &wald.formula.test(wald.form).expect("it has the form").graph;
    let count = |graph: &Graph| graph.ops.iter().filter(|op| op.operands().count() > 0).count();
    // A ray along the last axis.
    let along = graph.specialise(|input| match input {
        "d_x" | "d_y" => Some(0.0),
        "d_z" => Some(1.0),
        _ => None,
    });
    assert!(count(&along) < count(graph));
    let hoistable = graph.hoistable(|input| input.starts_with("o_"));
    assert!(hoistable.iter().any(|&hoistable| hoistable), "an origin less itself, at least");
    // The longest chain to a hit is longer than that to the decision, by a division at least.
    let cpu = Latencies::ICE_LAKE;
    let of = |name: &str| graph.latency(graph.output(name).expect("an output"), &cpu);
    assert!(of("t") > 11 && of("hit") > 4 * cpu.arithmetic, "{} {}", of("t"), of("hit"));
}

#[test]
fn methods_of_sums_and_products_are_exported_for_proofs() {
    let mut names = Vec::new();
    for subject in subjects::<f32>() {
        let name = subject.formula.info.name;
        if let Some(text) = subject.formula.numerators().and_then(|graph| graph.coq("name"))
            && !names.contains(&name)
        {
            let definitions = text.matches("Definition name_").count();
            assert_eq!(definitions, 10, "{name}: five numerators, plain and fused");
            names.push(name);
        }
    }
    assert!(names.contains(&"moller-trumbore") && names.contains(&"exact"), "{names:?}");
    assert!(!names.contains(&"wald"), "it divides when it prepares");
    assert!(names.len() >= 20, "{names:?}");
}
