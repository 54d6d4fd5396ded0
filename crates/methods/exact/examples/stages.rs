//! Which stage decides, by stress family: shares of the pairs, over all levels of difficulty.
//!
//! `cargo run --release -p trisect-exact --example stages`

use trisect_core::Precision;
use trisect_exact::Stage;
use trisect_workloads::{Stress, random};

/// Pairs per level.
const PAIRS: usize = 2000;

/// Prints a row.
fn row(name: &str, stages: impl Iterator<Item = Stage>) {
    let mut counts = [0_u64; 4];
    for stage in stages {
        for (count, other) in counts.iter_mut().zip(Stage::ALL) {
            *count += u64::from(stage == other);
        }
    }
    let all: u64 = counts.iter().sum();
    let [miss, filter, double, whole] = counts.map(|count| 100.0 * count as f64 / all as f64);
    println!("| {name} | {miss:.3} | {filter:.3} | {double:.3} | {whole:.3} |");
}

fn table<E: Precision>() {
    println!("\n| {}: per cent of pairs | miss | filter | f64 | whole |", E::FORMAT);
    println!("| --- | --: | --: | --: | --: |");
    let scene = random(1, 200, 500);
    let pairs = scene.rays.iter().flat_map(|ray| scene.triangles.iter().map(move |t| (ray, t)));
    row(
        "random",
        pairs.map(|(ray, triangle)| {
            let number = |&x: &f32| E::from_f64(f64::from(x));
            Stage::of(&ray.map(number), &triangle.map(number))
        }),
    );
    for family in Stress::ALL {
        let levels = family.levels::<E>();
        let pairs = levels.iter().flat_map(|&level| family.pairs::<E>(1, level, PAIRS));
        row(family.name(), pairs.map(|(ray, triangle)| Stage::of(&ray, &triangle)));
    }
}

fn main() {
    table::<f32>();
    table::<f64>();
}
