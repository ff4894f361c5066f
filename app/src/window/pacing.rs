//! When the next frame is due: a pure decision.

use std::time::{Duration, Instant};

/// The longest step by which a show is advanced, so that a pause does not become a leap.
pub(super) const LONGEST_STEP: Duration = Duration::from_millis(250);

/// How often an unseen window still advances a moving show.
const UNSEEN_INTERVAL: Duration = Duration::from_millis(100);

/// How things stand between two events.
#[derive(Clone, Copy, Debug)]
pub(super) struct Situation {
    /// Something to be seen has changed: an image, the panel, the window.
    pub(super) changed: bool,
    /// A key or button is held, or the show moves by itself.
    pub(super) moving: bool,
    /// The window has pixels that somebody may see.
    pub(super) visible: bool,
    /// When the last frame began.
    pub(super) last: Instant,
    /// The shortest time from frame to frame.
    pub(super) interval: Duration,
    /// When the panel wants to be drawn again by itself.
    pub(super) panel_due: Option<Instant>,
}

/// What to do until the next event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Draw now.
    Draw,
    /// Only advance the show now: nobody sees it.
    Advance,
    /// Sleep, but not beyond this time.
    SleepUntil(Instant),
    /// Sleep until something happens.
    Sleep,
}

/// Decides at `now`.
pub(super) fn next(situation: &Situation, now: Instant) -> Next {
    let Situation {
        changed,
        moving,
        visible,
        last,
        interval,
        panel_due,
    } = *situation;
    if !visible {
        let due = last + UNSEEN_INTERVAL;
        return match moving {
            true if now >= due => Next::Advance,
            true => Next::SleepUntil(due),
            false => Next::Sleep,
        };
    }
    let earliest = last + interval;
    let due = if changed || moving {
        earliest
    } else {
        match panel_due {
            Some(due) => due.max(earliest),
            None => return Next::Sleep,
        }
    };
    if now >= due {
        Next::Draw
    } else {
        Next::SleepUntil(due)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn still(last: Instant) -> Situation {
        Situation {
            changed: false,
            moving: false,
            visible: true,
            last,
            interval: Duration::from_millis(8),
            panel_due: None,
        }
    }

    #[test]
    fn it_sleeps_while_nothing_changes() {
        let last = Instant::now();
        let later = last + Duration::from_secs(5);
        assert_eq!(next(&still(last), later), Next::Sleep);
        let unseen = Situation {
            changed: true,
            visible: false,
            ..still(last)
        };
        assert_eq!(next(&unseen, later), Next::Sleep);
    }

    #[test]
    fn changes_and_movement_are_drawn_no_faster_than_the_interval() {
        let last = Instant::now();
        let due = last + Duration::from_millis(8);
        for (changed, moving) in [(true, false), (false, true)] {
            let situation = Situation {
                changed,
                moving,
                ..still(last)
            };
            assert_eq!(next(&situation, last), Next::SleepUntil(due));
            assert_eq!(next(&situation, due), Next::Draw);
        }
    }

    #[test]
    fn an_unseen_show_moves_on_undrawn() {
        let last = Instant::now();
        let situation = Situation {
            moving: true,
            visible: false,
            ..still(last)
        };
        let due = last + UNSEEN_INTERVAL;
        assert_eq!(next(&situation, last), Next::SleepUntil(due));
        assert_eq!(next(&situation, due), Next::Advance);
    }

    #[test]
    fn the_panel_is_drawn_when_it_asks() {
        let last = Instant::now();
        let due = last + Duration::from_millis(300);
        let situation = Situation {
            panel_due: Some(due),
            ..still(last)
        };
        assert_eq!(next(&situation, last), Next::SleepUntil(due));
        assert_eq!(next(&situation, due), Next::Draw);
    }
}
