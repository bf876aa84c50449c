//! The list of the file dialog: names, sizes and dates.

use super::browser::{FileBrowser, RowClick};
use super::listing::{FolderEntry, SortColumn, size_text};
use crate::ui::focus::keep_arrows;
use crate::ui::panel_context::PanelContext;
use egui::accesskit::Role;
use egui::{
    Align, Button, Id, Rangef, Rect, Response, ScrollArea, Sense, StrokeKind, TextStyle,
    TextWrapMode, Ui, UiBuilder, WidgetInfo, WidgetText, pos2, vec2,
};
use jiff::tz::TimeZone;
use std::time::SystemTime;

/// The state of the list.
#[derive(Default)]
pub struct FileRows {
    /// Whether the list scrolls to the cursor in the next frame.
    follows: bool,
    /// The number of rows that fit.
    page: usize,
}

/// Where the columns of the list begin and end.
#[derive(Clone, Copy, Debug)]
struct ListColumns {
    name: Rangef,
    size: Rangef,
    modified: Rangef,
    /// Whether dates have their time.
    has_time: bool,
}

impl ListColumns {
    /// The columns of a list: in a narrow one, dates have no time.
    fn new(x: Rangef) -> ListColumns {
        const BAR: f32 = 12.0;
        const NARROW: f32 = 440.0;
        let has_time = x.span() >= NARROW;
        let right = x.max - BAR;
        let modified = right - if has_time { 126.0 } else { 84.0 };
        let size = modified - 70.0;
        ListColumns {
            name: Rangef::new(x.min, size),
            size: Rangef::new(size, modified),
            modified: Rangef::new(modified, right),
            has_time,
        }
    }
}

impl FileRows {
    /// The widget that has the focus when the list has it.
    pub fn id() -> Id {
        Id::unique("file list")
    }

    /// The number of rows by which a page moves the cursor.
    pub fn page(&self) -> isize {
        isize::try_from(self.page).unwrap_or(1).max(1)
    }

    /// Scrolls to the cursor in the next frame.
    pub fn follow_cursor(&mut self) {
        self.follows = true;
    }

    /// Draws the list; returns whether a row was double-clicked.
    pub fn show(&mut self, ui: &mut Ui, cx: &PanelContext, browser: &mut FileBrowser) -> bool {
        let columns = ListColumns::new(ui.max_rect().x_range());
        let mut rect = ui.available_rect_before_wrap();
        headers(ui, cx, browser, columns, rect.top());
        rect.min.y += ui.spacing().interact_size.y + 2.0;
        let list = list_widget(ui, cx, browser, rect);
        ui.painter()
            .rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let is_accepted = ui
            .scope_builder(UiBuilder::new().max_rect(rect), |ui| {
                self.rows(ui, cx, browser, columns, &list)
            })
            .inner;
        if list.has_focus() {
            let stroke = ui.visuals().selection.stroke;
            ui.painter()
                .rect_stroke(rect, 2.0, stroke, StrokeKind::Inside);
        }
        is_accepted
    }

    fn rows(
        &mut self,
        ui: &mut Ui,
        cx: &PanelContext,
        browser: &mut FileBrowser,
        columns: ListColumns,
        list: &Response,
    ) -> bool {
        if let Some(text) = empty_text(cx, browser) {
            ui.add_space(8.0);
            ui.horizontal_wrapped(|ui| {
                ui.add_space(8.0);
                ui.weak(text);
            });
            return false;
        }
        let height = ui.text_style_height(&TextStyle::Body) + 4.0;
        let count = browser.len();
        let zone = TimeZone::system();
        let mut is_accepted = false;
        ScrollArea::vertical()
            .id_salt(&browser.folder)
            .auto_shrink(false)
            .show_viewport(ui, |ui, viewport| {
                ui.set_height(height * count as f32);
                let top = ui.max_rect().top();
                let row_rect = |row: usize| {
                    let x = columns.name.min..=columns.modified.max;
                    let y = top + height * row as f32;
                    Rect::from_x_y_ranges(x, y..=y + height)
                };
                self.page = (viewport.height() / height) as usize;
                if std::mem::take(&mut self.follows)
                    && let Some(row) = browser.cursor_row()
                {
                    ui.scroll_to_rect(row_rect(row), None);
                }
                let first = (viewport.min.y / height).max(0.0) as usize;
                let last = (viewport.max.y / height).ceil().max(0.0) as usize;
                for row in first..last.min(count) {
                    let clicked = row_widget(ui, browser, row, row_rect(row), columns, &zone);
                    is_accepted |= clicked.is_some_and(|how| use_click(browser, row, how, list));
                }
            });
        is_accepted
    }
}

