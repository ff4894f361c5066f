//! What there is to see, hear and touch with, what is missing, and how to get it.
//!
//! Each check runs on a thread of its own and has only so long: a driver that crashes or hangs
//! costs its own section, never the others.

mod access;
mod device;
#[cfg_attr(not(target_os = "linux"), path = "doctor/display_elsewhere.rs")]
mod display;
mod finding;
mod gamepad;
mod gpu;
mod hid;
mod program;
mod remedy;
mod rig;
mod serial;
mod sound;
#[cfg(target_os = "linux")]
mod window_library;

use std::fmt;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use sandtable_config::Rig;
use serde_json::{Value, json};

use finding::Finding;

/// How long all checks together may take. Loading a GPU driver for the first time takes seconds.
const LIMIT: Duration = Duration::from_secs(20);

/// Examines this machine, and the devices of a rig where one is given. Takes some seconds, at most
/// 20.
pub(crate) fn examine(rig: Option<Rig>) -> Report {
    let mut checks = vec![
        Check::new("gpus", "GPUs", gpu::examine),
        Check::new("displays", "Displays", display::examine),
        Check::new(
            "serial_ports",
            "Serial ports (trackers, PINCH gloves)",
            serial::examine,
        ),
        Check::new("hid_devices", "HID devices (gloves)", hid::examine),
        Check::new("gamepads", "Gamepads", gamepad::examine),
        Check::new("sound_outputs", "Sound outputs", sound::examine),
        Check::new("programs", "Programs", program::examine),
    ];
    if let Some(rig) = rig {
        let examined = rig.clone();
        let examine = move || Ok(rig::examine(&examined));
        checks.push(Check::new("rig", "The rig", examine));
        let examine = move || device::examine(&rig);
        checks.push(Check::new("devices", "Devices of the rig", examine));
    }
    run(checks, LIMIT)
}

/// What was found, section by section.
///
/// Displayed, it is text for people.
pub(crate) struct Report {
    sections: Vec<Section>,
}

impl Report {
    /// For programs: an object with a member for each section.
    ///
    /// Each has `status` (`ok`; `missing`, if something is not there that one might want; `failed`,
    /// if the check itself did not work), `found` (a list of objects, each with a `name`), `advice`
    /// (a list of sentences) and `error` (null unless failed).
    pub(crate) fn json(&self) -> Value {
        self.sections
            .iter()
            .map(|section| (section.key.to_owned(), section.json()))
            .collect()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, section) in self.sections.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            writeln!(f, "{}: {}", section.title, section.status())?;
            match &section.outcome {
                Ok(finding) => write!(f, "{finding}")?,
                Err(error) => writeln!(f, "  {error}")?,
            }
        }
        Ok(())
    }
}

/// One thing to look into.
struct Check {
    key: &'static str,
    title: &'static str,
    examine: Box<dyn FnOnce() -> Result<Finding, String> + Send>,
}

impl Check {
    fn new(
        key: &'static str,
        title: &'static str,
        examine: impl FnOnce() -> Result<Finding, String> + Send + 'static,
    ) -> Self {
        Self {
            key,
            title,
            examine: Box::new(examine),
        }
    }
}

/// What came of it.
struct Section {
    key: &'static str,
    title: &'static str,
    outcome: Result<Finding, String>,
}

impl Section {
    fn status(&self) -> &'static str {
        match &self.outcome {
            Ok(finding) if finding.advice.is_empty() => "ok",
            Ok(_) => "missing",
            Err(_) => "failed",
        }
    }

    fn json(&self) -> Value {
        let (found, advice, error) = match &self.outcome {
            Ok(finding) => (finding.json(), json!(finding.advice), Value::Null),
            Err(error) => (json!([]), json!([]), json!(error)),
        };
        json!({ "status": self.status(), "found": found, "advice": advice, "error": error })
    }
}

type Outcome = Result<Finding, String>;

