//! What the testkit holds every method to.

use trisect_angle_sum::AngleSum;

trisect_testkit::conformance_tests! {
    // Products of high degree in the edge underflow below an edge of about 1e-11.
    angle_sum: AngleSum, known_failures: ["S4-tiny/early"];
}
