//! The rival of Wan, Qu and Kaufman's caster (1999; papers' row W10): the ground as triangles,
//! drawn by the graphics adapter.
//!
//! ```text
//! Ground --a vertex a post, from the eye-----> vertices -------+
//!   |  +---two triangles a cell--------------> indices --------+--> one pass --> image
//!   +----a texel a post, or a photo's pixels-> texture --------+
//! View --its window's corners----------------> clip_from_eye --+
//! ```
//!
//! As in the paper, there are as many triangles for every view, none is simplified, and the
//! texture has no mip maps. Unlike a caster's terrain, a triangle is flat and the ground is a skin
//! without walls and without an inside; past its border there is sky of one colour.

mod error;
mod projection;
mod texels;

use crate::command::bench::measure::Work;
use anyhow::{Context, Result, anyhow, bail};
use bytemuck::cast_slice;
use error::MeshError;
use glam::{DVec2, DVec3};
use image::RgbaImage;
use projection::clip_from_eye;
use sandtable_stage::{Gpu, GpuError};
use sandtable_terrain::{Grid, Ground};
use sandtable_view::View;
use texels::Texels;
use wgpu::util::DownloadBuffer;

/// What is drawn where there is no ground: the casters' haze at the horizon.
const SKY: [u8; 3] = [200, 216, 232];

const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A ground's triangles on the GPU, and one view of them.
pub(super) struct Mesh<'a> {
    gpu: &'a Gpu,
    pipeline: wgpu::RenderPipeline,
    binding: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    target: wgpu::Texture,
    depth: wgpu::Texture,
}

/// A post, as in the shader.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Vertex {
    /// From the eye to the post, in world metres.
    offset: [f32; 3],
    /// Shares of the texture's width and height, from its first texel's outer corner.
    place: [f32; 2],
}

impl<'a> Mesh<'a> {
    /// Brings the ground to the GPU, to be drawn as `view` sees it.
    ///
    /// The texture is the photograph where there is one that the adapter can hold (the tint fills
    /// what it leaves bare), and otherwise the ground's colour at each post.
    ///
    /// # Errors
    /// [`MeshError`], and what the adapter says where it has no memory left.
    pub(super) fn new(gpu: &'a Gpu, ground: &Ground, view: &View) -> Result<Self> {
        let longest = gpu.longest_side();
        check_view(view, longest)?;
        check_buffers(ground.grid(), gpu.device.limits().max_buffer_size)?;
        let texels = Texels::new(ground, longest)?;
        let device = &gpu.device;
        let buffer = |label, contents: &[u8], usage| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: contents.len() as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            gpu.queue.write_buffer(&buffer, 0, contents);
            buffer
        };
        let vertices = vertices(ground, view.eye, &texels);
        let vertices = buffer("posts", cast_slice(&vertices), wgpu::BufferUsages::VERTEX);
        let indices = indices(ground.grid());
        let indices = buffer("triangles", cast_slice(&indices), wgpu::BufferUsages::INDEX);
        let clip_from_eye = clip_from_eye(view, ground.grid().cell_length()).to_cols_array();
        let clip_from_eye = buffer(
            "projection",
            cast_slice(&clip_from_eye),
            wgpu::BufferUsages::UNIFORM,
        );
        let sampled = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let colours = device.create_texture(&texture("colours", texels.size, COLOUR, sampled));
        gpu.queue.write_texture(
            colours.as_image_copy(),
            cast_slice(&texels.colours(ground)),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * texels.size[0]),
                rows_per_image: None,
            },
            colours.size(),
        );
        let pipeline = pipeline(device);
        let binding = bind(device, &pipeline, &clip_from_eye, &colours);
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let read = drawn | wgpu::TextureUsages::COPY_SRC;
        let mesh = Self {
            gpu,
            pipeline,
            binding,
            vertices,
            indices,
            target: device.create_texture(&texture("image", view.size, COLOUR, read)),
            depth: device.create_texture(&texture("depth", view.size, DEPTH, drawn)),
        };
        mesh.settle()?;
        Ok(mesh)
    }

    /// Draws a frame and waits until the GPU is done.
    ///
    /// # Errors
    /// What the adapter says, as where the device is lost.
    pub(super) fn draw(&self) -> Result<()> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let target = self.target.create_view(&Default::default());
        let depth = self.depth.create_view(&Default::default());
        let [r, g, b] = SKY.map(|channel| f64::from(channel) / 255.0);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("mesh"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.binding, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        let count = self.indices.size() / size_of::<u32>() as u64;
        pass.draw_indexed(0..count as u32, 0, 0..1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        self.settle()
    }

    /// The drawing as something to be timed.
    pub(super) fn as_work(&self) -> Work<'_> {
        Box::new(|| self.draw())
    }

    /// Draws a frame and reads it back.
    ///
    /// # Errors
    /// As [`Mesh::draw`].
    pub(super) fn image(&self) -> Result<RgbaImage> {
        self.draw()?;
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let size = self.target.size();
        let row = 4 * size.width;
        let padded_row = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("image"),
            size: u64::from(padded_row) * u64::from(size.height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded_row),
                    rows_per_image: None,
                },
            },
            size,
        );
        queue.submit([encoder.finish()]);
        let (sender, received) = crossbeam_channel::bounded(1);
        DownloadBuffer::read_buffer(device, queue, &buffer.slice(..), move |bytes| {
            // Nobody waits any more where the adapter has failed.
            let _ = sender.send(bytes);
        });
        self.settle()?;
        let bytes = received
            .try_recv()
            .context("the graphics adapter did not give the mesh's image back")?
            .context("the graphics adapter did not give the mesh's image back")?;
        let pixels = bytes
            .chunks_exact(padded_row as usize)
            .flat_map(|padded| &padded[..row as usize])
            .copied()
            .collect();
        RgbaImage::from_raw(size.width, size.height, pixels)
            .ok_or_else(|| anyhow!("the graphics adapter gave too few bytes of the mesh's image"))
    }

    /// Waits until the GPU is done.
    fn settle(&self) -> Result<()> {
        self.gpu
            .device
            .poll(wgpu::PollType::wait_indefinitely())
            .context("the graphics adapter did not draw the mesh")?;
        if let Some(error) = self.gpu.take_error() {
            bail!("the graphics adapter did not draw the mesh: {error}");
        }
        // A lost device does nothing, at once and without an error.
        if self.gpu.is_lost() {
            bail!("the graphics adapter did not draw the mesh: its device is lost");
        }
        Ok(())
    }
}

