//! The libraries that winit loads only when a window opens, so that no linker misses them before.
//!
//! They are loaded by the same crates in the same way as winit does it.

/// For which kind of session a library is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Session {
    X11,
    Wayland,
}

/// A library, and the Debian package that has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct WindowLibrary {
    /// What it is called to the loader.
    pub(super) name: &'static str,
    /// The Debian package.
    pub(super) package: &'static str,
}

/// The libraries without which no window opens in such a session, each with whether it loads.
pub(super) fn needed(session: Session) -> Vec<(WindowLibrary, bool)> {
    let library = |name, package, loads| (WindowLibrary { name, package }, loads);
    let xkbcommon = library(
        "libxkbcommon.so.0",
        "libxkbcommon0",
        xkbcommon_dl::xkbcommon_option().is_some(),
    );
    match session {
        Session::X11 => vec![
            library(
                "libX11.so.6",
                "libx11-6",
                x11_dl::xlib::Xlib::open().is_ok(),
            ),
            library(
                "libX11-xcb.so.1",
                "libx11-xcb1",
                x11_dl::xlib_xcb::Xlib_xcb::open().is_ok(),
            ),
            library(
                "libXcursor.so.1",
                "libxcursor1",
                x11_dl::xcursor::Xcursor::open().is_ok(),
            ),
            library(
                "libXi.so.6",
                "libxi6",
                x11_dl::xinput2::XInput2::open().is_ok(),
            ),
            xkbcommon,
            library(
                "libxkbcommon-x11.so.0",
                "libxkbcommon-x11-0",
                xkbcommon_dl::x11::xkbcommon_x11_option().is_some(),
            ),
        ],
        Session::Wayland => vec![
            library(
                "libwayland-client.so.0",
                "libwayland-client0",
                wayland_sys::client::is_lib_available(),
            ),
            xkbcommon,
        ],
    }
}
