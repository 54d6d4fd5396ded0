//! What the testkit holds every method to.

use trisect_jimenez_segura_feito::JimenezSeguraFeito;

trisect_testkit::conformance_tests! {
    jimenez_segura_feito: JimenezSeguraFeito;
}
