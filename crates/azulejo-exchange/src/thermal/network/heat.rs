//! Temperatures and heat fluxes.

use super::reflections::Reflections;
use super::{ExchangeError, STEFAN_BOLTZMANN, SurfaceBand, newton};
use crate::enclosure::Groups;
use crate::thermal::bands::SpectralRange;
use azulejo_factors::FormFactors;
use azulejo_trace::Progress;

/// What is known of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RowCondition {
    /// Its temperature, K.
    Temperature(f64),
    /// The net heat that leaves it by radiation, solar light included, W/m²; 0 for an adiabatic
    /// (reradiating) row.
    Flux(f64),
}

/// Surfaces, and what is known of them.
#[derive(Clone, Debug)]
pub struct HeatProblem<'a> {
    /// The bands; all have the same rows. Without [`SpectralRange::Solar`], solar light has no effect.
    pub bands: &'a [SurfaceBand<'a>],
    /// What is known of each row.
    pub conditions: &'a [RowCondition],
    /// Temperatures of sky and ground, black, K.
    pub surroundings: [f64; 2],
    /// Solar irradiation of each row from outside, W/m², by way of mirrors too; empty without sun.
    pub solar: &'a [f64],
}

/// Temperatures and fluxes of all rows, and of nodes with their standard errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatBalance {
    /// Temperature of each row, K.
    pub temperatures: Vec<f64>,
    /// Net heat that leaves each row by radiation, W/m²: what it emits less what it absorbs, solar
    /// light included.
    pub fluxes: Vec<f64>,
    /// Diffuse radiosity J of each row in all bands but the solar one, W/m².
    pub radiosities: Vec<f64>,
    /// Irradiation H of each row in all bands but the solar one, W/m².
    pub irradiations: Vec<f64>,
    /// Solar light that each row absorbs, W/m².
    pub solar: Vec<f64>,
    /// Net heat that sky and ground receive from surfaces, W, without solar light.
    pub to_surroundings: [f64; 2],
    /// Temperature of each node, K: of the mean of σT⁴ by area.
    pub node_temperatures: Vec<f64>,
    /// Standard errors of these, from those of the factors; NaN for more nodes than are worth it.
    pub node_temperature_errors: Vec<f64>,
    /// Net heat that leaves each node, W.
    pub node_heat: Vec<f64>,
    /// Standard errors of these, likewise.
    pub node_heat_errors: Vec<f64>,
    /// Steps of Newton's method; 0 where the problem is linear.
    pub iterations: usize,
}

/// One band, solved.
pub(super) struct SolvedBand {
    pub radiosity: Vec<f64>,
    pub irradiation: Vec<f64>,
}

/// Share of a row's light from which it sees an opening.
const OPEN: f64 = 1e-6;

/// Products of nodes and pairs up to which nodes get standard errors.
const WORTH: u64 = 20_000_000_000;

