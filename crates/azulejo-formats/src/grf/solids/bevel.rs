//! `bevel`, a key of prisms and texts.

use super::super::entries::{EntryValue, GrfEntries, Taken};
use super::super::parser::GrfParser;
use super::super::write::GrfOutput;
use azulejo_scene::{Bevel, BevelEnds, BevelProfile};
use std::io::{self, Write};
use std::sync::Arc;

const PROFILES: [(&str, BevelProfile); 2] = [
    ("chamfer", BevelProfile::Chamfer),
    ("round", BevelProfile::Round),
];
const ENDS: [(&str, BevelEnds); 2] = [("front", BevelEnds::Front), ("both", BevelEnds::Both)];

impl<'a> GrfParser<'a, '_, '_> {
    /// `bevel = chamfer` or `round`, with `bevel_size`, its inset and its depth, and `bevel_ends`.
    pub fn take_bevel(&mut self, entries: &mut GrfEntries<'a>) -> Taken<Arc<Bevel>> {
        let Some(profile) = self.take_choice(entries, "bevel", &PROFILES)? else {
            return Ok(None);
        };
        let size = self.needed(entries, "bevel_size")?;
        let ends = self.take_choice(entries, "bevel_ends", &ENDS)?;
        let EntryValue::Numbers(numbers) = &size.value else {
            return Err(self.wrong(&size, "two numbers"));
        };
        let &[inset, depth] = &numbers[..] else {
            return Err(self.wrong(&size, "two numbers"));
        };
        let bevel = Bevel {
            profile,
            inset,
            depth,
            ends: ends.unwrap_or(BevelEnds::Front),
        };
        if bevel.is_valid() {
            return Ok(Some(Arc::new(bevel)));
        }
        Err(self.fail(
            size.offset,
            format!("a bevel of size {inset} {depth}"),
            "an inset above 0, and a depth above 0 and at most 1, or 0.5 with `bevel_ends = both`",
        ))
    }
}

/// Writes the keys of a bevel.
pub(super) fn bevel(out: &mut GrfOutput<'_>, bevel: Option<&Arc<Bevel>>) -> io::Result<()> {
    let Some(bevel) = bevel else { return Ok(()) };
    let profile = match bevel.profile {
        BevelProfile::Chamfer => "chamfer",
        BevelProfile::Round => "round",
    };
    write!(
        out,
        " bevel = {profile} bevel_size = {} {}",
        bevel.inset, bevel.depth
    )?;
    match bevel.ends {
        BevelEnds::Front => Ok(()),
        BevelEnds::Both => out.write_all(b" bevel_ends = both"),
    }
}
