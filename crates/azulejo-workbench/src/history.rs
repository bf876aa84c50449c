//! Undo and redo.

/// Limit on the number of steps; the oldest are dropped first.
const MAX_STEPS: usize = 500;
/// This many steps are kept regardless of their size.
const MIN_STEPS: usize = 4;

/// The versions before and after the current one; `V` is cheap to keep, as documents are.
#[derive(Clone, Debug)]
pub struct History<V> {
    past: Vec<HistoryStep<V>>,
    future: Vec<HistoryStep<V>>,
    /// The gesture that made the last step, while it is in progress.
    gesture: Option<u64>,
}

/// The version before an edit (or after it, for redo), with the label of the edit.
#[derive(Clone, Debug)]
struct HistoryStep<V> {
    label: &'static str,
    /// The name of the one thing that the edit concerns.
    about: Option<String>,
    version: V,
    /// Bytes that only the version before the edit holds.
    bytes: u64,
}

impl<V> Default for History<V> {
    fn default() -> History<V> {
        History {
            past: Vec::new(),
            future: Vec::new(),
            gesture: None,
        }
    }
}

impl<V> History<V> {
    /// Records an edit, what it is about, and the version before it. Edits of one gesture, such as all positions of a
    /// dragged slider, are one step.
    pub fn record(
        &mut self,
        label: &'static str,
        about: Option<String>,
        before: V,
        gesture: Option<u64>,
    ) {
        self.future.clear();
        let goes_on = gesture.is_some() && gesture == self.gesture && !self.past.is_empty();
        self.gesture = gesture;
        if goes_on {
            return;
        }
        if self.past.len() == MAX_STEPS {
            self.past.remove(0);
        }
        self.past.push(HistoryStep {
            label,
            about,
            version: before,
            bytes: 0,
        });
    }

    /// Sets the number of bytes that only the last step holds. Called again while a gesture
    /// continues.
    pub fn set_bytes(&mut self, bytes: impl FnOnce(&V) -> u64) {
        if let Some(step) = self.past.last_mut() {
            step.bytes = bytes(&step.version);
        }
    }

    /// Total bytes of all undo steps. Redo steps hold no more than they did before they were
    /// undone.
    pub fn bytes(&self) -> u64 {
        self.past.iter().map(|step| step.bytes).sum()
    }

    /// Drops the oldest steps until the others hold at most `most` bytes; a minimum number of steps
    /// is always kept.
    pub fn limit_bytes(&mut self, most: u64) {
        let mut held = self.bytes();
        let spare = self.past.len().saturating_sub(MIN_STEPS);
        let mut oldest = self.past.iter().take(spare);
        let mut forgotten = 0;
        while held > most
            && let Some(step) = oldest.next()
        {
            held -= step.bytes;
            forgotten += 1;
        }
        self.past.drain(..forgotten);
    }

    /// Ends a gesture: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// Label of the edit that undo reverts.
    pub fn undo_label(&self) -> Option<&'static str> {
        self.past.last().map(|s| s.label)
    }

    /// Label of the edit that redo applies.
    pub fn redo_label(&self) -> Option<&'static str> {
        self.future.last().map(|s| s.label)
    }

    /// The name of the one thing that the edit concerns that undo reverts.
    pub fn undo_about(&self) -> Option<&str> {
        self.past.last()?.about.as_deref()
    }

    /// The name of the one thing that the edit concerns that redo applies.
    pub fn redo_about(&self) -> Option<&str> {
        self.future.last()?.about.as_deref()
    }

    /// Returns the version before the last edit in exchange for `now`; `None` if there is no edit.
    pub fn undo(&mut self, now: V) -> Option<V> {
        self.gesture = None;
        exchange(&mut self.past, &mut self.future, now)
    }

    /// Returns the version that the last undo reverted in exchange for `now`; `None` if there is
    /// none.
    pub fn redo(&mut self, now: V) -> Option<V> {
        self.gesture = None;
        exchange(&mut self.future, &mut self.past, now)
    }
}

fn exchange<V>(from: &mut Vec<HistoryStep<V>>, to: &mut Vec<HistoryStep<V>>, now: V) -> Option<V> {
    let step = from.pop()?;
    to.push(HistoryStep {
        label: step.label,
        about: step.about,
        version: now,
        bytes: step.bytes,
    });
    Some(step.version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gesture_is_one_step_and_a_new_edit_ends_the_future() {
        let mut history = History::default();
        history.record("a", None, 0, None);
        for before in 1..5 {
            history.record("drag", Some(format!("{before}")), before, Some(7));
        }
        assert_eq!(history.undo_label(), Some("drag"));
        assert_eq!(history.undo_about(), Some("1"));
        assert_eq!(history.undo(5), Some(1));
        assert_eq!(history.undo(1), Some(0));
        assert_eq!(history.undo(0), None);
        assert_eq!(history.redo(0), Some(1));
        assert_eq!(history.redo_label(), Some("drag"));
        assert_eq!(
            (history.undo_about(), history.redo_about()),
            (None, Some("1"))
        );
        history.record("b", None, 1, None);
        assert_eq!(history.redo(9), None);
    }

    #[test]
    fn steps_are_forgotten_by_what_they_hold() {
        let mut history = History::default();
        for k in 0..100 {
            history.record("k", None, k, None);
            history.set_bytes(|_| 10);
            history.limit_bytes(75);
            assert!(history.bytes() <= 75);
        }
        assert_eq!(history.bytes(), 70);
        // Undo and redo do not change the size of a step.
        for _ in 0..3 {
            history.undo(0);
        }
        assert_eq!(history.bytes(), 40);
        while history.redo(0).is_some() {}
        assert_eq!(history.bytes(), 70);
        // A step grows while its gesture continues.
        for bytes in [1, 30] {
            history.record("drag", None, 100, Some(1));
            history.set_bytes(|_| bytes);
        }
        assert_eq!(history.bytes(), 100);
        history.limit_bytes(0);
        let undone = std::iter::from_fn(|| history.undo(0)).count();
        assert_eq!(undone, MIN_STEPS);
    }

    #[test]
    fn the_oldest_steps_are_forgotten() {
        let mut history = History::default();
        for k in 0..2 * MAX_STEPS {
            history.record("k", None, k, None);
        }
        let undone = std::iter::from_fn(|| history.undo(0)).count();
        assert_eq!(undone, MAX_STEPS);
    }
}
