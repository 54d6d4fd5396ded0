//! What the testkit holds every method to.

use trisect_core::Vertex;
use trisect_havel_herout::HavelHerout;

trisect_testkit::conformance_tests! {
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    world: HavelHerout, known_failures: ["S4-tiny/deferred"];
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    relative: HavelHerout<Vertex>, known_failures: ["S4-tiny/deferred"];
}
