//! What the testkit holds every method to.

trisect_testkit::conformance_tests! {
    exact: trisect_exact::Exact;
}
