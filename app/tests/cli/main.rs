//! The real program, run as people and scripts run it: arguments in, files and text out.
//!
//! Each test has a temporary folder of its own and no display.

mod bad_input;
mod bench;
#[cfg(unix)]
mod calibrate;
mod doctor;
mod fly;
mod formats;
#[cfg(unix)]
mod gloves;
mod help;
mod info;
mod output;
mod overwriting;
mod program;
mod recording;
mod render;
mod reproduce;
#[cfg(unix)]
mod serve_vrpn;
#[cfg(unix)]
mod simulate;
mod track;
