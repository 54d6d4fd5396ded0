//! What the testkit holds every method to.

use trisect_badouel::{Badouel1990, BadouelCramer};
use trisect_method::Vertex;

trisect_testkit::conformance_tests! {
    cramer: BadouelCramer;
    branch: Badouel1990;
    relative: BadouelCramer<Vertex>;
}
