//! The GPU: an adapter and its device, and what has gone wrong with it.

use std::sync::{Arc, Mutex, PoisonError};

/// Why nothing can be drawn.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// There is no usable adapter.
    #[error(
        "no graphics adapter: {0}; install a driver (Debian: mesa-vulkan-drivers, which also \
         draws on the CPU)"
    )]
    NoAdapter(#[from] wgpu::RequestAdapterError),
    /// The adapter gives no device.
    #[error("the graphics adapter {adapter:?} gives no device: {source}")]
    NoDevice {
        /// The adapter's own name.
        adapter: String,
        /// What wgpu says.
        source: wgpu::RequestDeviceError,
    },
    /// The window cannot be drawn to.
    #[error(
        "no graphics driver can draw to the window ({}); install one (Debian: \
         mesa-vulkan-drivers, which also draws on the CPU)", in_words(.0)
    )]
    NoSurface(#[from] wgpu::CreateSurfaceError),
    /// The adapter supports no format or mode of the window's surface.
    #[error("the graphics adapter {0:?} cannot draw to this window")]
    SurfaceUnsupported(String),
    /// An image is larger than the adapter's textures.
    #[error(
        "an eye's image of {} x {} pixels is larger than the graphics adapter's {longest} pixels \
         a side; make the window smaller", size[0], size[1]
    )]
    TooLarge {
        /// Width and height of the image in pixels.
        size: [u32; 2],
        /// The longest side that the adapter can hold, in pixels.
        longest: u32,
    },
    /// Reading pixels back failed.
    #[error("cannot read the frame back from the graphics adapter: {0}")]
    ReadBack(String),
}

/// What wgpu says of a surface, without the empty list of causes that it ends with where there is
/// no driver at all.
fn in_words(error: &wgpu::CreateSurfaceError) -> String {
    let words = error.to_string();
    words.strip_suffix(": {}").unwrap_or(&words).to_owned()
}

/// What has gone wrong on a device since it was made.
#[derive(Clone, Debug, Default)]
struct Troubles {
    lost: Option<String>,
    /// The last error that no caller has caught, not yet reported.
    error: Option<String>,
}

/// A device with its queue. Only the thread that shows frames may hold one.
pub struct Gpu {
    /// The adapter.
    pub adapter: wgpu::Adapter,
    /// The device.
    pub device: wgpu::Device,
    /// The device's queue.
    pub queue: wgpu::Queue,
    troubles: Arc<Mutex<Troubles>>,
}

impl Gpu {
    /// A device that can draw to `surface`, or to textures only where there is none.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] and [`GpuError::NoDevice`].
    pub fn new(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<Self, GpuError> {
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
            compatible_surface: surface,
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        }))?;
        // The least that any desktop adapter gives, but frames as large as this one can.
        let limits = wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits());
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("sandtable"),
            required_limits: limits,
            ..Default::default()
        }))
        .map_err(|source| GpuError::NoDevice {
            adapter: adapter.get_info().name,
            source,
        })?;
        let troubles = Arc::new(Mutex::new(Troubles::default()));
        let theirs = Arc::clone(&troubles);
        device.set_device_lost_callback(move |reason, message| {
            tracing::warn!("graphics device lost ({reason:?}): {message}");
            lock(&theirs).lost = Some(message);
        });
        let theirs = Arc::clone(&troubles);
        device.on_uncaptured_error(Arc::new(move |error| {
            tracing::error!("graphics error: {error}");
            let mut troubles = lock(&theirs);
            if matches!(error, wgpu::Error::OutOfMemory { .. }) {
                // Nothing made since then can be relied on.
                troubles.lost = Some(error.to_string());
            }
            troubles.error = Some(error.to_string());
        }));
        Ok(Self {
            adapter,
            device,
            queue,
            troubles,
        })
    }

    /// A device that draws to textures.
    ///
    /// # Errors
    /// As [`Gpu::new`].
    pub fn offscreen() -> Result<Self, GpuError> {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        Self::new(&wgpu::Instance::new(descriptor), None)
    }

    /// The adapter's name and back end, for people.
    #[must_use]
    pub fn description(&self) -> String {
        let info = self.adapter.get_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Whether the device is gone, and all that was made on it with it.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        lock(&self.troubles).lost.is_some()
    }

    /// The last error that nobody has caught, once.
    #[must_use]
    pub fn take_error(&self) -> Option<String> {
        lock(&self.troubles).error.take()
    }

    /// The longest side that an image on this device may have, in pixels.
    #[must_use]
    pub fn longest_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }
}

/// Troubles are written whole, so that a panic elsewhere leaves them usable.
fn lock(troubles: &Mutex<Troubles>) -> std::sync::MutexGuard<'_, Troubles> {
    troubles.lock().unwrap_or_else(PoisonError::into_inner)
}
