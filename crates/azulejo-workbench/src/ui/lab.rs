//! The lab: a lesson beside the view.

use super::panel_context::PanelContext;
use crate::command::Command;
use crate::lab::{Lesson, TextPiece, Verdict, pieces};
use crate::variants::all;
use egui::text::{LayoutJob, TextFormat};
use egui::{
    Button, CollapsingHeader, ComboBox, FontSelection, Label, RichText, ScrollArea, TextEdit,
    TextStyle, Ui, WidgetInfo,
};

/// What was typed, and what was said about it, for each lesson.
#[derive(Default)]
pub struct LabPanel {
    typed: [String; Lesson::COUNT],
    verdicts: [Option<Verdict>; Lesson::COUNT],
}

impl LabPanel {
    /// Draws the lesson that is open.
    pub fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        let lesson = cx.app.lab.lesson;
        head(ui, cx, lesson);
        ui.separator();
        // Each lesson is read from its beginning.
        ScrollArea::vertical()
            .id_salt(lesson.number())
            .auto_shrink([false, false])
            .show(ui, |ui| {
                self.lesson(ui, cx, lesson);
                super::focus::follow(ui);
            });
    }

    fn lesson(&mut self, ui: &mut Ui, cx: &mut PanelContext, lesson: Lesson) {
        let texts = lesson.texts(cx.language);
        ui.add(Label::new(RichText::new(&texts.title).size(18.0).strong()).wrap());
        ui.add_space(4.0);
        for text in &texts.about {
            paragraph(ui, cx, text);
        }
        if ui.button(cx.tr("Open the scene")).clicked() {
            cx.send(Command::OpenLesson);
        }
        ui.add_space(6.0);
        ui.strong(cx.tr("Steps"));
        for (number, text) in (1..).zip(&texts.steps) {
            paragraph(ui, cx, &format!("{number}. {text}"));
        }
        ui.strong(cx.tr("Question"));
        paragraph(ui, cx, &texts.question);
        self.answer(ui, cx, lesson);
        ui.add_space(6.0);
        CollapsingHeader::new(cx.tr("Show the answer"))
            .id_salt(("answer", lesson.number()))
            .show_unindented(ui, |ui| {
                let value = lesson.known_answer().shown();
                for text in &texts.answer {
                    paragraph(ui, cx, &text.replace("{=}", &value));
                }
            });
        ui.add_space(12.0);
    }

    /// The field for the answer, and what is said about it.
    fn answer(&mut self, ui: &mut Ui, cx: &PanelContext, lesson: Lesson) {
        let index = lesson.number() - 1;
        let (typed, verdict) = (&mut self.typed[index], &mut self.verdicts[index]);
        ui.horizontal(|ui| {
            let field = TextEdit::singleline(typed).desired_width(90.0);
            let field = ui.add(field).accessible_name(cx.tr("Your answer"));
            ui.label(lesson.known_answer().unit);
            let is_entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let clicked = ui.button(cx.tr("Check")).clicked();
            if field.changed() {
                *verdict = None;
            }
            if (is_entered || clicked) && !typed.trim().is_empty() {
                *verdict = Some(lesson.check(typed));
            }
        });
        let Some(verdict) = *verdict else {
            return;
        };
        match verdict {
            Verdict::Right => {
                let tolerance = super::light::percent(lesson.known_answer().tolerance);
                let text = format!("✔ {} {tolerance}.", cx.tr("Right, within"));
                ui.strong(text);
            }
            Verdict::Wrong => {
                let hint = &lesson.texts(cx.language).hint;
                paragraph(ui, cx, &format!("{} {hint}", cx.tr("Not yet.")));
            }
            Verdict::Unreadable => {
                let text = RichText::new(cx.tr("This is not a number."));
                ui.label(text.color(ui.visuals().warn_fg_color));
            }
        }
    }
}

/// Narrower panels have the buttons below the list, points.
const NARROW: f32 = 220.0;

/// The choice of the lesson, and how the lab is closed.
fn head(ui: &mut Ui, cx: &mut PanelContext, lesson: Lesson) {
    let mut chosen = lesson;
    if ui.available_width() < NARROW {
        let width = ui.available_width();
        list(ui, cx, &mut chosen, width);
        ui.horizontal(|ui| buttons(ui, cx, &mut chosen));
    } else {
        ui.horizontal(|ui| {
            // What the buttons took in the last frame.
            let id = ui.scope_id().with("buttons");
            let taken: f32 = ui.data(|d| d.get_temp(id)).unwrap_or(120.0);
            let width = ui.available_width() - taken - 2.0 * ui.spacing().item_spacing.x;
            list(ui, cx, &mut chosen, width);
            let shown = ui.horizontal(|ui| buttons(ui, cx, &mut chosen));
            ui.data_mut(|d| d.insert_temp(id, shown.response.rect.width()));
        });
    }
    if chosen != lesson {
        cx.send(Command::ShowLab(Some(chosen)));
    }
}

/// All lessons.
fn list(ui: &mut Ui, cx: &PanelContext, chosen: &mut Lesson, width: f32) {
    let name = |l: Lesson| format!("{}. {}", l.number(), l.texts(cx.language).title);
    let (lab, number) = (cx.tr("Lab"), chosen.number());
    let about = name(*chosen);
    ComboBox::from_id_salt("lesson")
        .width(width.max(40.0))
        .truncate()
        .height(400.0)
        .selected_text(format!("{lab} {number} / {}", Lesson::COUNT))
        .show_ui(ui, |ui| {
            super::focus::close_list(ui);
            for other in all() {
                ui.selectable_value(chosen, other, name(other));
            }
        })
        .response
        .on_hover_text(about);
}

/// The lessons before and after, and the end of the lab.
fn buttons(ui: &mut Ui, cx: &mut PanelContext, chosen: &mut Lesson) {
    let button = |ui: &mut Ui, symbol: &str, name: &str, is_enabled: bool| {
        let button = ui.add_enabled(is_enabled, Button::new(symbol).small());
        let button = button.on_hover_text(name);
        button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, is_enabled, name));
        button.clicked()
    };
    let number = chosen.number();
    for (symbol, name, other) in [
        ("◀", cx.tr("Previous lesson"), number - 1),
        ("▶", cx.tr("Next lesson"), number + 1),
    ] {
        let other = Lesson::from_number(other);
        if button(ui, symbol, name, other.is_some()) {
            *chosen = other.unwrap_or(*chosen);
        }
    }
    if button(ui, "✖", cx.tr("Close the lab"), true) {
        cx.send(Command::ShowLab(None));
    }
}

/// A paragraph with labels of the window in bold, and names as code.
fn paragraph(ui: &mut Ui, cx: &PanelContext, text: &str) {
    let font = FontSelection::Default.resolve(ui.style());
    let mono = TextStyle::Monospace.resolve(ui.style());
    let (plain, strong) = (ui.visuals().text_color(), ui.visuals().strong_text_color());
    let mut job = LayoutJob::default();
    for piece in pieces(text) {
        let (words, font, color) = match piece {
            TextPiece::Plain(words) => (words, &font, plain),
            TextPiece::Label(label) => (cx.language.tr(label), &font, strong),
            TextPiece::Name(name) => (name, &mono, strong),
        };
        job.append(words, 0.0, TextFormat::simple(font.clone(), color));
    }
    ui.add(Label::new(job).wrap());
    ui.add_space(3.0);
}
