//! What data lines say.

use super::elements::{ElementFace, ElementType};
use super::keyword::{InputField, InputLine, unquoted};
use super::part::{CavityLoad, ElementItem, NO_SET, PartElement};
use super::reader::{AbaqusReader, InputSource};
use crate::ReadError;
use crate::reading::fortran::{identifier, real};
use crate::reading::text::{quoted, text};
use glam::{DAffine3, DQuat, DVec3};

/// What the data lines of the current keyword are.
#[derive(Clone, Debug)]
pub(super) enum DataBlock {
    /// Nothing that is read.
    Skipped,
    /// Nodes.
    Nodes {
        /// Whether they have a radius and an azimuth.
        is_cylindrical: bool,
    },
    /// Elements of one type.
    Elements {
        /// Their type.
        kind: ElementType,
        /// Their set.
        set: u32,
        /// The numbers of an element that continues on the next line.
        begun: Vec<u32>,
        /// Where that begins.
        at: usize,
    },
    /// A set.
    Set {
        /// Its index.
        set: u32,
        /// Whether lines are first, last and step.
        is_generated: bool,
        /// The instance of its elements, if it is not the part's own.
        instance: Option<String>,
    },
    /// The last surface.
    Surface,
    /// The place of the last instance.
    Instance {
        /// Lines that have been read.
        lines: usize,
    },
    /// Radiation loads, those of CalculiX in a cavity among them.
    Radiation {
        /// Its name.
        cavity: String,
    },
    /// The surfaces of a cavity.
    Cavity,
    /// A coordinate system for all nodes that follow.
    System,
}