/// A click on a row.
enum RowPress {
    Select(RowClick),
    Accept,
}

/// Selects a clicked row; returns whether it was a double click.
fn use_click(browser: &mut FileBrowser, row: usize, press: RowPress, list: &Response) -> bool {
    list.request_focus();
    match press {
        RowPress::Select(how) => {
            browser.click(row, how);
            false
        }
        RowPress::Accept => {
            browser.click(row, RowClick::Only);
            true
        }
    }
}

/// The widget that the focus is on. It says the name of the entry at the cursor, as the rows
/// themselves are none that Tab reaches.
fn list_widget(ui: &mut Ui, cx: &PanelContext, browser: &FileBrowser, rect: Rect) -> Response {
    let list = ui.interact(rect, FileRows::id(), Sense::focusable_noninteractive());
    if list.has_focus() {
        keep_arrows(&list);
    }
    let label = cx.tr("Files");
    list.widget_info(|| WidgetInfo::labeled(Role::ListBox, true, label));
    let current = browser.cursor_row().and_then(|row| browser.row(row));
    let current = current.map(|entry| entry.name.clone());
    ui.ctx().accesskit_node_builder(list.id, |node| {
        node.set_value(current.unwrap_or_default());
    });
    list
}

/// What stands in a list without rows.
fn empty_text(cx: &PanelContext, browser: &mut FileBrowser) -> Option<String> {
    if let Some(why) = &browser.unreadable {
        return Some(format!("{} {why}", cx.tr("This folder cannot be read:")));
    }
    if browser.is_reading() {
        return Some(cx.tr("reading").to_owned());
    }
    (browser.len() == 0).then(|| cx.tr("Nothing to show here").to_owned())
}

/// The headers, which sort the list.
fn headers(
    ui: &mut Ui,
    cx: &PanelContext,
    browser: &mut FileBrowser,
    columns: ListColumns,
    top: f32,
) {
    let height = ui.spacing().interact_size.y;
    for (column, x, label) in [
        (SortColumn::Name, columns.name, cx.tr("Name")),
        (SortColumn::Size, columns.size, cx.tr("Size")),
        (SortColumn::Modified, columns.modified, cx.tr("Modified")),
    ] {
        let order = browser.options().order;
        let text = match (order.column == column, order.is_descending) {
            (false, _) => label.to_owned(),
            (true, false) => format!("{label} ⏶"),
            (true, true) => format!("{label} ⏷"),
        };
        let rect = Rect::from_x_y_ranges(x, top..=top + height);
        let button = Button::new(text).frame(false).truncate();
        let layout = match column {
            SortColumn::Size => egui::Layout::right_to_left(Align::Center),
            _ => egui::Layout::left_to_right(Align::Center),
        };
        let builder = UiBuilder::new().max_rect(rect.shrink2(vec2(4.0, 0.0)));
        let header = ui.scope_builder(builder.layout(layout), |ui| ui.add(button));
        let header = header.inner;
        header.widget_info(|| WidgetInfo::labeled(Role::Button, true, label));
        if header.clicked() {
            browser.sort_by(column);
        }
    }
}

