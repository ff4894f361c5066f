//! The mesh against brute force, on whatever adapter there is (Mesa's lavapipe will do).

#[path = "../../../../../render/stage/tests/offscreen/gpu_thread.rs"]
mod gpu_thread;

use self::gpu_thread::on_a_gpu;
use super::*;
use image::Rgba;
use sandtable_cast::{Brute, CastPool, Image, Scene, standpoints};
use sandtable_terrain::{Photo, TerrainSource, TiledRaster};
use sandtable_view::{Attitude, Camera};

fn ridges(size: u32) -> Ground {
    let source = TerrainSource::Ridges { size, seed: 0 };
    sandtable_terrain::open(&source, None).unwrap().ground
}

fn brute(ground: &Ground, view: View) -> Image {
    let pool = CastPool::new(0).unwrap();
    let scene = Scene::new(ground.clone());
    pool.picture(&Brute, &scene, view).unwrap()
}

/// What brute force sees in a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    Surface(DVec3),
    /// The terrain's side, which the mesh has not.
    Wall,
    Sky,
}

fn seen(ground: &Ground, exact: &Image) -> Vec<Seen> {
    // A wall's top lies as near to the surface as one likes.
    let tolerance = 1e-4 * ground.grid().cell_length();
    let pixel = |i, j| match exact.point(i, j) {
        None => Seen::Sky,
        Some(point) => match ground.height_at(point.x, point.y) {
            Some(height) if (height - point.z).abs() < tolerance => Seen::Surface(point),
            _ => Seen::Wall,
        },
    };
    let [width, height] = exact.view.size;
    (0..height)
        .flat_map(|j| (0..width).map(move |i| (i, j)))
        .map(|(i, j)| pixel(i, j))
        .collect()
}

fn is_ground(pixel: &Rgba<u8>) -> bool {
    pixel.0[..3] != SKY
}

/// PSNR in dB of the mesh's colours over the pixels in which both show the surface.
fn psnr(mesh: &RgbaImage, exact: &Image, seen: &[Seen]) -> f64 {
    let mut squares = 0.0;
    let mut count = 0.0;
    for ((found, wanted), seen) in mesh.pixels().zip(exact.colour()).zip(seen) {
        if matches!(seen, Seen::Surface(_)) && is_ground(found) {
            for (&found, &wanted) in found.0.iter().zip(wanted).take(3) {
                squares += (f64::from(found) - f64::from(wanted)).powi(2);
                count += 1.0;
            }
        }
    }
    assert!(count > 0.0, "no pixel shows ground");
    10.0 * (255.0 * 255.0 * count / squares).log10()
}

/// Share of the pixels, walls apart, for which mesh and brute force do not agree within a pixel
/// on whether there is ground.
fn off_silhouette(mesh: &RgbaImage, seen: &[Seen]) -> f64 {
    let [width, height] = [mesh.width() as i32, mesh.height() as i32];
    let at = |x: i32, y: i32| seen[(y * width + x) as usize];
    let agrees = |x: i32, y: i32, ground: bool| match at(x, y) {
        Seen::Surface(_) => ground,
        Seen::Wall => false,
        Seen::Sky => !ground,
    };
    let mut off = 0;
    for (x, y, pixel) in mesh.enumerate_pixels() {
        let (x, y) = (x as i32, y as i32);
        let (columns, rows) = (
            (x - 1).max(0)..=(x + 1).min(width - 1),
            (y - 1).max(0)..=(y + 1).min(height - 1),
        );
        let ground = is_ground(pixel);
        let mut near = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        let agreed = at(x, y) == Seen::Wall || near.any(|(x, y)| agrees(x, y, ground));
        off += u32::from(!agreed);
    }
    f64::from(off) / seen.len() as f64
}

/// The ground with each post's height taken from elsewhere.
fn rearranged(ground: &Ground, from: impl Fn(u32, u32) -> (u32, u32) + Sync) -> Ground {
    let Grid {
        cols,
        rows,
        spacing,
    } = ground.grid();
    let height = |col, row| {
        let (col, row) = from(col, row);
        ground.heights().post(col, row)
    };
    Ground::from_fn(cols, rows, spacing, height).unwrap()
}

