//! What keywords begin.

use super::data::DataBlock;
use super::elements::{ElementDomain, ElementType};
use super::keyword::KeywordLine;
use super::part::{AbaqusInstance, AbaqusPart, ElementSurface, NO_SET};
use super::reader::{AbaqusReader, InputSource};
use crate::ReadError;
use crate::reading::text::shortened;
use glam::DAffine3;

impl AbaqusReader<'_> {
    /// Begins what a keyword says, and reads the file that it names, if it does.
    pub(super) fn keyword(
        &mut self,
        keyword: &KeywordLine,
        source: &mut InputSource,
    ) -> Result<(), ReadError> {
        // An include does not end the data before it: the file may hold more lines of them.
        if keyword.name == "INCLUDE" {
            return match keyword.value("INPUT") {
                Some(file) => self.include(file, keyword.at, source),
                None => {
                    Err(source.error(keyword.at, "*INCLUDE without INPUT", "the name of a file"))
                }
            };
        }
        // Any other keyword does; the data lines of what is not read are skipped.
        self.end_block(source);
        self.block = DataBlock::Skipped;
        match &*keyword.name {
            "NODE" => self.begin_nodes(keyword, source)?,
            "ELEMENT" => self.begin_elements(keyword, source),
            "ELSET" => self.begin_set(keyword, source),
            "SURFACE" => self.begin_surface(keyword, source),
            "PART" => self.begin_part(keyword),
            "INSTANCE" => self.begin_instance(keyword, source),
            "ENDPART" | "ENDINSTANCE" | "ENDASSEMBLY" | "ASSEMBLY" => self.scope = 0,
            "SHELLSECTION" | "SHELLGENERALSECTION" | "MEMBRANESECTION" | "SOLIDSECTION" => {
                let sections = &mut self.model.parts[self.scope].sections;
                sections.extend(keyword.value("ELSET").map(str::to_owned));
            }
            "RADIATE" => {
                if keyword
                    .value("OP")
                    .is_some_and(|op| op.eq_ignore_ascii_case("NEW"))
                {
                    self.model.loads.clear();
                }
                let cavity = keyword.value("CAVITY").unwrap_or("cavity").to_owned();
                self.block = DataBlock::Radiation { cavity };
            }
            "CAVITYDEFINITION" => self.block = DataBlock::Cavity,
            "SYSTEM" => self.block = DataBlock::System,
            "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" => {
                let message = format!("*{}, which makes nodes or elements: skipped", keyword.name);
                self.warn(source, keyword.at, message);
            }
            other => self.skip(other, keyword, source),
        }
        // The data lines of a keyword may be in another file.
        match (&self.block, keyword.value("INPUT")) {
            (DataBlock::Skipped, _) | (_, None) => Ok(()),
            (_, Some(file)) => self.include(file, keyword.at, source),
        }
    }

    /// Materials, loads, steps and the like: their names would fill pages.
    fn skip(&mut self, name: &str, keyword: &KeywordLine, source: &InputSource) {
        let first = self.first_other.get_or_insert_with(|| shortened(name));
        let message = format!("keyword without geometry (the first is *{first}): skipped");
        self.warn(source, keyword.at, message);
    }

    fn begin_nodes(
        &mut self,
        keyword: &KeywordLine,
        source: &InputSource,
    ) -> Result<(), ReadError> {
        let system = keyword.value("SYSTEM").unwrap_or("R").to_ascii_uppercase();
        let is_cylindrical = match &*system {
            "R" => false,
            "C" => true,
            _ => {
                let found = format!("nodes in the system {}", shortened(&system));
                return Err(source.error(keyword.at, found, "the systems R or C"));
            }
        };
        self.block = DataBlock::Nodes { is_cylindrical };
        Ok(())
    }

    fn begin_elements(&mut self, keyword: &KeywordLine, source: &InputSource) {
        let name = keyword.value("TYPE").unwrap_or("?").to_ascii_uppercase();
        let Some(mut kind) = ElementType::named(&name) else {
            let message = format!("elements of type {}: skipped", shortened(&name));
            self.warn(source, keyword.at, message);
            return;
        };
        match (name.contains("CAX"), self.sectors) {
            (true, Some(_)) => kind.domain = ElementDomain::Meridian,
            (true, None) => {
                let message = format!(
                    "elements of type {}, which are axisymmetric: read as a sheet in their plane, and not revolved \
                     (--revolve 64 does it)",
                    shortened(&name)
                );
                self.warn(source, keyword.at, message);
            }
            (false, _) => {}
        }
        let part = &mut self.model.parts[self.scope];
        let set = keyword.value("ELSET").map_or(NO_SET, |set| part.set(set));
        self.block = DataBlock::Elements {
            kind,
            set,
            begun: Vec::new(),
            at: keyword.at,
        };
    }

    fn begin_set(&mut self, keyword: &KeywordLine, source: &InputSource) {
        let Some(name) = keyword.value("ELSET") else {
            self.warn(source, keyword.at, "*ELSET without a name: skipped");
            return;
        };
        let part = &mut self.model.parts[self.scope];
        let set = part.set(name);
        part.sets[set as usize].is_internal |= keyword.parameter("INTERNAL").is_some();
        self.block = DataBlock::Set {
            set,
            is_generated: keyword.parameter("GENERATE").is_some(),
            instance: keyword.value("INSTANCE").map(str::to_owned),
        };
    }

    fn begin_surface(&mut self, keyword: &KeywordLine, source: &mut InputSource) {
        let kind = keyword
            .value("TYPE")
            .unwrap_or("ELEMENT")
            .to_ascii_uppercase();
        let is_combined = keyword.parameter("COMBINE").is_some();
        let name = keyword.value("NAME");
        let (Some(name), "ELEMENT", false) = (name, &*kind, is_combined) else {
            let kind = if is_combined { "COMBINE" } else { &kind };
            let message = format!("*SURFACE of type {}: skipped", shortened(kind));
            self.warn(source, keyword.at, message);
            return;
        };
        let surfaces = &mut self.model.parts[self.scope].surfaces;
        surfaces.push(ElementSurface {
            name: name.to_owned(),
            items: Vec::new(),
            place: source.place(keyword.at),
        });
        self.block = DataBlock::Surface;
    }

    fn begin_part(&mut self, keyword: &KeywordLine) {
        let name = keyword.value("NAME").unwrap_or("part").to_owned();
        self.scope = self.model.parts.len();
        let parts = &mut self.model.part_numbers;
        parts.entry(name.to_ascii_uppercase()).or_insert(self.scope);
        self.model.parts.push(AbaqusPart {
            name,
            ..AbaqusPart::default()
        });
    }

    fn begin_instance(&mut self, keyword: &KeywordLine, source: &mut InputSource) {
        let part = keyword.value("PART").unwrap_or_default().to_owned();
        let name = keyword.value("NAME").unwrap_or(&part).to_owned();
        self.scope = self.model.parts.len();
        self.model.parts.push(AbaqusPart::default());
        self.model.instances.push(AbaqusInstance {
            name,
            part,
            own: self.scope,
            place: DAffine3::IDENTITY,
            line: source.place(keyword.at),
        });
        self.block = DataBlock::Instance { lines: 0 };
    }
}