impl AbaqusReader<'_> {
    /// Takes in a data line.
    pub(super) fn data(
        &mut self,
        line: &InputLine,
        source: &mut InputSource,
    ) -> Result<(), ReadError> {
        match self.block {
            DataBlock::Skipped => Ok(()),
            DataBlock::Nodes { is_cylindrical } => self.node(line, is_cylindrical, source),
            DataBlock::Elements { .. } => self.element(line, source),
            DataBlock::Set { .. } => self.set_line(line, source),
            DataBlock::Surface => self.surface_line(line, source),
            DataBlock::Instance { lines } => self.instance_line(line, lines, source),
            DataBlock::Radiation { .. } => {
                self.load(line, source);
                Ok(())
            }
            DataBlock::Cavity => {
                let names = line.fields().map(|f| text(f.text).into_owned());
                let names = names.map(|name| unquoted(&name).to_ascii_uppercase());
                self.model.cavities.extend(names.filter(|n| !n.is_empty()));
                Ok(())
            }
            DataBlock::System => {
                let found = "a coordinate system (*SYSTEM)";
                Err(source.error(line.at, found, "nodes in the global system"))
            }
        }
    }

    /// Ends the data of a keyword.
    pub(super) fn end_block(&mut self, source: &InputSource) {
        if let DataBlock::Elements { begun, at, .. } = &self.block
            && !begun.is_empty()
        {
            let at = (*at).min(source.text.bytes().len());
            self.warn(source, at, "element with too few nodes: skipped");
        }
    }

    fn node(
        &mut self,
        line: &InputLine,
        is_cylindrical: bool,
        source: &InputSource,
    ) -> Result<(), ReadError> {
        let mut fields = line.fields();
        let number = whole(fields.next(), line, source)?;
        let mut at = [0.0; 3];
        for coordinate in &mut at {
            *coordinate = decimal(fields.next(), source)?;
        }
        let position = match (is_cylindrical, at) {
            (false, at) => DVec3::from(at),
            (true, [radius, degrees, z]) => {
                let (sine, cosine) = degrees.to_radians().sin_cos();
                DVec3::new(radius * cosine, radius * sine, z)
            }
        };
        let part = &mut self.model.parts[self.scope];
        let new = part.positions.len() as u32;
        let index = *part.node_numbers.entry(number).or_insert(new);
        if index == new {
            part.positions.push(position);
        } else if part.positions[index as usize] != position {
            part.positions[index as usize] = position;
            let message = "node of a number that another one has: the last one counts";
            self.warn(source, line.at, message);
        }
        Ok(())
    }

    fn element(&mut self, line: &InputLine, source: &InputSource) -> Result<(), ReadError> {
        let DataBlock::Elements {
            kind,
            set,
            begun,
            at,
        } = &mut self.block
        else {
            return Ok(());
        };
        // An element may continue on further lines: collect its number and nodes until they are complete.
        if begun.is_empty() {
            *at = line.at;
        }
        let (kind, set) = (*kind, *set);
        let mut is_long = false;
        for field in line.fields() {
            is_long |= begun.len() > kind.nodes && !field.text.is_empty();
            if begun.len() <= kind.nodes && !field.text.is_empty() {
                begun.push(whole(Some(field), line, source)?);
            }
        }
        if begun.len() <= kind.nodes {
            return Ok(());
        }
        let numbers = std::mem::take(begun);
        if is_long {
            self.warn(
                source,
                line.at,
                "element with too many nodes: the first ones are used",
            );
        }
        // Corners precede the nodes on edges, and no element has more than eight of them.
        let mut nodes = [0; 8];
        nodes
            .iter_mut()
            .zip(&numbers[1..])
            .for_each(|(node, number)| *node = *number);
        // Of several elements with the same number the first one counts.
        let part = &mut self.model.parts[self.scope];
        let index = part.elements.len() as u32;
        if *part.element_numbers.entry(numbers[0]).or_insert(index) != index {
            self.warn(
                source,
                line.at,
                "element of a number that another one has: skipped",
            );
            return Ok(());
        }
        part.elements.push(PartElement { kind, nodes, set });
        // Sets hold ranges of indices: an element that follows the last one extends its range.
        if set != NO_SET {
            let items = &mut part.sets[set as usize].items;
            match items.last_mut() {
                Some(ElementItem::Indices(_, end)) if *end == index => *end += 1,
                _ => items.push(ElementItem::Indices(index, index + 1)),
            }
        }
        Ok(())
    }

    fn set_line(&mut self, line: &InputLine, source: &InputSource) -> Result<(), ReadError> {
        let DataBlock::Set {
            set,
            is_generated,
            instance,
        } = &self.block
        else {
            return Ok(());
        };
        let mut items = Vec::new();
        if *is_generated {
            let mut fields = line.fields();
            let first = whole(fields.next(), line, source)?;
            let last = whole(fields.next(), line, source)?;
            let step = match fields.next() {
                None => 1,
                step => whole(step, line, source)?.max(1),
            };
            items.push(ElementItem::Numbers([first, last, step], instance.clone()));
        } else {
            let fields = line.fields().filter(|f| !f.text.is_empty());
            items.extend(fields.map(|field| item(field, instance)));
        }
        let set = *set as usize;
        self.model.parts[self.scope].sets[set].items.extend(items);
        Ok(())
    }

    fn surface_line(&mut self, line: &InputLine, source: &InputSource) -> Result<(), ReadError> {
        let mut fields = line.fields();
        let Some(target) = fields.next() else {
            return Ok(());
        };
        let face = fields.next().map_or(&b""[..], |f| f.text);
        let Some(face) = ElementFace::named(face) else {
            let message = format!("surface of {}, which is not a face: skipped", quoted(face));
            self.warn(source, line.at, message);
            return Ok(());
        };
        let surfaces = &mut self.model.parts[self.scope].surfaces;
        if let Some(surface) = surfaces.last_mut() {
            surface.items.push((item(target, &None), face));
        }
        Ok(())
    }

    /// Other loads than those of cavities (`R1`, `RP`) are between a face and its surroundings.
    fn load(&mut self, line: &InputLine, source: &mut InputSource) {
        let DataBlock::Radiation { cavity } = &self.block else {
            return;
        };
        let mut fields = line.fields();
        let (target, label) = (fields.next(), fields.next());
        let label = label.map_or(Vec::new(), |field| field.text.to_ascii_uppercase());
        let face = label.strip_prefix(b"R").and_then(|l| l.strip_suffix(b"CR"));
        let face = face.and_then(|face| ElementFace::named(&[b"S", face].concat()));
        if let (Some(target), Some(face)) = (target, face) {
            self.model.loads.push(CavityLoad {
                cavity: cavity.clone(),
                item: item(target, &None),
                face,
                place: source.place(line.at),
            });
        }
    }

    /// A translation, and then a rotation about a line through two points by an angle in degrees.
    fn instance_line(
        &mut self,
        line: &InputLine,
        lines: usize,
        source: &InputSource,
    ) -> Result<(), ReadError> {
        let mut numbers = [0.0; 7];
        for (number, field) in numbers.iter_mut().zip(line.fields()) {
            *number = decimal(Some(field), source)?;
        }
        let [ax, ay, az, bx, by, bz, degrees] = numbers;
        let a = DVec3::new(ax, ay, az);
        let change = match lines {
            0 => DAffine3::from_translation(a),
            1 => {
                let axis = (DVec3::new(bx, by, bz) - a).try_normalize();
                let Some(axis) = axis else {
                    let found = "a rotation about two points that are one";
                    return Err(source.error(line.at, found, "two points of its axis"));
                };
                let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
                DAffine3::from_rotation_translation(turn, a - turn * a)
            }
            _ => return Ok(()),
        };
        if let Some(instance) = self.model.instances.last_mut() {
            instance.place = change * instance.place;
        }
        self.block = DataBlock::Instance { lines: lines + 1 };
        Ok(())
    }
}

/// Elements by number or the set of a name, possibly after the name of an instance and a dot.
fn item(field: InputField, instance: &Option<String>) -> ElementItem {
    let whole = text(field.text);
    let whole = unquoted(&whole);
    if let Some(number) = identifier(whole.as_bytes()) {
        return ElementItem::Numbers([number, number, 1], instance.clone());
    }
    let (of, name) = match whole.split_once('.') {
        Some((of, name)) => (Some(unquoted(of).to_owned()), unquoted(name)),
        None => (instance.clone(), whole),
    };
    ElementItem::Set(name.to_owned(), of)
}

fn whole(
    field: Option<InputField>,
    line: &InputLine,
    source: &InputSource,
) -> Result<u32, ReadError> {
    const EXPECTED: &str = "a whole number";
    let Some(field) = field else {
        let end = line.at + line.text.len();
        return Err(source.error(end, "the end of the line", EXPECTED));
    };
    let number = identifier(field.text);
    number.ok_or_else(|| source.error(field.at, quoted(field.text), EXPECTED))
}

/// A real number; 0 where there is none.
fn decimal(field: Option<InputField>, source: &InputSource) -> Result<f64, ReadError> {
    match field {
        Some(field) if !field.text.is_empty() => {
            let number = real(field.text);
            number.ok_or_else(|| source.error(field.at, quoted(field.text), "a number"))
        }
        _ => Ok(0.0),
    }
}
