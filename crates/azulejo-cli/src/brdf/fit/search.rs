//! Minimization of the error from several starting points, by Levenberg and Marquardt's method.

use super::measured::FitSample;
use super::variables::{self, FitVariable};
use azulejo_scene::Brdf;
use azulejo_scene::brdf::{BrdfError, Description, Model, Value};
use azulejo_trace::{Cancelled, Progress};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use rayon::prelude::*;

/// Number of samples for the first minimization from all starting points.
const FEW: usize = 500;

/// Number of results from which minimization continues with all samples.
const KEPT: usize = 3;

/// Step of the finite differences, in dimensionless variables.
const STEP: f64 = 1e-5;

/// Limit of evaluations of all residuals per starting point and variable.
const PATIENCE: usize = 40;

/// A fit to be made.
pub struct FitProblem<'a> {
    /// The model with its fixed parameters.
    pub given: Model,
    /// The free parameters.
    pub variables: Vec<FitVariable>,
    /// The data.
    pub entries: &'a [FitSample],
    /// Whether the channels of the data differ.
    pub is_colored: bool,
}

/// A fit.
pub struct FitResult {
    /// The fitted model.
    pub brdf: Brdf,
    /// Value and standard error of each variable, and whether it is at a limit of its range.
    pub values: Vec<(f64, f64, bool)>,
    /// Number of starting points that reached the same error within 1%.
    pub agreeing: usize,
}

/// Why a fit failed.
#[derive(Debug)]
pub enum FitError {
    /// It was cancelled.
    Cancelled,
    /// The model is invalid at all starting points.
    Problem(BrdfError),
}

impl From<Cancelled> for FitError {
    fn from(_: Cancelled) -> FitError {
        FitError::Cancelled
    }
}

/// The point where a minimization ended, and the sum of squares there.
type End = (DVector<f64>, f64);

/// Fits from `starts` starting points.
pub fn search(
    question: &FitProblem,
    starts: usize,
    progress: &Progress,
) -> Result<FitResult, FitError> {
    let every = question.entries.len().div_ceil(FEW).max(1);
    let few: Vec<FitSample> = question.entries.iter().copied().step_by(every).collect();
    let last = starts.min(KEPT);
    progress.begin("fit", (starts + last) as u64);
    let mut ends = minimize_from(question, &few, starting_points(question, starts), progress)?;
    if ends.is_empty() {
        return Err(FitError::Problem(refused(question)));
    }
    ends.truncate(KEPT);
    let kept = ends.into_iter().map(|(place, _)| place).collect();
    let ends = minimize_from(question, question.entries, kept, progress)?;
    let Some((best, least)) = ends.first() else {
        return Err(FitError::Problem(refused(question)));
    };
    let agreeing = ends
        .iter()
        .filter(|(_, e)| *e <= 1.02 * least + 1e-12)
        .count();
    answer(question, best, agreeing, progress)
}

/// Evenly spread starting points: a Kronecker sequence with the steps of Roberts.
fn starting_points(question: &FitProblem, count: usize) -> Vec<DVector<f64>> {
    let variables = &question.variables;
    let root = (0..30).fold(1.5f64, |x, _| {
        (1.0 + x).powf(1.0 / (variables.len() + 1) as f64)
    });
    let place = |k: usize| {
        let at = variables.iter().enumerate().map(|(d, variable)| {
            // The channels of a colour start together.
            let d = d - variable.channel.unwrap_or(0);
            let step = root.powi(-(d as i32 + 1));
            variable.start((0.5 + k as f64 * step).fract())
        });
        DVector::from_iterator(variables.len(), at)
    };
    (0..count).map(place).collect()
}

/// Minimizes from each point; the results, best first.
fn minimize_from(
    question: &FitProblem,
    entries: &[FitSample],
    places: Vec<DVector<f64>>,
    progress: &Progress,
) -> Result<Vec<End>, FitError> {
    let one = |place: DVector<f64>| {
        let residuals = FitResiduals {
            question,
            entries,
            place,
            progress,
        };
        let method = LevenbergMarquardt::new().with_patience(PATIENCE);
        let (end, _) = method.with_ftol(1e-12).with_xtol(1e-10).minimize(residuals);
        progress.advance(1)?;
        let error = end.residuals().map(|r| r.norm_squared());
        Ok(error.filter(|e| e.is_finite()).map(|e| (end.place, e)))
    };
    let ends: Result<Vec<Option<End>>, Cancelled> = places.into_par_iter().map(one).collect();
    let mut ends: Vec<End> = ends?.into_iter().flatten().collect();
    ends.sort_by(|a, b| a.1.total_cmp(&b.1));
    Ok(ends)
}