/// Solves for temperatures where fluxes are given, and for fluxes where temperatures are.
///
/// One grey band is a linear problem in σT⁴; several with given fluxes take Newton's method.
/// Standard errors are of first order, as if factors of pairs were independent; in several bands
/// they are added up, and what follows from changed temperatures of rows with given fluxes is left out.
///
/// # Errors
/// [`ExchangeError`].
///
/// # Panics
/// If there is no band but a solar one, or not one condition and one group for each row.
pub fn heat_balance(
    problem: &HeatProblem,
    nodes: &Groups,
    progress: &Progress,
) -> Result<HeatBalance, ExchangeError> {
    let n = problem.conditions.len();
    assert!(
        problem.thermal().next().is_some(),
        "a band in which surfaces emit"
    );
    assert!(
        problem.bands.iter().all(|b| b.enclosure.len() == n),
        "one condition for each row"
    );
    // Rows that exchange heat only with one another, by given fluxes, could have any temperature.
    problem.check()?;
    progress.begin("heat balance", 0);
    // What a row has to lose by emission is its flux and the sunlight that it absorbs.
    let solar = problem.absorbed_solar(progress)?;
    let target = |i: usize| match problem.conditions[i] {
        RowCondition::Temperature(_) => 0.0,
        RowCondition::Flux(q) => q + solar[i],
    };
    let targets: Vec<f64> = (0..n).map(target).collect();
    let thermal: Vec<&SurfaceBand> = problem.thermal().collect();
    let has_fluxes = problem.has_fluxes();
    // Solve the cheapest problem: a linear one, or one for each band, or Newton's method for all of them.
    let (temperatures, bands, iterations) = match thermal[..] {
        [band] if band.range == SpectralRange::Thermal => {
            let (temperatures, solved) = problem.grey(band, &targets, progress)?;
            (temperatures, vec![solved], 0)
        }
        _ if !has_fluxes => {
            let temperatures = problem.given_temperatures(0.0);
            let solve = |band: &&SurfaceBand| problem.band(band, &temperatures, progress);
            let solved = thermal.iter().map(solve).collect::<Result<_, _>>()?;
            (temperatures, solved, 0)
        }
        _ => newton::temperatures(problem, &thermal, &targets, progress)?,
    };
    let mut balance = HeatBalance {
        temperatures,
        solar,
        iterations,
        ..HeatBalance::default()
    };
    // Derive fluxes, nodes and errors from the solved bands.
    balance.add_rows(problem, &thermal, &bands);
    balance.check(problem)?;
    balance.add_nodes(problem, nodes);
    balance.add_errors(problem, nodes, &thermal, &bands, progress)?;
    Ok(balance)
}

