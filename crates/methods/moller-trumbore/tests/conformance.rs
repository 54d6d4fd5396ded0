//! What the testkit holds every method to.

trisect_testkit::conformance_tests!(trisect_moller_trumbore::MollerTrumbore);
