//! sandtable
mod video;

fn main() {}
