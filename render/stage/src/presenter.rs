//! The presenter: frames on a window's surface, through every change of the window and the GPU.

use crate::reaction::{ATTEMPTS, Reaction, SurfaceState, react};
use crate::{Composing, FramePainter, Gpu, GpuError, Panel};
use image::RgbaImage;
use sandtable_cast::Image;
use std::time::{Duration, Instant};
use wgpu::CurrentSurfaceTexture as Acquired;

/// Makes a surface for the window, as often as one is lost, with the instance that it belongs to.
pub type SurfaceSource =
    Box<dyn Fn() -> Result<(wgpu::Instance, wgpu::Surface<'static>), wgpu::CreateSurfaceError>>;

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It is on its way to the glass.
    Drawn,
    /// The window was not ready; try again soon.
    Later,
    /// Nobody can see the window; wait until it changes.
    Hidden,
    /// The GPU was lost and everything on it was made anew: images, and the panel with all its
    /// textures, must be set again.
    Renewed,
}

/// Shows frames on a window. Belongs to the display thread alone: no other may call wgpu.
pub struct Presenter {
    source: SurfaceSource,
    /// In pixels; a side may be zero while the window is minimised.
    size: [u32; 2],
    /// Nothing after a renewal failed.
    live: Option<Live>,
    waited: Duration,
}

/// All that is lost with a device. The surface is dropped before the device.
struct Live {
    surface: wgpu::Surface<'static>,
    painter: FramePainter,
    configuration: wgpu::SurfaceConfiguration,
    /// The size for which the surface was configured.
    configured: Option<[u32; 2]>,
    gpu: Gpu,
}

impl Presenter {
    /// A presenter for the window of `source`, at present `size` pixels large.
    ///
    /// # Errors
    /// [`GpuError`] where there is no adapter, no device, or none that can draw to this window.
    pub fn new(source: SurfaceSource, size: [u32; 2]) -> Result<Self, GpuError> {
        let live = Live::new(&source)?;
        Ok(Self {
            source,
            size,
            live: Some(live),
            waited: Duration::ZERO,
        })
    }

    /// The size of a frame in pixels: the window's, as far as the GPU can fill it.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        let longest = self
            .live
            .as_ref()
            .map_or(u32::MAX, |live| live.gpu.longest_side());
        self.size.map(|side| side.min(longest))
    }

    /// The window is now `size` pixels large; zero while minimised.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.size = size;
    }

    /// The GPU, if there is one at present.
    #[must_use]
    pub fn gpu(&self) -> Option<&Gpu> {
        self.live.as_ref().map(|live| &live.gpu)
    }

    /// Shows `images` from the next frame on: one for both eyes, or a left and a right one.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`]; the old images stay then.
    pub fn set_images(&mut self, images: &[Image]) -> Result<(), GpuError> {
        match &mut self.live {
            Some(live) => live.painter.set_images(&live.gpu, images),
            None => Ok(()),
        }
    }

    /// Shows `panel` from the next frame on.
    pub fn set_panel(&mut self, mut panel: Panel) {
        match &mut self.live {
            Some(live) => live.painter.set_panel(&live.gpu, panel),
            None => panel.textures.clear(),
        }
    }

    /// Draws a frame to the window, mending what can be mended.
    ///
    /// `before_present` is called when the frame is drawn and about to be handed to the window
    /// system.
    ///
    /// # Errors
    /// [`GpuError`] where a lost GPU could not be replaced; the next call tries again.
    pub fn present(
        &mut self,
        composing: Composing,
        before_present: impl FnOnce(),
    ) -> Result<Presented, GpuError> {
        let size = self.size();
        self.waited = Duration::ZERO;
        for attempt in 0..ATTEMPTS {
            let (acquired, device_lost) = match &mut self.live {
                Some(live) if size.contains(&0) || live.gpu.is_lost() => (None, live.gpu.is_lost()),
                Some(live) => {
                    live.configure_for(size);
                    let asked = Instant::now();
                    let acquired = live.surface.get_current_texture();
                    self.waited += asked.elapsed();
                    (Some(acquired), live.gpu.is_lost())
                }
                None => (None, true),
            };
            let (state, texture) = split(acquired);
            let reaction = react(state, size, device_lost, attempt);
            match (reaction, texture, &mut self.live) {
                (Reaction::Draw | Reaction::DrawThenConfigure, Some(texture), Some(live)) => {
                    live.draw(texture, size, composing, before_present);
                    if reaction == Reaction::DrawThenConfigure {
                        live.configured = None;
                    }
                    return Ok(Presented::Drawn);
                }
                (Reaction::Configure, texture, Some(live)) => {
                    drop(texture);
                    live.configured = None;
                }
                (Reaction::Recreate, texture, _) => {
                    drop(texture);
                    // A window has room for one surface: the old one goes first.
                    self.live = None;
                    self.live = Some(Live::new(&self.source)?);
                    return Ok(Presented::Renewed);
                }
                (Reaction::Hidden, ..) => return Ok(Presented::Hidden),
                _ => return Ok(Presented::Later),
            }
        }
        Ok(Presented::Later)
    }

    /// How long the last frame waited for the window system to give it a place: where presenting
    /// keeps pace with the glass, this is the time that was left over.
    #[must_use]
    pub fn waited(&self) -> Duration {
        self.waited
    }

    /// The frame as it would be shown now, panel included, read back from the GPU.
    ///
    /// # Errors
    /// As [`FramePainter::capture`], and [`GpuError::ReadBack`] where there is no GPU at present.
    pub fn capture(&mut self, composing: Composing) -> Result<RgbaImage, GpuError> {
        let size = self.size();
        match &mut self.live {
            Some(live) => live.painter.capture(&live.gpu, size, composing),
            None => Err(GpuError::ReadBack("there is none at present".into())),
        }
    }
}

