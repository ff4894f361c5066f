//! What it takes to bring an image's colours and depths to the GPU.

use crate::command::bench::measure::Work;
use anyhow::{Context, Result};
use sandtable_cast::Image;
use sandtable_stage::Gpu;

/// A texture that is written anew from an image's bytes.
pub(super) struct Upload<'a> {
    gpu: &'a Gpu,
    texture: wgpu::Texture,
    bytes: &'a [u8],
}

impl<'a> Upload<'a> {
    /// The colours: four bytes a pixel.
    pub(super) fn of_colour(gpu: &'a Gpu, image: &'a Image) -> Self {
        let bytes = bytemuck::cast_slice(image.colour());
        Self::new(gpu, image, wgpu::TextureFormat::Rgba8Unorm, bytes)
    }

    /// The depths: one 32-bit float a pixel.
    pub(super) fn of_depth(gpu: &'a Gpu, image: &'a Image) -> Self {
        let bytes = bytemuck::cast_slice(&image.depth);
        Self::new(gpu, image, wgpu::TextureFormat::R32Float, bytes)
    }

    fn new(gpu: &'a Gpu, image: &Image, format: wgpu::TextureFormat, bytes: &'a [u8]) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("upload"),
            size: wgpu::Extent3d {
                width: image.width(),
                height: image.height(),
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Self {
            gpu,
            texture,
            bytes,
        }
    }

    /// Writes the texture and waits until the GPU has it.
    fn write(&self) -> Result<()> {
        let size = self.texture.size();
        self.gpu.queue.write_texture(
            self.texture.as_image_copy(),
            self.bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * size.width),
                rows_per_image: None,
            },
            size,
        );
        self.gpu.queue.submit([]);
        self.gpu
            .device
            .poll(wgpu::PollType::wait_indefinitely())
            .context("the graphics adapter did not take an image")?;
        if let Some(error) = self.gpu.take_error() {
            anyhow::bail!("the graphics adapter did not take an image: {error}");
        }
        // A lost device does nothing, at once and without an error.
        if self.gpu.is_lost() {
            anyhow::bail!("the graphics adapter did not take an image: its device is lost");
        }
        Ok(())
    }

    /// The upload as something to be timed.
    pub(super) fn as_work(&self) -> Work<'_> {
        Box::new(|| self.write())
    }
}
