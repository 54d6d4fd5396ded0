//! What the testkit holds every method to.

use trisect_core::Vertex;
use trisect_unit_triangle::UnitTriangle;

trisect_testkit::conformance_tests! {
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    world: UnitTriangle, known_failures: ["S4-tiny/early", "S4-tiny/deferred"];
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    relative: UnitTriangle<Vertex>, known_failures: ["S4-tiny/early", "S4-tiny/deferred"];
}
