#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod cost;
mod draw;
mod golden;
mod kernels;
pub mod lanes;
pub mod process;
pub mod properties;
mod readme;
mod subject;
mod truth;

pub use cost::{cost_table, readme_cost_tables};
pub use golden::golden_cases;
pub use subject::Subject;
pub use trisect_formula::{Cost, Ops, cost};

/// Stamps the tests that every method is held to, one `#[test]` per property: the properties of
/// one ray and one triangle, and the lanes, in a module for each method of the crate; then the
/// golden cases and the cost tables, as they stand in the README of the crate that calls.
///
/// ```text
/// trisect_testkit::conformance_tests! {
///     wald: trisect_wald::Wald;
/// }
/// ```
#[macro_export]
macro_rules! conformance_tests {
    ($($name:ident: $method:ty;)+) => {
        $(mod $name {
            #[allow(unused_imports, reason = "a method may be named by a path or not")]
            use super::*;
            $crate::conformance_tests!(@properties $method: properties
                formula_is_exact
                errors_are_within_the_claim
                corners_may_be_renamed
                translation_changes_no_more_than_claimed
                powers_of_two_scale_exactly
                culling_hides_one_side
                normals_are_normal
                nan_and_infinity_never_come_out
                degenerate_input_never_hits
                the_interval_is_closed
                any_bits_are_survived
            );
            $crate::conformance_tests!(@properties $method: lanes
                every_width_has_the_scalar_bits
                every_division_has_the_scalar_bits
                fused_and_newton_keep_the_claim
            );
        })+
        #[test]
        fn golden_cases() {
            let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
            $crate::golden_cases(readme.as_ref(), &[$($crate::Subject::of::<$method>()),+]);
        }
        #[test]
        fn readme_has_the_cost_tables() {
            let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
            $crate::readme_cost_tables(readme.as_ref(), &[$($crate::cost_table::<$method>()),+]);
        }
    };
    (@properties $method:ty: $module:ident $($property:ident)+) => {
        $(
            #[test]
            fn $property() {
                $crate::$module::$property(&$crate::Subject::of::<$method>());
            }
        )+
    };
}
