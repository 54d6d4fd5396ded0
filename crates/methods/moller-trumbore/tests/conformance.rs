//! What the testkit holds every method to.

use trisect_moller_trumbore::{MollerTrumbore, PublishedOrder};

trisect_testkit::conformance_tests! {
    moller_trumbore: MollerTrumbore;
    order_1: PublishedOrder<1>;
    order_2: PublishedOrder<2>;
    order_3: PublishedOrder<3>;
    order_4: PublishedOrder<4>;
}
