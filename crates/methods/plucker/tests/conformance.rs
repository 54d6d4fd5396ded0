//! What the testkit holds every method to.

use trisect_plucker::Plucker;

trisect_testkit::conformance_tests! {
    plucker: Plucker;
}