/// Draws a row; returns how it was clicked.
fn row_widget(
    ui: &mut Ui,
    browser: &FileBrowser,
    row: usize,
    rect: Rect,
    columns: ListColumns,
    zone: &TimeZone,
) -> Option<RowPress> {
    let entry = browser.row(row)?;
    let sign = if entry.is_folder { "🗀" } else { "🗋" };
    let name = format!("{sign} {}", entry.name);
    let is_selected = browser.is_selected(row);
    // Tab goes to the list, not to each of its rows.
    let id = ui.scope_id().with(row);
    let response = ui.interact(rect, id, Sense::CLICK);
    response.widget_info(|| WidgetInfo::labeled(Role::ListBoxOption, true, &name));
    ui.ctx()
        .accesskit_node_builder(id, |node| node.set_selected(is_selected));
    let is_elided = ui.is_rect_visible(rect)
        && paint_row(
            ui,
            entry,
            &name,
            rect,
            columns,
            zone,
            (is_selected, &response),
        );
    let modifiers = ui.input(|i| i.modifiers);
    let press = if response.double_clicked() {
        Some(RowPress::Accept)
    } else if !response.clicked() {
        None
    } else if modifiers.shift {
        Some(RowPress::Select(RowClick::Range))
    } else if modifiers.command {
        Some(RowPress::Select(RowClick::Toggle))
    } else {
        Some(RowPress::Select(RowClick::Only))
    };
    if is_elided {
        response.on_hover_text(&entry.name);
    }
    press
}

/// Paints a row; returns whether its name is cut.
fn paint_row(
    ui: &Ui,
    entry: &FolderEntry,
    name: &str,
    rect: Rect,
    columns: ListColumns,
    zone: &TimeZone,
    (is_selected, response): (bool, &Response),
) -> bool {
    let visuals = ui.style().interact_selectable(response, is_selected);
    if is_selected || response.hovered() {
        ui.painter().rect_filled(rect, 2.0, visuals.weak_bg_fill);
    }
    let color = if is_selected {
        visuals.text_color()
    } else {
        ui.visuals().text_color()
    };
    let text = |x: Rangef, text: &str, is_right: bool| {
        let width = x.span() - 8.0;
        let galley = WidgetText::from(text).into_galley(
            ui,
            Some(TextWrapMode::Truncate),
            width,
            TextStyle::Body,
        );
        let left = if is_right {
            x.max - 4.0 - galley.size().x
        } else {
            x.min + 4.0
        };
        let at = pos2(left, rect.center().y - 0.5 * galley.size().y);
        let is_elided = galley.elided;
        ui.painter().galley(at, galley, color);
        is_elided
    };
    if let Some(size) = entry.size {
        text(columns.size, &size_text(size), true);
    }
    if let Some(time) = entry.modified {
        text(
            columns.modified,
            &time_text(time, zone, columns.has_time),
            false,
        );
    }
    text(columns.name, name, false)
}

/// A date, and a time of day on demand, in a time zone.
fn time_text(time: SystemTime, zone: &TimeZone, has_time: bool) -> String {
    let Ok(time) = jiff::Timestamp::try_from(time) else {
        return String::new();
    };
    let format = if has_time {
        "%Y-%m-%d %H:%M"
    } else {
        "%Y-%m-%d"
    };
    time.to_zoned(zone.clone()).strftime(format).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates_are_those_of_the_time_zone() {
        let time = SystemTime::UNIX_EPOCH + Duration::from_secs(1_700_000_000);
        let zone = TimeZone::fixed(jiff::tz::offset(2));
        assert_eq!(time_text(time, &TimeZone::UTC, true), "2023-11-14 22:13");
        assert_eq!(time_text(time, &zone, true), "2023-11-15 00:13");
        assert_eq!(time_text(time, &zone, false), "2023-11-15");
    }

    #[test]
    fn names_keep_most_of_a_narrow_list() {
        let columns = ListColumns::new(Rangef::new(0.0, 400.0));
        assert!(!columns.has_time && columns.name.span() > 200.0);
        assert!(ListColumns::new(Rangef::new(0.0, 600.0)).has_time);
    }
}
