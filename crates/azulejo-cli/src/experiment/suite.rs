//! The file of a suite: its tables, and errors with their positions.

use crate::failure::Failure;
use crate::values;
use azulejo::spelling;
use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// A suite.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Title of the report.
    pub title: String,
    /// Introduction of the report.
    #[serde(default)]
    pub about: String,
    /// Repetitions and time limit.
    #[serde(default)]
    pub run: RunTable,
    /// The reference that runs are compared with.
    pub reference: Option<ReferenceTable>,
    /// The scenes.
    #[serde(default)]
    pub scene: Vec<SceneTable>,
    /// The engines.
    #[serde(default)]
    pub engine: Vec<EngineTable>,
    /// Whether every engine computes the scenes with known solutions.
    #[serde(default)]
    pub truths: bool,
}

/// `[run]`
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunTable {
    /// Number of repetitions of each run, with different seeds.
    pub repetitions: u32,
    /// Seed of the first repetition.
    pub seed: u64,
    /// Time limit of one run; a run that takes longer is killed and reported as failed.
    pub timeout: Option<SuiteDuration>,
}

impl Default for RunTable {
    fn default() -> RunTable {
        RunTable {
            repetitions: 1,
            seed: 0,
            timeout: None,
        }
    }
}

/// `[reference]`
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReferenceTable {
    /// The engine, by the name of the command line.
    pub engine: Spanned<String>,
    /// Rays per row.
    pub rays: Option<u32>,
    /// Pixels along the side of a hemicube.
    pub resolution: Option<u32>,
    /// Points of each patch.
    pub patch_points: Option<u32>,
    /// Target for the error of row sums, where formulas are used.
    pub accuracy: Option<f64>,
    /// Number of rows to compare, evenly spread over the scene.
    #[serde(default = "ReferenceTable::default_rows")]
    pub rows: usize,
}

impl ReferenceTable {
    fn default_rows() -> usize {
        256
    }
}

/// `[[scene]]`
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneTable {
    /// Its name in the report.
    pub name: Spanned<String>,
    /// A model file, relative to the suite.
    pub file: Option<Spanned<String>>,
    /// Or the name of a generator.
    pub generator: Option<Spanned<String>>,
    /// Approximate number of facets to generate; a list makes several scenes.
    #[serde(default)]
    pub facets: OneOrMany<usize>,
    /// Number of facets that are mirrors; a list makes several scenes.
    #[serde(default)]
    pub mirrors: OneOrMany<usize>,
    /// Factor on the generator's default number of facets.
    pub detail: Option<f64>,
    /// Approximate number of patches; by default faces are not divided.
    pub patches: Option<usize>,
}

/// `[[engine]]`
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EngineTable {
    /// The engine, by the name of the command line.
    pub engine: Spanned<String>,
    /// Its name in the report, if another.
    pub name: Option<String>,
    /// Rays per row; a list makes several runs.
    #[serde(default)]
    pub rays: OneOrMany<u32>,
    /// Pixels along the side of a hemicube.
    #[serde(default)]
    pub resolution: OneOrMany<u32>,
    /// Hemicubes per patch.
    #[serde(default)]
    pub patch_points: OneOrMany<u32>,
    /// Backend that renders hemicubes.
    pub gpu: Option<Spanned<String>>,
    /// Whether Embree traces the rays, or the path of its library.
    pub embree: Option<EmbreeTable>,
    /// Whether the report says so where the engine is not available, instead of failing.
    #[serde(default)]
    pub optional: bool,
    /// Whether close pairs and lamps are computed in closed form where that is more accurate.
    #[serde(default = "yes")]
    pub formulas: bool,
    /// Target for the error of row sums, where formulas are used.
    pub accuracy: Option<f64>,
    /// Scenes in which closure is enforced: `never`, `closed` or `always`.
    pub closure: Option<Spanned<String>>,
    /// Names of the scenes it computes; all if empty.
    #[serde(default)]
    pub scenes: Vec<Spanned<String>>,
}

/// `embree = true`, or the path of the library.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(
    untagged,
    expecting = "expected true, false, or the path of Embree's library"
)]
pub enum EmbreeTable {
    /// Whether Embree traces the rays; the system finds the library.
    Wanted(bool),
    /// The library.
    Library(PathBuf),
}

impl EmbreeTable {
    /// The option of the command line.
    pub fn option(&self) -> Option<Option<PathBuf>> {
        match self {
            EmbreeTable::Wanted(false) => None,
            EmbreeTable::Wanted(true) => Some(None),
            EmbreeTable::Library(path) => Some(Some(path.clone())),
        }
    }
}

fn yes() -> bool {
    true
}

/// One value or a list; empty if missing.
#[derive(Clone, Debug, PartialEq)]
pub struct OneOrMany<T>(pub Vec<T>);

impl<T> Default for OneOrMany<T> {
    fn default() -> OneOrMany<T> {
        OneOrMany(Vec::new())
    }
}

