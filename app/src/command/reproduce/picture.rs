//! Images of a report: what was cast, crops of it, depth, strips.

use super::report::Picture;
use super::trial::Attempt;
use image::{GrayImage, Luma, RgbaImage, imageops};
use sandtable_cast::Image;

impl Picture {
    /// A picture of `file` (a name without its ending) under `caption`.
    pub(super) fn new(
        file: impl Into<String>,
        caption: impl Into<String>,
        image: RgbaImage,
    ) -> Self {
        Self {
            file: format!("{}.png", file.into()),
            caption: caption.into(),
            image,
        }
    }

    /// What an attempt cast first, unless it failed.
    pub(super) fn of(attempt: &Attempt, file: &str, caption: &str) -> Option<Self> {
        let outcome = attempt.as_ref().ok()?;
        Some(Self::new(file, caption, colours(&outcome.images[0])))
    }
}

/// The colours of an image.
pub(super) fn colours(image: &Image) -> RgbaImage {
    let bytes: &[u8] = bytemuck::cast_slice(image.colour());
    RgbaImage::from_raw(image.width(), image.height(), bytes.to_vec())
        .expect("an image has four bytes a pixel")
}

/// A part of an image, `times` as large: its left, top, width and height in pixels.
pub(super) fn enlarged(image: &RgbaImage, [x, y, w, h]: [u32; 4], times: u32) -> RgbaImage {
    let part = imageops::crop_imm(image, x, y, w, h).to_image();
    imageops::resize(&part, w * times, h * times, imageops::FilterType::Nearest)
}

/// Images beside each other, all of the first one's size.
pub(super) fn strip(images: &[Image]) -> Option<RgbaImage> {
    let first = images.first()?;
    let [width, height] = [first.width(), first.height()];
    let mut strip = RgbaImage::new(width * images.len() as u32, height);
    for (place, image) in images.iter().enumerate() {
        let x = i64::from(width) * place as i64;
        imageops::replace(&mut strip, &colours(image), x, 0);
    }
    Some(strip)
}

/// Depth as Szenberg, Gattass and Carvalho (1997) keep it, from black near to white far: slice i of
/// n to f has (f − f·n/i)/(f − n).
///
/// A slice is a plane parallel to the window; here n and f are the nearest and the farthest that
/// were hit. Sky is white.
pub(super) fn slice_depth(image: &Image) -> RgbaImage {
    let window = image.view.window;
    let across = window.lower_right - window.lower_left;
    let up = window.upper_left - window.lower_left;
    let normal = across.cross(up).normalize_or_zero();
    let slices: Vec<f64> = (0..image.height())
        .flat_map(|j| (0..image.width()).map(move |i| (i, j)))
        .map(|(i, j)| {
            let hit = image.point(i, j);
            hit.map_or(f64::INFINITY, |hit| {
                (hit - image.view.eye).dot(normal).abs()
            })
        })
        .collect();
    let hits = slices.iter().copied().filter(|slice| slice.is_finite());
    let (near, far) = hits.fold((f64::INFINITY, 0.0_f64), |(near, far), slice| {
        (near.min(slice), far.max(slice))
    });
    let near = near.max(f64::MIN_POSITIVE);
    let grey = GrayImage::from_fn(image.width(), image.height(), |i, j| {
        let slice = slices[(j * image.width() + i) as usize];
        let depth = if slice.is_finite() && far > near {
            (far - far * near / slice) / (far - near)
        } else {
            1.0
        };
        Luma([(255.0 * depth.clamp(0.0, 1.0) + 0.5) as u8])
    });
    image::DynamicImage::ImageLuma8(grey).into_rgba8()
}