/// PSNR in dB that a mesh reaches and no wrongly placed one does. Triangles are flat where brute
/// force's cells are bilinear, which costs most along the ridges.
const LEAST_DB: f64 = 36.0;

/// Asserts that the mesh of `ground` shows what brute force does, and that none of a ground that
/// is mirrored, upside down or a post aside would pass for it.
fn assert_like_brute_force(name: &str, gpu: &Gpu, ground: &Ground, view: View) {
    let exact = brute(ground, view);
    let seen = seen(ground, &exact);
    assert!(seen.contains(&Seen::Sky), "{name} has a silhouette");
    let image = |ground: &Ground| Mesh::new(gpu, ground, &view).unwrap().image().unwrap();
    let mesh = image(ground);
    let db = psnr(&mesh, &exact, &seen);
    assert!(db > LEAST_DB, "{name}: {db} dB");
    let off = off_silhouette(&mesh, &seen);
    assert!(off < 0.001, "{name}: {off} of the pixels");

    let Grid { cols, rows, .. } = ground.grid();
    for (fault, wrong) in [
        (
            "mirrored",
            rearranged(ground, |col, row| (cols - 1 - col, row)),
        ),
        (
            "upside down",
            rearranged(ground, |col, row| (col, rows - 1 - row)),
        ),
        (
            "a post east",
            rearranged(ground, |col, row| (col.saturating_sub(1), row)),
        ),
        (
            "a post south",
            rearranged(ground, |col, row| (col, (row + 1).min(rows - 1))),
        ),
    ] {
        let db = psnr(&image(&wrong), &exact, &seen);
        assert!(db < LEAST_DB, "{name}, {fault}: {db} dB");
    }
}

#[test]
fn pitched_rolled_and_table_views_are_brute_forces() {
    on_a_gpu(|gpu| {
        let ground = ridges(129);
        let [pitched, ..] = &standpoints::mixed(&ground)[..] else {
            panic!("a pitched view comes first");
        };
        let rolled = standpoints::wan(&ground, 0.3);
        // Far to the right of the glass's middle, so that the view is off-axis both ways.
        let table = standpoints::at_table(&ground, DVec3::new(0.5, -0.75, 0.6), [480, 293]);
        for (name, view) in [
            ("pitched", pitched.view),
            ("rolled", rolled),
            ("table", table),
        ] {
            assert_like_brute_force(name, &gpu, &ground, view);
        }
    });
}

/// Level ground under a photograph of noise that reaches over its western half and beyond, with
/// pixels missing in the middle.
fn photographed() -> Ground {
    let ground = Ground::from_fn(9, 7, DVec2::new(10.0, 12.0), |_, _| 3.0).unwrap();
    let mut state = 1_u32;
    let noise: Vec<[u8; 4]> = std::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let [r, g, b, _] = state.to_be_bytes();
        [r, g, b, 255]
    })
    .take(20 * 16)
    .collect();
    let missing = |col, row| (6..9).contains(&col) && (4..8).contains(&row);
    let pixels = TiledRaster::from_fn(20, 16, |col, row| {
        if missing(col, row) {
            [0; 4]
        } else {
            noise[(20 * row + col) as usize]
        }
    });
    ground.with_photo(Photo {
        pixels,
        origin: DVec2::new(-25.0, -11.0),
        spacing: DVec2::new(3.7, 6.1),
    })
}

