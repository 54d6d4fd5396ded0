//! What the testkit holds every method to.

use trisect_arenberg::Arenberg;

trisect_testkit::conformance_tests! {
    arenberg: Arenberg;
}
