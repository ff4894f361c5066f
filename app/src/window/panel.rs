//! The panel below the picture: where one is, how fast, by which caster and in which stereo mode.

use super::latency::{LatencyTable, milliseconds};
use super::show::{Device, GuideStep, GuideWish, Readings, TableReadings, Wish};
use crate::scene::caster_choices;
use egui::{
    Color32, ComboBox, DragValue, Frame, Grid, Label, RichText, ScrollArea, TextWrapMode, Ui,
};
use sandtable_stage::StereoMode;
use sandtable_view::Attitude;
use std::time::Duration;

/// The panel's own settings: those of the window, not of what it shows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Settings {
    pub(super) mode: StereoMode,
    pub(super) swap_eyes: bool,
    /// Eyes are cast at their size divided by this.
    pub(super) reduction: u32,
    /// Whether the list of keys shows.
    pub(super) keys: bool,
    /// What is being written to the calibration.
    pub(super) entry: String,
}

/// What the panel says about the window and its threads.
#[derive(Clone, Debug, Default)]
pub(super) struct Vitals {
    pub(super) cast_ms: Option<f64>,
    pub(super) casts_per_second: usize,
    pub(super) display_ms: Option<f64>,
    pub(super) frames_per_second: usize,
    /// Once a frame has been shown that follows a tracked head.
    pub(super) latency: Option<LatencyTable>,
    pub(super) threads: usize,
    pub(super) eye_size: [u32; 2],
    pub(super) gpu: String,
    pub(super) messages: Vec<String>,
}

/// The latency shown is of the frames of this last while.
pub(super) const LATELY: Duration = Duration::from_secs(2);

/// How many messages show at once, the newest last.
const MESSAGES: usize = 3;

/// Lays the panel out and returns what was asked for.
pub(super) fn lay_out(
    ui: &mut Ui,
    settings: &mut Settings,
    readings: &Readings,
    vitals: &Vitals,
    bindings: &[(String, String)],
) -> Vec<Wish> {
    let mut wishes = Vec::new();
    let background = Frame::new()
        .fill(Color32::from_rgba_unmultiplied(24, 26, 30, 232))
        .inner_margin(8);
    egui::Panel::bottom("panel")
        .frame(background)
        .show(ui, |ui| {
            ScrollArea::horizontal().show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    ui.spacing_mut().item_spacing.x = 18.0;
                    ui.style_mut().wrap_mode = Some(TextWrapMode::Extend);
                    column(ui, "Position", |ui| position(ui, readings, &mut wishes));
                    column(ui, "Attitude", |ui| attitude(ui, readings, &mut wishes));
                    column(ui, "Flight", |ui| flight(ui, readings, &mut wishes));
                    column(ui, "Picture", |ui| {
                        picture(ui, settings, readings, &mut wishes);
                    });
                    column(ui, "Times", |ui| times(ui, vitals));
                    // Before what hardly changes: in a narrow window the last columns lie beside it.
                    column(ui, "Devices", |ui| devices(ui, &readings.devices));
                    column(ui, "Terrain", |ui| {
                        terrain(ui, readings, &mut settings.keys);
                    });
                    if readings.can_calibrate {
                        column(ui, "Calibrate", |ui| calibrations(ui, &mut wishes));
                    }
                });
            });
            messages(ui, readings.messages.iter().chain(&vitals.messages));
        });
    if settings.keys {
        let room = ui.ctx().content_rect().height() - 60.0;
        let window = egui::Window::new("Controls").open(&mut settings.keys);
        let window = window.vscroll(true).default_height(room).max_height(room);
        window.show(ui.ctx(), |ui| controls(ui, bindings));
    }
    wishes
}

fn column(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    ui.vertical(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        ui.label(RichText::new(title).strong().color(Color32::WHITE));
        Grid::new(title).num_columns(2).show(ui, contents);
    });
}

