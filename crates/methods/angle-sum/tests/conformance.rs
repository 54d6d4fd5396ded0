//! What the testkit holds every method to.

use trisect_angle_sum::AngleSum;

trisect_testkit::conformance_tests! {
    angle_sum: AngleSum;
}
