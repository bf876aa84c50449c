//! A JSON document that keeps the order of its members, and keys, texts and numbers as they are spelled.
//!
//! `serde_json` has features for the order and for numbers, but a feature is switched on for a whole
//! workspace, whose other outputs would change.

use serde_json::Value;
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Json<'a> {
    /// Members; keys are spelled as between their quotation marks.
    Object(Vec<(Cow<'a, str>, Json<'a>)>),
    /// Elements.
    List(Vec<Json<'a>>),
    /// Anything else, as it is spelled: a text with its quotation marks, a number, `true`, `false`, `null`.
    Scalar(Cow<'a, str>),
}

/// Levels of a document that is edited. `serde_json` reads 127, and the mark of an edit may repeat values some levels
/// deeper.
pub const MOST_LEVELS: usize = 110;

impl<'a> Json<'a> {
    /// Parses a text.
    ///
    /// # Errors
    /// Text that is not JSON, and values nested too deeply.
    pub fn parse(text: &'a str, levels: usize) -> Result<Json<'a>, String> {
        let checked: &RawValue =
            serde_json::from_str(text).map_err(|e| format!("invalid JSON: {e}"))?;
        let (text, at) = (checked.get(), 0);
        let value = Parser { text, at }.value(levels);
        value.ok_or_else(|| format!("JSON nested more than {levels} deep"))
    }

    /// The members of an object; none for other values.
    pub fn members(&self) -> &[(Cow<'a, str>, Json<'a>)] {
        match self {
            Json::Object(members) => members,
            _ => &[],
        }
    }

    /// The elements of a list; none for other values.
    pub fn list(&self) -> &[Json<'a>] {
        match self {
            Json::List(list) => list,
            _ => &[],
        }
    }

    /// The member of a member of ... an object. Of several of one name the last counts, as for most parsers.
    pub fn find(&self, steps: &[&str]) -> Option<&Json<'a>> {
        steps.iter().try_fold(self, |value, step| {
            let mut members = value.members().iter().rev();
            Some(&members.find(|(key, _)| is_named(key, step))?.1)
        })
    }

    /// A member.
    pub fn get(&self, key: &str) -> Option<&Json<'a>> {
        self.find(&[key])
    }

    /// The elements of a list that is a member.
    pub fn entries(&self, key: &str) -> &[Json<'a>] {
        self.get(key).map_or(&[], Json::list)
    }

    /// A text without its quotation marks and escapes.
    pub fn text(&self) -> Option<Cow<'_, str>> {
        match self {
            Json::Scalar(spelled) => unescaped(spelled.strip_prefix('"')?.strip_suffix('"')?),
            _ => None,
        }
    }

    /// A number.
    pub fn number(&self) -> Option<f64> {
        match self {
            Json::Scalar(spelled) => spelled.parse().ok().filter(|n: &f64| n.is_finite()),
            _ => None,
        }
    }

    /// A whole number; some writers give indices a fraction of zero.
    pub fn index(&self) -> Option<usize> {
        let is_index = |n: &f64| *n >= 0.0 && n.fract() == 0.0 && *n < 2f64.powi(53);
        self.number().filter(is_index).map(|n| n as usize)
    }

    /// The place of a member, which is `null` if it is new. What is not an object becomes one.
    pub fn key(&mut self, key: &str) -> &mut Json<'a> {
        if !matches!(self, Json::Object(_)) {
            *self = Json::Object(Vec::new());
        }
        let Json::Object(members) = self else {
            return self;
        };
        let known = members.iter().rposition(|(k, _)| is_named(k, key));
        let place = known.unwrap_or_else(|| {
            members.push((escaped(key), Value::Null.into()));
            members.len() - 1
        });
        &mut members[place].1
    }

    /// The place of an element, a new one at the end if the list is shorter. What is not a list becomes one.
    pub fn at(&mut self, place: usize) -> &mut Json<'a> {
        if place >= self.list().len() {
            self.push(Value::Null);
        }
        match self {
            Json::List(list) => {
                let last = list.len() - 1;
                &mut list[place.min(last)]
            }
            other => other,
        }
    }

    /// Adds an element, and returns its index. What is not a list becomes one.
    pub fn push(&mut self, value: impl Into<Json<'a>>) -> usize {
        match self {
            Json::List(list) => list.push(value.into()),
            _ => *self = Json::List(vec![value.into()]),
        }
        self.list().len() - 1
    }

    /// Replaces the value.
    pub fn set(&mut self, value: impl Into<Json<'a>>) {
        *self = value.into();
    }

    /// Removes a member, if it is there.
    pub fn remove(&mut self, key: &str) {
        if let Json::Object(members) = self {
            members.retain(|(k, _)| !is_named(k, key));
        }
    }

    /// Removes the member at the end of some steps, and the objects around it that have nothing else.
    pub fn prune(&mut self, steps: &[&str]) {
        let ([key, below @ ..], Some(_)) = (steps, self.find(steps)) else {
            return;
        };
        let own = self.key(key);
        own.prune(below);
        if below.is_empty() || *own == Json::Object(Vec::new()) {
            self.remove(key);
        }
    }
}

impl fmt::Display for Json<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let comma = |i: usize| if i == 0 { "" } else { "," };
        match self {
            Json::Scalar(spelled) => f.write_str(spelled),
            Json::List(list) => {
                f.write_str("[")?;
                let mut list = list.iter().enumerate();
                list.try_for_each(|(i, value)| write!(f, "{}{value}", comma(i)))?;
                f.write_str("]")
            }
            Json::Object(list) => {
                f.write_str("{")?;
                let mut list = list.iter().enumerate();
                list.try_for_each(|(i, (key, value))| write!(f, "{}\"{key}\":{value}", comma(i)))?;
                f.write_str("}")
            }
        }
    }
}

