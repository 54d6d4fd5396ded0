#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

use trisect_method::MethodVisitor;

include!(concat!(env!("OUT_DIR"), "/methods.rs"));
