//! Messages for unknown names, with the most similar known one.

use std::fmt::Write;

/// `unknown engine "ray", did you mean "rays"? (known: rays, embree)`
pub fn unknown(what: &str, found: &str, known: &[&str]) -> String {
    let mut words = format!("unknown {what} \"{found}\"");
    if let Some(near) = nearest(found, known) {
        let _ = write!(words, ", did you mean \"{near}\"?");
    }
    let _ = write!(words, " (known: {})", known.join(", "));
    words
}

/// Inserts the nearest name into a message of `serde`: "unknown field `a`, expected one of `b`,
/// `c`".
pub fn with_hint(message: &str) -> String {
    let parts = message
        .split_once(", expected ")
        .filter(|(head, _)| head.starts_with("unknown "));
    let Some((head, list)) = parts else {
        return message.trim_end().to_owned();
    };
    let quoted = |text: &str| -> Vec<String> {
        text.split('`')
            .skip(1)
            .step_by(2)
            .map(str::to_owned)
            .collect()
    };
    let known = quoted(list);
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    match quoted(head)
        .first()
        .and_then(|spelling| nearest(spelling, &known))
    {
        Some(near) => format!("{head}, did you mean `{near}`? (expected {list})"),
        None => message.trim_end().to_owned(),
    }
}

/// The known name at the smallest edit distance, if that is small.
fn nearest<'a>(spelling: &str, known: &[&'a str]) -> Option<&'a str> {
    let far = |name: &&&str| distance(spelling, name);
    let near = known.iter().min_by_key(far)?;
    (distance(spelling, near) <= 1 + spelling.chars().count() / 3).then_some(*near)
}

/// Edit distance with transpositions (Damerau 1964).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = match (i, j) {
                (0, _) | (_, 0) => i + j,
                _ => {
                    let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                    let least = replaced.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                    let is_swap = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                    if is_swap {
                        least.min(rows[i - 2][j - 2] + 1)
                    } else {
                        least
                    }
                }
            };
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested() {
        assert_eq!(nearest("enigne", &["scene", "engine"]), Some("engine"));
        assert_eq!(nearest("rys", &["rays", "hybrid"]), Some("rays"));
        assert_eq!(nearest("xyzzy", &["rays", "hybrid"]), None);
        let message = unknown("engine", "ray", &["rays", "hybrid"]);
        assert_eq!(
            message,
            "unknown engine \"ray\", did you mean \"rays\"? (known: rays, hybrid)"
        );
        assert_eq!(with_hint("missing field `name`"), "missing field `name`");
    }
}
