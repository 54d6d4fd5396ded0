//! The lines of `trisect-by-hand`.

use trisect_machine::forms::{Border, CallTime, FormTime, LeafTime};

use crate::record::lines;

lines! {
    FormTime = "form",
    Border = "border",
    LeafTime = "leaf",
    CallTime = "call",
}
