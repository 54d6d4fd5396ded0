//! What the testkit holds every method to.

use trisect_method::Vertex;
use trisect_wald::{ByIndices, ByTable, Fixed, Grouped, Wald};

trisect_testkit::conformance_tests! {
    wald: Wald;
    table: Wald<ByTable>;
    indices: Wald<ByIndices>;
    fixed_axis: Wald<Fixed>;
    relative: Wald<Grouped, Vertex>;
}
