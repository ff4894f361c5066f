//! Composition on the CPU: two eyes' images to one frame, for files and for machines with no GPU.
//!
//! The shader `compositor.wgsl` does the same arithmetic; a test compares the two.

use crate::StereoMode;
use image::{Rgba, RgbaImage};
use sandtable_cast::Image;
use sandtable_view::StereoPair;

/// A place in an eye's image, as shares of its width and height from the upper left corner.
#[derive(Clone, Copy)]
struct Place {
    x: f32,
    y: f32,
}

/// Composes a frame of `size` pixels from the eyes' images.
///
/// With `swap` the eyes change places, for glasses or projectors that are the other way round.
/// Mono shows the left image (the right one with `swap`). Anaglyph takes red from the left and
/// green and blue from the right image as they are: every pair of red-cyan glasses separates
/// these, the colours of the terrain stay recognisable, and no channel mixes the eyes. Images that
/// are larger or smaller than their share of the frame are sampled bilinearly; at the size that
/// [`StereoMode::eye_size`] names, pixels are copied. An image without pixels is black.
#[must_use]
pub fn compose(
    left: &Image,
    right: &Image,
    mode: StereoMode,
    swap: bool,
    size: [u32; 2],
) -> RgbaImage {
    let mut frame = RgbaImage::new(size[0], size[1]);
    compose_into(left, right, mode, swap, &mut frame);
    frame
}

/// As [`compose`], into a frame that is there already, whatever it holds.
pub fn compose_into(
    left: &Image,
    right: &Image,
    mode: StereoMode,
    swap: bool,
    frame: &mut RgbaImage,
) {
    let pair = StereoPair { left, right };
    let StereoPair { left, right } = if swap { pair.swapped() } else { pair };
    let size = [frame.width(), frame.height()];
    let [width, height] = size;
    for (i, j, pixel) in frame.enumerate_pixels_mut() {
        // The pixel's centre within the part of the frame from `first` to `end`.
        let place = |first: [u32; 2], end: [u32; 2]| Place {
            x: ((i - first[0]) as f32 + 0.5) / (end[0] - first[0]) as f32,
            y: ((j - first[1]) as f32 + 0.5) / (end[1] - first[1]) as f32,
        };
        let whole = || place([0, 0], size);
        *pixel = Rgba(match mode {
            StereoMode::Mono => sample(left, whole()),
            StereoMode::SideBySide => {
                let middle = width / 2;
                if i < middle {
                    sample(left, place([0, 0], [middle, height]))
                } else {
                    sample(right, place([middle, 0], size))
                }
            }
            StereoMode::TopBottom => {
                let middle = height / 2;
                if j < middle {
                    sample(left, place([0, 0], [width, middle]))
                } else {
                    sample(right, place([0, middle], size))
                }
            }
            StereoMode::Anaglyph => {
                let [red, ..] = sample(left, whole());
                let [_, green, blue, _] = sample(right, whole());
                [red, green, blue, 255]
            }
        });
    }
}

/// The image's colour at `place`, bilinear between pixel centres, in the encoded (sRGB) values.
fn sample(image: &Image, place: Place) -> [u8; 4] {
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return [0, 0, 0, 255];
    }
    let (i0, i1, u) = neighbours(place.x, width);
    let (j0, j1, v) = neighbours(place.y, height);
    let at = |i: usize, j: usize| image.colour()[j * width as usize + i];
    let (a, b, c, d) = (at(i0, j0), at(i1, j0), at(i0, j1), at(i1, j1));
    std::array::from_fn(|channel| {
        let [a, b, c, d] = [a, b, c, d].map(|colour| f32::from(colour[channel]));
        let (upper, lower) = (a + (b - a) * u, c + (d - c) * u);
        (upper + (lower - upper) * v).round() as u8
    })
}

