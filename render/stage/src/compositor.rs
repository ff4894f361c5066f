//! Composition on the GPU: the eyes' images as textures, and one pass over the frame.

use crate::{Gpu, GpuError, StereoMode};
use sandtable_cast::Image;

/// The part of the frame that comes from the caster.
pub(crate) struct Compositor {
    /// One for each mode, in the order of [`StereoMode::ALL`].
    pipelines: [wgpu::RenderPipeline; 4],
    layout: wgpu::BindGroupLayout,
    composition: wgpu::Buffer,
    eyes: Vec<wgpu::Texture>,
    /// Left and right as they are, and exchanged.
    bindings: [wgpu::BindGroup; 2],
}

/// As in the shader.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Composition {
    frame: [u32; 2],
    /// Uniforms are a multiple of 16 bytes on some back ends.
    padding: [u32; 2],
}

/// The mode's number in the shader.
fn number(mode: StereoMode) -> u32 {
    match mode {
        StereoMode::Mono => 0,
        StereoMode::SideBySide => 1,
        StereoMode::TopBottom => 2,
        StereoMode::Anaglyph => 3,
    }
}

impl Compositor {
    /// A compositor that draws to targets of `format`, black until images come.
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let device = &gpu.device;
        let shader = device.create_shader_module(wgpu::include_wgsl!("compositor.wgsl"));
        let texture = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("composition"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                },
                texture(1),
                texture(2),
            ],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("composition"),
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let encodes = f64::from(u8::from(format.is_srgb()));
        let pipelines = StereoMode::ALL.map(|mode| {
            let constants = [
                ("mode", f64::from(number(mode))),
                ("target_encodes", encodes),
            ];
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("composition"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &shader,
                    entry_point: Some("cover"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                fragment: Some(wgpu::FragmentState {
                    module: &shader,
                    entry_point: Some("shade"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    targets: &[Some(format.into())],
                }),
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                multiview_mask: None,
                cache: None,
            })
        });
        let composition = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("composition"),
            size: size_of::<Composition>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        // wgpu sets textures to zero, which the shader shows as black.
        let eyes = vec![eye_texture(device, [1, 1])];
        let bindings = bind(device, &layout, &composition, &eyes);
        Self {
            pipelines,
            layout,
            composition,
            eyes,
            bindings,
        }
    }

    /// Takes over the colours of `images`: one for both eyes, or a left and a right one. Images
    /// without pixels are passed over.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`]; the old images stay then.
    pub(crate) fn upload(&mut self, gpu: &Gpu, images: &[Image]) -> Result<(), GpuError> {
        let images: Vec<&Image> = images
            .iter()
            .filter(|image| !image.colour().is_empty())
            .take(2)
            .collect();
        let longest = gpu.longest_side();
        if let Some(image) = images
            .iter()
            .find(|image| image.width().max(image.height()) > longest)
        {
            return Err(GpuError::TooLarge {
                size: image.view.size,
                longest,
            });
        }
        if images.is_empty() {
            return Ok(());
        }
        let sizes = |texture: &wgpu::Texture| [texture.width(), texture.height()];
        let fits = self
            .eyes
            .iter()
            .map(sizes)
            .eq(images.iter().map(|image| image.view.size));
        if !fits {
            self.eyes = images
                .iter()
                .map(|image| eye_texture(&gpu.device, image.view.size))
                .collect();
            self.bindings = bind(&gpu.device, &self.layout, &self.composition, &self.eyes);
        }
        for (texture, image) in self.eyes.iter().zip(images) {
            gpu.queue.write_texture(
                texture.as_image_copy(),
                bytemuck::cast_slice(image.colour()),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * image.width()),
                    rows_per_image: None,
                },
                texture.size(),
            );
        }
        Ok(())
    }

    /// Draws the composition over all of a target of `frame` pixels.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        frame: [u32; 2],
        mode: StereoMode,
        swap: bool,
    ) {
        let composition = Composition {
            frame,
            padding: [0; 2],
        };
        gpu.queue
            .write_buffer(&self.composition, 0, bytemuck::bytes_of(&composition));
        pass.set_pipeline(&self.pipelines[number(mode) as usize]);
        pass.set_bind_group(0, &self.bindings[usize::from(swap)], &[]);
        pass.draw(0..3, 0..1);
    }
}

fn eye_texture(device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("eye"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    composition: &wgpu::Buffer,
    eyes: &[wgpu::Texture],
) -> [wgpu::BindGroup; 2] {
    let (first, last) = (&eyes[0], &eyes[eyes.len() - 1]);
    [[first, last], [last, first]].map(|[left, right]| {
        let (left, right) = (
            left.create_view(&Default::default()),
            right.create_view(&Default::default()),
        );
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("composition"),
            layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: composition.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::TextureView(&left),
                },
                wgpu::BindGroupEntry {
                    binding: 2,
                    resource: wgpu::BindingResource::TextureView(&right),
                },
            ],
        })
    })
}
