//! What the testkit holds every method to.

use trisect_core::Vertex;
use trisect_havel_herout::HavelHerout;

trisect_testkit::conformance_tests! {
    world: HavelHerout;
    relative: HavelHerout<Vertex>;
}
