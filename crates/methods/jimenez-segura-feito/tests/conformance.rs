//! What the testkit holds every method to.

use trisect_jimenez_segura_feito::JimenezSeguraFeito;

trisect_testkit::conformance_tests! {
    // gamma is what alpha and beta leave, so that a small one has the error of a number near 1.
    jimenez_segura_feito: JimenezSeguraFeito, known_failures: ["H1/early", "H1/deferred"];
}
