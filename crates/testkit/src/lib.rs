//! testkit
#![forbid(unsafe_code)]

mod cost;
mod counting;
mod draw;
pub mod lanes;
pub mod properties;
mod truth;

pub use cost::{Cost, cost, cost_table, readme_cost_table};
pub use counting::{Counting, Ops, counted};

/// Stamps tests.
#[macro_export]
macro_rules! conformance_tests {
    ($method:ty $(, known_failures: [$($failure:literal),* $(,)?])? $(,)?) => {
        $crate::conformance_tests!(@properties $method: properties
            formula_is_exact
            errors_are_within_the_claim
            corners_may_be_renamed
            translation_changes_no_more_than_claimed
            powers_of_two_scale_exactly
            culling_hides_one_side
            nan_and_infinity_never_come_out
            degenerate_input_never_hits
            the_interval_is_closed
            any_bits_are_survived
        );
        $crate::conformance_tests!(@properties $method: lanes
            every_width_has_the_scalar_bits
            leaving_early_changes_no_bit
            fused_and_newton_keep_the_claim
        );
    };
    (@properties $method:ty: $module:ident $($property:ident)+) => {
        $(
            #[test]
            fn $property() {
                $crate::$module::$property::<$method>();
            }
        )+
    };
}