impl Live {
    fn new(source: &SurfaceSource) -> Result<Self, GpuError> {
        let (instance, surface) = source()?;
        let gpu = Gpu::new(&instance, Some(&surface))?;
        let unsupported = || GpuError::SurfaceUnsupported(gpu.adapter.get_info().name);
        let capabilities = surface.get_capabilities(&gpu.adapter);
        let mut configuration = surface
            .get_default_config(&gpu.adapter, 1, 1)
            .ok_or_else(unsupported)?;
        // The casters' colours and egui's are encoded already: a target that does not encode keeps
        // them exactly.
        configuration.format = capabilities
            .formats
            .iter()
            .find(|format| is_plain_8_bit(**format))
            .or_else(|| {
                capabilities
                    .formats
                    .iter()
                    .find(|format| is_8_bit(**format))
            })
            .copied()
            .ok_or_else(unsupported)?;
        configuration.present_mode = wgpu::PresentMode::AutoVsync;
        // A head moves on while frames queue.
        configuration.desired_maximum_frame_latency = 1;
        let painter = FramePainter::new(&gpu, configuration.format);
        Ok(Self {
            surface,
            painter,
            configuration,
            configured: None,
            gpu,
        })
    }

    fn configure_for(&mut self, size: [u32; 2]) {
        if self.configured != Some(size) {
            [self.configuration.width, self.configuration.height] = size;
            self.surface
                .configure(&self.gpu.device, &self.configuration);
            self.configured = Some(size);
        }
    }

    fn draw(
        &mut self,
        texture: wgpu::SurfaceTexture,
        size: [u32; 2],
        composing: Composing,
        before_present: impl FnOnce(),
    ) {
        let view = texture.texture.create_view(&Default::default());
        self.painter.draw(&self.gpu, &view, size, composing);
        before_present();
        self.gpu.queue.present(texture);
    }
}

fn is_8_bit(format: wgpu::TextureFormat) -> bool {
    is_plain_8_bit(format.remove_srgb_suffix())
}

fn is_plain_8_bit(format: wgpu::TextureFormat) -> bool {
    use wgpu::TextureFormat::{Bgra8Unorm, Rgba8Unorm};
    matches!(format, Bgra8Unorm | Rgba8Unorm)
}

/// The answer's state, and the texture if there is one. Without an answer nothing is ready.
fn split(acquired: Option<Acquired>) -> (SurfaceState, Option<wgpu::SurfaceTexture>) {
    match acquired {
        Some(Acquired::Success(texture)) => (SurfaceState::Ready, Some(texture)),
        Some(Acquired::Suboptimal(texture)) => (SurfaceState::Suboptimal, Some(texture)),
        Some(Acquired::Timeout) => (SurfaceState::Timeout, None),
        Some(Acquired::Outdated) => (SurfaceState::Outdated, None),
        Some(Acquired::Lost) => (SurfaceState::Lost, None),
        Some(Acquired::Validation) => (SurfaceState::Refused, None),
        Some(Acquired::Occluded) | None => (SurfaceState::Occluded, None),
    }
}
