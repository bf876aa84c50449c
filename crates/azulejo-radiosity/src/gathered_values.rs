//! What irradiance at points is computed from: all light at each of them, both kinds of light apart, or direct light alone.

use crate::records::RecordCells;
use azulejo_scene::Rgb;
use azulejo_trace::{Gathered, SplitIrradiance};

/// What is gathered at the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum GatherKind {
    /// All light.
    All,
    /// Direct light.
    Direct,
}

/// What irradiance at points is computed from.
#[derive(Clone, Debug)]
pub(crate) struct GatheredValues {
    pub kind: GatherKind,
    /// Irradiance of each point; direct light where the rest is apart or left out.
    own: Vec<Gathered>,
    /// Indirect light of each point; empty where it is not kept apart.
    indirect: Vec<Gathered>,
}

impl GatheredValues {
    /// All light is gathered at every point.
    pub fn everywhere(count: usize) -> GatheredValues {
        GatheredValues {
            kind: GatherKind::All,
            own: vec![Gathered::default(); count],
            indirect: Vec::new(),
        }
    }

    /// All light is gathered at every point, with indirect light apart.
    pub fn apart(count: usize) -> GatheredValues {
        GatheredValues {
            indirect: vec![Gathered::default(); count],
            ..GatheredValues::everywhere(count)
        }
    }

    /// Direct light alone is gathered, at every point.
    pub fn direct_only(count: usize) -> GatheredValues {
        GatheredValues {
            kind: GatherKind::Direct,
            ..GatheredValues::everywhere(count)
        }
    }

    /// The light of each cell's record, for all of its points; `found` is in the order of the cells.
    pub fn of_cells(
        cells: &RecordCells,
        count: usize,
        found: &[SplitIrradiance],
    ) -> GatheredValues {
        let mut values = GatheredValues::everywhere(count);
        for (of_cell, inside) in found.iter().zip(cells.points()) {
            for &point in inside {
                values.own[point as usize] = of_cell.whole();
            }
        }
        values
    }

    /// Indirect light of each point; empty where it is not kept apart.
    pub fn indirect(&self) -> &[Gathered] {
        &self.indirect
    }

    /// Direct light of each point, where the rest is kept apart.
    pub fn direct(&self) -> &[Gathered] {
        &self.own
    }

    /// Blends in what was gathered at a point, with a weight in 0..=1.
    pub fn add(&mut self, point: usize, new: &SplitIrradiance, share: f64) {
        let own = &mut self.own[point];
        match self.indirect.get_mut(point) {
            Some(indirect) => {
                *own = own.blend(&new.direct, share);
                *indirect = indirect.blend(&new.indirect, share);
            }
            None => *own = own.blend(&new.whole(), share),
        }
    }

    /// Irradiance of all points.
    pub fn combined(&self) -> Vec<Gathered> {
        if self.indirect.is_empty() {
            return self.own.clone();
        }
        let both = self.own.iter().zip(&self.indirect);
        both.map(|(direct, indirect)| direct.plus(indirect))
            .collect()
    }

    /// The variance of the light of a point, per channel: of both kinds as if they were independent, where they are
    /// apart.
    pub fn variance(&self, point: usize) -> Rgb {
        let own = self.own[point].variance();
        match self.indirect.get(point) {
            Some(indirect) => own + indirect.variance(),
            None => own,
        }
    }
}
