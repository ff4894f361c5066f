//! Calibration: from what a person touched, pivoted and sighted to the numbers of a rig.
//!
//! ```text
//! touched marks  --register-------> table_from_tracker, residuals, findings
//! pivoting poses --pivot----------> the stylus's tip (sensor axes)
//! sightings      --locate_eyes----> middle, rightwards, interpupillary (head sensor's axes)
//! field samples  --fit_distortion-> sandtable_field::Correction: measured place -> true place (table)
//! ```
//!
//! Right-handed, metres, radians, f64; a transform is named `target_from_source`. The *tracker*
//! frame is the transmitter's after the axis map, the *table* frame has its origin at the glass's
//! centre, x right, y away from the user, z up out of the glass.
//!
//! Everything here is mathematics: no device, no clock, no file, no random source. Each result
//! says how well the measurements agree on it ([`Residuals`]) and names those that disagree with
//! all others ([`Outlier`]); each refusal says what to do ([`CalibrationError`]). Indices count
//! from 0, texts from 1.
//!
//! ```
//! use glam::{DQuat, DVec3};
//! use sandtable_calibration::{Touch, register};
//! use sandtable_pose::Rigid;
//!
//! // A tracker that stands turned at the table's far edge.
//! let turn = DQuat::from_rotation_z(2.0);
//! let table_from_tracker = Rigid::new(turn, DVec3::new(0.1, 0.7, -0.2));
//! let marks = [[-0.9, -0.5, 0.0], [0.9, -0.5, 0.0], [0.9, 0.5, 0.0], [0.0, 0.1, 0.4]];
//! let touches = marks.map(DVec3::from_array).map(|marked| Touch {
//!     measured: table_from_tracker.inverse().point(marked),
//!     marked,
//! });
//!
//! let found = register(&touches)?;
//! assert!(found.residuals.rms < 1e-12);
//! assert!(found.findings.is_empty());
//! assert!((found.table_from_tracker.translation - table_from_tracker.translation).length() < 1e-12);
//!
//! // Axes that are left-handed are no rotation, and are refused.
//! let mirrored = touches.map(|t| Touch { measured: t.measured * DVec3::new(1.0, 1.0, -1.0), ..t });
//! assert!(register(&mirrored).unwrap_err().to_string().contains("left-handed"));
//! # Ok::<(), sandtable_calibration::CalibrationError>(())
//! ```
//!
//! Limits: noise is taken to be equal in all directions and at all places, as it is not far from a
//! magnetic transmitter; attitudes are never corrected; two outliers that agree can hide.
//!
//! Absolute orientation after Kabsch (1976) and Umeyama (1991); outliers by deletion after Cook
//! and Weisberg (1982); corrections of magnetic fields after Ghazisaedy and others (1995) and Ikits
//! and others (2001), by smoothing splines (Duchon 1977, Wahba 1990).

mod decomposition;
mod distortion;
mod error;
mod eyes;
mod item;
mod outlier;
mod pivot;
mod plausible;
mod registration;
mod residuals;
mod smoothing_spline;

pub use distortion::{DistortionFit, FieldSample, admit_field_marks, fit_distortion};
pub use error::CalibrationError;
pub use eyes::{Eye, Eyes, LocatedEyes, Side, Sighting, admit_pairs, locate_eye, locate_eyes};
pub use item::{Item, Items};
pub use outlier::Outlier;
pub use pivot::{Pivot, pivot};
pub use registration::{Finding, Registration, Touch, register};
pub use residuals::Residuals;
