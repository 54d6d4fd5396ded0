//! What the testkit holds every method to.

use trisect_signed_areas::SignedAreas;

trisect_testkit::conformance_tests! {
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    signed_areas: SignedAreas, known_failures: ["S4-tiny/early", "S4-tiny/deferred"];
}
