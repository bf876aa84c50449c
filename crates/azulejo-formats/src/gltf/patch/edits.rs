//! Changes of a JSON text that keep every other byte of it.

use super::scan::{Member, Span, elements, members};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

/// A change of a value: none, until something is done with it.
#[derive(Clone, Debug)]
pub enum Edit {
    /// The value becomes this text.
    Set(String),
    /// The value is removed from its list or its object.
    Remove,
    /// Values in it change.
    Within {
        /// Members of an object. New ones are added in this order.
        members: BTreeMap<String, Edit>,
        /// Elements of a list. Those after its end are added there.
        elements: BTreeMap<usize, Edit>,
    },
}

impl Default for Edit {
    fn default() -> Edit {
        Edit::Within {
            members: BTreeMap::new(),
            elements: BTreeMap::new(),
        }
    }
}

/// A part of a text that another replaces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Splice {
    /// The bytes that are replaced; empty for an insertion.
    pub range: Range<usize>,
    /// What takes their place.
    pub text: String,
}

impl Edit {
    /// The change of a member.
    pub fn key(&mut self, key: &str) -> &mut Edit {
        if !matches!(self, Edit::Within { .. }) {
            *self = Edit::default();
        }
        match self {
            Edit::Within { members, .. } => members.entry(key.to_owned()).or_default(),
            other => other,
        }
    }

    /// The change of an element.
    pub fn index(&mut self, index: usize) -> &mut Edit {
        if !matches!(self, Edit::Within { .. }) {
            *self = Edit::default();
        }
        match self {
            Edit::Within { elements, .. } => elements.entry(index).or_default(),
            other => other,
        }
    }

    /// Replaces the value by a text, or adds it.
    pub fn set(&mut self, text: impl Into<String>) {
        *self = Edit::Set(text.into());
    }

    /// Removes the value, if it is there.
    pub fn remove(&mut self) {
        *self = Edit::Remove;
    }

    /// Whether nothing changes.
    pub fn is_empty(&self) -> bool {
        match self {
            Edit::Within { members, elements } => {
                let mut all = members.values().chain(elements.values());
                all.all(Edit::is_empty)
            }
            Edit::Set(_) | Edit::Remove => false,
        }
    }

    /// The replacements in a text, in its order, that change the value at `span` in this way.
    pub fn splices(&self, text: &str, span: &Span) -> Vec<Splice> {
        let mut splices = Vec::new();
        self.add_splices(text, span, &mut splices);
        splices
    }

    /// The changed text of the value at `span`.
    pub fn applied(&self, text: &str, span: &Span) -> String {
        let mut splices = self.splices(text, span);
        for splice in &mut splices {
            splice.range = splice.range.start - span.start..splice.range.end - span.start;
        }
        spliced(&text[span.clone()], &splices)
    }

    fn add_splices(&self, text: &str, span: &Span, splices: &mut Vec<Splice>) {
        if self.is_empty() {
            return;
        }
        match self {
            Edit::Within {
                members: changes, ..
            } if !changes.is_empty() => {
                if let Some(list) = members(text, span) {
                    return splice_object(text, span, &list, changes, splices);
                }
            }
            Edit::Within {
                elements: changes, ..
            } => {
                if let Some(list) = elements(text, span) {
                    return splice_list(text, span, &list, changes, splices);
                }
            }
            _ => {}
        }
        splices.push(Splice {
            range: span.clone(),
            text: self.rendered(),
        });
    }

    /// The value where there was none.
    pub fn rendered(&self) -> String {
        match self {
            Edit::Set(text) => text.clone(),
            Edit::Remove => "null".to_owned(),
            Edit::Within { members, elements } if members.is_empty() => {
                let parts = elements
                    .values()
                    .filter(|edit| is_present(edit))
                    .map(Edit::rendered);
                format!("[{}]", parts.collect::<Vec<_>>().join(","))
            }
            Edit::Within { members, .. } => {
                let members = members.iter().filter(|(_, edit)| is_present(edit));
                let parts = members.map(|(key, edit)| named(key, edit));
                format!("{{{}}}", parts.collect::<Vec<_>>().join(","))
            }
        }
    }
}

fn named(key: &str, edit: &Edit) -> String {
    format!("{}:{}", quoted(key), edit.rendered())
}

/// A text as a JSON string.
pub fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A text with some of its parts replaced; they are in its order.
pub fn spliced(text: &str, splices: &[Splice]) -> String {
    let added: usize = splices.iter().map(|s| s.text.len()).sum();
    let mut result = String::with_capacity(text.len() + added);
    let mut at = 0;
    for splice in splices {
        result += &text[at..splice.range.start];
        result += &splice.text;
        at = splice.range.end;
    }
    result + &text[at..]
}

fn splice_object(
    text: &str,
    span: &Span,
    list: &[Member],
    changes: &BTreeMap<String, Edit>,
    splices: &mut Vec<Splice>,
) {
    // Of several members of one name the last counts; all of them are removed.
    let places = list.iter().enumerate().map(|(i, m)| (m.key.as_str(), i));
    let last: HashMap<&str, usize> = places.collect();
    let items = list.iter().enumerate().map(|(i, m)| {
        let edit = changes.get(&m.key);
        let is_last = last.get(m.key.as_str()) == Some(&i);
        Item {
            span: m.span.clone(),
            value: m.value.clone(),
            edit: edit.filter(|edit| is_last || matches!(edit, Edit::Remove)),
        }
    });
    let items: Vec<Item> = items.collect();
    let is_new = |key: &str| !last.contains_key(key);
    let added = changes
        .iter()
        .filter(|(key, edit)| is_new(key) && is_present(edit));
    let added = added.map(|(key, edit)| named(key, edit)).collect();
    splice_items(text, span, &items, added, splices);
}

