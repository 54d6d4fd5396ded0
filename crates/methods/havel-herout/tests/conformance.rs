//! What the testkit holds every method to.

use trisect_havel_herout::HavelHerout;
use trisect_method::Vertex;

trisect_testkit::conformance_tests! {
    world: HavelHerout;
    relative: HavelHerout<Vertex>;
}
