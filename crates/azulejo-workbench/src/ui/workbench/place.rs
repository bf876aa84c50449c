//! Where the window is on the desktop: kept for the next session, and taken up again.

use super::Workbench;
use crate::preferences::WindowPlace;

/// So much of a window must be on a screen for it to be found and moved, pixels.
#[cfg(not(target_arch = "wasm32"))]
const GRIP: i32 = 80;

impl Workbench {
    /// Notes where the window is. A maximized window keeps the size that it had before.
    #[cfg(not(target_arch = "wasm32"))]
    pub(super) fn note_place(&mut self, frame: &eframe::Frame) {
        let Some(window) = frame.winit_window() else {
            return;
        };
        if window.is_minimized() == Some(true) || window.fullscreen().is_some() {
            return;
        }
        let mut place = self.place.unwrap_or(self.app.preferences.window);
        place.is_maximized = window.is_maximized();
        if !place.is_maximized {
            let size = window.inner_size().to_logical::<f32>(window.scale_factor());
            place.size = [size.width, size.height];
            // Not every desktop tells programs where their windows are.
            let position = window.outer_position().ok();
            let points = |p: i32| (f64::from(p) / window.scale_factor()).round() as i32;
            let position = position.map(|p| [points(p.x), points(p.y)]);
            place.position = position.or(place.position);
        }
        self.place = Some(place);
    }

    /// A page is where its browser is.
    #[cfg(target_arch = "wasm32")]
    pub(super) fn note_place(&mut self, _: &eframe::Frame) {}

    /// Keeps the place of the window for the next session, unless a script has chosen its size.
    pub(super) fn keep_place(&mut self) {
        if let Some(place) = self.place.filter(|_| !self.is_sized_by_script) {
            self.app.keep_window(place);
        }
    }
}

/// Height of a title bar and of the bar of a desktop, points: so much less than a screen has a window.
#[cfg(not(target_arch = "wasm32"))]
const TITLE: f64 = 60.0;

#[cfg(target_arch = "wasm32")]
pub(super) fn bring_back(_: &eframe::CreationContext<'_>, _: WindowPlace) {}

/// Shrinks a new window that is higher than its screen, and moves it to a screen if it was made where it last was and that screen is gone.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn bring_back(context: &eframe::CreationContext<'_>, place: WindowPlace) {
    let Some(window) = context.winit_window() else {
        return;
    };
    if !place.is_maximized
        && let Some(screen) = window.current_monitor()
    {
        let (mut size, screen_height) = (window.inner_size(), screen.size().height);
        let most = screen_height.saturating_sub((TITLE * window.scale_factor()) as u32);
        if size.height > most {
            size.height = most;
            // A desktop that does not allow this keeps the window as it is.
            let _ = window.request_inner_size(size);
        }
    }
    let Some(position) = place.position else {
        return;
    };
    let scale = window.scale_factor() as f32;
    let position = position.map(|points| (points as f32 * scale) as i32);
    let size = place.size.map(|points| (points * scale) as i32);
    let screens = window.available_monitors();
    let screens: Vec<[[i32; 2]; 2]> = screens
        .map(|screen| {
            let (at, size) = (screen.position(), screen.size());
            [[at.x, at.y], [size.width as i32, size.height as i32]]
        })
        .collect();
    if place.is_maximized || is_within(&screens, position, size) {
        return;
    }
    if let (Some([[left, top], _]), Ok(mut corner)) = (screens.first(), window.outer_position()) {
        (corner.x, corner.y) = (left + GRIP, top + GRIP);
        window.set_outer_position(corner);
    }
}

/// Whether the upper edge of a window, where it is moved, is on one of the screens, each with its
/// position and size.
#[cfg(not(target_arch = "wasm32"))]
fn is_within(screens: &[[[i32; 2]; 2]], position: [i32; 2], size: [i32; 2]) -> bool {
    let [x, y] = position;
    screens.iter().any(|[[left, top], [width, height]]| {
        let seen = (x + size[0]).min(left + width) - x.max(*left);
        seen >= GRIP.min(size[0]) && y >= *top && y < top + height - GRIP
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_returns_only_to_a_screen_that_is_there() {
        let screens = [[[0, 0], [1920, 1080]], [[1920, 200], [1280, 1024]]];
        let is_there = |x, y| is_within(&screens, [x, y], [1280, 800]);
        for (x, y) in [(0, 0), (100, 900), (-1000, 50), (1900, 300), (3000, 400)] {
            assert!(is_there(x, y), "{x} {y}");
        }
        for (x, y) in [
            (-1250, 50),
            (3150, 300),
            (100, -30),
            (100, 1070),
            (2500, 100),
        ] {
            assert!(!is_there(x, y), "{x} {y}");
        }
        assert!(!is_within(&screens[..1], [2000, 300], [1280, 800]));
    }
}
