//! Input fields for numbers and colours of the document. Displaying a value never changes it.

use crate::ui::focus;
use azulejo::scene::Rgb;
use egui::emath::format_with_decimals_in_range;
use egui::{ComboBox, DragValue, Id, Response, Slider, Ui, Widget, WidgetText};
use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::rc::Rc;

/// Tolerance per channel within which a colour counts as unchanged, linear and relative to the
/// brightest channel if that is above 1: the colour picker converts to gamma and back in 32 bits,
/// which does not preserve all colours.
const TOLERANCE: f64 = 1e-5;

/// A label and a field of this name.
pub fn labelled(ui: &mut Ui, name: &str, field: impl Widget) -> Response {
    let label = ui.label(name);
    ui.add(field).labelled_by(label.id)
}

/// The same as a row of a grid.
pub fn labelled_row(ui: &mut Ui, name: &str, field: impl Widget) -> Response {
    let field = labelled(ui, name, field);
    ui.end_row();
    field
}

/// A row of a grid with a relative error as a percentage.
pub fn error_row(ui: &mut Ui, name: &str, about: &str, error: &mut f64) {
    let label = ui.label(name).on_hover_text(about);
    let mut percent = 100.0 * *error;
    let drag = DragValue::new(&mut percent)
        .range(0.1..=100.0)
        .speed(0.05)
        .max_decimals(2)
        .suffix(" %")
        .update_while_editing(false);
    let field = ui.add(drag).labelled_by(label.id).on_hover_text(about);
    if field.changed() {
        *error = percent / 100.0;
    }
    ui.end_row();
}

/// A list from which a value is chosen; `name` returns the text of an entry.
pub fn choice<T: PartialEq, N: Into<WidgetText>>(
    combo: ComboBox,
    ui: &mut Ui,
    value: &mut T,
    entries: impl IntoIterator<Item = T>,
    name: impl Fn(&T) -> N,
) -> Response {
    let combo = combo.selected_text(name(value));
    let shown = combo.show_ui(ui, |ui| {
        focus::close_list(ui);
        for entry in entries {
            let text = name(&entry);
            ui.selectable_value(value, entry, text);
        }
    });
    shown.response
}

/// A number field with `range`. A value outside the range stays until the user changes it.
pub fn number(value: &mut f64, range: RangeInclusive<f64>) -> DragValue<'_> {
    let range = range.start().min(*value)..=range.end().max(*value);
    let read = ShownNumber::default();
    let show = ShownNumber(Rc::clone(&read.0));
    DragValue::new(value)
        .range(range)
        .update_while_editing(false)
        .custom_formatter(move |x, decimals| show.text(x, decimals))
        .custom_parser(move |text| read.number(text))
}

/// The same with a slider.
pub fn slider(value: &mut f64, range: RangeInclusive<f64>) -> Slider<'_> {
    let read = ShownNumber::default();
    let show = ShownNumber(Rc::clone(&read.0));
    Slider::new(value, range)
        .update_while_editing(false)
        .custom_formatter(move |x, decimals| show.text(x, decimals))
        .custom_parser(move |text| read.number(text))
}

/// A number and the text that displayed it: the text stands for the number with all its digits.
#[derive(Default)]
struct ShownNumber(Rc<RefCell<(f64, String)>>);

impl ShownNumber {
    fn text(&self, x: f64, decimals: RangeInclusive<usize>) -> String {
        let text = format_with_decimals_in_range(x, decimals);
        self.0.replace((x, text.clone()));
        text
    }

    fn number(&self, text: &str) -> Option<f64> {
        let (x, shown) = &*self.0.borrow();
        if text == shown { Some(*x) } else { parse(text) }
    }
}

/// Parses a number with spaces between thousands or a typographic minus sign.
fn parse(text: &str) -> Option<f64> {
    let written = text.chars().filter(|c| !c.is_whitespace());
    let plain: String = written.map(|c| if c == '−' { '-' } else { c }).collect();
    plain.parse().ok()
}

/// The last colour of a picker, and the document's colour made from it.
#[derive(Clone, Copy)]
struct PickedColor {
    shown: [f32; 3],
    made: Rgb,
}

/// A button that opens a colour picker; returns whether another colour was picked. `settle` maps
/// the picked colour to the one to store, or rejects it.
pub fn picked(
    ui: &mut Ui,
    name: &str,
    color: &mut Rgb,
    settle: impl Fn(Rgb) -> Option<Rgb>,
) -> bool {
    let id = ui.auto_id_with("picked");
    // The hue of a grey survives only in the picker's own numbers.
    let last = ui.data(|d| d.get_temp::<PickedColor>(id));
    let last = last.filter(|last| is_same(last.made, *color));
    let before = last.map_or_else(|| color.to_f32(), |last| last.shown);
    let mut now = before;
    ui.color_edit_button_rgb(&mut now).accessible_name(name);
    let [before, linear] = [before, now].map(|c| Rgb::from(c.map(f64::from)));
    if is_same(before, linear) {
        return false;
    }
    let Some(made) = settle(linear) else {
        return false;
    };
    ui.data_mut(|d| d.insert_temp(id, PickedColor { shown: now, made }));
    let is_new = !is_same(made, *color);
    if is_new {
        *color = made;
    }
    is_new
}

fn is_same(a: Rgb, b: Rgb) -> bool {
    let most = TOLERANCE * a.max_channel().max(1.0);
    (0..3).all(|channel| (a[channel] - b[channel]).abs() <= most)
}

