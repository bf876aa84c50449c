//! The fields of cards as numbers, and cards as what they define.

use super::card::BulkCard;
use super::coordinates::{CoordinateKind, DefinedSystem, DefiningPoints};
use super::elements::BulkElement;
use super::reader::BulkSource;
use super::thermal::{RadiatingElement, RadiatingSurface};
use crate::ReadError;
use crate::reading::fortran::{identifier, real};
use crate::reading::text::{quoted, text};
use crate::surface::finite::FiniteShape;

/// The fields of a card as numbers.
pub(super) struct CardFields<'a> {
    pub card: &'a BulkCard,
    pub source: &'a BulkSource<'a>,
}

impl CardFields<'_> {
    fn error(&self, field: usize, expected: &str) -> ReadError {
        let found = match self.card.field(field) {
            b"" => format!("{} without one", text(&self.card.name)),
            other => quoted(other),
        };
        let at = self.card.offset(field).min(self.source.text.bytes().len());
        self.source
            .text
            .error(self.source.file, at, found, expected)
    }

    /// An identifier that must be there.
    pub fn required(&self, field: usize, expected: &str) -> Result<u32, ReadError> {
        identifier(self.card.field(field)).ok_or_else(|| self.error(field, expected))
    }

    /// An identifier, unless the field is blank.
    pub fn optional(&self, field: usize) -> Result<Option<u32>, ReadError> {
        match self.card.field(field) {
            b"" => Ok(None),
            _ => self.required(field, "a whole number").map(Some),
        }
    }

    /// A coordinate; blank is 0.
    pub fn real(&self, field: usize) -> Result<f64, ReadError> {
        match self.card.field(field) {
            b"" => Ok(0.0),
            other => real(other).ok_or_else(|| self.error(field, "a real number")),
        }
    }

    /// An element of this shape.
    pub fn element(&self, shape: FiniteShape, place: (u32, u32)) -> Result<BulkElement, ReadError> {
        let id = self.required(1, "the number of an element")?;
        let mut corners = [0; 8];
        for (k, corner) in corners.iter_mut().take(shape.corner_count()).enumerate() {
            *corner = self.required(3 + k, "the number of a grid point")?;
        }
        Ok(BulkElement {
            id,
            shape,
            property: self.optional(2)?.unwrap_or(0),
            corners,
            place,
        })
    }

    /// One of the two systems of a `CORD1` card; its number, the first of the four fields, may be blank.
    pub fn system_of_grids(
        &self,
        first: usize,
        place: (u32, u32),
    ) -> Result<Option<(u32, DefinedSystem)>, ReadError> {
        let Some(id) = self.optional(first)? else {
            return Ok(None);
        };
        let grid = |k: usize| self.required(first + k, "the number of a grid point");
        let points = DefiningPoints::Grids([grid(1)?, grid(2)?, grid(3)?]);
        Ok(Some((id, self.defined(points, place))))
    }

    /// The system of a `CORD2` card.
    pub fn system_of_points(&self, place: (u32, u32)) -> Result<(u32, DefinedSystem), ReadError> {
        let id = self.required(1, "the number of a coordinate system")?;
        let mut points = [[0.0; 3]; 3];
        for (k, coordinate) in points.as_flattened_mut().iter_mut().enumerate() {
            *coordinate = self.real(3 + k)?;
        }
        let points = DefiningPoints::Points(self.optional(2)?.unwrap_or(0), points);
        Ok((id, self.defined(points, place)))
    }

    fn defined(&self, points: DefiningPoints, place: (u32, u32)) -> DefinedSystem {
        let kind = CoordinateKind::of_card(self.card);
        DefinedSystem {
            kind: kind.unwrap_or(CoordinateKind::Rectangular),
            points,
            place,
        }
    }

    /// A surface element; `None` if it is not a polygon.
    pub fn radiating(&self, place: (u32, u32)) -> Result<Option<RadiatingElement>, ReadError> {
        let views = [self.optional(4)?, self.optional(5)?];
        let surface = if &*self.card.name == b"CHBDYE" {
            RadiatingSurface::Side {
                element: self.required(2, "the number of an element")?,
                side: self.required(3, "the number of a side")?,
            }
        } else {
            let count = match self.card.field(3).to_ascii_uppercase().as_slice() {
                b"AREA3" | b"AREA6" => 3,
                b"AREA4" | b"AREA8" => 4,
                _ => return Ok(None),
            };
            let mut corners = [0; 4];
            for (k, corner) in corners.iter_mut().take(count).enumerate() {
                *corner = self.required(9 + k, "the number of a grid point")?;
            }
            RadiatingSurface::Corners(corners, count)
        };
        Ok(Some(RadiatingElement {
            surface,
            views,
            place,
        }))
    }
}