fn splice_list(
    text: &str,
    span: &Span,
    list: &[Span],
    changes: &BTreeMap<usize, Edit>,
    splices: &mut Vec<Splice>,
) {
    let items = list.iter().enumerate().map(|(i, span)| Item {
        span: span.clone(),
        value: span.clone(),
        edit: changes.get(&i),
    });
    let items: Vec<Item> = items.collect();
    let added = changes.range(list.len()..).map(|(_, edit)| edit);
    let added = added
        .filter(|edit| is_present(edit))
        .map(Edit::rendered)
        .collect();
    splice_items(text, span, &items, added, splices);
}

/// Whether a change adds something where nothing was.
fn is_present(edit: &Edit) -> bool {
    match edit {
        Edit::Set(_) => true,
        Edit::Remove => false,
        Edit::Within { members, elements } => {
            let mut all = members.values().chain(elements.values());
            all.any(is_present)
        }
    }
}

/// A member or an element, and its change.
struct Item<'e> {
    span: Span,
    value: Span,
    edit: Option<&'e Edit>,
}

impl Item<'_> {
    fn is_removed(&self) -> bool {
        matches!(self.edit, Some(Edit::Remove))
    }
}

fn splice_items(
    text: &str,
    span: &Span,
    items: &[Item],
    added: Vec<String>,
    splices: &mut Vec<Splice>,
) {
    let leading = items.iter().take_while(|item| item.is_removed()).count();
    if leading > 0 {
        let start = items[0].span.start;
        let end = items.get(leading).map(|next| next.span.start);
        splices.push(Splice {
            range: start..end.unwrap_or(items[leading - 1].span.end),
            text: String::new(),
        });
    }
    for i in leading..items.len() {
        match items[i].edit {
            Some(Edit::Remove) => splices.push(Splice {
                range: items[i - 1].span.end..items[i].span.end,
                text: String::new(),
            }),
            Some(edit) => edit.add_splices(text, &items[i].value, splices),
            None => {}
        }
    }
    if added.is_empty() {
        return;
    }
    let at = items.last().map_or(span.start + 1, |last| last.span.end);
    let comma = if leading < items.len() { "," } else { "" };
    splices.push(Splice {
        range: at..at,
        text: comma.to_owned() + &added.join(","),
    });
}

#[cfg(test)]
mod tests {
    use super::super::scan::whole;
    use super::*;

    fn check(text: &str, change: impl Fn(&mut Edit), expected: &str) {
        let mut edit = Edit::default();
        change(&mut edit);
        let splices = edit.splices(text, &whole(text));
        assert!(
            splices
                .windows(2)
                .all(|w| w[0].range.end <= w[1].range.start)
        );
        assert_eq!(spliced(text, &splices), expected, "{text}");
    }

    #[test]
    fn what_is_not_meant_stays() {
        let text = "{ \"a\" : 1e0,\r\n\"b\":[ -0.0 , {} ] , \"c\":\"x\" }";
        check(text, |e| e.key("a").set("7"), &text.replace("1e0", "7"));
        check(
            text,
            |e| {
                e.key("b").index(1).key("k").key("l").set("1");
                e.key("b").index(2).set("2");
                e.key("b").index(3).set("3");
                e.key("d").index(9).set("4");
            },
            "{ \"a\" : 1e0,\r\n\"b\":[ -0.0 , {\"k\":{\"l\":1}},2,3 ] , \"c\":\"x\",\"d\":[4] }",
        );
        check(text, |e| e.key("z").remove(), text);
        check(text, |e| _ = e.key("z").key("y"), text);
        check(text, |e| e.key("z").key("y").remove(), text);
    }

    #[test]
    fn removals_take_their_commas() {
        let text = "{\"a\":1, \"b\":2 ,\"c\":3}";
        check(text, |e| e.key("a").remove(), "{\"b\":2 ,\"c\":3}");
        check(text, |e| e.key("b").remove(), "{\"a\":1 ,\"c\":3}");
        check(text, |e| e.key("c").remove(), "{\"a\":1, \"b\":2}");
        let all = |e: &mut Edit| ["a", "b", "c"].iter().for_each(|k| e.key(k).remove());
        check(text, all, "{}");
        check(
            text,
            |e| {
                all(e);
                e.key("d").set("4");
            },
            "{\"d\":4}",
        );
        check("[1,2]", |e| e.index(0).remove(), "[2]");
        check("[]", |e| e.index(0).set("1"), "[1]");
        check("[ ]", |e| e.index(0).key("a").set("1"), "[{\"a\":1} ]");
    }

    #[test]
    fn values_of_other_kinds_are_replaced() {
        check(
            "{\"a\":null}",
            |e| e.key("a").key("b").set("1"),
            "{\"a\":{\"b\":1}}",
        );
        check(
            "{\"a\":1,\"a\":2}",
            |e| e.key("a").set("3"),
            "{\"a\":1,\"a\":3}",
        );
    }
}
