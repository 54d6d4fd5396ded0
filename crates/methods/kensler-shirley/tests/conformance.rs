//! What the testkit holds every method to.

use trisect_kensler_shirley::{Edges, Everything, KenslerShirley, Points, PointsAndNormal};

trisect_testkit::conformance_tests! {
    edges: KenslerShirley<Edges>;
    points: KenslerShirley<Points>;
    normal: KenslerShirley<PointsAndNormal>;
    stored: KenslerShirley<Everything>;
}
