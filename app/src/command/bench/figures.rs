//! The figures of one caster in one view, under the names that other programs read.

use crate::command::bench::measure::Times;
use sandtable_cast::{Difference, Work};
use serde::Serialize;

/// One line of figures. Times and counts are there unless the view was refused.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Figures {
    pub(super) caster: String,
    pub(super) view: String,
    pub(super) threads: usize,
    pub(super) scheme: &'static str,
    pub(super) isa: &'static str,
    pub(super) median_ms: Option<f64>,
    pub(super) p5_ms: Option<f64>,
    pub(super) p95_ms: Option<f64>,
    pub(super) mpix_per_s: Option<f64>,
    /// Of the image of the first caster that took the view.
    pub(super) shade_only_ms: Option<f64>,
    pub(super) pixels: u64,
    pub(super) rays: Option<u64>,
    pub(super) rays_per_pixel: Option<f64>,
    pub(super) samples_per_ray: Option<f64>,
    pub(super) cells_per_ray: Option<f64>,
    /// Null where the caster does not suit the scene.
    pub(super) prepare_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) refused: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) check: Option<Check>,
    pub(super) first_picture_ms: Option<f64>,
    pub(super) peak_resident_bytes: Option<u64>,
    pub(super) resident_limit_bytes: u64,
}

impl Figures {
    /// Sets the times of a frame.
    pub(super) fn set_times(&mut self, times: &Times) {
        let median = times.median();
        self.median_ms = Some(median);
        self.p5_ms = Some(times.at(0.05));
        self.p95_ms = Some(times.at(0.95));
        self.mpix_per_s = Some(self.pixels as f64 / median / 1e3);
    }

    /// Sets the counts of a frame's work.
    pub(super) fn set_work(&mut self, work: Work) {
        let per_ray = |count: u64| count as f64 / work.rays.max(1) as f64;
        self.rays = Some(work.rays);
        self.rays_per_pixel = Some(work.rays as f64 / self.pixels.max(1) as f64);
        self.samples_per_ray = Some(per_ray(work.samples));
        self.cells_per_ray = Some(per_ray(work.cells));
    }
}

/// The distance from brute force.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Check {
    /// Infinite where sky and ground were taken for each other; JSON has no infinity: it is `null`.
    pub(super) max_cells: f64,
    pub(super) over_0_1_cell: u64,
    pub(super) over_0_5_cell: u64,
    pub(super) psnr_db: Option<f64>,
}

impl From<Difference> for Check {
    fn from(difference: Difference) -> Self {
        Self {
            max_cells: difference.max_cells,
            over_0_1_cell: difference.over_tenth_cell,
            over_0_5_cell: difference.over_half_cell,
            psnr_db: difference.psnr_db,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_without_a_number_is_null_in_json() {
        let check = Check {
            max_cells: f64::INFINITY,
            over_0_1_cell: 3,
            over_0_5_cell: 2,
            psnr_db: None,
        };
        let json = serde_json::to_value(&check).unwrap();
        assert!(json["max_cells"].is_null() && json["psnr_db"].is_null());
        assert_eq!(json["over_0_1_cell"], 3);
    }
}
