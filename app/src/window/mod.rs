//! The window: shows what a [`Show`] lets see, and hands it what keyboard, mouse and panel ask for.
//!
//! ```text
//! keyboard, mouse --Drive--> Show --views--> BackgroundCaster --newest finished--> Presenter
//!        panel ----Wish----> Show --readings--> panel --------------------------------^
//! ```
//!
//! One thread, the display thread, runs the event loop and alone owns the GPU. It never waits for
//! a cast: it hands over the newest views and shows the newest finished images until there are
//! newer ones. While nothing changes and no key is held, it sleeps.

mod events;
mod frame;
mod guide;
mod keys;
mod latency;
mod latency_report;
mod mouse;
mod open;
mod pacing;
mod panel;
mod shell;
mod show;
mod times;

pub(crate) use latency::HeadTimes;
pub(crate) use mouse::MouseDrive;
pub(crate) use show::{
    Activity, Advanced, Device, Drive, GuideReadings, GuideStep, GuideWish, HandReadings, Readings,
    Show, TableReadings, Wish,
};

use sandtable_cast::CastPool;
use sandtable_stage::{Composing, GpuError};
use std::path::PathBuf;
use std::sync::Arc;
use winit::event_loop::{EventLoop, EventLoopProxy};

/// How the window starts.
#[derive(Clone, Debug)]
pub(crate) struct WindowOptions {
    /// The window's title.
    pub(crate) title: String,
    /// Width and height of the picture, in pixels at a scale factor of one.
    pub(crate) size: [u32; 2],
    /// Whether it starts over the full screen.
    pub(crate) full_screen: bool,
    /// How the eyes share the frame at first.
    pub(crate) composing: Composing,
    /// Whether the panel shows at first.
    pub(crate) panel: bool,
    /// Whether the latency is told on standard error at intervals and at the end.
    pub(crate) latency: bool,
    /// Where screenshots go.
    pub(crate) screenshots: PathBuf,
}

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WindowError {
    /// The session has no display.
    #[error(
        "no display to open a window on: neither WAYLAND_DISPLAY nor DISPLAY leads to a display \
         server"
    )]
    NoDisplay,
    /// The display refuses a window.
    #[error("the display refuses a window: {0}")]
    NoWindow(winit::error::OsError),
    /// Nothing can draw in the window.
    #[error(transparent)]
    NoGpu(#[from] GpuError),
    /// There is no thread to cast on.
    #[error("cannot start the casting thread: {0}")]
    NoThread(std::io::Error),
    /// The event loop broke off.
    #[error("the window's event loop broke off: {0}")]
    BrokeOff(winit::error::EventLoopError),
}

/// What reaches the display thread from others.
#[derive(Debug)]
enum Wake {
    /// There is something new to look at.
    Look,
    /// For the people at the panel.
    Message(String),
    /// The system, or who started the program, asks for its end.
    Quit,
}

/// Wakes the display thread from any other, where it sleeps because nothing moved.
#[derive(Clone)]
pub(crate) struct Waker(EventLoopProxy<Wake>);

impl Waker {
    /// Has the show advanced and looked at soon.
    pub(crate) fn wake(&self) {
        // Fails only when the window has been closed, and then nobody looks.
        let _ = self.0.send_event(Wake::Look);
    }

    /// Has the window closed, as by people.
    pub(crate) fn quit(&self) {
        // One that is closed needs no telling.
        let _ = self.0.send_event(Wake::Quit);
    }
}

/// A connection to the display, before there is a window.
pub(crate) struct Display {
    events: EventLoop<Wake>,
}

impl Display {
    /// Connects to the display. At most once in a process, on its main thread.
    ///
    /// # Errors
    /// [`WindowError::NoDisplay`], on which a caller can still do without a window.
    pub(crate) fn connect() -> Result<Self, WindowError> {
        let events = EventLoop::with_user_event().build().map_err(|error| {
            // It names places in winit's source; of use to programmers only.
            tracing::debug!("{error}");
            WindowError::NoDisplay
        })?;
        Ok(Self { events })
    }

    /// What wakes the window from other threads, for instance when a tracker reports.
    pub(crate) fn waker(&self) -> Waker {
        Waker(self.events.create_proxy())
    }

    /// Opens the window and shows `show`, cast on `pool`, until people close it.
    ///
    /// # Errors
    /// [`WindowError`], also where the GPU is lost and none can be found again.
    pub(crate) fn run(
        self,
        options: WindowOptions,
        pool: Arc<CastPool>,
        show: &mut dyn Show,
    ) -> Result<(), WindowError> {
        let mut shell = shell::Shell::new(options, pool, show, self.waker());
        self.events
            .run_app(&mut shell)
            .map_err(WindowError::BrokeOff)?;
        shell.end()
    }
}
