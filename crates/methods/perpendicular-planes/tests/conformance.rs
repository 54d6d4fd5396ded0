//! What the testkit holds every method to.

use trisect_method::Vertex;
use trisect_perpendicular_planes::PerpendicularPlanes;

trisect_testkit::conformance_tests! {
    world: PerpendicularPlanes;
    relative: PerpendicularPlanes<Vertex>;
}
