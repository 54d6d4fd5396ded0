//! What the testkit holds every method to.

use trisect_signed_areas::SignedAreas;

trisect_testkit::conformance_tests! {
    signed_areas: SignedAreas;
}
