//! What the cards mean.

use super::card::BulkCard;
use super::coordinates::{DefinedSystem, GridPoint};
use super::elements::{is_other_element, shape_of};
use super::fields::CardFields;
use super::reader::{BulkReader, BulkSource};
use crate::ReadError;
use crate::reading::text::text;

impl BulkReader<'_> {
    /// Takes what a card says into the deck; `line` is that of its first line.
    pub(super) fn card(
        &mut self,
        card: &BulkCard,
        source: &BulkSource,
        line: u32,
    ) -> Result<(), ReadError> {
        let place = (source.number, line);
        let fields = CardFields { card, source };
        if card.is_long {
            self.warn(source, card.at, "fields after the ninth of a line: skipped");
        }
        if let Some(shape) = shape_of(card) {
            let element = fields.element(shape, place)?;
            self.deck.names.read_card(card, Some(element.property));
            self.deck.elements.push(element);
            return Ok(());
        }
        self.deck.names.read_card(card, None);
        match &*card.name {
            b"GRID" => self.grid(&fields)?,
            b"GRDSET" => self.deck.default_system = fields.optional(2)?.unwrap_or(0),
            b"CORD1R" | b"CORD1C" | b"CORD1S" => {
                for first in [1, 5] {
                    if let Some((id, system)) = fields.system_of_grids(first, place)? {
                        self.system(&fields, id, system);
                    }
                }
            }
            b"CORD2R" | b"CORD2C" | b"CORD2S" => {
                let (id, system) = fields.system_of_points(place)?;
                self.system(&fields, id, system);
            }
            b"CHBDYG" | b"CHBDYE" => match fields.radiating(place)? {
                Some(element) => self.deck.radiation.elements.push(element),
                None => self.warn(source, card.at, "CHBDYG that is not a polygon: skipped"),
            },
            b"CHBDYP" => self.warn(
                source,
                card.at,
                "CHBDYP, which is a point, a line or a tube: skipped",
            ),
            b"VIEW" => self.view(&fields)?,
            b"BDYOR" => {
                for (side, view) in [fields.optional(2)?, fields.optional(3)?]
                    .into_iter()
                    .enumerate()
                {
                    self.deck.radiation.default_views[side] = view.unwrap_or(0);
                }
            }
            b"RADSET" => {
                for k in 1..=card.len() {
                    let cavity = fields.optional(k)?;
                    self.deck.radiation.analysed.extend(cavity);
                }
            }
            name if name.starts_with(b"=") || card.field(1) == b"=" => {
                self.warn(source, card.at, "card that repeats others (=): skipped");
            }
            name if is_other_element(name) => {
                let message = format!("element {}: skipped", text(name));
                self.warn(source, card.at, message);
            }
            name => {
                // Loads, materials and the like: their names would fill pages.
                let first = self
                    .first_other
                    .get_or_insert_with(|| text(name).into_owned());
                let message = format!("card without geometry (the first is {first}): skipped");
                self.warn(source, card.at, message);
            }
        }
        Ok(())
    }

    fn grid(&mut self, fields: &CardFields) -> Result<(), ReadError> {
        let id = fields.required(1, "the number of a grid point")?;
        let point = GridPoint {
            system: fields.optional(2)?,
            coordinates: [fields.real(3)?, fields.real(4)?, fields.real(5)?],
        };
        let index = self.deck.grids.len() as u32;
        let known = *self.deck.grid_numbers.entry(id).or_insert(index);
        if known == index {
            self.deck.grids.push(point);
        } else if self.deck.grids[known as usize] != point {
            let message = "grid point of a number that another one has: skipped";
            self.warn(fields.source, fields.card.at, message);
        }
        Ok(())
    }

    fn system(&mut self, fields: &CardFields, id: u32, system: DefinedSystem) {
        if self.deck.systems.insert(id, system).is_some() {
            let message = "coordinate system of a number that another one has: the last one counts";
            self.warn(fields.source, fields.card.at, message);
        }
    }

    fn view(&mut self, fields: &CardFields) -> Result<(), ReadError> {
        let id = fields.required(1, "the number of a view")?;
        if let Some(cavity) = fields.optional(2)? {
            self.deck.radiation.cavities.insert(id, cavity);
        }
        if !matches!(fields.card.field(3), b"" | b"BOTH") {
            let message = "VIEW of surfaces that do not shade, or are not shaded: they do and are";
            self.warn(fields.source, fields.card.at, message);
        }
        Ok(())
    }
}
