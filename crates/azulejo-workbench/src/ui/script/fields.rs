//! The words of a step, as numbers, names and switches.

use crate::variants::script_name;
use clap::ValueEnum;
use glam::DVec3;
use std::path::PathBuf;

/// The first word of a text and the rest.
pub(super) fn split(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim())
}

/// `N` finite numbers.
pub(super) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let values = finite(text).and_then(|v| v.try_into().ok());
    values.ok_or_else(|| format!("\"{text}\" is not {N} numbers"))
}

/// Finite numbers of any count; `None` if a word is not a number.
pub(super) fn finite(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace()
        .map(|w| w.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect()
}

/// Three numbers.
pub(super) fn vector(text: &str) -> Result<DVec3, String> {
    numbers::<3>(text).map(DVec3::from)
}

/// Two points: six numbers.
pub(super) fn two_points(text: &str) -> Result<[DVec3; 2], String> {
    let [a, b, c, d, e, f] = numbers(text)?;
    Ok([DVec3::new(a, b, c), DVec3::new(d, e, f)])
}

/// One number.
pub(super) fn number(text: &str) -> Result<f64, String> {
    match numbers(text) {
        Ok([x]) => Ok(x),
        Err(_) => Err(format!("\"{text}\" is not a number")),
    }
}

/// A whole number from 1.
pub(super) fn whole(text: &str, most: u32) -> Result<u32, String> {
    let n: Option<u32> = text.parse().ok();
    n.filter(|n| (1..=most).contains(n))
        .ok_or_else(|| format!("\"{text}\" is not a number from 1 to {most}"))
}

/// `None` if the text is this word, and otherwise what `read` makes of it.
pub(super) fn unless<T>(
    word: &str,
    text: &str,
    read: impl FnOnce(&str) -> Result<T, String>,
) -> Result<Option<T>, String> {
    if text == word {
        return Ok(None);
    }
    match read(text) {
        Ok(value) => Ok(Some(value)),
        Err(why) => Err(format!("{why}, nor \"{word}\"")),
    }
}

/// `on` or `off`.
pub(super) fn switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        other => Err(format!("\"{other}\", expected on or off")),
    }
}

/// The choice of this name; `what` says in messages what has names.
pub(super) fn one_of<T: Copy>(
    what: &str,
    text: &str,
    choices: &[T],
    name: impl Fn(T) -> String,
) -> Result<T, String> {
    let choice = choices.iter().copied().find(|&c| name(c) == text);
    choice.ok_or_else(|| {
        let names: Vec<String> = choices.iter().map(|&c| name(c)).collect();
        format!("no {what} \"{text}\", expected one of {}", names.join(", "))
    })
}

/// The variant of a name.
pub(super) fn variant<T: ValueEnum + Copy + 'static>(what: &str, text: &str) -> Result<T, String> {
    one_of(what, text, T::value_variants(), script_name)
}

/// A percentage from `least` to 100, as a fraction.
pub(super) fn percent(text: &str, least: f64) -> Result<f64, String> {
    let value = text.strip_suffix('%').and_then(|t| t.trim().parse().ok());
    let valid = value.filter(|p: &f64| (least..=100.0).contains(p));
    valid
        .map(|p| p / 100.0)
        .ok_or_else(|| format!("\"{text}\" is not an error, expected as in 5%"))
}

/// A file; `step` needs one.
pub(super) fn path(step: &str, text: &str) -> Result<PathBuf, String> {
    match text {
        "" => Err(format!("{step} needs a file")),
        some => Ok(PathBuf::from(some)),
    }
}

/// What is not empty; `step` needs it.
pub(super) fn name(step: &str, text: &str) -> Result<String, String> {
    match text {
        "" => Err(format!("{step} needs a name")),
        some => Ok(some.to_owned()),
    }
}