impl<'a> HeatProblem<'a> {
    pub(super) fn factors(&self) -> &'a FormFactors {
        &self.bands[0].enclosure.factors
    }

    fn thermal(&self) -> impl Iterator<Item = &'a SurfaceBand<'a>> {
        let is_thermal = |b: &&SurfaceBand| b.range != SpectralRange::Solar;
        self.bands.iter().filter(is_thermal)
    }

    fn has_fluxes(&self) -> bool {
        let mut conditions = self.conditions.iter();
        conditions.any(|c| matches!(c, RowCondition::Flux(_)))
    }

    /// The given temperatures, and `other` where fluxes are given.
    pub(super) fn given_temperatures(&self, other: f64) -> Vec<f64> {
        let given = |c: &RowCondition| match c {
            RowCondition::Temperature(t) => *t,
            RowCondition::Flux(_) => other,
        };
        self.conditions.iter().map(given).collect()
    }

    pub(super) fn name(&self, row: usize) -> String {
        self.bands[0].enclosure.rows.names[row].clone()
    }

    /// Refuses rows whose temperature could be any.
    fn check(&self) -> Result<(), ExchangeError> {
        let factors = self.factors();
        let groups = self.bands[0].enclosure.operator().connected();
        let mut anchored = vec![false; factors.len()];
        let mut members = vec![0; factors.len()];
        for (i, &root) in groups.iter().enumerate() {
            let root = root as usize;
            members[root] += 1;
            anchored[root] |= matches!(self.conditions[i], RowCondition::Temperature(_))
                || factors.rest[i].escaped() > OPEN;
        }
        let floating = (0..factors.len()).find(|&i| {
            let root = groups[i] as usize;
            members[root] > 1 && !anchored[root]
        });
        match floating {
            None => Ok(()),
            Some(i) => Err(ExchangeError::Floating {
                row: self.name(i),
                rows: members[groups[i] as usize],
            }),
        }
    }

    /// Solar light that rows absorb, after all reflections.
    fn absorbed_solar(&self, progress: &Progress) -> Result<Vec<f64>, ExchangeError> {
        let n = self.conditions.len();
        let mut absorbed = vec![0.0; n];
        let bands = self
            .bands
            .iter()
            .filter(|b| b.range == SpectralRange::Solar);
        for band in bands.filter(|_| !self.solar.is_empty()) {
            let diffuse = band.diffuse();
            let source = (0..n).map(|i| diffuse[i] * self.solar[i]).collect();
            let solved = solve(band, &diffuse, source, self.solar, progress)?;
            let rows = band.emissivity.iter().zip(&solved.irradiation);
            for (absorbed, (emissivity, h)) in absorbed.iter_mut().zip(rows) {
                *absorbed += emissivity * h;
            }
        }
        Ok(absorbed)
    }

    /// H₀ of each row in a band: from sky and ground.
    pub(super) fn surroundings_light(&self, band: &SurfaceBand) -> Vec<f64> {
        let [sky, ground] = self.surroundings.map(|t| band.range.emission(t));
        let rest = band.enclosure.factors.rest.iter();
        rest.map(|r| r.sky * sky + r.ground * ground).collect()
    }

    /// One band in which all temperatures are known.
    pub(super) fn band(
        &self,
        band: &SurfaceBand,
        temperatures: &[f64],
        progress: &Progress,
    ) -> Result<SolvedBand, ExchangeError> {
        let (diffuse, outside) = (band.diffuse(), self.surroundings_light(band));
        let source = |i: usize| {
            band.emissivity[i] * band.range.emission(temperatures[i]) + diffuse[i] * outside[i]
        };
        let source = (0..temperatures.len()).map(source).collect();
        solve(band, &diffuse, source, &outside, progress)
    }

    /// All of a grey problem, in which rows with given fluxes reflect all but their mirror's share.
    pub(super) fn grey(
        &self,
        band: &SurfaceBand,
        targets: &[f64],
        progress: &Progress,
    ) -> Result<(Vec<f64>, SolvedBand), ExchangeError> {
        let outside = self.surroundings_light(band);
        let shares = self.reflected(band);
        let source = |i: usize| match self.conditions[i] {
            RowCondition::Temperature(t) => {
                band.emissivity[i] * STEFAN_BOLTZMANN * t.powi(4) + shares[i] * outside[i]
            }
            RowCondition::Flux(_) => targets[i] + shares[i] * outside[i],
        };
        let source = (0..targets.len()).map(source).collect();
        let solved = solve(band, &shares, source, &outside, progress)?;
        let temperature = |i: usize| match self.conditions[i] {
            RowCondition::Temperature(t) => Ok(t),
            RowCondition::Flux(_) => {
                let emissivity = band.emissivity[i];
                if targets[i] != 0.0 && emissivity == 0.0 {
                    return Err(ExchangeError::NeitherEmitsNorAbsorbs { row: self.name(i) });
                }
                let given = if emissivity > 0.0 {
                    targets[i] / emissivity
                } else {
                    0.0
                };
                let emission = solved.irradiation[i] + given;
                // Rounding may leave a little less than nothing.
                if emission < -1e-9 * given.abs() {
                    return Err(ExchangeError::BelowZero { row: self.name(i) });
                }
                Ok((emission.max(0.0) / STEFAN_BOLTZMANN).powf(0.25))
            }
        };
        let temperatures = (0..targets.len()).map(temperature);
        Ok((temperatures.collect::<Result<_, _>>()?, solved))
    }

    /// c of each row: ρ_d, or 1 − ρ_s where the flux is given.
    fn reflected(&self, band: &SurfaceBand) -> Vec<f64> {
        let mut shares = band.diffuse();
        for ((share, condition), ends) in shares
            .iter_mut()
            .zip(self.conditions)
            .zip(&band.enclosure.factors.ends)
        {
            if matches!(condition, RowCondition::Flux(_)) {
                *share = *ends;
            }
        }
        shares
    }
}

