//! The voxel model of Wan, Qu and Kaufman (1999): its size, and what its filters do for the image.

use super::Setup;
use super::picture::{colours, enlarged};
use super::report::{Cell, Picture, Report, Table};
use super::trial::{Trial, prepared};
use super::truth::{SIDE, Truth};
use crate::command::bench::measure::timed;
use anyhow::Result;
use sandtable_cast::Scene;
use sandtable_terrain::{DensityFilter, VoxelError, VoxelShape, VoxelVolume};
use sandtable_view::View;
use std::sync::Arc;

/// Slices of the paper's volume.
pub(super) const LEVELS: u32 = 64;

/// A ridge near the eye, where voxels are large and edges sharp, in pixels.
const CROP: [u32; 4] = [300, 90, 80, 60];

/// The voxel model's size and the time it takes to build, for each filter.
pub(super) fn size(setup: &Setup, scene: &Scene) -> Result<Table> {
    let ground = &scene.ground;
    let shape = VoxelShape::with_levels(ground, LEVELS)?;
    let mut table = Table::new(
        format!(
            "The volume, packed down to what lies near the surface; built on {} threads.",
            setup.many.threads()
        ),
        &[
            "filter",
            "full MiB",
            "packed MiB",
            "bytes a column",
            "with boundary array MiB",
            "built in ms",
        ],
    );
    let mib = |bytes: usize| Cell::Number(bytes as f64 / f64::from(1 << 20), 2);
    for (label, filter) in [
        ("none", DensityFilter::None),
        (
            "oriented box, 2 voxels wide",
            DensityFilter::OrientedBox { width: 2.0 },
        ),
        (
            "Gaussian, sigma 1 voxel",
            DensityFilter::Gaussian { sigma: 1.0 },
        ),
    ] {
        let build = || -> Result<_, VoxelError> {
            let volume = VoxelVolume::new(ground, shape, filter)?;
            let boundary = volume.boundary(127);
            Ok((volume, boundary))
        };
        let (built, ms) = timed(|| setup.many.run(build));
        let (volume, boundary) = built?;
        let columns = ground.grid().posts() as f64;
        table.row([
            label.into(),
            mib(volume.full_bytes()),
            mib(volume.bytes()),
            Cell::Number(volume.bytes() as f64 / columns, 1),
            mib(volume.bytes() + boundary.bytes()),
            Cell::Number(ms, 0),
        ]);
    }
    Ok(table)
}

/// How near casters with and without antialiasing come to what a pixel ought to show.
pub(super) fn antialiasing(
    report: &mut Report,
    setup: &Setup,
    scene: &Arc<Scene>,
    view: &View,
) -> Result<()> {
    let truth = Truth::cast(&setup.many, scene, view)?;
    let mut table = Table::new(
        format!("Colours against the truth: the mean of {SIDE} by {SIDE} exact rays a pixel."),
        &["caster", "PSNR dB"],
    );
    let mut pictures = Vec::new();
    for (file, text, caption) in [
        (
            "edge-boundary",
            "boundary?levels=64",
            "boundary cells alone",
        ),
        (
            "edge-nearest",
            "inclined-corrected?posts=nearest",
            "nearest posts",
        ),
        (
            "edge-binary",
            "volume?levels=64&filter=none",
            "volume without a filter",
        ),
        (
            "edge-volume",
            "volume?levels=64",
            "volume under an oriented box filter",
        ),
    ] {
        let prepared = prepared(&setup.many, scene, text)?;
        let outcome = Trial::new(&prepared, &setup.many, *view).images();
        match outcome {
            Ok(images) => {
                let image = colours(&images[0]);
                table.row([
                    format!("{text}: {caption}").into(),
                    Cell::Number(truth.psnr_db(&image), 1),
                ]);
                pictures.push(Picture::new(file, caption, enlarged(&image, CROP, 4)));
            }
            Err(error) => table.row([text.into(), Cell::Refused(error.to_string())]),
        }
    }
    let image = truth.image();
    pictures.push(Picture::new(
        "edge-truth",
        "the truth",
        enlarged(&image, CROP, 4),
    ));
    report.table(table);
    report.figure(5, pictures);
    Ok(())
}