/// A number that can be dragged or typed; returns the new one.
fn number(
    ui: &mut Ui,
    label: &str,
    value: f64,
    style: impl FnOnce(DragValue<'_>) -> DragValue<'_>,
) -> Option<f64> {
    let mut edited = value;
    ui.label(label);
    let changed = ui
        .add(style(
            DragValue::new(&mut edited).update_while_editing(false),
        ))
        .changed();
    ui.end_row();
    (changed && edited.is_finite()).then_some(edited)
}

fn position(ui: &mut Ui, readings: &Readings, wishes: &mut Vec<Wish>) {
    let mut position = readings.position;
    for (label, axis) in [("x (east)", 0), ("y (north)", 1), ("height", 2)] {
        if let Some(value) = number(ui, label, position[axis], |drag| {
            drag.speed(10.0).fixed_decimals(0).suffix(" m")
        }) {
            position[axis] = value;
            wishes.push(Wish::Position(position));
        }
    }
    // The middle of a glass is a place on the table, not one that flies.
    if readings.table.is_some() {
        return;
    }
    ui.label("above ground");
    ui.label(readings.above_ground.map_or_else(
        || "off the terrain".to_owned(),
        |height| format!("{height:.0} m"),
    ));
    ui.end_row();
}

fn attitude(ui: &mut Ui, readings: &Readings, wishes: &mut Vec<Wish>) {
    let looking = readings.attitude;
    let degrees = |ui: &mut Ui, label: &str, angle: f64| {
        number(ui, label, angle.to_degrees(), |drag| {
            drag.speed(0.5).fixed_decimals(1).suffix("\u{b0}")
        })
        .map(f64::to_radians)
    };
    if let Some(yaw) = degrees(ui, "yaw", looking.yaw) {
        wishes.push(Wish::Attitude(Attitude { yaw, ..looking }));
    }
    if let Some(table) = readings.table {
        if let Some(scale) = number(ui, "scale 1 :", table.scale, |drag| {
            drag.speed(table.scale * 0.01).fixed_decimals(0)
        }) {
            wishes.push(Wish::Table(TableReadings { scale, ..table }));
        }
        if let Some(exaggeration) = number(ui, "relief \u{d7}", table.exaggeration, |drag| {
            drag.speed(0.02).fixed_decimals(2)
        }) {
            wishes.push(Wish::Table(TableReadings {
                exaggeration,
                ..table
            }));
        }
        return;
    }
    if let Some(pitch) = degrees(ui, "pitch", looking.pitch) {
        wishes.push(Wish::Attitude(Attitude { pitch, ..looking }));
    }
    if let Some(roll) = degrees(ui, "roll", looking.roll) {
        wishes.push(Wish::Attitude(Attitude { roll, ..looking }));
    }
}

fn flight(ui: &mut Ui, readings: &Readings, wishes: &mut Vec<Wish>) {
    if let Some(speed) = number(ui, "speed", readings.speed, |drag| {
        drag.speed(readings.speed * 0.01 + 0.01)
            .range(0.0..=1e6)
            .max_decimals(1)
            .suffix(" m/s")
    }) {
        wishes.push(Wish::Speed(speed));
    }
    ui.label("hand");
    ui.label(readings.hand.mode);
    ui.end_row();
    ui.label("points at");
    ui.label(readings.hand.pointed.map_or_else(
        || "-".to_owned(),
        |at| format!("{:.0} E, {:.0} N, {:.0} m", at.x, at.y, at.z),
    ));
    ui.end_row();
    ui.label("start");
    if ui.button("back").clicked() {
        wishes.push(Wish::Home);
    }
    ui.end_row();
}

fn picture(ui: &mut Ui, settings: &mut Settings, readings: &Readings, wishes: &mut Vec<Wish>) {
    ui.label("caster");
    ComboBox::from_id_salt("caster")
        .selected_text(&readings.caster)
        .show_ui(ui, |ui| {
            for (name, summary) in caster_choices() {
                let label = ui.selectable_label(readings.caster == name, name);
                if label.on_hover_text(summary).clicked() {
                    wishes.push(Wish::Caster(name));
                }
            }
        });
    ui.end_row();
    ui.label("stereo");
    ComboBox::from_id_salt("stereo")
        .selected_text(settings.mode.name())
        .show_ui(ui, |ui| {
            for mode in StereoMode::ALL {
                ui.selectable_value(&mut settings.mode, mode, mode.name());
            }
        });
    ui.end_row();
    ui.label("eyes");
    ui.checkbox(&mut settings.swap_eyes, "swapped");
    ui.end_row();
    ui.label("cast at");
    let share = |reduction: u32| match reduction {
        1 => "full size".to_owned(),
        reduction => format!("1/{reduction} size"),
    };
    ComboBox::from_id_salt("reduction")
        .selected_text(share(settings.reduction))
        .show_ui(ui, |ui| {
            for reduction in [1, 2, 4] {
                ui.selectable_value(&mut settings.reduction, reduction, share(reduction));
            }
        });
    ui.end_row();
}

fn times(ui: &mut Ui, vitals: &Vitals) {
    let row = |ui: &mut Ui, label: &str, time: Option<f64>, rate: usize, hint: &str| {
        ui.label(label).on_hover_text(hint);
        ui.label(time.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.1} ms, {rate}/s")));
        ui.end_row();
    };
    let cast_hint = "time of the last cast, of all its eyes, and casts in the last second";
    row(
        ui,
        "cast",
        vitals.cast_ms,
        vitals.casts_per_second,
        cast_hint,
    );
    let display_hint = format!("time of the last frame, without waiting, on {}", vitals.gpu);
    row(
        ui,
        "display",
        vitals.display_ms,
        vitals.frames_per_second,
        &display_hint,
    );
    if let Some(table) = &vitals.latency {
        to_the_glass(ui, table);
    }
    ui.label("threads");
    ui.label(vitals.threads.to_string());
    ui.end_row();
    ui.label("an eye");
    let [width, height] = vitals.eye_size;
    ui.label(format!("{width} \u{d7} {height}"));
    ui.end_row();
}

/// From the head's measurement to the frame that follows it; all stages where it is pointed at.
fn to_the_glass(ui: &mut Ui, table: &LatencyTable) {
    let [median, p95] = [table.total.median, table.total.p95].map(milliseconds);
    let label = ui.label("to the glass");
    let value = ui.label(format!("{median:.1} ms, 95 % {p95:.1}"));
    label.union(value).on_hover_ui(|ui| {
        ui.label("from a measurement of the head to the frame presented, in the last 2 s");
        ui.monospace(table.to_string());
    });
    ui.end_row();
}

/// How many points of a device's state show: all of it where it is pointed at.
const ROOM: f32 = 160.0;

fn devices(ui: &mut Ui, devices: &[Device]) {
    if devices.is_empty() {
        ui.label("keyboard, mouse");
        ui.end_row();
    }
    for device in devices {
        ui.label(&device.name);
        let colour = if device.works {
            Color32::LIGHT_GREEN
        } else {
            Color32::from_rgb(255, 170, 90)
        };
        ui.scope(|ui| {
            ui.set_max_width(ROOM);
            ui.add(Label::new(RichText::new(&device.state).color(colour)).truncate());
        });
        ui.end_row();
    }
}

/// The calibration's steps, two a row.
fn calibrations(ui: &mut Ui, wishes: &mut Vec<Wish>) {
    for pair in GuideStep::ALL.chunks(2) {
        for step in pair {
            if ui
                .button(step.name())
                .on_hover_text(step.meaning())
                .clicked()
            {
                wishes.push(Wish::Guide(GuideWish::Begin(*step)));
            }
        }
        ui.end_row();
    }
}

fn terrain(ui: &mut Ui, readings: &Readings, keys: &mut bool) {
    ui.label("name");
    ui.label(&readings.terrain);
    ui.end_row();
    ui.label("help");
    ui.toggle_value(keys, "what asks for what");
    ui.end_row();
}

/// The newest messages, a line each, as wide as the panel.
fn messages<'a>(ui: &mut Ui, all: impl Iterator<Item = &'a String>) {
    let all: Vec<_> = all.collect();
    for message in &all[all.len().saturating_sub(MESSAGES)..] {
        ui.add(egui::Label::new(*message).truncate());
    }
}