/// J and H of one band: J = source + c F^s J, H = F^s J + outside.
fn solve(
    band: &SurfaceBand,
    c: &[f64],
    source: Vec<f64>,
    outside: &[f64],
    progress: &Progress,
) -> Result<SolvedBand, ExchangeError> {
    let reflections = Reflections::new(band.enclosure, c, progress)?;
    let radiosity = reflections.solve(&[source], progress)?;
    let arriving = reflections.arriving(&radiosity);
    let rows = arriving[0]
        .iter()
        .zip(&band.enclosure.factors.areas)
        .zip(outside);
    let irradiation = |((s, &area), outside): ((&f64, &f64), &f64)| {
        if area > 0.0 {
            s / area + outside
        } else {
            *outside
        }
    };
    Ok(SolvedBand {
        irradiation: rows.map(irradiation).collect(),
        radiosity: radiosity.into_iter().next().unwrap_or_default(),
    })
}

impl HeatBalance {
    /// Fluxes, radiosities and irradiations of rows, and what leaves the scene.
    fn add_rows(&mut self, problem: &HeatProblem, thermal: &[&SurfaceBand], solved: &[SolvedBand]) {
        let n = self.temperatures.len();
        self.radiosities = vec![0.0; n];
        self.irradiations = vec![0.0; n];
        self.fluxes = self.solar.iter().map(|s| -s).collect();
        for (band, solved) in thermal.iter().zip(solved) {
            let factors = &band.enclosure.factors;
            let unit = band.enclosure.metres_per_unit().powi(2);
            let black = problem.surroundings.map(|t| band.range.emission(t));
            for i in 0..n {
                let (j, h) = (solved.radiosity[i], solved.irradiation[i]);
                self.radiosities[i] += j;
                self.irradiations[i] += h;
                self.fluxes[i] +=
                    band.emissivity[i] * (band.range.emission(self.temperatures[i]) - h);
                let (rest, area) = (&factors.rest[i], unit * factors.areas[i]);
                for (k, share) in [rest.sky, rest.ground].into_iter().enumerate() {
                    self.to_surroundings[k] += area * share * (j - factors.ends[i] * black[k]);
                }
            }
        }
        for (flux, condition) in self.fluxes.iter_mut().zip(problem.conditions) {
            if let RowCondition::Flux(q) = condition {
                *flux = *q;
            }
        }
    }

    fn check(&self, problem: &HeatProblem) -> Result<(), ExchangeError> {
        let is_finite = |i: &usize| {
            let HeatBalance {
                temperatures,
                fluxes,
                radiosities,
                ..
            } = self;
            [temperatures, fluxes, radiosities]
                .iter()
                .all(|of| of[*i].is_finite())
        };
        match (0..self.temperatures.len()).find(|i| !is_finite(i)) {
            None => Ok(()),
            Some(i) => Err(ExchangeError::TooHot {
                row: problem.name(i),
            }),
        }
    }

