//! Messages about a file while it is read: each reported once, with its first location.

use crate::Position;
use crate::reading::warnings::Warnings;
use std::collections::HashMap;

/// Distinct messages kept, which is more than are ever shown.
const KEPT: usize = 1000;

/// Messages, each counted, with its first location.
///
/// Parsed JSON has no line numbers any more, so a location is a path: `meshes[3]`.
#[derive(Debug, Default)]
pub(super) struct GltfMessages {
    list: Vec<Message>,
    known: HashMap<String, usize>,
}

#[derive(Debug)]
struct Message {
    text: String,
    location: String,
    position: Position,
    count: usize,
}

impl GltfMessages {
    /// Counts a message about the part of the file with path `location`.
    pub fn of(&mut self, message: &str, location: impl FnOnce() -> String) {
        self.add(message, Position::Whole, location);
    }

    /// Counts a message about a byte or a line.
    pub fn at(&mut self, message: &str, position: Position) {
        self.add(message, position, String::new);
    }

    /// Counts a message about the whole file.
    pub fn whole(&mut self, message: &str) {
        self.at(message, Position::Whole);
    }

    /// Counts a message about the whole file `count` times, at least once.
    pub fn whole_many(&mut self, message: &str, count: usize) {
        (0..count.max(1)).for_each(|_| self.whole(message));
    }

    fn add(&mut self, message: &str, position: Position, location: impl FnOnce() -> String) {
        if let Some(&known) = self.known.get(message) {
            self.list[known].count += 1;
        } else if self.list.len() < KEPT {
            self.known.insert(message.to_owned(), self.list.len());
            self.list.push(Message {
                text: message.to_owned(),
                location: location(),
                position,
                count: 1,
            });
        } else {
            // Beyond the limit, only the number of messages matters.
            self.list[KEPT - 1].count += 1;
        }
    }

    /// The first message that begins with `start`.
    pub fn first_of(&self, start: &str) -> Option<&str> {
        let mut texts = self.list.iter().map(|m| m.text.as_str());
        texts.find(|text| text.starts_with(start))
    }

    /// Converts all messages to warnings.
    pub fn report(self, file: &str, warnings: &mut Warnings) {
        for m in self.list {
            let text = match m.location.as_str() {
                "" => m.text,
                location if m.count > 1 => format!("{} (first at {location})", m.text),
                location => format!("{} (at {location})", m.text),
            };
            warnings.add_many(file, text, m.count, || m.position);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_message_once_with_its_first_location() {
        let mut messages = GltfMessages::default();
        messages.of("points: skipped", || "meshes[3]".into());
        messages.of("points: skipped", || "meshes[4]".into());
        messages.of("lines: skipped", || "meshes[5]".into());
        messages.whole("no normals");
        for i in 0..2 * KEPT {
            messages.whole(&i.to_string());
        }
        assert_eq!(messages.first_of("lines"), Some("lines: skipped"));
        let mut warnings = Warnings::default();
        messages.report("a.gltf", &mut warnings);
        let list = warnings.finish("a.gltf");
        let shown: Vec<String> = list.iter().take(3).map(ToString::to_string).collect();
        assert_eq!(
            shown,
            [
                "a.gltf: points: skipped (first at meshes[3]) (2 times)",
                "a.gltf: lines: skipped (at meshes[5])",
                "a.gltf: no normals",
            ]
        );
        assert_eq!(list.iter().map(|w| w.count).sum::<usize>(), 2 * KEPT + 4);
    }
}
