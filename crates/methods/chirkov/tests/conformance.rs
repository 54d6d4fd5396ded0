//! What the testkit holds every method to.

use trisect_chirkov::Chirkov;
use trisect_method::Vertex;

trisect_testkit::conformance_tests! {
    world: Chirkov;
    relative: Chirkov<Vertex>;
}
