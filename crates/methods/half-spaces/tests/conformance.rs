//! What the testkit holds every method to.

use trisect_half_spaces::HalfSpaces;

trisect_testkit::conformance_tests! {
    half_spaces: HalfSpaces;
}
