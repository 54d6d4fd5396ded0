//! What the testkit holds every method to.

use trisect_badouel::{Badouel1990, BadouelCramer};
use trisect_core::Vertex;

trisect_testkit::conformance_tests! {
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    cramer: BadouelCramer, known_failures: ["S4-tiny/deferred"];
    branch: Badouel1990;
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    relative: BadouelCramer<Vertex>, known_failures: ["S4-tiny/deferred"];
}