/// Whether `view` has rays, and an image that textures of `longest` texels a side can hold.
fn check_view(view: &View, longest: u32) -> Result<(), MeshError> {
    let size = view.size;
    if size.contains(&0) || !view.is_proper() {
        return Err(MeshError::View);
    }
    if size.iter().any(|&side| side > longest) {
        return Err(GpuError::TooLarge { size, longest }.into());
    }
    Ok(())
}

/// Whether the triangles of `grid` fit into buffers of `limit` bytes.
fn check_buffers(grid: Grid, limit: u64) -> Result<(), MeshError> {
    let Grid { cols, rows, .. } = grid;
    let cells = u64::from(cols - 1) * u64::from(rows - 1);
    // A draw counts its indices in 32 bits, whatever a buffer may hold.
    let limit = limit.min(u64::from(u32::MAX));
    for (part, count, each) in [
        ("vertices", grid.posts(), size_of::<Vertex>()),
        ("triangles", cells, 6 * size_of::<u32>()),
    ] {
        let bytes = count.saturating_mul(each as u64);
        if bytes > limit {
            return Err(MeshError::Buffer {
                cols,
                rows,
                part,
                bytes,
                limit,
            });
        }
    }
    Ok(())
}

/// One vertex a post, row by row. The offset from the eye is taken in f64, so that it keeps its
/// precision where coordinates are large.
fn vertices(ground: &Ground, eye: DVec3, texels: &Texels) -> Vec<Vertex> {
    let Grid {
        cols,
        rows,
        spacing,
    } = ground.grid();
    (0..rows)
        .flat_map(|row| (0..cols).map(move |col| (col, row)))
        .map(|(col, row)| {
            let post = DVec2::new(f64::from(col), f64::from(row)) * spacing;
            let height = f64::from(ground.heights().post(col, row));
            Vertex {
                offset: (post.extend(height) - eye).as_vec3().to_array(),
                place: texels.place(post).as_vec2().to_array(),
            }
        })
        .collect()
}

/// Two triangles a cell, parted from south-west to north-east, counterclockwise seen from above.
fn indices(grid: Grid) -> Vec<u32> {
    let Grid { cols, rows, .. } = grid;
    (0..rows - 1)
        .flat_map(|row| (0..cols - 1).map(move |col| row * cols + col))
        .flat_map(|sw| {
            let (se, nw, ne) = (sw + 1, sw + cols, sw + cols + 1);
            [sw, se, ne, sw, ne, nw]
        })
        .collect()
}

fn texture(
    label: &'static str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

fn pipeline(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let shader = device.create_shader_module(wgpu::include_wgsl!("mesh.wgsl"));
    let vertex = wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2],
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("mesh"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: Some("project"),
            compilation_options: Default::default(),
            buffers: &[Some(vertex)],
        },
        fragment: Some(wgpu::FragmentState {
            module: &shader,
            entry_point: Some("shade"),
            compilation_options: Default::default(),
            targets: &[Some(COLOUR.into())],
        }),
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        multiview_mask: None,
        cache: None,
    })
}

fn bind(
    device: &wgpu::Device,
    pipeline: &wgpu::RenderPipeline,
    clip_from_eye: &wgpu::Buffer,
    colours: &wgpu::Texture,
) -> wgpu::BindGroup {
    let colours = colours.create_view(&Default::default());
    // Clamped at the borders, as a sampler is by default.
    let bilinear = device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("bilinear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("mesh"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: clip_from_eye.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&colours),
            },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::Sampler(&bilinear),
            },
        ],
    })
}

#[cfg(test)]
mod tests;
