//! The calibration's talk in the window, and the mark that is to be touched, shown on the glass.

use super::show::{GuideReadings, GuideWish, Wish};
use egui::{Align2, Color32, Context, LayerId, Pos2, Rect, RichText, ScrollArea, Stroke, Ui, Vec2};
use sandtable_stage::StereoMode;

/// Lays out the talk and returns what was answered; `entry` is what is being written.
pub(super) fn lay_out(
    context: &Context,
    guide: &GuideReadings,
    mode: StereoMode,
    entry: &mut String,
) -> Vec<Wish> {
    let mut wishes = Vec::new();
    show_mark(context, guide, mode);
    let window = egui::Window::new(format!("Calibration: {}", guide.title))
        .anchor(Align2::CENTER_CENTER, Vec2::ZERO)
        .default_width(560.0)
        .collapsible(false)
        .resizable(false);
    window.show(context, |ui| {
        ScrollArea::vertical()
            .max_height(220.0)
            .stick_to_bottom(true)
            .show(ui, |ui| {
                for line in &guide.lines {
                    ui.monospace(line);
                }
            });
        ui.separator();
        match (&guide.question, guide.ended) {
            (Some(question), _) => {
                ui.label(RichText::new(question).strong().color(Color32::WHITE));
            }
            (None, false) => {
                ui.label("measuring");
            }
            (None, true) => {}
        }
        ui.horizontal(|ui| buttons(ui, guide, entry, &mut wishes));
    });
    wishes
}

fn buttons(ui: &mut Ui, guide: &GuideReadings, entry: &mut String, wishes: &mut Vec<Wish>) {
    let mut wish = |wish| wishes.push(Wish::Guide(wish));
    if guide.ended {
        if ui.button("Close").clicked() {
            wish(GuideWish::Close);
        }
        return;
    }
    if ui.button("Now (Space)").clicked() {
        wish(GuideWish::Answer(String::new()));
    }
    if guide.mark.is_some() && ui.button("Leave out").clicked() {
        wish(GuideWish::Answer("s".into()));
    }
    if ui.button("Stop").clicked() {
        wish(GuideWish::Stop);
    }
    let field = ui.text_edit_singleline(entry);
    let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
    if (entered || ui.button("Say").clicked()) && !entry.is_empty() {
        wish(GuideWish::Answer(std::mem::take(entry)));
    }
}

/// A cross at the mark's place on the glass, in each eye's picture; a ring around it where the mark
/// stands above.
fn show_mark(context: &Context, guide: &GuideReadings, mode: StereoMode) {
    let Some(mark) = guide.mark else {
        return;
    };
    let painter = context.layer_painter(LayerId::background());
    for picture in pictures(context.content_rect(), mode) {
        let at = Pos2::new(
            picture.left() + mark.x as f32 * picture.width(),
            picture.top() + mark.y as f32 * picture.height(),
        );
        for (width, colour) in [(7.0, Color32::BLACK), (3.0, Color32::YELLOW)] {
            let stroke = Stroke::new(width, colour);
            let arms = [Vec2::new(22.0, 0.0), Vec2::new(0.0, 22.0)];
            for arm in arms {
                painter.line_segment([at - arm, at + arm], stroke);
            }
            if guide.mark_is_raised {
                painter.circle_stroke(at, 30.0, stroke);
            }
        }
    }
}

/// Each eye's picture in the window.
fn pictures(window: Rect, mode: StereoMode) -> Vec<Rect> {
    match mode {
        StereoMode::Mono | StereoMode::Anaglyph => vec![window],
        StereoMode::SideBySide => {
            let (left, right) = window.split_left_right_at_fraction(0.5);
            vec![left, right]
        }
        StereoMode::TopBottom => {
            let (top, bottom) = window.split_top_bottom_at_fraction(0.5);
            vec![top, bottom]
        }
    }
}
