//! Surface elements for heat transfer: `CHBDYG`, `CHBDYE` and the views and cavities that they belong to.

use super::deck::{BulkDeck, PlacedGrids};
use super::elements::{BulkElement, side};
use crate::Position;
use crate::reading::warnings::Warnings;
use crate::surface::named::NamedSurfaces;
use std::collections::{HashMap, HashSet};

/// A surface element that exchanges radiation.
#[derive(Clone, Copy, Debug)]
pub(super) struct RadiatingElement {
    pub surface: RadiatingSurface,
    /// The views of its front and of its back, 0 for none, if the card states them.
    pub views: [Option<u32>; 2],
    /// File and line.
    pub place: (u32, u32),
}

/// Where a surface element lies.
#[derive(Clone, Copy, Debug)]
pub(super) enum RadiatingSurface {
    /// Between grid points of which the first `usize` count.
    Corners([u32; 4], usize),
    /// On a side of an element.
    Side { element: u32, side: u32 },
}

/// Views, cavities and the elements in them.
#[derive(Debug, Default)]
pub(super) struct RadiationDeck {
    pub elements: Vec<RadiatingElement>,
    /// The cavity of each view.
    pub cavities: HashMap<u32, u32>,
    /// The views of elements that state none, those of `BDYOR`.
    pub default_views: [u32; 2],
    /// The cavities that are analysed, if the file lists them.
    pub analysed: HashSet<u32>,
}

impl RadiationDeck {
    /// The name of the surface that a view stands for; `None` if its cavity is not analysed.
    fn name(&self, view: u32) -> Option<String> {
        match self.cavities.get(&view) {
            _ if view == 0 => Some("no view".to_owned()),
            Some(cavity) if !self.analysed.is_empty() && !self.analysed.contains(cavity) => None,
            Some(cavity) => Some(format!("cavity {cavity}/view {view}")),
            None => Some(format!("view {view}")),
        }
    }

    /// Adds the elements to surfaces by cavity and view: the front with the first view, the back with the
    /// second one. An element without a view is there for what it hides.
    pub fn collect(
        &self,
        deck: &BulkDeck,
        grids: &PlacedGrids,
        surfaces: &mut NamedSurfaces,
        warnings: &mut Warnings,
    ) {
        let by_id: HashMap<u32, &BulkElement> = if self.has_sides() {
            deck.elements.iter().map(|e| (e.id, e)).collect()
        } else {
            HashMap::new()
        };
        let mut numbers: HashMap<u32, Option<usize>> = HashMap::new();
        for element in &self.elements {
            let place = || Position::Line(element.place.1, 1);
            let file = deck.file(element.place);
            let Some(corners) = self.corners(element, &by_id) else {
                let message = "CHBDYE on a side that is not a face of an element: skipped";
                warnings.add(file, message.to_owned(), place);
                continue;
            };
            let Some(mut corners) = grids.of(&corners) else {
                let message = "surface element with a grid point that does not exist: skipped";
                warnings.add(file, message.to_owned(), place);
                continue;
            };
            let view = |side: usize| element.views[side].unwrap_or(self.default_views[side]);
            let (front, back) = (view(0), view(1));
            let sides = [(front, back == 0 || front > 0), (back, back > 0)];
            for (view, is_there) in sides {
                let number = numbers
                    .entry(view)
                    .or_insert_with(|| self.name(view).map(|name| surfaces.number(&name)));
                match (is_there, *number) {
                    (true, Some(number)) => surfaces.push(number, &corners, &grids.positions),
                    (true, None) => {
                        let message =
                            "surface element of a cavity that RADSET does not list: skipped";
                        warnings.add(file, message.to_owned(), place);
                    }
                    (false, _) => {}
                }
                corners.reverse();
            }
        }
    }

    fn has_sides(&self) -> bool {
        let is_side = |e: &RadiatingElement| matches!(e.surface, RadiatingSurface::Side { .. });
        self.elements.iter().any(is_side)
    }

    /// The grid points of an element, counter-clockwise from its front.
    fn corners(
        &self,
        element: &RadiatingElement,
        by_id: &HashMap<u32, &BulkElement>,
    ) -> Option<Vec<u32>> {
        match element.surface {
            RadiatingSurface::Corners(corners, count) => Some(corners[..count].to_vec()),
            RadiatingSurface::Side {
                element,
                side: number,
            } => {
                let element = by_id.get(&element)?;
                let corners = side(element.shape, number)?;
                Some(corners.iter().map(|&k| element.corners[k]).collect())
            }
        }
    }
}