impl<T: Copy> OneOrMany<T> {
    /// The values, or a single `None`.
    pub fn options(&self) -> Vec<Option<T>> {
        if self.0.is_empty() {
            vec![None]
        } else {
            self.0.iter().copied().map(Some).collect()
        }
    }
}

impl<'de, T: Deserialize<'de> + TryFrom<i64>> Deserialize<'de> for OneOrMany<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<OneOrMany<T>, D::Error> {
        from.deserialize_any(OneOrManyVisitor(PhantomData))
    }
}

struct OneOrManyVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + TryFrom<i64>> Visitor<'de> for OneOrManyVisitor<T> {
    type Value = OneOrMany<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a whole number that is not negative, or a list of them")
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<OneOrMany<T>, E> {
        let wrong = || E::invalid_value(serde::de::Unexpected::Signed(value), &self);
        T::try_from(value)
            .map(|x| OneOrMany(vec![x]))
            .map_err(|_| wrong())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<OneOrMany<T>, A::Error> {
        let mut values = Vec::new();
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(OneOrMany(values))
    }
}

/// A length of time as on the command line: `"90s"`, `"10m"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuiteDuration(pub Duration);

impl<'de> Deserialize<'de> for SuiteDuration {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<SuiteDuration, D::Error> {
        let text = String::deserialize(from)?;
        values::duration(&text)
            .map(SuiteDuration)
            .map_err(serde::de::Error::custom)
    }
}

/// The text of a suite, for errors with positions.
#[derive(Clone, Debug)]
pub struct SuiteSource {
    /// The file.
    pub path: PathBuf,
    text: String,
}

impl SuiteSource {
    /// Reads a suite.
    pub fn read(path: &Path) -> Result<(Suite, SuiteSource), Failure> {
        let text = std::fs::read_to_string(path).map_err(|e| Failure::file("read", path, &e))?;
        let source = SuiteSource::new(path, text);
        let suite = source.parse()?;
        Ok((suite, source))
    }

    /// The text of a suite from `path`.
    pub fn new(path: &Path, text: String) -> SuiteSource {
        SuiteSource {
            path: path.to_owned(),
            text,
        }
    }

    /// The tables of the suite.
    pub fn parse(&self) -> Result<Suite, Failure> {
        toml::from_str(&self.text).map_err(|e| {
            let message = spelling::with_hint(e.message());
            self.wrong(e.span().map_or(0, |s| s.start), message)
        })
    }

    /// An error at a byte of the text.
    pub fn wrong(&self, byte: usize, message: impl fmt::Display) -> Failure {
        let before = self.text.get(..byte).unwrap_or(&self.text);
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.rsplit('\n').next().unwrap_or("").chars().count();
        Failure::failed(format_args!(
            "{}:{line}:{column}: {message}",
            self.path.display()
        ))
    }

    /// An error for an unknown name.
    pub fn unknown(&self, what: &str, found: &Spanned<String>, known: &[&str]) -> Failure {
        let message = spelling::unknown(what, found.get_ref(), known);
        self.wrong(found.span().start, message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Suite, String> {
        let source = SuiteSource {
            path: "s.toml".into(),
            text: text.to_owned(),
        };
        source.parse().map_err(|e| e.to_string())
    }

    #[test]
    fn one_value_or_several() {
        let suite = parse(
            "title = 't'\n[[engine]]\nengine = 'rays'\nrays = [64, 256]\nresolution = 32\n\
             [run]\ntimeout = '2m'\n",
        );
        let suite = suite.unwrap();
        assert_eq!(suite.engine[0].rays.options(), [Some(64), Some(256)]);
        assert_eq!(suite.engine[0].resolution, OneOrMany(vec![32]));
        assert_eq!(suite.engine[0].patch_points.options(), [None]);
        assert_eq!(
            suite.run.timeout,
            Some(SuiteDuration(Duration::from_secs(120)))
        );
    }

    #[test]
    fn errors_say_where_what_and_what_else() {
        for (text, words) in [
            (
                "title = 't'\nenigne = 3\n",
                "s.toml:2:1: unknown field `enigne`, did you mean `engine`?",
            ),
            (
                "title = 3\n",
                "s.toml:1:9: invalid type: integer `3`, expected a string",
            ),
            (
                "title = 't'\n[run]\ntimeout = '3 apples'\n",
                "s.toml:3:11: unknown unit \"apples\"",
            ),
            (
                "title = 't'\n[[engine]]\nengine = 'rays'\nrays = -3\n",
                "s.toml:4:8: invalid value",
            ),
            (
                "title = 't'\n[[engine]]\nengine = 'rays'\nrays = 'x'\n",
                "expected a whole number",
            ),
            ("title = 't'\n[[scene]]\n", "missing field `name`"),
            ("title = [\n", "s.toml:"),
        ] {
            let message = parse(text).unwrap_err();
            assert!(message.contains(words), "{message}\n  lacks\n{words}");
        }
    }
}
