//! sandtable
fn main() {}