/// A colour relative to its brightest channel; its strength is stored separately. `None` for black.
pub fn hue(color: Rgb) -> Option<Rgb> {
    let most = color.max_channel();
    (most > 0.0).then(|| color / most)
}

/// Strength and colour of a light, as defined by [`hue`]. While the strength is 0, the colour is
/// the one last stored under `id`.
pub fn parts(ui: &Ui, id: Id, light: Rgb) -> (f64, Rgb) {
    let kept = hue(light).or_else(|| ui.data(|d| d.get_temp(id)));
    let kept = kept.unwrap_or(Rgb::WHITE);
    keep_hue(ui, id, kept);
    (light.max_channel().max(0.0), kept)
}

/// Remembers the colour of a light that may be off.
pub fn keep_hue(ui: &Ui, id: Id, hue: Rgb) {
    ui.data_mut(|d| d.insert_temp(id, hue));
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::accesskit::Role;
    use egui::{Event, Key, Modifiers, vec2};
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    /// A number and a colour, with counts of their changes.
    struct InputFixture {
        number: f64,
        color: Rgb,
        changes: usize,
    }

    fn sheet(number: f64, color: Rgb) -> Harness<'static, InputFixture> {
        let state = InputFixture {
            number,
            color,
            changes: 0,
        };
        let show = |ui: &mut Ui, sheet: &mut InputFixture| {
            let drag = self::number(&mut sheet.number, -1.0..=1.0).max_decimals(4);
            let changed = ui.add(drag).accessible_name("number").changed();
            let old = sheet.color;
            let picks = picked(ui, "colour", &mut sheet.color, Some);
            assert_eq!(picks, old != sheet.color);
            sheet.changes += usize::from(changed) + usize::from(picks);
        };
        let mut harness = Harness::builder()
            .with_size([500.0, 600.0])
            .build_ui_state(show, state);
        harness.run();
        harness
    }

    fn enter(harness: &mut Harness<InputFixture>, text: Option<&str>) {
        harness
            .get_by_role_and_label(Role::SpinButton, "number")
            .focus();
        harness.run();
        if let Some(text) = text {
            harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
            harness.event(Event::Text(text.to_owned()));
            harness.run();
        }
        harness.key_press(Key::Enter);
        harness.run();
    }

    #[test]
    fn a_number_that_is_only_looked_at_keeps_its_digits() {
        for number in [0.482_374_81, 3e-5, -1e-9, 2.5] {
            let mut harness = sheet(number, Rgb::WHITE);
            enter(&mut harness, None);
            assert_eq!(harness.state().number, number);
            assert_eq!(harness.state().changes, 0);
        }
        let mut harness = sheet(0.482_374_81, Rgb::WHITE);
        enter(&mut harness, Some("− 0.25"));
        assert_eq!(harness.state().number, -0.25);
        enter(&mut harness, Some("7"));
        assert_eq!(harness.state().number, 1.0, "within its range");
        enter(&mut harness, Some("none"));
        assert_eq!(harness.state().number, 1.0);
        assert_eq!(harness.state().changes, 2);
    }

    #[test]
    fn a_number_beyond_its_range_stays_until_it_is_changed() {
        let mut harness = sheet(4.0, Rgb::WHITE);
        enter(&mut harness, None);
        assert_eq!((harness.state().number, harness.state().changes), (4.0, 0));
    }

    fn open(harness: &mut Harness<InputFixture>) {
        harness
            .get_by_role_and_label(Role::ColorWell, "colour")
            .click();
        harness.run_steps(8);
        harness.get_by_role_and_label(Role::SpinButton, "R");
    }

    #[test]
    fn opening_a_picker_changes_no_colour() {
        let mut state = 1u32;
        let mut channel = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX)
        };
        let mut colors = vec![Rgb::BLACK, Rgb::grey(0.3), Rgb::new(40.0, 7.3, 0.1)];
        colors.extend((0..20).map(|_| Rgb::new(channel(), channel(), channel())));
        for color in colors {
            let mut harness = sheet(0.0, color);
            open(&mut harness);
            assert_eq!(harness.state().changes, 0, "{color:?}");
            assert_eq!(harness.state().color, color);
        }
    }

    #[test]
    fn a_colour_that_is_picked_is_taken_once() {
        let mut harness = sheet(0.0, Rgb::new(0.9, 0.2, 0.1));
        open(&mut harness);
        let row = harness.get_by_role_and_label(Role::SpinButton, "R").rect();
        harness.drag_at(row.left_bottom() + vec2(40.0, 120.0));
        harness.run_steps(6);
        assert_eq!(harness.state().changes, 1);
        assert_ne!(harness.state().color, Rgb::new(0.9, 0.2, 0.1));
    }

    #[test]
    fn a_light_that_is_off_remembers_its_colour() {
        let amber = Rgb::new(1.0, 0.5, 0.25);
        let id = Id::unique("lamp");
        let show = move |ui: &mut Ui, light: &mut Rgb| {
            let (strength, hue) = parts(ui, id, *light);
            assert_eq!((strength, hue), (light.max_channel(), amber));
            *light = Rgb::BLACK;
        };
        let mut harness = Harness::new_ui_state(show, amber * 8.0);
        harness.run_steps(3);
        assert_eq!(hue(Rgb::BLACK), None);
    }
}
