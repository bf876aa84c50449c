//! Names of properties, which bulk data has only in comments of the programs that write it.

use super::card::{BulkCard, BulkLine};
use crate::reading::fortran::identifier;
use crate::reading::text::text;
use std::collections::HashMap;

/// The names by the number of the property.
#[derive(Debug, Default)]
pub(super) struct PropertyNames {
    /// HyperMesh's and ANSA's properties, Femap's, and Patran's regions.
    properties: HashMap<u32, String>,
    /// HyperMesh's components, which need not have the numbers of their properties.
    components: HashMap<u32, String>,
    /// A name that belongs to the next property, or to that of the next element.
    pending: Option<String>,
    /// The property that ANSA names on the line that follows.
    begun: Option<u32>,
}

impl PropertyNames {
    /// The name of a property: its own, that of a component, or its number. Where elements state none, it
    /// would be their own number by the manual; but a surface for each element would help nobody.
    pub fn name(&self, property: u32) -> String {
        if property == 0 {
            return "elements".to_owned();
        }
        let known = self.properties.get(&property);
        let known = known.or_else(|| self.components.get(&property));
        known.cloned().unwrap_or_else(|| format!("PID {property}"))
    }

    /// Takes the name out of a comment, if there is one.
    pub fn read_comment(&mut self, line: &BulkLine) {
        if !line.text.is_empty() || line.comment.len() < 2 {
            return;
        }
        let comment = text(line.comment);
        let comment = comment.trim_end();
        if let Some(number) = self.begun.take() {
            self.name_property(number, comment.trim_start_matches('$'));
        } else if let Some(rest) = comment.strip_prefix("$HMNAME ") {
            self.read_hypermesh(rest);
        } else if let Some(rest) = comment.strip_prefix("$ANSA_NAME_COMMENT;") {
            self.read_ansa(rest, true);
        } else if let Some(rest) = comment.strip_prefix("$ANSA_NAME;") {
            self.read_ansa(rest, false);
        } else if let Some(rest) = comment.strip_prefix("$ Femap") {
            self.read_femap(rest);
        } else if let Some(name) = region(comment) {
            self.pending = Some(name.to_owned());
        }
    }

    /// Gives the name that waits for it to the property of a card.
    pub fn read_card(&mut self, card: &BulkCard, property: Option<u32>) {
        if self.pending.is_none() {
            return;
        }
        let own = identifier(card.field(1)).filter(|_| card.name.starts_with(b"P"));
        let is_other = own.is_some() && card.name == b"PARAM";
        if let Some(number) = property.or(own).filter(|_| !is_other)
            && let Some(name) = self.pending.take()
        {
            self.name_property(number, &name);
        }
    }

    fn name_property(&mut self, number: u32, name: &str) {
        let name = name.trim();
        if !name.is_empty() {
            let known = self.properties.entry(number);
            known.or_insert_with(|| name.to_owned());
        }
    }

    /// `COMP  1"plate"`, with the number and name of the property behind it in later versions, and
    /// `PROP  1"shell" 4`.
    fn read_hypermesh(&mut self, rest: &str) {
        let Some((kind, rest)) = rest.split_once(' ') else {
            return;
        };
        let mut parts = rest.split('"');
        let number = identifier(parts.next().unwrap_or_default().trim().as_bytes());
        let name = parts.next().unwrap_or_default().trim();
        let (Some(number), false) = (number, name.is_empty()) else {
            return;
        };
        let property = identifier(parts.next().unwrap_or_default().trim().as_bytes());
        match kind {
            "PROP" => self.name_property(number, name),
            "COMP" => {
                let number = property.filter(|&p| p > 0).unwrap_or(number);
                let known = self.components.entry(number);
                known.or_insert_with(|| name.to_owned());
            }
            _ => {}
        }
    }

    /// `1;PSHELL;plate;;NO;…`, or in older versions with the name in the comment that follows.
    fn read_ansa(&mut self, rest: &str, is_complete: bool) {
        let mut parts = rest.split(';');
        let number = identifier(parts.next().unwrap_or_default().trim().as_bytes());
        let kind = parts.next().unwrap_or_default();
        let Some(number) = number.filter(|_| kind.starts_with('P')) else {
            return;
        };
        if is_complete {
            self.name_property(number, parts.next().unwrap_or_default());
        } else {
            self.begun = Some(number);
        }
    }

    /// ` with NX Nastran Property 1 : plate`, or without the program.
    fn read_femap(&mut self, rest: &str) {
        let Some((_, rest)) = rest.split_once("Property ") else {
            return;
        };
        if let Some((number, name)) = rest.split_once(':')
            && let Some(number) = identifier(number.trim().as_bytes())
        {
            self.name_property(number, name);
        }
    }
}

/// The name of the region or property that follows, by Patran or by Simcenter.
fn region(comment: &str) -> Option<&str> {
    let patran = comment
        .strip_prefix("$ Elements and Element Properties for region")
        .and_then(|rest| rest.trim_start().strip_prefix(':'));
    let simcenter = || {
        let rest = comment.strip_prefix("$*")?;
        rest.trim_start().strip_prefix("Property:")
    };
    let name = patran.or_else(simcenter)?.trim();
    (!name.is_empty()).then_some(name)
}
