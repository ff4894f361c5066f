//! A rig's glass and head: whether what the file says can be meant.

use super::finding::{Finding, Item};
use sandtable_config::{Rig, Viewing};
use serde_json::json;

pub(super) fn examine(rig: &Rig) -> Finding {
    let mut finding = Finding::default();
    let item = match (&rig.viewing, &rig.head) {
        (Viewing::Table(table), Some(head)) => {
            let width = table.lower_left.distance(table.lower_right);
            let height = table.lower_left.distance(table.upper_left);
            let before = table.before_glass(head.rest.point(head.eyes.middle));
            let side = if before < 0.0 { "behind" } else { "before" };
            let detail = format!(
                "a glass of {width:.2} by {height:.2} m, the eyes of the head at rest {:.2} m {side} it",
                before.abs()
            );
            let facts = json!({ "glass_m": [width, height], "eyes_before_glass_m": before });
            Item::new(&rig.name, detail, facts)
        }
        _ => Item::new(&rig.name, "a desktop", json!({})),
    };
    finding.found(item);
    for doubt in rig.doubts() {
        let doubt = doubt.to_string();
        let mut letters = doubt.chars();
        let first = letters.next().map(|letter| letter.to_ascii_uppercase());
        finding.advise(format!("{}{}.", String::from_iter(first), letters.as_str()));
    }
    finding
}
