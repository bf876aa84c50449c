//! What irradiance at points is computed from: all light at each of them, or direct light, with the indirect light of
//! some.

use crate::interpolation::Stencil;
use crate::records::RecordCells;
use crate::strata::Strata;
use azulejo_scene::Rgb;
use azulejo_trace::{Gathered, SplitIrradiance};

/// Cost of the rays of a point at which direct light alone is gathered, relative to others.
const DIRECT_COST: f64 = 0.2;

/// What is gathered at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum PointKind {
    /// All its light.
    Record,
    /// Direct light.
    Interpolated,
}

impl PointKind {
    /// Cost of a ray.
    pub fn cost(self) -> f64 {
        match self {
            PointKind::Record => 1.0,
            PointKind::Interpolated => DIRECT_COST,
        }
    }
}

/// What irradiance at points is computed from.
#[derive(Clone, Debug)]
pub(crate) struct GatheredValues {
    /// Irradiance of each point; direct light if the rest is interpolated.
    own: Vec<Gathered>,
    interpolated: Option<InterpolatedValues>,
}

/// Indirect light at records, and how that of all points follows from it.
#[derive(Clone, Debug)]
struct InterpolatedValues {
    /// Which record each point is.
    record_of: Vec<Option<u32>>,
    stencils: Vec<Stencil>,
    /// Per record: indirect irradiance, and the sum over all points of its squared weights by their areas relative to
    /// the mean.
    indirect: Vec<Gathered>,
    influence: Vec<f64>,
}

impl GatheredValues {
    /// All light is gathered at every point.
    pub fn everywhere(count: usize) -> GatheredValues {
        GatheredValues {
            own: vec![Gathered::default(); count],
            interpolated: None,
        }
    }

    /// All light is gathered at every point, with indirect light apart.
    pub fn apart(strata: &Strata) -> GatheredValues {
        let all = 0..strata.shares().len() as u32;
        let alone = all.clone().map(Stencil::alone).collect();
        GatheredValues::at_records(all.map(Some).collect(), alone, strata)
    }

    /// Indirect light of each point; nothing where it is not kept apart.
    pub fn indirect(&self) -> Vec<Gathered> {
        let Some(between) = &self.interpolated else {
            return vec![Gathered::default(); self.own.len()];
        };
        let all = between.stencils.iter();
        all.map(|stencil| stencil.apply(&between.indirect))
            .collect()
    }

    /// Direct light of each point, where the rest is kept apart.
    pub fn direct(&self) -> &[Gathered] {
        match &self.interpolated {
            Some(_) => &self.own,
            None => &[],
        }
    }

    /// Indirect light of each record, where it is kept apart.
    pub fn indirect_of_records(&self) -> &[Gathered] {
        match &self.interpolated {
            Some(between) => &between.indirect,
            None => &[],
        }
    }

    /// Indirect light is gathered where there is a record.
    pub fn at_records(
        record_of: Vec<Option<u32>>,
        stencils: Vec<Stencil>,
        strata: &Strata,
    ) -> GatheredValues {
        let count = record_of.iter().flatten().count();
        let mut influence = vec![0.0; count];
        for (point, stencil) in stencils.iter().enumerate() {
            for (record, weight) in stencil.weights() {
                influence[record] += strata.weight(point) * weight * weight;
            }
        }
        GatheredValues {
            own: vec![Gathered::default(); record_of.len()],
            interpolated: Some(InterpolatedValues {
                record_of,
                stencils,
                indirect: vec![Gathered::default(); count],
                influence,
            }),
        }
    }

    /// All light of each cell's record, for all of its points; `found` is in the order of the cells.
    pub fn of_cells(
        cells: &RecordCells,
        strata: &Strata,
        found: &[SplitIrradiance],
    ) -> GatheredValues {
        let points = strata.shares().len();
        let mut record_of = vec![None; points];
        let mut stencils = vec![Stencil::default(); points];
        let mut own = vec![Gathered::default(); points];
        for (number, (record, inside)) in cells.records().zip(cells.points()).enumerate() {
            record_of[record as usize] = Some(number as u32);
            for &point in inside {
                own[point as usize] = found[number].direct;
                stencils[point as usize] = Stencil::alone(number as u32);
            }
        }
        let mut values = GatheredValues::at_records(record_of, stencils, strata);
        values.own = own;
        if let Some(between) = &mut values.interpolated {
            between.indirect = found.iter().map(|f| f.indirect).collect();
        }
        values
    }

    /// Blends in what was gathered at a point, with a weight in 0..=1.
    pub fn add(&mut self, point: usize, new: &SplitIrradiance, share: f64) {
        let own = &mut self.own[point];
        let Some(between) = &mut self.interpolated else {
            *own = own.blend(&new.whole(), share);
            return;
        };
        *own = own.blend(&new.direct, share);
        if let Some(record) = between.record_of[point] {
            let indirect = &mut between.indirect[record as usize];
            *indirect = indirect.blend(&new.indirect, share);
        }
    }

    /// Irradiance of all points.
    pub fn combined(&self) -> Vec<Gathered> {
        let Some(between) = &self.interpolated else {
            return self.own.clone();
        };
        let all = self.own.iter().zip(&between.stencils);
        all.map(|(direct, stencil)| direct.plus(&stencil.apply(&between.indirect)))
            .collect()
    }

    /// Number of points at which all light is gathered.
    pub fn records(&self) -> usize {
        match &self.interpolated {
            Some(between) => between.indirect.len(),
            None => self.own.len(),
        }
    }

    /// What is gathered at a point.
    pub fn kind(&self, point: usize) -> PointKind {
        match &self.interpolated {
            Some(between) if between.record_of[point].is_none() => PointKind::Interpolated,
            _ => PointKind::Record,
        }
    }

    /// The variance that the rays of a point cause, summed over all points by their weights, per channel; `weight` is
    /// that of the point.
    pub fn variance(&self, point: usize, weight: f64) -> Rgb {
        let own = self.own[point].variance() * weight;
        let Some(between) = &self.interpolated else {
            return own;
        };
        match between.record_of[point] {
            Some(r) => {
                let r = r as usize;
                own + between.indirect[r].variance() * between.influence[r]
            }
            None => own,
        }
    }

    /// The mean of a property over the points of each kind.
    pub fn mean_by_kind(&self, points: &[u32], of: &impl Fn(usize) -> f64) -> [f64; 2] {
        let mut sums = [(0.0, 0.0); 2];
        for &i in points {
            let sum = &mut sums[self.kind(i as usize) as usize];
            *sum = (sum.0 + of(i as usize), sum.1 + 1.0);
        }
        sums.map(|(sum, count)| sum / f64::max(count, 1.0))
    }
}