impl From<Value> for Json<'_> {
    fn from(value: Value) -> Self {
        match value {
            Value::Array(list) => Json::List(list.into_iter().map(Json::from).collect()),
            Value::Object(list) => {
                let member = |(key, value): (String, Value)| (escaped(&key), value.into());
                Json::Object(list.into_iter().map(member).collect())
            }
            scalar => Json::Scalar(scalar.to_string().into()),
        }
    }
}

impl From<usize> for Json<'_> {
    fn from(number: usize) -> Self {
        Value::from(number).into()
    }
}

impl From<&str> for Json<'_> {
    fn from(text: &str) -> Self {
        Value::from(text).into()
    }
}

/// Text as between quotation marks.
fn escaped<'a>(text: &str) -> Cow<'a, str> {
    let quoted = Value::from(text).to_string();
    quoted[1..quoted.len() - 1].to_owned().into()
}

/// Text from between quotation marks.
pub fn unescaped(spelled: &str) -> Option<Cow<'_, str>> {
    if !spelled.contains('\\') {
        return Some(spelled.into());
    }
    let text: String = serde_json::from_str(&format!("\"{spelled}\"")).ok()?;
    Some(text.into())
}

/// Whether a key that is spelled in this way is this one.
fn is_named(spelled: &str, key: &str) -> bool {
    spelled == key || spelled.contains('\\') && unescaped(spelled).is_some_and(|k| k == key)
}

/// Takes apart a text that is known to be JSON.
struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Parser<'a> {
    /// The next byte that is neither a blank nor a mark between values.
    fn peek(&mut self) -> Option<u8> {
        let rest = self.text.as_bytes().get(self.at..)?;
        let is_between = |b: &u8| matches!(b, b' ' | b'\t' | b'\r' | b'\n' | b',' | b':');
        self.at += rest.iter().take_while(|b| is_between(b)).count();
        self.text.as_bytes().get(self.at).copied()
    }

    fn value(&mut self, levels: usize) -> Option<Json<'a>> {
        let levels = levels.checked_sub(1)?;
        let (mut members, mut list) = (Vec::new(), Vec::new());
        match self.peek()? {
            b'{' => {
                self.at += 1;
                while self.peek()? != b'}' {
                    let key = self.scalar()?;
                    let key = key.get(1..key.len().checked_sub(1)?)?;
                    members.push((key.into(), self.value(levels)?));
                }
                self.at += 1;
                Some(Json::Object(members))
            }
            b'[' => {
                self.at += 1;
                while self.peek()? != b']' {
                    list.push(self.value(levels)?);
                }
                self.at += 1;
                Some(Json::List(list))
            }
            _ => Some(Json::Scalar(self.scalar()?.into())),
        }
    }

    /// The text, number or word that begins here.
    fn scalar(&mut self) -> Option<&'a str> {
        let rest = &self.text.as_bytes()[self.at..];
        let length = if rest.first() == Some(&b'"') {
            let mut end = 1;
            while *rest.get(end)? != b'"' {
                end += if rest[end] == b'\\' { 2 } else { 1 };
            }
            end + 1
        } else {
            let is_end = |b: &u8| matches!(b, b',' | b']' | b'}' | b' ' | b'\t' | b'\r' | b'\n');
            rest.iter().position(is_end).unwrap_or(rest.len())
        };
        let start = self.at;
        self.at += length.max(1);
        self.text.get(start..self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = " {\r\n \"a\" : [ 1.0, -0.0,{\"]\":\"}\\\"\"} , [],1e-3 ],\"\\u0062\":{},\"b\" :\"\u{e9},:\" }\n";

    #[test]
    fn order_and_spelling_stay() {
        let json = Json::parse(TEXT, 4).unwrap();
        let compact =
            "{\"a\":[1.0,-0.0,{\"]\":\"}\\\"\"},[],1e-3],\"\\u0062\":{},\"b\":\"\u{e9},:\"}";
        assert_eq!(json.to_string(), compact);
        assert_eq!(Json::parse(compact, 4).unwrap(), json);
        assert_eq!(json.entries("a")[0].index(), Some(1));
        assert_eq!(json.entries("a")[4].index(), None);
        let deep = json.entries("a")[2].get("]").unwrap();
        assert_eq!(deep.text().unwrap(), "}\"");
        assert_eq!(json.get("b").unwrap().text().unwrap(), "\u{e9},:");
        assert!(json.get("a").unwrap().members().is_empty());
    }

    #[test]
    fn changes() {
        let mut json = Json::parse(TEXT, 4).unwrap();
        json.key("a").at(1).set(7);
        json.key("a").at(9).key("k \"").set("v");
        json.key("b").set(serde_json::json!({ "x": [0.5] }));
        json.prune(&["b", "x", "y"]);
        let text = json.to_string();
        assert!(text.starts_with("{\"a\":[1.0,7,{\"]\":\"}\\\"\"},[],1e-3,{\"k \\\"\":\"v\"}],"));
        assert!(text.ends_with("\"\\u0062\":{},\"b\":{\"x\":[0.5]}}"));
        json.prune(&["b", "x"]);
        // All members of the name.
        assert_eq!(json.members().len(), 1);
    }

    #[test]
    fn damage() {
        for end in 0..TEXT.trim_end().len() {
            assert!(
                TEXT.get(..end)
                    .is_none_or(|text| Json::parse(text, 4).is_err())
            );
        }
        let nested = |n: usize| "[".repeat(n) + &"]".repeat(n);
        assert!(Json::parse(&nested(100), 100).is_ok());
        for levels in [101, 1_000_000] {
            let error = Json::parse(&nested(levels), 100).unwrap_err();
            assert!(error.contains("nested"), "{error}");
        }
    }
}
