//! The GPU's frames against the CPU's, on whatever adapter there is (Mesa's lavapipe will do).

mod gpu_thread;

use self::gpu_thread::on_a_gpu;
use glam::DVec3;
use image::RgbaImage;
use sandtable_cast::Image;
use sandtable_stage::{Composing, FramePainter, Gpu, Panel, StereoMode, compose};
use sandtable_view::{Screen, View};

/// An image in which every pixel differs from its neighbours.
fn noise(size: [u32; 2], seed: u32) -> Image {
    let mut image = Image::default();
    image.reset(View {
        eye: DVec3::Z,
        window: Screen::horizontal(1.0, 1.0),
        size,
    });
    let mut state = seed;
    for pixel in image.colour_mut() {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let [a, b, c, _] = state.to_be_bytes();
        *pixel = [a, b, c, 255];
    }
    image
}

/// The largest difference of any channel of any pixel.
fn difference(a: &RgbaImage, b: &RgbaImage) -> u8 {
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

fn painter(gpu: &Gpu) -> FramePainter {
    FramePainter::new(gpu, wgpu::TextureFormat::Bgra8Unorm)
}

#[test]
fn every_mode_is_composed_as_on_the_cpu() {
    on_a_gpu(|gpu| {
        let mut painter = painter(&gpu);
        let frame = [250, 141];
        for mode in StereoMode::ALL {
            let exact = mode.eye_size(frame);
            for size in [exact, [exact[0] / 2, exact[1] / 2], [301, 97]] {
                let (left, right) = (noise(size, 1), noise(size, 2));
                painter
                    .set_images(&gpu, &[left.clone(), right.clone()])
                    .unwrap();
                for swap_eyes in [false, true] {
                    let composing = Composing { mode, swap_eyes };
                    let theirs = painter.capture(&gpu, frame, composing).unwrap();
                    let ours = compose(&left, &right, mode, swap_eyes, frame);
                    let off = difference(&ours, &theirs);
                    assert!(
                        off <= 1,
                        "{mode}, eyes of {size:?}, swap {swap_eyes}: {off}"
                    );
                }
            }
        }
        assert_eq!(gpu.take_error(), None);
    });
}

#[test]
fn an_encoding_target_shows_the_same_colours() {
    on_a_gpu(|gpu| {
        let frame = [64, 48];
        let (left, right) = (noise(frame, 3), noise(frame, 4));
        let mut painter = FramePainter::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb);
        painter
            .set_images(&gpu, &[left.clone(), right.clone()])
            .unwrap();
        let composing = Composing {
            mode: StereoMode::Anaglyph,
            swap_eyes: false,
        };
        let theirs = painter.capture(&gpu, frame, composing).unwrap();
        let ours = compose(&left, &right, StereoMode::Anaglyph, false, frame);
        assert!(difference(&ours, &theirs) <= 1);
    });
}

#[test]
fn frames_follow_every_resize() {
    on_a_gpu(|gpu| {
        let mut painter = painter(&gpu);
        let composing = Composing {
            mode: StereoMode::SideBySide,
            swap_eyes: false,
        };
        for step in 0..30 {
            let frame = [17 + step * 13 % 97, 1 + step * 29 % 83];
            let size = composing.mode.eye_size(frame);
            let (left, right) = (noise(size, step), noise(size, step + 100));
            painter
                .set_images(&gpu, &[left.clone(), right.clone()])
                .unwrap();
            let theirs = painter.capture(&gpu, frame, composing).unwrap();
            let ours = compose(&left, &right, composing.mode, false, frame);
            assert!(difference(&ours, &theirs) <= 1, "{frame:?}");
        }
        let empty = painter.capture(&gpu, [0, 40], composing).unwrap();
        assert_eq!(empty.dimensions(), (0, 40));
        assert_eq!(gpu.take_error(), None);
    });
}

#[test]
fn before_the_first_cast_the_frame_is_black_and_one_image_serves_both_eyes() {
    on_a_gpu(|gpu| {
        let mut painter = painter(&gpu);
        let composing = Composing {
            mode: StereoMode::TopBottom,
            swap_eyes: false,
        };
        painter.set_images(&gpu, &[]).unwrap();
        let black = painter.capture(&gpu, [8, 8], composing).unwrap();
        assert!(black.pixels().all(|pixel| pixel.0 == [0, 0, 0, 255]));
        let image = noise([8, 4], 9);
        painter
            .set_images(&gpu, std::slice::from_ref(&image))
            .unwrap();
        let theirs = painter.capture(&gpu, [8, 8], composing).unwrap();
        let ours = compose(&image, &image, StereoMode::TopBottom, false, [8, 8]);
        assert_eq!(ours, theirs);
    });
}

#[test]
fn the_panel_lies_over_the_frame_and_is_captured() {
    on_a_gpu(|gpu| {
        let mut painter = painter(&gpu);
        let image = noise([64, 64], 5);
        painter
            .set_images(&gpu, std::slice::from_ref(&image))
            .unwrap();
        let context = egui::Context::default();
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(
                egui::Pos2::ZERO,
                egui::vec2(64.0, 64.0),
            )),
            ..Default::default()
        };
        let output = context.run_ui(input, |ui| {
            let half = egui::Rect::from_min_size(egui::pos2(0.0, 32.0), egui::vec2(64.0, 32.0));
            ui.painter().rect_filled(half, 0, egui::Color32::GREEN);
        });
        let primitives = context.tessellate(output.shapes, output.pixels_per_point);
        painter.set_panel(
            &gpu,
            Panel {
                primitives,
                textures: output.textures_delta,
                pixels_per_point: output.pixels_per_point,
            },
        );
        let frame = painter
            .capture(&gpu, [64, 64], Composing::default())
            .unwrap();
        assert_eq!(frame.get_pixel(20, 60).0, [0, 255, 0, 255]);
        assert_eq!(frame.get_pixel(20, 10).0, image.colour()[10 * 64 + 20]);
        painter.set_panel(&gpu, Panel::default());
        let frame = painter
            .capture(&gpu, [64, 64], Composing::default())
            .unwrap();
        assert_eq!(frame.get_pixel(20, 60).0, image.colour()[60 * 64 + 20]);
    });
}

#[test]
fn an_image_too_large_for_the_gpu_is_refused_by_its_size() {
    on_a_gpu(|gpu| {
        let mut painter = painter(&gpu);
        let small = noise([4, 4], 6);
        painter
            .set_images(&gpu, std::slice::from_ref(&small))
            .unwrap();
        let wide = noise([gpu.longest_side() + 1, 1], 7);
        let error = painter.set_images(&gpu, &[wide]).unwrap_err().to_string();
        assert!(error.contains(&gpu.longest_side().to_string()), "{error}");
        let frame = painter.capture(&gpu, [4, 4], Composing::default()).unwrap();
        assert_eq!(frame.get_pixel(3, 3).0, small.colour()[15]);
    });
}

#[test]
fn a_lost_device_is_noticed_and_survived() {
    on_a_gpu(|gpu| {
        let mut painter = painter(&gpu);
        let image = noise([16, 16], 8);
        assert!(!gpu.is_lost());
        gpu.device.destroy();
        // The callback comes with the next poll; drawing with a lost device must not panic.
        let _ = painter.set_images(&gpu, std::slice::from_ref(&image));
        assert!(
            painter
                .capture(&gpu, [16, 16], Composing::default())
                .is_err()
        );
        assert!(gpu.is_lost());
    });
}
