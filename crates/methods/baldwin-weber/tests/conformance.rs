//! What the testkit holds every method to.

use trisect_baldwin_weber::{BaldwinWeber9, BaldwinWeber12};
use trisect_method::Vertex;

trisect_testkit::conformance_tests! {
    nine: BaldwinWeber9;
    twelve: BaldwinWeber12;
    nine_relative: BaldwinWeber9<Vertex>;
    twelve_relative: BaldwinWeber12<Vertex>;
}
