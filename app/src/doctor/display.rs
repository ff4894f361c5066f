//! Displays on Linux: is there a session to open a window in, can it be opened, which monitors has
//! it.

use serde_json::json;

use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::WindowId;

use super::finding::{Finding, Item};
use super::remedy::install;
use super::window_library::{Session, WindowLibrary, needed};

pub(super) fn examine() -> Result<Finding, String> {
    let set = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
    let candidate = |session, display| Candidate {
        session,
        display,
        libraries: needed(session),
    };
    let wayland = set("WAYLAND_DISPLAY").or_else(|| set("WAYLAND_SOCKET"));
    let judged = [
        candidate(Session::Wayland, wayland),
        candidate(Session::X11, set("DISPLAY")),
    ];
    let (mut finding, may_open) = judge(&judged);
    if may_open {
        match monitors() {
            Ok(monitors) => monitors.into_iter().for_each(|item| finding.found(item)),
            Err(error) => finding.advise(format!(
                "The display is set but no window can be opened on it: {error}. Is it running, \
                 and may this user use it?"
            )),
        }
    }
    Ok(finding)
}

/// A kind of session that may be there.
struct Candidate {
    session: Session,
    /// The environment variable that names it, if set.
    display: Option<String>,
    /// What it needs, each with whether it loads.
    libraries: Vec<(WindowLibrary, bool)>,
}

/// Judges the sessions, and says whether it is worth while to try to open one.
fn judge(sessions: &[Candidate]) -> (Finding, bool) {
    let mut finding = Finding::default();
    for Candidate {
        session, display, ..
    } in sessions
    {
        if let Some(display) = display {
            let name = format!("{session:?}");
            finding.found(Item::new(name, display, json!({ "display": display })));
        }
    }
    let is_set = !finding.is_empty();
    if !is_set {
        finding.advise(
            "There is no display (neither WAYLAND_DISPLAY nor DISPLAY is set): sandtable fly writes \
             a flight to a file instead. To have one: run it from a desktop session, over ssh -X, \
             or as xvfb-run sandtable fly."
                .to_owned(),
        );
    }
    // With no display at all, what either kind of session would lack is good to know.
    let wanted = sessions
        .iter()
        .filter(|candidate| candidate.display.is_some() || !is_set);
    let mut missing: Vec<_> = wanted
        .flat_map(|candidate| &candidate.libraries)
        .filter(|(_, loads)| !loads)
        .map(|(library, _)| *library)
        .collect();
    // Both kinds need some of them.
    missing.sort();
    missing.dedup();
    if !missing.is_empty() {
        let names: Vec<_> = missing.iter().map(|library| library.name).collect();
        let packages: Vec<_> = missing.iter().map(|library| library.package).collect();
        finding.advise(format!(
            "No window can be opened without {}: {}.",
            names.join(", "),
            install(&packages)
        ));
    }
    (finding, is_set && missing.is_empty())
}

/// The monitors, by opening the display.
fn monitors() -> Result<Vec<Item>, String> {
    use winit::platform::wayland::EventLoopBuilderExtWayland;
    use winit::platform::x11::EventLoopBuilderExtX11;

    let mut builder = EventLoop::builder();
    EventLoopBuilderExtWayland::with_any_thread(&mut builder, true);
    EventLoopBuilderExtX11::with_any_thread(&mut builder, true);
    let event_loop = builder.build().map_err(|error| reason(&error))?;
    let mut look = Look::default();
    event_loop
        .run_app(&mut look)
        .map_err(|error| reason(&error))?;
    Ok(look.monitors)
}

/// Why, without the place in winit's source that its errors begin with.
fn reason(error: &winit::error::EventLoopError) -> String {
    let text = error.to_string();
    match text.split_once(": ") {
        Some((place, reason)) if place.starts_with("os error at ") => reason.to_owned(),
        _ => text,
    }
}

/// A program that looks at the monitors and leaves.
#[derive(Default)]
struct Look {
    monitors: Vec<Item>,
}

impl ApplicationHandler for Look {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        for monitor in event_loop.available_monitors() {
            let size = monitor.size();
            let hertz = monitor
                .refresh_rate_millihertz()
                .map(|rate| f64::from(rate) / 1000.0);
            let rate = hertz.map_or_else(String::new, |hertz| format!(" at {hertz:.2} Hz"));
            self.monitors.push(Item::new(
                monitor.name().unwrap_or_else(|| "monitor".to_owned()),
                format!("{} x {}{rate}", size.width, size.height),
                json!({
                    "size": [size.width, size.height],
                    "hertz": hertz,
                    "scale": monitor.scale_factor(),
                }),
            ));
        }
        event_loop.exit();
    }

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    const XI: WindowLibrary = WindowLibrary {
        name: "libXi.so.6",
        package: "libxi6",
    };
    const WAYLAND: WindowLibrary = WindowLibrary {
        name: "libwayland-client.so.0",
        package: "libwayland-client0",
    };

    fn judged(x11: Option<&str>, xi_loads: bool, wayland_loads: bool) -> (Finding, bool) {
        judge(&[
            Candidate {
                session: Session::Wayland,
                display: None,
                libraries: vec![(WAYLAND, wayland_loads)],
            },
            Candidate {
                session: Session::X11,
                display: x11.map(str::to_owned),
                libraries: vec![(XI, xi_loads)],
            },
        ])
    }

    #[test]
    fn only_what_the_session_in_force_needs_is_missed() {
        let (finding, may_open) = judged(Some(":0"), true, false);
        assert!(finding.advice.is_empty() && may_open);
        let (finding, may_open) = judged(Some(":0"), false, false);
        assert!(!may_open);
        assert!(finding.advice[0].contains("libXi.so.6") && finding.advice[0].contains("libxi6"));
        assert!(!finding.advice[0].contains("wayland"));
    }

    #[test]
    fn without_a_display_both_kinds_are_looked_at() {
        let (finding, may_open) = judged(None, true, false);
        assert!(!may_open);
        assert!(finding.advice[0].contains("xvfb-run"));
        assert!(finding.advice[1].contains("libwayland-client0"));
        assert_eq!(judged(None, true, true).0.advice.len(), 1);
    }
}
