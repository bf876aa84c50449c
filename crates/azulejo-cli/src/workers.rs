//! Who computes the blocks of a work that goes on with all of them: light at vertices, points or texels.

use crate::failure::Failure;
use crate::ranks::{RankJournal, Ranks, Sharing};
use crate::session::Session;
use crate::shards::{MergedParts, WorkKey};
use azulejo_trace::{Journal, NoJournal};
use std::path::Path;

/// Who computes them.
pub enum Workers<'a> {
    /// This process.
    Alone,
    /// All ranks, each of which gets the result. At rank 0, finished blocks are kept next to this output, if there is
    /// one.
    Ranks(Ranks, Option<&'a Path>),
    /// Shards, which have ended: the result is made of their parts.
    Parts(&'a MergedParts),
}

impl<'a> Workers<'a> {
    /// Those of parts, if there are any, or of the session.
    pub fn new(
        parts: Option<&'a MergedParts>,
        output: Option<&'a Path>,
        session: &Session,
    ) -> Workers<'a> {
        match (parts, session.ranks()) {
            (Some(parts), _) => Workers::Parts(parts),
            (None, Some(ranks)) => Workers::Ranks(ranks.clone(), output),
            (None, None) => Workers::Alone,
        }
    }

    /// The result of `work` with the blocks of all, and the journal of ranks, which is to be removed once the result is
    /// written. `key` says what the blocks depend on.
    ///
    /// # Errors
    /// Those of the work; ranks do not have the same work; these are parts of other work.
    pub fn compute<T>(
        self,
        key: impl FnOnce() -> WorkKey,
        session: &mut Session,
        work: impl FnOnce(&dyn Journal, &Session) -> Result<T, Failure>,
    ) -> Result<(T, Option<RankJournal>), Failure> {
        match self {
            Workers::Alone => Ok((work(&NoJournal, session)?, None)),
            Workers::Ranks(ranks, output) => {
                let journal = ranks.journal(Sharing::All, &key(), output)?;
                let found = journal.run(session, |journal, session| work(journal, session))?;
                Ok((found, Some(journal)))
            }
            Workers::Parts(parts) => {
                parts.check(&key())?;
                Ok((parts.used(work(parts, session))?, None))
            }
        }
    }
}
