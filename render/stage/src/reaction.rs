//! What to do when a window gives, or does not give, a place to draw: a pure decision.

/// What the window's surface answered to being asked for the next frame's texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceState {
    /// There is one, of the right size.
    Ready,
    /// There is one, but the window has changed since the surface was configured.
    Suboptimal,
    /// None became free in time.
    Timeout,
    /// The window cannot be seen.
    Occluded,
    /// The window has changed so much that the surface must be configured anew.
    Outdated,
    /// The surface is gone.
    Lost,
    /// wgpu refused the request itself.
    Refused,
}

/// What the presenter then does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// Draw the frame.
    Draw,
    /// Draw the frame, then configure the surface for the next one.
    DrawThenConfigure,
    /// Configure the surface and ask again at once.
    Configure,
    /// Make surface, device and all that is on it anew.
    Recreate,
    /// Give this frame up and try again soon.
    Later,
    /// Give this frame up until the window system reports a change.
    Hidden,
}

/// How often one frame asks before it gives up.
pub(crate) const ATTEMPTS: u32 = 3;

/// Decides after the `attempt`-th answer (0 the first) for one frame.
///
/// A lost device is renewed before anything is drawn with it, and a surface that configuring does
/// not mend is made anew once; a window without pixels is never touched.
#[must_use]
pub fn react(state: SurfaceState, size: [u32; 2], device_lost: bool, attempt: u32) -> Reaction {
    if size.contains(&0) {
        return Reaction::Hidden;
    }
    if device_lost {
        return Reaction::Recreate;
    }
    match state {
        SurfaceState::Ready => Reaction::Draw,
        SurfaceState::Suboptimal => Reaction::DrawThenConfigure,
        SurfaceState::Timeout => Reaction::Later,
        SurfaceState::Occluded => Reaction::Hidden,
        SurfaceState::Outdated if attempt + 1 < ATTEMPTS => Reaction::Configure,
        // While a window is being resized, it may be outdated again before it is drawn to.
        SurfaceState::Outdated => Reaction::Later,
        SurfaceState::Refused if attempt == 0 => Reaction::Configure,
        SurfaceState::Refused | SurfaceState::Lost => Reaction::Recreate,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use SurfaceState::*;

    const ALL: [SurfaceState; 7] = [
        Ready, Suboptimal, Timeout, Occluded, Outdated, Lost, Refused,
    ];
    const SIZE: [u32; 2] = [800, 600];

    #[test]
    fn a_minimised_window_is_never_touched() {
        for state in ALL {
            for lost in [false, true] {
                assert_eq!(react(state, [0, 600], lost, 0), Reaction::Hidden);
                assert_eq!(react(state, [800, 0], lost, 2), Reaction::Hidden);
            }
        }
    }

    #[test]
    fn a_lost_device_is_renewed_before_it_is_drawn_with() {
        for state in ALL {
            assert_eq!(react(state, SIZE, true, 0), Reaction::Recreate);
        }
    }

    #[test]
    fn every_answer_ends_within_the_attempts() {
        for state in ALL {
            let last = react(state, SIZE, false, ATTEMPTS - 1);
            assert_ne!(last, Reaction::Configure, "{state:?} would ask for ever");
        }
    }

    #[test]
    fn a_resized_surface_is_configured_and_a_lost_one_recreated() {
        assert_eq!(react(Outdated, SIZE, false, 0), Reaction::Configure);
        assert_eq!(
            react(Suboptimal, SIZE, false, 0),
            Reaction::DrawThenConfigure
        );
        assert_eq!(react(Lost, SIZE, false, 0), Reaction::Recreate);
        assert_eq!(react(Refused, SIZE, false, 0), Reaction::Configure);
        assert_eq!(react(Refused, SIZE, false, 1), Reaction::Recreate);
        assert_eq!(react(Timeout, SIZE, false, 0), Reaction::Later);
        assert_eq!(react(Occluded, SIZE, false, 0), Reaction::Hidden);
    }
}
