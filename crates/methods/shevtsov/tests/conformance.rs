//! What the testkit holds every method to.

use trisect_method::Vertex;
use trisect_shevtsov::Shevtsov;

trisect_testkit::conformance_tests! {
    shevtsov: Shevtsov;
    relative: Shevtsov<Vertex>;
}
