//! A whole frame: the composed eyes, and the panel over them.

use crate::compositor::Compositor;
use crate::{Gpu, GpuError, StereoMode};
use egui_wgpu::ScreenDescriptor;
use image::RgbaImage;
use sandtable_cast::Image;
use std::time::Duration;

/// What the panel looks like, as egui gives it.
#[derive(Default)]
pub struct Panel {
    /// The tessellated shapes.
    pub primitives: Vec<egui::ClippedPrimitive>,
    /// Textures that changed, and those that no later panel needs.
    pub textures: egui::TexturesDelta,
    /// Pixels a point.
    pub pixels_per_point: f32,
}

/// How the eyes' images are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Composing {
    /// How they share the frame.
    pub mode: StereoMode,
    /// Whether the eyes change places.
    pub swap_eyes: bool,
}

/// Draws frames to targets of one format: to a window's surface, or to a texture to be read back.
pub struct FramePainter {
    format: wgpu::TextureFormat,
    compositor: Compositor,
    panel_painter: egui_wgpu::Renderer,
    panel: Panel,
}

impl FramePainter {
    /// A painter for targets of `format`. Anything but encoded 8-bit formats loses precision.
    #[must_use]
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        Self {
            format,
            compositor: Compositor::new(gpu, format),
            panel_painter: egui_wgpu::Renderer::new(&gpu.device, format, Default::default()),
            panel: Panel::default(),
        }
    }

    /// Shows `images` from now on: one for both eyes, or a left and a right one.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`]; the old images stay then.
    pub fn set_images(&mut self, gpu: &Gpu, images: &[Image]) -> Result<(), GpuError> {
        self.compositor.upload(gpu, images)
    }

    /// Shows `panel` from now on.
    pub fn set_panel(&mut self, gpu: &Gpu, panel: Panel) {
        let mut old = std::mem::replace(&mut self.panel, panel);
        for id in &old.textures.free {
            self.panel_painter.free_texture(id);
        }
        // egui checks that what it handed out was applied before it is dropped.
        old.textures.clear();
        for (id, changes) in &self.panel.textures.set {
            for change in changes {
                self.panel_painter
                    .update_texture(&gpu.device, &gpu.queue, *id, change);
            }
        }
        self.panel.textures.set.clear();
    }

    /// Draws the frame to `target`, which is `size` pixels large, and submits it.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        target: &wgpu::TextureView,
        size: [u32; 2],
        composing: Composing,
    ) {
        let screen = ScreenDescriptor {
            size_in_pixels: size,
            pixels_per_point: self.panel.pixels_per_point,
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let shapes = &self.panel.primitives;
        let extra = self.panel_painter.update_buffers(
            &gpu.device,
            &gpu.queue,
            &mut encoder,
            shapes,
            &screen,
        );
        {
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("frame"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            let mut pass = pass.forget_lifetime();
            self.compositor
                .draw(gpu, &mut pass, size, composing.mode, composing.swap_eyes);
            if !shapes.is_empty() {
                self.panel_painter.render(&mut pass, shapes, &screen);
            }
        }
        gpu.queue
            .submit(extra.into_iter().chain([encoder.finish()]));
    }

    /// Draws the frame of `size` pixels once more and reads it back, panel included.
    ///
    /// Waits for the GPU; meant for screenshots, not for every frame.
    ///
    /// # Errors
    /// [`GpuError::ReadBack`] where the device is lost or takes longer than ten seconds, and
    /// [`GpuError::TooLarge`].
    pub fn capture(
        &mut self,
        gpu: &Gpu,
        size: [u32; 2],
        composing: Composing,
    ) -> Result<RgbaImage, GpuError> {
        let [width, height] = size;
        let longest = gpu.longest_side();
        if width.max(height) > longest {
            return Err(GpuError::TooLarge { size, longest });
        }
        if width == 0 || height == 0 {
            return Ok(RgbaImage::new(width, height));
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("captured frame"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        self.draw(
            gpu,
            &texture.create_view(&Default::default()),
            size,
            composing,
        );
        let mut image = read_back(gpu, &texture)?;
        if matches!(
            self.format.remove_srgb_suffix(),
            wgpu::TextureFormat::Bgra8Unorm
        ) {
            for pixel in image.pixels_mut() {
                pixel.0.swap(0, 2);
            }
        }
        Ok(image)
    }
}

/// The bytes of an 8-bit, four-channel texture.
fn read_back(gpu: &Gpu, texture: &wgpu::Texture) -> Result<RgbaImage, GpuError> {
    let failed = |text: &dyn std::fmt::Display| GpuError::ReadBack(text.to_string());
    let (width, height) = (texture.width(), texture.height());
    let row = 4 * width;
    let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("captured frame"),
        size: u64::from(padded_row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded_row),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let (sender, mapped) = crossbeam_channel::bounded(1);
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // Nobody waits any more where the frame took too long.
        let _ = sender.send(result);
    });
    gpu.device
        .poll(wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(Duration::from_secs(10)),
        })
        .map_err(|error| failed(&error))?;
    mapped
        .try_recv()
        .map_err(|error| failed(&error))?
        .map_err(|error| failed(&error))?;
    let bytes = buffer
        .get_mapped_range(..)
        .map_err(|error| failed(&error))?;
    let mut pixels = Vec::with_capacity(row as usize * height as usize);
    for padded in bytes.chunks_exact(padded_row as usize) {
        pixels.extend_from_slice(&padded[..row as usize]);
    }
    RgbaImage::from_raw(width, height, pixels).ok_or_else(|| failed(&"too few bytes"))
}
