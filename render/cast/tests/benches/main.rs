//! What the benches measure is what their tables say.

#![allow(dead_code, reason = "tests use parts of what the benches use")]

#[path = "../../benches/contest/mod.rs"]
mod contest;
#[path = "../../benches/embree/mod.rs"]
mod embree;
#[path = "../../benches/scenes/mod.rs"]
mod scenes;

mod terrains;
mod turns;
mod views;
#[path = "../../benches/warm_up.rs"]
mod warm_up;
