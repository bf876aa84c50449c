//! Options of work that several runs of the command divide: each with `--shard K/N` computes a part by itself,
//! and `merge` puts parts together.

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::PathBuf;

/// Which part of the work is computed.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct PartArgs {
    /// Compute only shard K of N of the rows, points, vertices or texels, counted from 1, and write it to -o
    /// as a part, for `azulejo merge`
    ///
    /// An interrupted shard resumes when the same command is run again. Light needs --rays, without --error and
    /// --time: work to an error or a time cannot be divided.
    #[arg(id = "part", long = "shard", value_name = "K/N", value_parser = shard)]
    pub shard: Option<Shard>,
}

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

/// `merge`
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The parts: what each run of the command with --shard wrote
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::FilePath)]
    pub parts: Vec<PathBuf>,
    /// Output file: whatever -o of the command may be without --shard
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath, required_unless_present = "lightmap")]
    pub output: Option<PathBuf>,
    /// With parts of `bake`, write the irradiance as OpenEXR, as its --lightmap does
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub lightmap: Option<PathBuf>,
    /// With parts of `bake`, write the standard error of the irradiance, likewise
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub error_map: Option<PathBuf>,
    /// Folder in which the model, and other files that the command names, are now, if not where
    /// they were when the parts were computed. Their content has to be the same
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub files: Option<PathBuf>,
}

/// Examples and notes below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo form-factors room.obj --patches 20000 --shard 1/2 -o part-1
  azulejo form-factors room.obj --patches 20000 --shard 2/2 -o part-2
  azulejo merge part-1 part-2 -o f.npz
  azulejo merge parts/* -o f.npz --files models
  azulejo solve city.obj --rays 2048 --shard 3/64 -o parts/3
  azulejo probe city.obj --points p.npy --rays 2048 --shard 3/64 -o parts/3
  azulejo bake city.glb --rays 1024 --shard 3/64 -o parts/3
  azulejo merge parts/* -o lit.glb --lightmap E.exr

Parts can be computed in any order, on any machines, by any number of threads: the result has the same
bytes as that of the command without --shard. merge runs the command that the parts record, with their
blocks instead of computing them, so it needs the model too. docs/shards.md has scripts for queues.";

impl MergeArgs {
    /// The pictures of a lightmap that are written.
    pub fn maps(&self) -> impl Iterator<Item = &PathBuf> {
        self.lightmap.iter().chain(&self.error_map)
    }

    /// All files that are written.
    pub fn outputs(&self) -> impl Iterator<Item = &PathBuf> {
        self.output.iter().chain(self.maps())
    }
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
}
