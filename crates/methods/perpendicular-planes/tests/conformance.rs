//! What the testkit holds every method to.

use trisect_core::Vertex;
use trisect_perpendicular_planes::PerpendicularPlanes;

trisect_testkit::conformance_tests! {
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    world: PerpendicularPlanes, known_failures: ["S4-tiny/early"];
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    relative: PerpendicularPlanes<Vertex>, known_failures: ["S4-tiny/early"];
}
