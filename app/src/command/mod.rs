//! The commands, a file or folder each.

pub(crate) mod bench;
pub(crate) mod calibrate;
pub(crate) mod casters;
pub(crate) mod doctor;
pub(crate) mod fly;
pub(crate) mod info;
pub(crate) mod record;
pub(crate) mod render;
pub(crate) mod reproduce;
pub(crate) mod serve_vrpn;
pub(crate) mod simulate;
