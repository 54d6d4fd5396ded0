//! What a method costs, counted from the very formula that runs.

use std::fmt::Write;
use std::path::Path;

use trisect_core::{
    Culling, Deferred, Division, Early, Interval, Method, Ray, Record, Scalar, Triangle,
    TrueDivision, Vec3,
};

use crate::counting::{Counting, Ops, counted};

/// Operations of each part of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Finding a triangle's kind and preparing it.
    pub prepare: Ops,
    /// Preparing a ray for triangles of one kind.
    pub per_ray: Ops,
    /// The test that divides first, to the hit.
    pub test_early: Ops,
    /// The test that divides last, to the decision.
    pub test_deferred: Ops,
    /// From the deferred decision to the hit.
    pub finish_deferred: Ops,
    /// Numbers stored per triangle.
    pub stored_numbers: usize,
}

/// Counts the operations of method `M`, with the true division and without culling.
///
/// # Panics
/// When `M` decides the sample pair wrongly.
pub fn cost<M: Method>() -> Cost {
    let number = Counting::from_f64;
    let vector = |x, y, z| Vec3::new(number(x), number(y), number(z));
    let triangle =
        Triangle::new(vector(0.0, 0.0, 1.0), vector(4.0, 0.0, 2.0), vector(0.0, 4.0, 3.0));
    // Meets the triangle inside, at t = 2.75.
    let ray = |tmax| Ray {
        o: vector(1.0, 1.0, -1.0),
        d: vector(0.0, 0.0, 1.0),
        tmin: number(0.0),
        tmax: number(tmax),
    };
    let (prepare, (group, prepared)) = counted(|| {
        let group = M::group(&triangle);
        (group, M::prepare(&triangle, group))
    });
    let (per_ray, prepared_ray) = counted(|| M::prepare_ray(&ray(4.0), group));
    // The interval is made ready once per ray, outside the count.
    let interval = |tmax| Interval { tmin: number(0.0), tmax: number(tmax) };
    let test = |tmax, test: TestOf<M>| {
        let mut hit = false;
        let (ops, ()) = counted(|| test(&prepared_ray, &prepared, interval(tmax), &mut hit));
        (ops, hit)
    };
    let (test_early, hit_early) = test(4.0, run::<M, Early<TrueDivision, true>>);
    let (whole, hit_deferred) = test(4.0, run::<M, Deferred<TrueDivision, true>>);
    // Everything but t is in range: the early-out falls after the last comparison.
    let (test_deferred, missed) = test(2.0, run::<M, Deferred<TrueDivision, true>>);
    assert!(hit_early && hit_deferred && !missed, "the sample pair is decided wrongly");
    Cost {
        prepare,
        per_ray,
        test_early,
        test_deferred,
        finish_deferred: whole - test_deferred,
        stored_numbers: M::Prepared::NUMBERS,
    }
}

type TestOf<M> = fn(
    &<M as Method>::PreparedRay<Counting>,
    &trisect_core::Of<<M as Method>::Prepared, Counting>,
    Interval<Counting>,
    &mut bool,
);

fn run<M: Method, D: Division>(
    ray: &M::PreparedRay<Counting>,
    triangle: &trisect_core::Of<M::Prepared, Counting>,
    interval: Interval<Counting>,
    hit: &mut bool,
) {
    D::test::<M, Counting>(ray, triangle, interval, Culling::None, |mask, _| *hit = mask);
}

/// [`cost`] as the Markdown table that stands in a method's README.
///
/// # Panics
/// As [`cost`].
pub fn cost_table<M: Method>() -> String {
    let cost = cost::<M>();
    let mut table = String::from(
        "| | multiplies | adds | divisions | comparisons | sign flips |\n\
         | --- | --- | --- | --- | --- | --- |\n",
    );
    for (part, ops) in [
        ("prepare a triangle", cost.prepare),
        ("prepare a ray", cost.per_ray),
        ("test, early division", cost.test_early),
        ("test, deferred division", cost.test_deferred),
        ("finish a hit, deferred division", cost.finish_deferred),
    ] {
        let Ops { multiplies, adds, divisions, comparisons, signs } = ops;
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "| {part} | {multiplies} | {adds} | {divisions} | {comparisons} | {signs} |"
        );
    }
    let numbers = cost.stored_numbers;
    let _ = writeln!(
        table,
        "\nStored per triangle: {numbers} numbers, {} bytes in f32, {} in f64.",
        numbers * size_of::<f32>(),
        numbers * size_of::<f64>(),
    );
    table
}

const BEGIN: &str = "<!-- cost table, counted: TRISECT_BLESS=1 cargo test rewrites it -->\n";
const END: &str = "<!-- end of cost table -->";

/// `readme` with the text between its markers replaced by `table`; `None` without markers.
fn spliced(readme: &str, table: &str) -> Option<String> {
    let (head, rest) = readme.split_once(BEGIN)?;
    let (_, tail) = rest.split_once(END)?;
    Some(format!("{head}{BEGIN}\n{table}\n{END}{tail}"))
}

/// Holds the cost table in the README at `path` to [`cost_table`]; with `TRISECT_BLESS` set in
/// the environment, rewrites it.
///
/// # Panics
/// When the README cannot be read or written, has no markers, or another table.
pub fn readme_cost_table<M: Method>(path: &Path) {
    let readme = std::fs::read_to_string(path).expect("a method has a README");
    let wanted = spliced(&readme, &cost_table::<M>())
        .unwrap_or_else(|| panic!("{} lacks {BEGIN}{END}", path.display()));
    if std::env::var_os("TRISECT_BLESS").is_some() {
        std::fs::write(path, wanted).expect("blessing needs a README that can be written");
    } else {
        assert_eq!(
            readme,
            wanted,
            "the cost table of {} is out of date: TRISECT_BLESS=1 cargo test rewrites it",
            path.display()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splicing_replaces_what_is_between_the_markers_alone() {
        let readme = format!("a\n{BEGIN}old\n{END}\nb");
        let once = spliced(&readme, "new\n").expect("there are markers");
        assert_eq!(once, format!("a\n{BEGIN}\nnew\n\n{END}\nb"));
        assert_eq!(spliced(&once, "new\n").expect("there are markers"), once);
    }

    #[test]
    fn without_markers_there_is_nothing_to_splice() {
        assert_eq!(spliced("a", "b"), None);
    }
}
