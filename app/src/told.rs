//! What commands without a window say of their devices, each thing once.

use sandtable_input::{Condition, DeviceState, Devices};

/// What has been said so far.
#[derive(Default)]
pub(crate) struct Told(Vec<(String, &'static str)>);

impl Told {
    /// Says what has become of each device since the last time.
    pub(crate) fn tell(&mut self, devices: &Devices) {
        for line in self.news(devices.states()) {
            eprintln!("{line}");
        }
    }

    fn news(&mut self, states: Vec<DeviceState>) -> Vec<String> {
        let told = |state: DeviceState| {
            let word = word(&state);
            (state.name, word)
        };
        let conditions: Vec<_> = states.into_iter().map(told).collect();
        let news = conditions.iter().filter(|told| !self.0.contains(told));
        let lines = news.map(|(name, word)| format!("{name}: {word}")).collect();
        self.0 = conditions;
        lines
    }
}

/// A device's condition in a word. Why it waits the driver logs, whenever that changes; that it is
/// tried again twice a second is no news.
fn word(state: &DeviceState) -> &'static str {
    match state.condition {
        Condition::Streaming => "streaming",
        Condition::Starting if state.trouble.is_none() => "starting",
        Condition::Starting | Condition::Waiting(_) => "waiting",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_input::StreamCounts;

    #[test]
    fn a_device_that_is_gone_is_told_once_until_it_is_back() {
        let mut told = Told::default();
        let mut news = |condition: Condition, trouble: Option<&str>| {
            told.news(vec![DeviceState {
                name: "flock".into(),
                condition,
                counts: StreamCounts::default(),
                trouble: trouble.map(str::to_owned),
            }])
        };
        let waiting = |why: &str| Condition::Waiting(why.to_owned());
        assert_eq!(news(Condition::Starting, None), ["flock: starting"]);
        assert_eq!(news(Condition::Streaming, None), ["flock: streaming"]);
        assert_eq!(
            news(waiting("it is gone"), Some("it is gone")),
            ["flock: waiting"]
        );
        let none: [&str; 0] = [];
        assert_eq!(news(Condition::Starting, Some("it is gone")), none);
        assert_eq!(
            news(waiting("cannot open it"), Some("cannot open it")),
            none
        );
        assert_eq!(news(Condition::Streaming, None), ["flock: streaming"]);
    }
}
