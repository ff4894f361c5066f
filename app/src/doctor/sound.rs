//! Sound outputs.

use std::path::Path;

use sandtable_audio::{OutputDevice, list_outputs};
use serde_json::json;

use super::finding::{Finding, Item};
use super::remedy::{install, join_group};

pub(super) fn examine() -> Result<Finding, String> {
    let outputs = list_outputs().map_err(|error| error.to_string())?;
    // Not so of a sound server elsewhere, but then the default output works.
    let has_card = !cfg!(target_os = "linux") || Path::new("/dev/snd").exists();
    Ok(judge(&outputs, has_card))
}

fn judge(outputs: &[OutputDevice], has_card: bool) -> Finding {
    let mut finding = Finding::default();
    for output in outputs.iter().filter(|output| !leads_nowhere(output)) {
        let which = if output.is_default { "default, " } else { "" };
        let (detail, usable) = match &output.format {
            Ok((channels, rate)) => (format!("{which}{channels} channels at {rate} Hz"), true),
            // Of the many that a sound system may offer, those that do not work help nobody.
            Err(_) if !output.is_default => continue,
            Err(error) => (format!("{which}cannot be opened: {error}"), false),
        };
        finding.found(Item::new(
            &output.name,
            detail,
            json!({
                "id": output.id,
                "default": output.is_default,
                "usable": usable,
                "channels": output.format.as_ref().ok().map(|f| f.0),
                "sample_rate": output.format.as_ref().ok().map(|f| f.1),
            }),
        ));
    }
    let plays = outputs
        .iter()
        .any(|output| output.is_default && output.format.is_ok());
    if plays {
        return finding;
    }
    finding.advise(if !has_card {
        "The kernel knows no sound card (there is no /dev/snd), so sandtable is silent: plug one \
         in, or in a container share /dev/snd with it."
            .to_owned()
    } else if cfg!(target_os = "linux") {
        format!(
            "The default output cannot be opened, so sandtable is silent: {}. With PipeWire or \
             PulseAudio: {}.",
            join_group("audio"),
            install(&["pipewire-alsa"])
        )
    } else {
        "The default output cannot be opened, so sandtable is silent: choose one that works in the \
         system's sound settings."
            .to_owned()
    });
    finding
}

/// ALSA offers one that takes any sound and drops it.
fn leads_nowhere(output: &OutputDevice) -> bool {
    output.id == "alsa:null"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(id: &str, is_default: bool, works: bool) -> OutputDevice {
        OutputDevice {
            name: id.to_owned(),
            id: id.to_owned(),
            is_default,
            format: works
                .then_some((2, 48_000))
                .ok_or_else(|| "No such file".to_owned()),
        }
    }

    #[test]
    fn a_machine_without_a_card_is_silent_though_alsa_lists_outputs() {
        let finding = judge(
            &[
                output("alsa:null", false, true),
                output("alsa:default", true, false),
                output("alsa:front", false, false),
            ],
            false,
        );
        assert_eq!(finding.advice.len(), 1);
        let json = finding.json();
        assert_eq!(json.as_array().unwrap().len(), 1);
        assert_eq!(json[0]["usable"], false);
        assert!(finding.advice[0].contains("/dev/snd"));
        assert!(!judge(&[], true).advice[0].contains("/dev/snd"));
    }

    #[test]
    fn a_default_that_plays_is_all_one_needs() {
        let finding = judge(
            &[
                output("alsa:default", true, true),
                output("alsa:hdmi", false, true),
            ],
            true,
        );
        assert!(finding.advice.is_empty());
        assert_eq!(finding.json()[0]["sample_rate"], 48_000);
        assert_eq!(finding.json()[1]["default"], false);
    }
}