#[test]
fn a_photograph_lies_where_brute_force_has_it() {
    on_a_gpu(|gpu| {
        let ground = photographed();
        let photo = ground.photo().unwrap();
        let camera = |eye, pitch| Camera {
            eye,
            attitude: Attitude {
                yaw: 0.3,
                pitch,
                roll: 0.0,
            },
            horizontal_fov: 1.2,
        };
        // Pixels compared where there is tint, and where there is photograph.
        let mut compared = [0, 0];
        // From above, and from a hand's breadth over the ground, some of it behind the eye.
        for camera in [
            camera(DVec3::new(20.0, -10.0, 60.0), -0.9),
            camera(DVec3::new(21.0, 9.0, 3.1), -0.1),
        ] {
            let view = camera.view([320, 240]);
            let exact = brute(&ground, view);
            let mesh = Mesh::new(&gpu, &ground, &view).unwrap().image().unwrap();
            let seen = seen(&ground, &exact);
            let off = off_silhouette(&mesh, &seen);
            assert!(off < 0.0001, "{off} of the pixels");
            for ((found, wanted), seen) in mesh.pixels().zip(exact.colour()).zip(&seen) {
                let Seen::Surface(point) = seen else { continue };
                // A texel's width from where photograph and tint meet they blend.
                let covered = |east: f64, north: f64| {
                    let at = point.truncate() + DVec2::new(east, north) * photo.spacing;
                    photo.colour_at(at.x, at.y).is_some()
                };
                let here = covered(0.0, 0.0);
                let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
                if is_ground(found) && corners.iter().all(|&(x, y)| covered(x, y) == here) {
                    compared[usize::from(here)] += 1;
                    let off = (0..3).map(|k| found.0[k].abs_diff(wanted[k])).max();
                    assert!(off <= Some(3), "{found:?} is not {wanted:?} at {point}");
                }
            }
        }
        assert!(compared.iter().all(|&pixels| pixels > 1000), "{compared:?}");
    });
}

#[test]
fn posts_far_from_the_origin_keep_their_precision() {
    let spacing = DVec2::new(10_000.1, 10_000.1);
    let ground = Ground::from_fn(2001, 2, spacing, |_, _| 1.0).unwrap();
    let eye = DVec3::new(1999.5 * spacing.x, 0.0, 2.0);
    let texels = Texels::new(&ground, 4096).unwrap();
    let east = vertices(&ground, eye, &texels)[2000].offset;
    assert!(
        (f64::from(east[0]) - 0.5 * spacing.x).abs() < 1e-3,
        "{east:?}"
    );
}

#[test]
fn what_the_adapter_cannot_hold_is_refused_with_its_limit() {
    let grid = |side| Grid {
        cols: side,
        rows: side,
        spacing: DVec2::ONE,
    };
    let limit = 256 << 20;
    assert!(check_buffers(grid(3345), limit).is_ok());
    let error = check_buffers(grid(3346), limit).unwrap_err().to_string();
    assert!(
        error.contains("3346 x 3346") && error.contains("max_buffer_size"),
        "{error}"
    );
    assert!(check_buffers(grid(20_000), u64::MAX).is_err());

    on_a_gpu(|gpu| {
        let strip = Ground::from_fn(gpu.longest_side() + 1, 2, DVec2::ONE, |_, _| 0.0).unwrap();
        let view = standpoints::wan(&strip, 0.0);
        let refusal = |ground: &Ground, view: &View| match Mesh::new(&gpu, ground, view) {
            Ok(_) => panic!("a mesh was made"),
            Err(error) => error.to_string(),
        };
        let error = refusal(&strip, &view);
        assert!(error.contains("max_texture_dimension_2d"), "{error}");

        let small = ridges(33);
        let size = [gpu.longest_side() + 1, 1];
        let error = refusal(&small, &View { size, ..view });
        assert!(error.contains(&gpu.longest_side().to_string()), "{error}");
        let error = refusal(
            &small,
            &View {
                size: [0, 9],
                ..view
            },
        );
        assert!(error.contains("no pixels"), "{error}");
        let eye = view.window.centre();
        assert_eq!(refusal(&small, &View { eye, ..view }), error);
        assert_eq!(gpu.take_error(), None);
    });
}

#[test]
fn a_lost_device_is_an_error() {
    on_a_gpu(|gpu| {
        let ground = ridges(33);
        let view = standpoints::wan(&ground, 0.0);
        let mesh = Mesh::new(&gpu, &ground, &view).unwrap();
        mesh.as_work()().unwrap();
        gpu.device.destroy();
        assert!(mesh.as_work()().is_err());
        assert!(mesh.image().is_err());
        assert!(Mesh::new(&gpu, &ground, &view).is_err());
    });
}
