//! What the testkit holds every method to.

use trisect_method::Vertex;
use trisect_unit_triangle::UnitTriangle;

trisect_testkit::conformance_tests! {
    world: UnitTriangle;
    relative: UnitTriangle<Vertex>;
}
