//! Work divided over any queue: each command with `--shard K/N` computes a part by itself, and `merge`
//! puts parts together.
//!
//! A part is a journal: a file of finished blocks behind a header that says of what work they are. `merge`
//! runs the recorded command with the parts as its journal, so that its result is that of one
//! process by construction.

mod command;
mod header;
pub mod merge;
mod merged;
mod part;

use crate::failure::Failure;
pub use command::{ShardedArgs, files_of_command, named_files, sharded};
pub use header::{NamedFile, WorkKey};
pub use merged::MergedParts;
pub use part::PartPlan;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// One of several parts of a work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Its number, from 1.
    pub number: u32,
    /// Number of all.
    pub of: u32,
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.number, self.of)
    }
}

/// Most shards of a work.
const MOST: u32 = 1 << 20;

/// A shard as in `3/64`.
pub fn shard(text: &str) -> Result<Shard, String> {
    let expected = "expected K/N as in 3/64, the third of 64 shards";
    let (number, of) = text.split_once('/').ok_or(expected)?;
    let parse = |word: &str| word.trim().parse::<u32>().map_err(|_| expected.to_owned());
    let shard = Shard {
        number: parse(number)?,
        of: parse(of)?,
    };
    match shard {
        Shard { of: 0, .. } => Err("there are 0 shards, expected 1 or more".to_owned()),
        Shard { number: 0, .. } => Err(format!(
            "shards count from 1: 1/{of} to {of}/{of}; where the queue counts from 0, add 1, as in \
             --shard $((I + 1))/{of}"
        )),
        Shard { of, .. } if of > MOST => Err(format!("{of} shards, expected at most {MOST}")),
        Shard { number, of } if number > of => Err(format!(
            "shard {number} of only {of}, expected 1/{of} to {of}/{of}"
        )),
        shard => Ok(shard),
    }
}

/// Refuses what cannot be read a second time.
pub fn refuse_stream(path: &Path) -> Result<(), Failure> {
    if path == Path::new("-") {
        return Err(Failure::misuse(
            "--shard: merge has to read the model again, which it cannot do from standard input; give a file",
        ));
    }
    Ok(())
}

/// Numbers with runs joined: `3, 7–12`.
fn runs(numbers: &[u32]) -> String {
    let mut words: Vec<String> = Vec::new();
    for run in numbers.chunk_by(|a, b| a + 1 == *b) {
        words.push(match run {
            [first, .., last] if run.len() > 2 => format!("{first}–{last}"),
            run => run
                .iter()
                .map(u32::to_string)
                .collect::<Vec<_>>()
                .join(", "),
        });
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::tests::{check, refuse};

    #[test]
    fn shards_count_from_one() {
        check(shard, "3/64", Shard { number: 3, of: 64 });
        check(shard, "1/1", Shard { number: 1, of: 1 });
        let bad = [
            "0/4",
            "5/4",
            "3/0",
            "0/0",
            "x/y",
            "3",
            "",
            "/",
            "1/",
            "-1/4",
            "1/4/8",
            "1.5/4",
            "1/9999999",
        ];
        refuse(shard, &bad);
        assert!(shard("0/4").unwrap_err().contains("count from 1"));
    }

    #[test]
    fn missing_numbers_are_joined() {
        let check = |numbers: &[u32], want: &str| assert_eq!(runs(numbers), want);
        check(&[3, 7, 8, 9, 10, 11, 12], "3, 7–12");
        check(&[1, 2], "1, 2");
        check(&[64], "64");
        check(&[], "");
    }
}
