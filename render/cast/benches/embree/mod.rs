//! Embree, in a process of its own that `embree.cpp` tells about.

mod compile;
mod process;

pub(crate) use compile::{Compiled, compiled};
pub(crate) use process::{Built, Embree, Geometry};