fn answer(
    question: &FitProblem,
    place: &DVector<f64>,
    agreeing: usize,
    progress: &Progress,
) -> Result<FitResult, FitError> {
    let brdf = question.brdf(place).map_err(FitError::Problem)?.0;
    let brdf = rounded(&brdf).unwrap_or(brdf);
    let residuals = FitResiduals {
        question,
        entries: question.entries,
        place: place.clone(),
        progress,
    };
    let errors = residuals.standard_errors();
    let value = |(k, variable): (usize, &FitVariable)| {
        let free = place[k];
        let error = errors.as_ref().map_or(f64::NAN, |e| e[k]);
        let spread = error * variable.slope(free).abs();
        (variable.value(free), spread, variable.is_at_end(free))
    };
    Ok(FitResult {
        brdf,
        values: question.variables.iter().enumerate().map(value).collect(),
        agreeing,
    })
}

/// The model with its numbers rounded to seven digits, if that is valid.
fn rounded(brdf: &Brdf) -> Option<Brdf> {
    let Description::Model(mut model) = brdf.description().clone() else {
        return None;
    };
    for parameter in &mut model.parameters {
        match &mut parameter.value {
            Value::Number(number) => *number = seven_digits(*number),
            Value::Color(color) => *color = color.map(seven_digits),
            Value::Word(_) => {}
        }
    }
    Brdf::new(Description::Model(model)).ok()
}

fn seven_digits(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// The problem in the middle of all ranges.
fn refused(question: &FitProblem) -> BrdfError {
    let middle = DVector::zeros(question.variables.len());
    match question.brdf(&middle) {
        Err(problem) => problem,
        Ok(_) => BrdfError::Other("the fit failed from all starting points".to_owned()),
    }
}

impl FitProblem<'_> {
    /// The model at a point, and the excess of its albedo over 1, for which its colours have been
    /// scaled down.
    fn brdf(&self, place: &DVector<f64>) -> Result<(Brdf, f64), BrdfError> {
        let (mut dimmed, mut excess) = (1.0, 0.0);
        for _ in 0..8 {
            let free = place.as_slice();
            let model = variables::model(&self.given, &self.variables, free, dimmed);
            match Brdf::new(Description::Model(model)) {
                Err(BrdfError::Energy { sum, .. }) if sum > 1.0 => {
                    excess += sum - 1.0;
                    dimmed /= sum * (1.0 + 1e-12);
                }
                made => return made.map(|brdf| (brdf, excess)),
            }
        }
        Err(BrdfError::Other(
            "the fixed parameters reflect more light than arrives".to_owned(),
        ))
    }
}

/// The differences between a model and the data.
struct FitResiduals<'a> {
    question: &'a FitProblem<'a>,
    entries: &'a [FitSample],
    place: DVector<f64>,
    progress: &'a Progress,
}

