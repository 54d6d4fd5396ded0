//! What the testkit holds every method to.

use trisect_plucker_translated::{PluckerTranslated, UnitInTheLastPlace};

trisect_testkit::conformance_tests! {
    exactly: PluckerTranslated;
    tolerance: PluckerTranslated<UnitInTheLastPlace>;
}
