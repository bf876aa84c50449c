//! What a teacher's link opens.

use super::Lesson;
use crate::words::Language;
use std::str::FromStr;

/// A lesson and a language, each only where the link says so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LabLink {
    /// The lesson to open.
    pub lesson: Option<Lesson>,
    /// The language of the window.
    pub language: Option<Language>,
}

impl LabLink {
    /// Reads the query of a web address, as in `?lab=3&lang=es`; parameters of other names are left alone.
    ///
    /// # Errors
    ///
    /// A message with what was found and what was expected.
    ///
    /// ```
    /// use azulejo_workbench::lab::{LabLink, Lesson};
    /// use azulejo_workbench::words::Language;
    ///
    /// let link = LabLink::from_query("?lab=3&lang=es")?;
    /// assert_eq!(link.lesson, Some(Lesson::Reciprocity));
    /// assert_eq!(link.language, Some(Language::Spanish));
    /// # Ok::<(), String>(())
    /// ```
    pub fn from_query(query: &str) -> Result<LabLink, String> {
        let mut link = LabLink::default();
        let query = query.strip_prefix('?').unwrap_or(query);
        for parameter in query.split('&') {
            match parameter.split_once('=') {
                Some(("lab", value)) => link.lesson = Some(value.parse()?),
                Some(("lang", value)) => link.language = Some(value.parse()?),
                _ => {}
            }
        }
        Ok(link)
    }
}

impl FromStr for Lesson {
    type Err = String;

    /// Reads the number of a lesson.
    fn from_str(text: &str) -> Result<Lesson, String> {
        let lesson = text.parse().ok().and_then(Lesson::from_number);
        lesson.ok_or_else(|| format!("lesson \"{text}\", expected 1 to {}", Lesson::COUNT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queries_are_read_and_nonsense_is_said() {
        for (query, lesson, language) in [
            ("", None, None),
            ("?", None, None),
            ("?lab=8", Some(Lesson::ErrorBar), None),
            ("lang=pt&x=1&lab", None, Some(Language::Portuguese)),
        ] {
            let link = LabLink { lesson, language };
            assert_eq!(LabLink::from_query(query), Ok(link), "{query}");
        }
        for (query, said) in [
            ("?lab=9", "lesson \"9\", expected 1 to 8"),
            ("?lab=-1", "lesson \"-1\""),
            ("?lang=fr", "language \"fr\", expected one of en, es, pt"),
        ] {
            let why = LabLink::from_query(query).unwrap_err();
            assert!(why.contains(said), "{why}");
        }
    }
}
