//! `sandtable render`: one image, or a flight along a track.

use crate::cli::{RenderArgs, StereoArg};
use crate::exit::usage;
use crate::files::{check_depth_name, image_form, write_depth, write_image};
use crate::film::whole_frame;
use crate::{overwriting, scene, track};
use anyhow::{Context, Result};
use image::RgbaImage;
use sandtable_cast::{CastPool, Image};
use sandtable_stage::compose_into;
use sandtable_view::{View, ViewFile, ViewFileError};
use std::path::Path;
use std::sync::Arc;

pub(crate) fn run(args: &RenderArgs) -> Result<()> {
    // Before anything is read or cast: a wrong name should cost neither a wait nor a file.
    refuse_overwriting(args)?;
    if args.path.is_none() {
        image_form(&args.output)?;
    }
    args.depth.as_deref().map_or(Ok(()), check_depth_name)?;
    let caster = scene::caster_at_detail(&args.caster, args.lod, false)?;
    let view_file = args.view.as_deref().map(read_view).transpose()?;
    if let Some(path) = &args.path {
        return track::render(args, path, view_file.as_ref(), &caster);
    }
    let (path, view_file) = args
        .view
        .as_deref()
        .zip(view_file)
        .ok_or_else(|| usage("a view file is needed: --view FILE"))?;
    let views = views(&view_file, args.stereo)
        .map_err(|error| usage(format_args!("in the view file {}: {error}", path.display())))?;
    let open = scene::open(&args.terrain)?;
    let pool = CastPool::new(args.threads)
        .context("cannot start the casting threads")?
        .with_scheme(args.scheme);
    let prepared = pool.run(|| caster.caster.prepare(Arc::clone(&open.scene)))?;
    // Before the cast, which is lost where there is no memory for what is written of it.
    let mut frame = blank(whole_frame(args.stereo.mode(), view_file.size()))?;
    let mut images = vec![Image::default(); views.len()];
    pool.cast(&*prepared, &views, &mut images)?;

    compose_into(
        &images[0],
        images.last().unwrap_or(&images[0]),
        args.stereo.mode(),
        false,
        &mut frame,
    );
    write_image(&args.output, &frame)?;
    if let Some(path) = &args.depth {
        write_depth(path, &images[0])?;
    }
    Ok(())
}

/// Refuses outputs that would take the place of what is read, or of one another.
fn refuse_overwriting(args: &RenderArgs) -> Result<()> {
    let [terrain, photo] = args.terrain.files();
    overwriting::refuse(
        [
            terrain,
            photo,
            ("the view", args.view.as_deref()),
            ("the track", args.path.as_deref()),
        ],
        [
            ("--output", Some(&*args.output)),
            ("--depth", args.depth.as_deref()),
            ("--audio", args.audio.as_deref()),
        ],
    )
}

/// Reads a view file, naming it in errors.
pub(crate) fn read_view(path: &Path) -> Result<ViewFile> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("cannot read the view file {}", path.display()))?;
    ViewFile::parse(&text).with_context(|| format!("in the view file {}", path.display()))
}

/// One view, or two where the mode shows two.
fn views(file: &ViewFile, stereo: StereoArg) -> Result<Vec<View>, ViewFileError> {
    match stereo {
        StereoArg::Mono => Ok(vec![file.mono()]),
        _ => Ok(file.stereo()?.into_array().to_vec()),
    }
}

/// A frame in which each eye has its own full size, to be filled.
fn blank([width, height]: [u32; 2]) -> Result<RgbaImage> {
    let bytes = 4 * width as usize * height as usize;
    let mut pixels = Vec::new();
    let given = pixels.try_reserve_exact(bytes);
    given.ok().with_context(|| {
        format!(
            "a picture of {width} by {height} pixels needs {} MiB of memory, which the system does \
             not give; make `size` in the view file smaller",
            bytes >> 20
        )
    })?;
    pixels.resize(bytes, 0);
    RgbaImage::from_raw(width, height, pixels).context("a picture has four bytes a pixel")
}