    fn add_nodes(&mut self, problem: &HeatProblem, nodes: &Groups) {
        let enclosure = problem.bands[0].enclosure;
        let unit = enclosure.metres_per_unit().powi(2);
        let count = nodes.names.len();
        let (mut heat, mut emission, mut areas) =
            (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        for (i, node) in nodes.of_rows.iter().enumerate() {
            if let Some(node) = node {
                let (node, area) = (*node as usize, unit * enclosure.factors.areas[i]);
                heat[node] += area * self.fluxes[i];
                emission[node] += area * self.temperatures[i].powi(4);
                areas[node] += area;
            }
        }
        let temperature = |(e, a): (&f64, &f64)| {
            if *a > 0.0 { (e / a).powf(0.25) } else { 0.0 }
        };
        self.node_temperatures = emission.iter().zip(&areas).map(temperature).collect();
        self.node_heat = heat;
    }

    /// Standard errors of nodes. The change of Σ A_i w_i H_i with the factors is Σ_ij r_i dS_ij J_j +
    /// Σ_i r_i A_i dX_is E_s, where r solves the same system with the source w.
    fn add_errors(
        &mut self,
        problem: &HeatProblem,
        nodes: &Groups,
        thermal: &[&SurfaceBand],
        solved: &[SolvedBand],
        progress: &Progress,
    ) -> Result<(), ExchangeError> {
        let count = nodes.names.len();
        let pairs = problem.bands[0].enclosure.operator().numbers();
        if pairs.saturating_mul(count as u64) > WORTH {
            self.node_heat_errors = vec![f64::NAN; count];
            self.node_temperature_errors = vec![f64::NAN; count];
            return Ok(());
        }
        let enclosure = problem.bands[0].enclosure;
        let unit = enclosure.metres_per_unit().powi(2);
        self.node_heat_errors = vec![0.0; count];
        let mut emission_errors = vec![0.0; count];
        for (band, solved) in thermal.iter().zip(solved) {
            let reflections = Reflections::new(band.enclosure, &problem.reflected(band), progress)?;
            let adjoint = Adjoint {
                problem,
                nodes,
                band,
                solved,
                reflections,
            };
            let heat = adjoint.errors(false, progress)?;
            let emission = adjoint.errors(true, progress)?;
            for a in 0..count {
                self.node_heat_errors[a] += unit * heat[a];
                emission_errors[a] += emission[a];
            }
        }
        let temperature = |(error, t): (&f64, &f64)| {
            let slope = 4.0 * STEFAN_BOLTZMANN * t.powi(3);
            if *error == 0.0 { 0.0 } else { error / slope }
        };
        let errors = emission_errors.iter().zip(&self.node_temperatures);
        self.node_temperature_errors = errors.map(temperature).collect();
        Ok(())
    }
}

/// What standard errors of nodes need.
struct Adjoint<'a> {
    problem: &'a HeatProblem<'a>,
    nodes: &'a Groups,
    band: &'a SurfaceBand<'a>,
    solved: &'a SolvedBand,
    reflections: Reflections<'a>,
}

impl Adjoint<'_> {
    /// For each node the error of the heat that its rows of given temperature absorb (per square
    /// scene unit), or of the mean emission of its rows of given fluxes.
    fn errors(&self, is_emission: bool, progress: &Progress) -> Result<Vec<f64>, ExchangeError> {
        let factors = &self.band.enclosure.factors;
        let matrix = self.band.enclosure.operator();
        let sources: Vec<Vec<f64>> = (0..self.nodes.names.len())
            .map(|a| self.source(a, is_emission))
            .collect();
        let solutions = self.reflections.solve(&sources, progress)?;
        let black = self
            .problem
            .surroundings
            .map(|t| self.band.range.emission(t));
        let error = |r: &Vec<f64>| {
            let openings: f64 = (0..factors.len())
                .map(|i| {
                    let rest = &factors.rest[i];
                    let scale = factors.areas[i] * r[i];
                    let [sky, ground] = [rest.sky_error * black[0], rest.ground_error * black[1]];
                    (scale * sky).powi(2) + (scale * ground).powi(2)
                })
                .filter(|v| v.is_finite())
                .sum();
            let pairs = matrix.variance_between(r, &self.solved.radiosity);
            (pairs + openings).sqrt()
        };
        Ok(solutions.iter().map(error).collect())
    }

    fn source(&self, node: usize, is_emission: bool) -> Vec<f64> {
        let areas = &self.band.enclosure.factors.areas;
        let is_in = |i: usize| {
            let has_flux = matches!(self.problem.conditions[i], RowCondition::Flux(_));
            self.nodes.of_rows[i] == Some(node as u32) && has_flux == is_emission
        };
        let members: Vec<usize> = (0..areas.len()).filter(|&i| is_in(i)).collect();
        let whole: f64 = (0..areas.len())
            .filter(|&i| self.nodes.of_rows[i] == Some(node as u32))
            .map(|i| areas[i])
            .sum();
        let mut source = vec![0.0; areas.len()];
        for i in members {
            source[i] = if is_emission {
                whole.max(f64::MIN_POSITIVE).recip()
            } else {
                self.band.emissivity[i]
            };
        }
        source
    }
}
