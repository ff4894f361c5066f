//! sandtable
mod doctor;
mod video;

fn main() {}
