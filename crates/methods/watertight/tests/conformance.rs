//! What the testkit holds every method to.

use trisect_watertight::{OnePrecision, ShearFirst, Watertight};

trisect_testkit::conformance_tests! {
    watertight: Watertight;
    one_precision: Watertight<OnePrecision>;
    packet: Watertight<OnePrecision, ShearFirst>;
}