impl FitResiduals<'_> {
    /// The differences at a point, followed by the excess of the albedo; `None` where the model is
    /// invalid, or if the work was cancelled.
    fn at(&self, place: &DVector<f64>) -> Option<DVector<f64>> {
        self.progress.advance(0).ok()?;
        let (brdf, excess) = self.question.brdf(place).ok()?;
        let channels = if self.question.is_colored { 3 } else { 1 };
        let mut residuals = Vec::with_capacity(channels * self.entries.len() + 1);
        for entry in self.entries {
            let value = brdf.eval(entry.wo, entry.wi);
            let off = entry.compressed(value) - entry.compressed(entry.value);
            residuals.extend(&off.to_array()[..channels]);
        }
        // Weighted like the data, so that scaling colours down is penalized.
        residuals.push(excess * (self.entries.len() as f64).sqrt());
        Some(DVector::from_vec(residuals))
    }

    /// Heteroscedasticity-consistent standard errors of the variables (White, Econometrica 48,
    /// 1980).
    fn standard_errors(&self) -> Option<Vec<f64>> {
        let residuals = self.residuals()?;
        let jacobian = self.jacobian()?;
        let inverse = (jacobian.transpose() * &jacobian).pseudo_inverse(1e-14);
        let inverse = inverse.ok()?;
        let mut scattered = jacobian;
        for (mut row, residual) in scattered.row_iter_mut().zip(residuals.iter()) {
            row *= *residual;
        }
        let spare = residuals.len().saturating_sub(self.place.len()).max(1);
        let scale = residuals.len() as f64 / spare as f64;
        let covariance = &inverse * (scattered.transpose() * scattered) * &inverse * scale;
        let error = |k: usize| covariance[(k, k)].max(0.0).sqrt();
        Some((0..self.place.len()).map(error).collect())
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for FitResiduals<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, place: &DVector<f64>) {
        self.place.copy_from(place);
    }

    fn params(&self) -> DVector<f64> {
        self.place.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.at(&self.place)
    }

    /// By central differences.
    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let column = |k: usize| {
            let beside = |step: f64| {
                let mut place = self.place.clone();
                place[k] += step;
                self.at(&place)
            };
            Some((beside(STEP)? - beside(-STEP)?) / (2.0 * STEP))
        };
        let columns: Option<Vec<_>> = (0..self.place.len()).map(column).collect();
        Some(DMatrix::from_columns(&columns?))
    }
}

#[cfg(test)]
mod tests {
    use super::super::measured::{entries, errors};
    use super::*;
    use azulejo_scene::brdf::find;
    use azulejo_trace::sampling::uniform;

    fn brdf(text: &str) -> Brdf {
        Brdf::new(text.parse().unwrap()).unwrap()
    }

    fn fit(name: &str, entries: &[FitSample], is_colored: bool) -> (FitResult, Vec<FitVariable>) {
        let info = find(name).unwrap();
        let given = Model::new(info.name, []);
        let question = FitProblem {
            variables: variables::variables(info, &given, is_colored),
            given,
            entries,
            is_colored,
        };
        let answer = search(&question, 8, &Progress::new());
        (
            answer.unwrap_or_else(|e| panic!("{name}: {e:?}")),
            question.variables,
        )
    }

    #[test]
    fn a_model_is_found_again() {
        let check = |name: &str, text: &str, expected: &[f64]| {
            let (answer, _) = fit(name, &entries(&brdf(text), 1.4), text.contains('('));
            for ((value, ..), expected) in answer.values.iter().zip(expected) {
                assert!(
                    (value - expected).abs() < 0.01 * expected.max(0.01),
                    "{text}: {value}"
                );
            }
        };
        check("lewis", "lewis kd = 0.2 ks = 0.5 n = 40", &[0.2, 0.5, 40.0]);
        check(
            "lewis",
            "lewis kd = (0.5, 0.3, 0.1) ks = 0.3 n = 9",
            &[0.5, 0.3, 0.1, 0.3, 0.3, 0.3, 9.0],
        );
        check("diffuse", "diffuse kd = 0.37", &[0.37]);
    }

    #[test]
    fn noise_is_in_the_standard_errors() {
        let model = brdf("lewis kd = 0.2 ks = 0.5 n = 40");
        let mut data = entries(&model, 1.4);
        for (k, entry) in data.iter_mut().enumerate() {
            let random = (0..12)
                .map(|d| f64::from(uniform(&[k as u32, d])))
                .sum::<f64>()
                - 6.0;
            entry.value *= 1.0 + 0.1 * random;
        }
        let (answer, _) = fit("lewis", &data, false);
        for ((value, error, _), expected) in answer.values.iter().zip([0.2, 0.5, 40.0]) {
            assert!((value - expected).abs() < 4.0 * error, "{value} ± {error}");
            assert!(
                (1e-4..0.03).contains(&(error / expected)),
                "{value} ± {error}"
            );
        }
        let off = errors(&data, &answer.brdf).relative;
        assert!((0.07..0.13).contains(&off), "{off}");
    }

    #[test]
    fn too_much_light_is_not_an_answer() {
        // All directions alike and a mirror's share: together at the most that can be.
        let (answer, _) = fit(
            "lewis",
            &entries(&brdf("lewis kd = 0.5 ks = 0.5 n = 5"), 1.4),
            false,
        );
        let sum = answer.values[0].0 + answer.values[1].0;
        assert!((sum - 1.0).abs() < 0.01, "{sum}");
    }
}
