//! What the testkit holds every method to.

use trisect_signed_volumes::SignedVolumes;

trisect_testkit::conformance_tests! {
    signed_volumes: SignedVolumes;
}
