//! What the testkit holds every method to.

trisect_testkit::conformance_tests!(
    trisect_perpendicular_planes::PerpendicularPlanes,
    // n² is of fourth degree in the edge, and underflows below an edge of about 1e-11.
    known_failures: ["S4-tiny/early", "S4-tiny/deferred"],
);
