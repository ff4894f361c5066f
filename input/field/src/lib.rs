//! Field: how bent a magnetic tracker's field is, as a grid that straightens its poses.
//!
//! ```text
//! samples --sandtable-calibration--> Correction --file beside the rig--> every sample's place
//! ```
//!
//! Table frame, metres, f64. A crate of its own because calibration makes a [`Correction`], a rig
//! holds it and every tracker's stream asks it, and neither of these needs the mathematics of the
//! fit. No device, no clock, no file.
//!
//! ```
//! use glam::{DVec3, UVec3};
//! use sandtable_field::Correction;
//!
//! // The field pushes places to the right, by 1 cm for each metre away from the user.
//! let push = |place: DVec3| DVec3::new(-0.01 * place.y, 0.0, 0.0);
//! let correction = Correction::sampled(DVec3::ZERO, DVec3::ONE, UVec3::splat(2), push)?;
//! let corrected = correction.correct(DVec3::new(0.505, 0.5, 0.2));
//! assert!(corrected.distance(DVec3::new(0.5, 0.5, 0.2)) < 1e-12);
//! # Ok::<(), sandtable_field::CorrectionError>(())
//! ```
//!
//! Limits: places only, attitudes stay as measured; one field for all sensors, constant in time.
//!
//! The look-up table of Ghazisaedy and others (1995).

mod correction;

pub use correction::{Correction, CorrectionError, fade};
