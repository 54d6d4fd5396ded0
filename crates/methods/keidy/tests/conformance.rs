//! What the testkit holds every method to.

use trisect_keidy::Keidy;

trisect_testkit::conformance_tests! {
    keidy: Keidy;
}
