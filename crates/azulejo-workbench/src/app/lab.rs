//! The lab: which lesson is shown, and its scene.

use super::App;
use crate::command::Command;
use crate::lab::{LabLink, Lesson};

impl App {
    /// Opens what a teacher's link says: a lesson with its scene, unless there is another model already. A language of
    /// its own is that of this session.
    pub fn follow(&mut self, link: LabLink) {
        if let Some(language) = link.language {
            self.preferences.language = language;
        }
        if let Some(lesson) = link.lesson {
            self.show_lab(Some(lesson));
            if self.is_blank() {
                self.execute(Command::OpenLesson);
            }
        }
    }

    pub(super) fn show_lab(&mut self, lesson: Option<Lesson>) {
        self.lab.is_open = lesson.is_some();
        self.lab.lesson = lesson.unwrap_or(self.lab.lesson);
    }

    /// Opens the scene of the lesson, with the settings and the shading mode with which it begins.
    pub(super) fn open_lesson(&mut self) {
        let lesson = self.lab.lesson;
        self.clear();
        self.lighting.settings = lesson.settings();
        self.replace(lesson.document(), None);
        self.view.shading = lesson.shading();
    }
}
