//! What the testkit holds every method to.

use trisect_keidy::Keidy;

trisect_testkit::conformance_tests! {
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    keidy: Keidy, known_failures: ["S4-tiny/early", "S4-tiny/deferred"];
}
