//! What sounds from where: the listener, one source, and the wind of flying.

use glam::DVec3;

/// Who hears: a place and the direction of the right ear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Listener {
    /// The middle of the head, in metres.
    pub position: DVec3,
    /// Towards the right ear; any length but zero.
    pub right: DVec3,
}

impl Listener {
    /// A listener at a table, who keeps facing across it: the right ear is on the table's +x side
    /// however the head turns, as loudspeakers beside the table do not turn with it.
    ///
    /// `head` is the middle of the head in table metres.
    #[must_use]
    pub const fn at_table(head: DVec3) -> Self {
        Self {
            position: head,
            right: DVec3::X,
        }
    }
}

/// A point that sounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// In the listener's frame, metres.
    pub position: DVec3,
    /// Amplitude at the reference distance and within, from 0 (silent) to 1.
    pub level: f64,
    /// The distance in metres from which on the level falls by 6 dB a doubling.
    pub reference_distance: f64,
}

impl Source {
    /// A source at full level with a reference distance of 0.25 m, which suits a table.
    #[must_use]
    pub const fn at(position: DVec3) -> Self {
        Self {
            position,
            level: 1.0,
            reference_distance: 0.25,
        }
    }

    /// The amplitudes left and right at which `listener` hears this source.
    ///
    /// Their squares add up to the square of the level that the distance leaves (constant power).
    /// None if a number is not finite, a direction is zero or a distance is not positive.
    pub(crate) fn gains(&self, listener: &Listener) -> Option<[f64; 2]> {
        let right = listener.right.try_normalize()?;
        let to_source = self.position - listener.position;
        // Within the reference distance the direction fades to the centre, so that a source passing
        // through the head moves over steadily instead of jumping sides.
        let distance = to_source.length().max(self.reference_distance);
        let meant = to_source.is_finite() && self.level.is_finite() && distance.is_finite();
        if !(meant && self.reference_distance > 0.0) {
            return None;
        }
        let pan = (to_source.dot(right) / distance).clamp(-1.0, 1.0);
        let angle = (pan + 1.0) * std::f64::consts::FRAC_PI_4;
        let amplitude = self.level.clamp(0.0, 1.0) * self.reference_distance / distance;
        Some([amplitude * angle.cos(), amplitude * angle.sin()])
    }
}

/// Everything that the mixer follows; set whole, so that no half of it is ever heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Soundscape {
    /// Who hears.
    pub listener: Listener,
    /// What sounds, if anything.
    pub source: Option<Source>,
    /// How fast the listener flies, in metres per second, as felt: 0 is still air. See
    /// [`Settings::half_wind_speed`](crate::Settings::half_wind_speed).
    pub airspeed: f64,
}

impl Default for Soundscape {
    /// Silence, at the table's centre.
    fn default() -> Self {
        Self {
            listener: Listener::at_table(DVec3::ZERO),
            source: None,
            airspeed: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EAR: Listener = Listener::at_table(DVec3::new(0.1, -0.9, 0.6));

    #[test]
    fn power_depends_on_distance_alone() {
        for step in 0..24 {
            let azimuth = f64::from(step) * std::f64::consts::TAU / 24.0;
            let towards = DVec3::new(azimuth.sin(), azimuth.cos(), 0.0);
            let [l, r] = Source::at(EAR.position + towards).gains(&EAR).unwrap();
            assert!((l.hypot(r) - 0.25).abs() < 1e-12);
        }
    }

    #[test]
    fn a_source_in_the_head_sounds_from_the_middle() {
        let [l, r] = Source::at(EAR.position).gains(&EAR).unwrap();
        assert!((l - r).abs() < 1e-12 && (l.hypot(r) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn numbers_without_meaning_give_no_gains() {
        let listener = EAR;
        let mut source = Source::at(DVec3::NAN);
        assert_eq!(source.gains(&listener), None);
        source = Source::at(DVec3::X);
        source.reference_distance = 0.0;
        assert_eq!(source.gains(&listener), None);
        source = Source::at(DVec3::X);
        source.level = f64::NAN;
        assert_eq!(source.gains(&listener), None);
        let deaf = Listener {
            right: DVec3::ZERO,
            ..listener
        };
        assert_eq!(Source::at(DVec3::X).gains(&deaf), None);
    }
}
