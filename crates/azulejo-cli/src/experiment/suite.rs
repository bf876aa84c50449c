//! What a suite says: the tables of its file, and where in the file something is wrong.

use super::spelling;
use crate::failure::Failure;
use crate::values;
use serde::de::{Deserialize, Deserializer, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Spanned;

/// A suite as it is written.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Title of the report.
    pub title: String,
    /// What it is about, in a few sentences.
    #[serde(default)]
    pub about: String,
    /// How often, how long.
    #[serde(default)]
    pub run: RunTable,
    /// What runs are compared with.
    pub reference: Option<ReferenceTable>,
    /// Scenes to compute.
    #[serde(default)]
    pub scene: Vec<SceneTable>,
    /// Engines to compute them.
    #[serde(default)]
    pub engine: Vec<EngineTable>,
    /// Whether every engine answers the scenes with known answers.
    #[serde(default)]
    pub truths: bool,
}

/// `[run]`
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunTable {
    /// How often each run is done, each time with another seed.
    pub repetitions: u32,
    /// Seed of the first repetition.
    pub seed: u64,
    /// Longest time of one run; what takes longer is ended and reported so.
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
    /// Error of the sums of rows that formulas are to keep within.
    pub accuracy: Option<f64>,
    /// Rows that are kept and compared, evenly spread over the scene.
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
    /// A model, relative to the suite.
    pub file: Option<Spanned<String>>,
    /// Or a generator.
    pub generator: Option<Spanned<String>>,
    /// About how many facets the generator should make; several are several scenes.
    #[serde(default)]
    pub facets: OneOrMany<usize>,
    /// How many facets are mirrors; several are several scenes.
    #[serde(default)]
    pub mirrors: OneOrMany<usize>,
    /// How many times as many facets the generator should make as usual.
    pub detail: Option<f64>,
    /// About how many patches to divide the surfaces into; by default faces stay whole.
    pub patches: Option<usize>,
}

/// `[[engine]]`
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EngineTable {
    /// The engine, by the name of the command line.
    pub engine: Spanned<String>,
    /// Its name in the report, if not that.
    pub name: Option<String>,
    /// Rays per row; several are several runs.
    #[serde(default)]
    pub rays: OneOrMany<u32>,
    /// Pixels along the side of a hemicube.
    #[serde(default)]
    pub resolution: OneOrMany<u32>,
    /// Points of each patch from which one is drawn.
    #[serde(default)]
    pub patch_points: OneOrMany<u32>,
    /// Who draws.
    pub gpu: Option<Spanned<String>>,
    /// Embree's library.
    pub embree: Option<PathBuf>,
    /// Whether close pairs and lamps are computed by formula where that is better.
    #[serde(default = "yes")]
    pub formulas: bool,
    /// Error of the sums of rows that formulas are to keep within.
    pub accuracy: Option<f64>,
    /// Which scenes have their rows made to add up: `never`, `closed` or `always`.
    pub closure: Option<Spanned<String>>,
    /// The scenes that it computes; all, if it does not say.
    #[serde(default)]
    pub scenes: Vec<Spanned<String>>,
}

fn yes() -> bool {
    true
}

/// One value or a list of them; nothing said is an empty list.
#[derive(Clone, Debug, PartialEq)]
pub struct OneOrMany<T>(pub Vec<T>);

impl<T> Default for OneOrMany<T> {
    fn default() -> OneOrMany<T> {
        OneOrMany(Vec::new())
    }
}

impl<T: Copy> OneOrMany<T> {
    /// The values, or one that says nothing.
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

/// A suite with its text, so that errors can say where.
#[derive(Clone, Debug)]
pub struct SuiteSource {
    /// Where it was read.
    pub path: PathBuf,
    text: String,
}

impl SuiteSource {
    /// Reads a suite.
    pub fn read(path: &Path) -> Result<(Suite, SuiteSource), Failure> {
        let text = std::fs::read_to_string(path).map_err(|e| Failure::file("read", path, &e))?;
        let source = SuiteSource {
            path: path.to_owned(),
            text,
        };
        let suite = source.parse()?;
        Ok((suite, source))
    }

    fn parse(&self) -> Result<Suite, Failure> {
        toml::from_str(&self.text).map_err(|e| {
            let message = spelling::with_hint(e.message());
            self.wrong(e.span().map_or(0, |s| s.start), message)
        })
    }

    /// The failure of what stands at a byte of the text.
    pub fn wrong(&self, byte: usize, message: impl fmt::Display) -> Failure {
        let before = self.text.get(..byte).unwrap_or(&self.text);
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.rsplit('\n').next().unwrap_or("").chars().count();
        Failure::failed(format_args!(
            "{}:{line}:{column}: {message}",
            self.path.display()
        ))
    }

    /// The failure of a name that is none of those there are.
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
            let said = parse(text).unwrap_err();
            assert!(said.contains(words), "{said}\n  lacks\n{words}");
        }
    }
}
