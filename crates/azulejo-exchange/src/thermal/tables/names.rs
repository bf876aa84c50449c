//! Which record is for which row.

use super::TableError;
use super::records::NamedRecord;
use crate::enclosure::Enclosure;
use globset::{Glob, GlobMatcher};
use std::collections::{BTreeSet, HashMap};

/// Names that are listed in a message.
const LISTED: usize = 8;

/// The records of a table by their names.
#[derive(Clone, Debug)]
pub(super) struct RecordNames {
    names: Vec<String>,
    exact: HashMap<String, usize>,
    patterns: Vec<(usize, GlobMatcher)>,
}

impl RecordNames {
    /// Fails if a name is there twice.
    pub fn new(records: &[NamedRecord]) -> Result<RecordNames, TableError> {
        let mut names = RecordNames {
            names: records.iter().map(|r| r.name.clone()).collect(),
            exact: HashMap::new(),
            patterns: Vec::new(),
        };
        for (k, record) in records.iter().enumerate() {
            if names.exact.insert(record.name.clone(), k).is_some() {
                return Err(TableError::new(format_args!(
                    "{}: \"{}\" is there already",
                    record.place, record.name
                )));
            }
            if record.name.contains(['*', '?', '['])
                && let Ok(glob) = Glob::new(&record.name)
            {
                names.patterns.push((k, glob.compile_matcher()));
            }
        }
        Ok(names)
    }

    /// The record of each row. `what` is what rows need, in a message about those without.
    pub fn required_records(
        &self,
        enclosure: &Enclosure,
        what: &str,
    ) -> Result<Vec<usize>, TableError> {
        let (records, missing) = self.find(enclosure);
        if missing.is_empty() {
            return Ok(records.into_iter().flatten().collect());
        }
        Err(TableError::without_record(&missing, what))
    }

    /// The record of each row that has one.
    pub fn records(&self, enclosure: &Enclosure) -> Vec<Option<usize>> {
        self.find(enclosure).0
    }

    /// Records that no row has, without `*`, which may be there for none.
    pub fn unused(&self, enclosure: &Enclosure) -> Vec<&str> {
        let (records, _) = self.find(enclosure);
        let used: BTreeSet<usize> = records.into_iter().flatten().collect();
        let names = self.names.iter().enumerate();
        names
            .filter(|(k, name)| !used.contains(k) && *name != "*")
            .map(|(_, name)| name.as_str())
            .collect()
    }

    /// The record of each row, and the names of objects, or of rows that are groups, that have none.
    fn find(&self, enclosure: &Enclosure) -> (Vec<Option<usize>>, BTreeSet<String>) {
        let (factors, rows) = (&enclosure.factors, &enclosure.rows);
        let mut missing = BTreeSet::new();
        let mut row = |i: usize| {
            let own = rows.names[i].as_str();
            let mut names = vec![own.to_owned()];
            names.extend(own.strip_suffix(" (back)").map(str::to_owned));
            if let Some(face) = factors.faces.get(i) {
                if let Some(object) = rows.objects.get(face.object as usize) {
                    names.push(format!("{object}/{}", face.face));
                    names.push(object.clone());
                }
                let material = factors.materials.get(i);
                names.extend(material.and_then(|&m| rows.materials.get(m as usize).cloned()));
            }
            let record = self.record(&names);
            if record.is_none() {
                let object = if rows.are_groups {
                    0
                } else {
                    names.len().saturating_sub(2)
                };
                missing.insert(names[object].clone());
            }
            record
        };
        let records = (0..enclosure.len()).map(&mut row).collect();
        (records, missing)
    }

    /// The record for a surface that has these names, the narrowest first.
    pub fn record(&self, names: &[String]) -> Option<usize> {
        let exact = names.iter().find_map(|name| self.exact.get(name));
        exact.copied().or_else(|| {
            let mut patterns = self.patterns.iter();
            let matches = |glob: &GlobMatcher| names.iter().any(|name| glob.is_match(name));
            // `*` alone is for what no other pattern is for.
            let narrow = patterns.find(|(k, glob)| self.names[*k] != "*" && matches(glob));
            narrow
                .map(|(k, _)| *k)
                .or_else(|| self.exact.get("*").copied())
        })
    }
}

/// Names in quotation marks, not too many of them.
pub(super) fn listed(names: &BTreeSet<String>) -> String {
    let some: Vec<String> = names
        .iter()
        .take(LISTED)
        .map(|n| format!("\"{n}\""))
        .collect();
    match names.len().saturating_sub(LISTED) {
        0 => some.join(", "),
        more => format!("{} and {more} more", some.join(", ")),
    }
}
