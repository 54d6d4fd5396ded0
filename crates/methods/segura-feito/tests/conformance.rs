//! What the testkit holds every method to.

use trisect_segura_feito::SeguraFeito;

trisect_testkit::conformance_tests! {
    segura_feito: SeguraFeito;
}