/// A check that was started: its key and title, its thread, and where its outcome comes.
type Pending = (
    [&'static str; 2],
    std::io::Result<JoinHandle<()>>,
    mpsc::Receiver<Outcome>,
);

/// Runs all checks at once and waits for them until `limit`.
fn run(checks: Vec<Check>, limit: Duration) -> Report {
    let deadline = Instant::now() + limit;
    let pending: Vec<Pending> = checks
        .into_iter()
        .map(
            |Check {
                 key,
                 title,
                 examine,
             }| {
                let (sender, outcome) = mpsc::channel();
                let started = std::thread::Builder::new()
                    .name(format!("doctor: {key}"))
                    // The receiver may have given up by then.
                    .spawn(move || drop(sender.send(examine())));
                ([key, title], started, outcome)
            },
        )
        .collect();
    let section = |([key, title], started, outcome): Pending| {
        let left = deadline.saturating_duration_since(Instant::now());
        let outcome = match (started, outcome.recv_timeout(left)) {
            (Err(error), _) => Err(format!("there is no thread for this check: {error}")),
            (Ok(_), Ok(outcome)) => outcome,
            (Ok(_), Err(RecvTimeoutError::Timeout)) => Err(format!(
                "no answer within {} s: a driver or service hangs",
                limit.as_secs_f64()
            )),
            (Ok(_), Err(RecvTimeoutError::Disconnected)) => {
                Err("this check crashed; what it said stands above".to_owned())
            }
        };
        Section {
            key,
            title,
            outcome,
        }
    };
    Report {
        sections: pending.into_iter().map(section).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use finding::Item;

    fn good() -> Result<Finding, String> {
        let mut finding = Finding::default();
        finding.found(Item::new("a thing", "shiny", json!({ "shine": 3 })));
        Ok(finding)
    }

    fn check(key: &'static str, examine: fn() -> Result<Finding, String>) -> Check {
        Check::new(key, key, examine)
    }

    #[test]
    fn a_check_that_fails_crashes_or_hangs_hides_no_other() {
        let report = run(
            vec![
                check("fails", || Err("not today".into())),
                check("crashes", || panic!("a driver does this")),
                check("hangs", || {
                    loop {
                        std::thread::park();
                    }
                }),
                check("lacks", || {
                    let mut finding = Finding::default();
                    finding.advise("buy one".to_owned());
                    Ok(finding)
                }),
                check("works", good),
            ],
            Duration::from_secs(1),
        );
        let json = report.json();
        let status = |key: &str| json[key]["status"].clone();
        assert_eq!(status("fails"), "failed");
        assert_eq!(status("crashes"), "failed");
        assert_eq!(status("hangs"), "failed");
        assert_eq!(status("lacks"), "missing");
        assert_eq!(status("works"), "ok");
        assert_eq!(json["fails"]["error"], "not today");
        assert!(json["hangs"]["error"].as_str().unwrap().contains("1 s"));
        assert_eq!(json["works"]["error"], Value::Null);
        assert_eq!(
            json["works"]["found"],
            json!([{ "name": "a thing", "shine": 3 }])
        );
        assert_eq!(json["lacks"]["advice"], json!(["buy one"]));

        let text = report.to_string();
        for line in [
            "fails: failed",
            "  not today",
            "lacks: missing",
            "  → buy one",
            "works: ok",
            "  a thing: shiny",
        ] {
            assert!(text.lines().any(|l| l == line), "no {line:?} in\n{text}");
        }
    }

    /// Whatever this machine has or lacks, every section is there and says something.
    #[test]
    fn this_machine_is_examined_whole() {
        let report = examine(None);
        let json = report.json();
        for key in [
            "gpus",
            "displays",
            "serial_ports",
            "hid_devices",
            "gamepads",
            "sound_outputs",
            "programs",
        ] {
            let section = &json[key];
            let [found, advice] = ["found", "advice"].map(|k| section[k].as_array().unwrap());
            assert!(found.iter().all(|item| item["name"].is_string()), "{key}");
            let said = found.len() + advice.len() + usize::from(!section["error"].is_null());
            assert!(said > 0, "{key} says nothing");
        }
    }
}
