//! Calibrations from simulated measurements whose truth is known, and from measurements that
//! nothing can be made of.

mod distortion;
mod eyes;
mod noise;
mod pivot;
mod refused;
mod registration;
