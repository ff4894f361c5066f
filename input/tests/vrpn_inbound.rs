//! The VRPN wire's inbound side: who is heard, how reads may be cut, and what a number means.

use glam::{DQuat, DVec3};
use sandtable_input::vrpn::{
    Event, Header, Inbound, LengthError, Report, Stamp, TrackerPose, write_description,
    write_message,
};

const TRACKER: &str = "Tracker0";

fn inbound() -> Inbound {
    Inbound::new([TRACKER, "Wand0"])
}

fn report_bytes(sender: i32, kind: i32, report: &Report<'_>) -> Vec<u8> {
    let header = Header {
        payload: 0,
        stamp: Stamp {
            seconds: 7,
            microseconds: 8,
        },
        sender,
        kind,
        number: 0,
    };
    let mut bytes = Vec::new();
    write_message(&header, |out| report.encode(out), &mut bytes);
    bytes
}

fn described(names: &[(i32, i32, &str)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (kind, number, name) in names {
        write_description(*kind, *number, name.as_bytes(), &mut bytes);
    }
    bytes
}

fn pose(x: f64) -> Report<'static> {
    Report::Pose(TrackerPose {
        sensor: 0,
        position: DVec3::new(x, 0.0, 0.0),
        rotation: DQuat::IDENTITY,
    })
}

/// Names, then poses of the tracker with a stranger's between, and a button of the wand.
fn conversation() -> Vec<u8> {
    let mut bytes = described(&[
        (-1, 0, "VRPN Control"),
        (-1, 5, TRACKER),
        (-1, 9, "Wand0"),
        (-2, 2, "vrpn_Tracker Pos_Quat"),
        (-2, 3, "vrpn_Button Change"),
        (-2, 4, "vrpn_Tracker Workspace"),
    ]);
    bytes.extend(report_bytes(5, 2, &pose(1.0)));
    bytes.extend(report_bytes(0, 2, &pose(9.0)));
    bytes.extend(report_bytes(5, 4, &pose(9.0)));
    bytes.extend(report_bytes(77, 88, &Report::Ping));
    let change = Report::ButtonChange {
        button: 1,
        state: 1,
    };
    bytes.extend(report_bytes(9, 3, &change));
    bytes.extend(report_bytes(5, 2, &pose(2.0)));
    bytes
}

fn events(inbound: &mut Inbound, chunks: &[&[u8]]) -> Vec<String> {
    let mut events = Vec::new();
    for chunk in chunks {
        let result = inbound.push(chunk, &mut |event| events.push(format!("{event:?}")));
        assert_eq!(result, Ok(()));
    }
    events
}

#[test]
fn only_wanted_senders_and_known_types_are_heard() {
    let bytes = conversation();
    let events = events(&mut inbound(), &[&bytes]);
    let reports: Vec<_> = events.iter().filter(|e| e.contains("Report {")).collect();
    assert_eq!(reports.len(), 3);
    assert!(reports[0].contains("sender: 0") && reports[0].contains("seconds: 7"));
    assert!(reports[1].contains("sender: 1") && reports[1].contains("ButtonChange"));
    assert!(
        reports[2].contains("DVec3(2.0, 0.0, 0.0)"),
        "{}",
        reports[2]
    );
    assert_eq!(events.iter().filter(|e| *e == "Foreign").count(), 3);
    assert_eq!(events.iter().filter(|e| e.starts_with("Sender")).count(), 3);
}

#[test]
fn how_the_bytes_were_cut_changes_nothing() {
    let bytes = conversation();
    let whole = events(&mut inbound(), &[&bytes]);
    for at in 0..=bytes.len() {
        let (a, b) = bytes.split_at(at);
        assert_eq!(events(&mut inbound(), &[a, b]), whole, "cut at {at}");
    }
    for size in [1, 7, 23, 24, 25] {
        let chunks: Vec<&[u8]> = bytes.chunks(size).collect();
        assert_eq!(events(&mut inbound(), &chunks), whole, "reads of {size}");
    }
}

#[test]
fn numbers_mean_what_this_connection_says() {
    let mut inbound = inbound();
    let named = described(&[(-1, 1, TRACKER), (-2, 2, "vrpn_Tracker Pos_Quat")]);
    let said = report_bytes(1, 2, &pose(0.0));
    assert_eq!(events(&mut inbound, &[&said]), ["Foreign"]);
    assert_eq!(events(&mut inbound, &[&named, &said]).len(), 2);
    // Numbers given to other names mean those from then on.
    let renamed = described(&[(-1, 1, "Other")]);
    assert_eq!(events(&mut inbound, &[&renamed, &said])[1], "Foreign");
    assert_eq!(events(&mut inbound, &[&named, &said]).len(), 2);
    // After a restart neither the senders' numbers mean anything nor the types'.
    let sender = described(&[(-1, 1, TRACKER)]);
    let kind = described(&[(-2, 2, "vrpn_Tracker Pos_Quat")]);
    for half in [&sender, &kind] {
        events(&mut inbound, &[&named]);
        inbound.restart();
        let events = events(&mut inbound, &[half, &said]);
        assert_eq!(events.last().map(String::as_str), Some("Foreign"));
    }
}

#[test]
fn an_impossible_length_ends_it_until_a_restart() {
    let mut inbound = inbound();
    let mut bytes = report_bytes(0, 0, &Report::Ping);
    bytes[..4].copy_from_slice(&0x8000_0000u32.to_be_bytes());
    let claimed = 0x8000_0000;
    let mut none = |event: Event<'_>| panic!("{event:?}");
    assert_eq!(
        inbound.push(&bytes, &mut none),
        Err(LengthError { claimed })
    );
    assert_eq!(
        inbound.push(&conversation(), &mut none),
        Err(LengthError { claimed })
    );
    assert_eq!(inbound.problem(), Some(LengthError { claimed }));
    inbound.restart();
    assert!(!events(&mut inbound, &[&conversation()]).is_empty());
    // The same, byte by byte.
    let mut result = Ok(());
    for byte in &bytes {
        result = inbound.push(&[*byte], &mut none);
    }
    assert_eq!(result, Err(LengthError { claimed }));
}