/// What people can ask for, and by what.
fn controls(ui: &mut Ui, bindings: &[(String, String)]) {
    Grid::new("controls").num_columns(2).show(ui, |ui| {
        for (meaning, sources) in bindings {
            ui.label(meaning);
            ui.label(RichText::new(sources).strong());
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::latency::Spread;
    use glam::DVec3;

    /// Lays the panel out a few times without anybody touching it.
    fn untouched(readings: &Readings) -> Vec<Wish> {
        let mut settings = Settings {
            mode: StereoMode::Anaglyph,
            swap_eyes: true,
            reduction: 2,
            keys: true,
            entry: String::new(),
        };
        let before = settings.clone();
        let context = egui::Context::default();
        let mut wishes = Vec::new();
        for _ in 0..3 {
            let mut output = context.run_ui(egui::RawInput::default(), |ui| {
                let bindings = [("act".to_owned(), "key Space".to_owned())];
                wishes.extend(lay_out(
                    ui,
                    &mut settings,
                    readings,
                    &Vitals::default(),
                    &bindings,
                ));
            });
            assert!(output.shapes.len() > 20, "the panel is empty");
            output.textures_delta.clear();
        }
        assert_eq!(settings, before);
        wishes
    }

    #[test]
    fn an_untouched_panel_asks_for_nothing() {
        // Values that no display of theirs gives back exactly.
        let camera = Readings {
            position: DVec3::new(1_234.567_89, -0.004, 2_345.678_9),
            attitude: Attitude {
                yaw: 0.123_456_7,
                pitch: -1.2,
                roll: 0.3,
            },
            speed: 123.456_789,
            caster: "planes".to_owned(),
            messages: vec!["a message".into(); 9],
            ..Default::default()
        };
        assert_eq!(untouched(&camera), []);
        let table = Readings {
            table: Some(TableReadings {
                scale: 12_345.678,
                exaggeration: 1.234_567,
            }),
            can_calibrate: true,
            devices: vec![Device {
                name: "head".into(),
                state: "lost".into(),
                works: false,
            }],
            ..camera
        };
        assert_eq!(untouched(&table), []);
    }

    /// All words on the panel.
    fn words(vitals: &Vitals) -> Vec<String> {
        let mut settings = Settings {
            mode: StereoMode::Mono,
            swap_eyes: false,
            reduction: 1,
            keys: false,
            entry: String::new(),
        };
        let context = egui::Context::default();
        let mut words = Vec::new();
        for _ in 0..2 {
            let mut output = context.run_ui(egui::RawInput::default(), |ui| {
                lay_out(ui, &mut settings, &Readings::default(), vitals, &[]);
            });
            output.textures_delta.clear();
            let shapes = output.shapes.into_iter();
            words = shapes
                .filter_map(|clipped| match clipped.shape {
                    egui::Shape::Text(text) => Some(text.galley.text().to_owned()),
                    _ => None,
                })
                .collect();
        }
        words
    }

    #[test]
    fn the_way_to_the_glass_shows_once_it_is_known() {
        let untracked = words(&Vitals::default());
        assert!(untracked.contains(&"display".to_owned()));
        assert!(!untracked.contains(&"to the glass".to_owned()));
        let ms = Duration::from_millis;
        let spread = |median, p95| Spread {
            median: ms(median),
            p95: ms(p95),
        };
        let table = LatencyTable {
            frames: 9,
            stages: [spread(3, 4); 5],
            total: spread(15, 19),
            predicted: spread(0, 0),
        };
        let tracked = words(&Vitals {
            latency: Some(table),
            ..Vitals::default()
        });
        assert!(tracked.contains(&"to the glass".to_owned()));
        assert!(tracked.contains(&"15.0 ms, 95 % 19.0".to_owned()));
    }
}
