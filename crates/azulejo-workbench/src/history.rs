//! Undo and redo.

/// More steps than this are forgotten, the oldest first.
const MOST_STEPS: usize = 500;

/// Versions before and after; `V` is cheap to keep, as documents are.
#[derive(Clone, Debug)]
pub struct History<V> {
    past: Vec<Step<V>>,
    future: Vec<Step<V>>,
    /// The gesture that made the last step, while it goes on.
    gesture: Option<u64>,
}

/// What was there before an edit (or, in the future, after it), and what the edit was.
#[derive(Clone, Debug)]
struct Step<V> {
    label: &'static str,
    version: V,
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
    /// Notes an edit, with what was before it. Edits of one gesture, such as all moments of
    /// dragging a slider, are one step.
    pub fn note(&mut self, label: &'static str, before: V, gesture: Option<u64>) {
        self.future.clear();
        let goes_on = gesture.is_some() && gesture == self.gesture && !self.past.is_empty();
        self.gesture = gesture;
        if goes_on {
            return;
        }
        if self.past.len() == MOST_STEPS {
            self.past.remove(0);
        }
        self.past.push(Step {
            label,
            version: before,
        });
    }

    /// Ends a gesture: the next edit is a step of its own.
    pub fn end_gesture(&mut self) {
        self.gesture = None;
    }

    /// What undo would take back.
    pub fn undo_label(&self) -> Option<&'static str> {
        self.past.last().map(|s| s.label)
    }

    /// What redo would bring again.
    pub fn redo_label(&self) -> Option<&'static str> {
        self.future.last().map(|s| s.label)
    }

    /// What was before the last edit, for `now`; `None` if there was no edit.
    pub fn undo(&mut self, now: V) -> Option<V> {
        self.gesture = None;
        exchange(&mut self.past, &mut self.future, now)
    }

    /// What the last undo took, for `now`; `None` if there is nothing.
    pub fn redo(&mut self, now: V) -> Option<V> {
        self.gesture = None;
        exchange(&mut self.future, &mut self.past, now)
    }
}

fn exchange<V>(from: &mut Vec<Step<V>>, to: &mut Vec<Step<V>>, now: V) -> Option<V> {
    let step = from.pop()?;
    to.push(Step {
        label: step.label,
        version: now,
    });
    Some(step.version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gesture_is_one_step_and_a_new_edit_ends_the_future() {
        let mut history = History::default();
        history.note("a", 0, None);
        for before in 1..5 {
            history.note("drag", before, Some(7));
        }
        assert_eq!(history.undo_label(), Some("drag"));
        assert_eq!(history.undo(5), Some(1));
        assert_eq!(history.undo(1), Some(0));
        assert_eq!(history.undo(0), None);
        assert_eq!(history.redo(0), Some(1));
        assert_eq!(history.redo_label(), Some("drag"));
        history.note("b", 1, None);
        assert_eq!(history.redo(9), None);
    }

    #[test]
    fn the_oldest_steps_are_forgotten() {
        let mut history = History::default();
        for k in 0..2 * MOST_STEPS {
            history.note("k", k, None);
        }
        let undone = std::iter::from_fn(|| history.undo(0)).count();
        assert_eq!(undone, MOST_STEPS);
    }
}
