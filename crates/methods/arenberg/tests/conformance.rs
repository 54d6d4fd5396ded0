//! What the testkit holds every method to.

use trisect_arenberg::Arenberg;

trisect_testkit::conformance_tests! {
    // gamma is what alpha and beta leave, so that a small one has the error of a number near 1.
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    arenberg: Arenberg, known_failures: ["H1/early", "S4-tiny/early", "H1/deferred", "S4-tiny/deferred"];
}