/// The two pixels between whose centres `share` of `count` pixels lies, and how far along.
fn neighbours(share: f32, count: u32) -> (usize, usize, f32) {
    let last = (count - 1) as f32;
    let place = (share * count as f32 - 0.5).clamp(0.0, last);
    // Rounding of the share must not blur pixels that are meant to be copied.
    let nearest = place.round();
    let place = if (place - nearest).abs() < 1.0 / 256.0 {
        nearest
    } else {
        place
    };
    let first = place.floor();
    let second = (first + 1.0).min(last);
    (first as usize, second as usize, place - first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use sandtable_view::{Screen, View};

    fn image(size: [u32; 2], colour: impl Fn(u32, u32) -> [u8; 3]) -> Image {
        let mut image = Image::default();
        image.reset(View {
            eye: DVec3::Z,
            window: Screen::horizontal(1.0, 1.0),
            size,
        });
        for (index, pixel) in image.colour_mut().iter_mut().enumerate() {
            let index = index as u32;
            let [r, g, b] = colour(index % size[0], index / size[0]);
            *pixel = [r, g, b, 255];
        }
        image
    }

    fn coded(base: u8) -> impl Fn(u32, u32) -> [u8; 3] {
        move |i, j| [base + i as u8, base + j as u8, base]
    }

    #[test]
    fn eyes_cast_at_their_size_are_copied_pixel_by_pixel() {
        let frame = [600, 90];
        for (mode, second) in [
            (StereoMode::SideBySide, [300, 0]),
            (StereoMode::TopBottom, [0, 45]),
        ] {
            let size = mode.eye_size(frame);
            let hash = |i: u32, j: u32| [(i * 37 + j * 101) as u8, (i ^ j) as u8, i as u8];
            let left = image(size, hash);
            let right = image(size, |i, j| hash(i + 1000, j));
            for swap in [false, true] {
                let composed = compose(&left, &right, mode, swap, frame);
                let at = |eye: &Image, origin: [u32; 2]| {
                    (0..size[1]).all(|j| {
                        (0..size[0]).all(|i| {
                            composed.get_pixel(origin[0] + i, origin[1] + j).0
                                == eye.colour()[(j * size[0] + i) as usize]
                        })
                    })
                };
                let (first, last) = if swap {
                    (&right, &left)
                } else {
                    (&left, &right)
                };
                assert!(at(first, [0, 0]) && at(last, second), "{mode} {swap}");
            }
        }
    }

    #[test]
    fn anaglyph_is_red_of_the_left_and_cyan_of_the_right_eye() {
        let left = image([3, 2], |_, _| [200, 10, 20]);
        let right = image([3, 2], |_, _| [5, 120, 130]);
        let plain = compose(&left, &right, StereoMode::Anaglyph, false, [3, 2]);
        assert!(plain.pixels().all(|p| p.0 == [200, 120, 130, 255]));
        let swapped = compose(&left, &right, StereoMode::Anaglyph, true, [3, 2]);
        assert!(swapped.pixels().all(|p| p.0 == [5, 10, 20, 255]));
    }

    #[test]
    fn mono_shows_one_eye_and_swapping_shows_the_other() {
        let (left, right) = (image([4, 3], coded(10)), image([4, 3], coded(100)));
        let shown = |swap| compose(&left, &right, StereoMode::Mono, swap, [4, 3]);
        assert_eq!(shown(false).get_pixel(2, 1).0, [12, 11, 10, 255]);
        assert_eq!(shown(true).get_pixel(2, 1).0, [102, 101, 100, 255]);
    }

    #[test]
    fn an_odd_width_keeps_both_eyes_whole() {
        let left = image([3, 1], |_, _| [40, 0, 0]);
        let right = image([3, 1], |_, _| [0, 40, 0]);
        let composed = compose(&left, &right, StereoMode::SideBySide, false, [5, 1]);
        let reds: Vec<u8> = composed.pixels().map(|p| p.0[0]).collect();
        assert_eq!(reds, [40, 40, 0, 0, 0]);
    }

    #[test]
    fn a_half_sized_image_is_enlarged_bilinearly() {
        let ramp = image([2, 1], |i, _| [i as u8 * 100, 0, 0]);
        let composed = compose(&ramp, &ramp, StereoMode::Mono, false, [4, 1]);
        let reds: Vec<u8> = composed.pixels().map(|p| p.0[0]).collect();
        assert_eq!(reds, [0, 25, 75, 100]);
    }

    #[test]
    fn nothing_cast_yet_is_black_and_an_empty_frame_is_empty() {
        let none = Image::default();
        let composed = compose(&none, &none, StereoMode::SideBySide, false, [4, 2]);
        assert!(composed.pixels().all(|p| p.0 == [0, 0, 0, 255]));
        for mode in StereoMode::ALL {
            assert_eq!(compose(&none, &none, mode, false, [0, 0]).len(), 0);
            assert_eq!(compose(&none, &none, mode, false, [1, 1]).len(), 4);
        }
    }
}
