//! The parameters of a model as variables without bounds.

use azulejo_scene::Rgb;
use azulejo_scene::brdf::{Model, ModelInfo, Parameter, ParameterInfo, ParameterKind, Value};

/// Sets of Fresnel parameters that a fit may choose among: only this one is fitted.
const FITTED_FRESNEL: &str = "f0";

/// Ranges whose ends are further apart than this factor are searched by factors.
const WIDE: f64 = 200.0;

/// The widest exponents and slopes worth starting from; the bounds are wider.
const FIRST: [f64; 2] = [1e-3, 1e3];

/// One number that a fit looks for.
#[derive(Clone, Copy)]
pub struct FitVariable {
    /// Whose value, or part of value, it is.
    pub parameter: &'static ParameterInfo,
    /// Which channel of a colour; `None` for all of them.
    pub channel: Option<usize>,
    scale: VariableScale,
}

/// How equal steps of a variable change its value.
#[derive(Clone, Copy, Debug, PartialEq)]
enum VariableScale {
    /// By equal amounts.
    Linear,
    /// By equal factors, above the least value or 1e-3 of what is common.
    Logarithmic { offset: f64 },
}

impl FitVariable {
    fn new(parameter: &'static ParameterInfo, channel: Option<usize>) -> FitVariable {
        let (least, most) = (parameter.least, parameter.most);
        let scale = match parameter.kind {
            ParameterKind::Number if least > 0.0 && most > WIDE * least => {
                VariableScale::Logarithmic { offset: 0.0 }
            }
            ParameterKind::Number if least <= 0.0 && most > WIDE => VariableScale::Logarithmic {
                offset: 1.0 - least,
            },
            _ => VariableScale::Linear,
        };
        FitVariable {
            parameter,
            channel,
            scale,
        }
    }

    fn stretched(&self, value: f64) -> f64 {
        match self.scale {
            VariableScale::Linear => value,
            VariableScale::Logarithmic { offset } => (value + offset).ln(),
        }
    }

    fn value_of(&self, stretched: f64) -> f64 {
        let value = match self.scale {
            VariableScale::Linear => stretched,
            VariableScale::Logarithmic { offset } => stretched.exp() - offset,
        };
        // The map and its inverse may leave the range by a rounding.
        value.clamp(self.parameter.least, self.parameter.most)
    }

    fn ends(&self) -> [f64; 2] {
        [self.parameter.least, self.parameter.most].map(|x| self.stretched(x))
    }

    /// The value of a variable without bounds: between the ends as a sine (MINUIT's way).
    pub fn value(&self, free: f64) -> f64 {
        let [low, high] = self.ends();
        self.value_of(low + (high - low) * 0.5 * (1.0 + free.sin()))
    }

    /// How fast the value changes with the variable.
    pub fn slope(&self, free: f64) -> f64 {
        let step = 1e-6;
        (self.value(free + step) - self.value(free - step)) / (2.0 * step)
    }

    /// Where to start from: a share of the way between the ends of what is common.
    pub fn start(&self, share: f64) -> f64 {
        let [low, high] = self.ends();
        let clamped = |x: f64| x.clamp(self.parameter.least, self.parameter.most);
        let [first, last] = match self.scale {
            VariableScale::Linear => [low, high],
            VariableScale::Logarithmic { .. } => FIRST.map(|x| self.stretched(clamped(x))),
        };
        let share = 0.03 + 0.94 * share;
        let place = (first + (last - first) * share - low) / (high - low);
        (2.0 * place - 1.0).clamp(-1.0, 1.0).asin()
    }

    /// Whether the value is at an end of its range.
    pub fn is_at_end(&self, free: f64) -> bool {
        let [low, high] = self.ends();
        let place = (self.stretched(self.value(free)) - low) / (high - low);
        !(1e-4..=1.0 - 1e-4).contains(&place)
    }

    /// Its name: `kd`, or `kd.r`.
    pub fn name(&self) -> String {
        match self.channel {
            Some(channel) => format!("{}.{}", self.parameter.name, ["r", "g", "b"][channel]),
            None => self.parameter.name.to_owned(),
        }
    }
}

/// All numbers of a model that are not given: one per parameter, three per colour where the data
/// is coloured.
pub fn variables(info: &'static ModelInfo, given: &Model, is_colored: bool) -> Vec<FitVariable> {
    let is_given = |p: &&ParameterInfo| given.value(p.name).is_some();
    let has_fresnel = info.all_parameters().skip(info.parameters.len());
    let has_fresnel = has_fresnel.into_iter().any(|p| is_given(&p));
    let fitted = info.all_parameters().enumerate().filter(|(k, p)| {
        let is_fresnel = *k >= info.parameters.len();
        let is_fitted = p.name == FITTED_FRESNEL && !has_fresnel;
        p.kind != ParameterKind::Word && !is_given(p) && (!is_fresnel || is_fitted)
    });
    let mut variables = Vec::new();
    for (_, parameter) in fitted {
        if is_colored && parameter.kind == ParameterKind::Color {
            variables.extend([0, 1, 2].map(|c| FitVariable::new(parameter, Some(c))));
        } else {
            variables.push(FitVariable::new(parameter, None));
        }
    }
    variables
}

/// The model with values for its variables; colours are multiplied by `dimmed`.
pub fn model(given: &Model, variables: &[FitVariable], free: &[f64], dimmed: f64) -> Model {
    let mut model = given.clone();
    for (variable, &free) in variables.iter().zip(free) {
        let mut value = variable.value(free);
        if variable.parameter.kind == ParameterKind::Color {
            value = (value * dimmed).max(variable.parameter.least);
        }
        let name = variable.parameter.name;
        match variable.channel {
            None => model.parameters.push(parameter(name, Value::Number(value))),
            Some(0) => {
                let color = Rgb::new(value, 0.0, 0.0);
                model.parameters.push(parameter(name, Value::Color(color)));
            }
            Some(channel) => {
                if let Some(Value::Color(color)) = model.parameters.last_mut().map(|p| &mut p.value)
                {
                    color[channel] = value;
                }
            }
        }
    }
    model
}

fn parameter(name: &str, value: Value) -> Parameter {
    Parameter {
        name: name.to_owned(),
        value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::brdf::find;

    #[test]
    fn values_stay_in_their_ranges() {
        let given = Model::new("lewis", []);
        let fit_variables = variables(find("lewis").unwrap(), &given, false);
        let names: Vec<String> = fit_variables.iter().map(FitVariable::name).collect();
        assert_eq!(names, ["kd", "ks", "n"]);
        for variable in fit_variables {
            for free in [-9.0, -1.5, 0.0, 0.7, 1.6, 40.0] {
                let value = variable.value(free);
                let parameter = variable.parameter;
                assert!(
                    (parameter.least..=parameter.most).contains(&value),
                    "{value}"
                );
            }
            let start = variable.value(variable.start(0.5));
            assert!(
                (0.01..1000.0).contains(&start),
                "{} {start}",
                variable.name()
            );
        }
    }

    #[test]
    fn colours_have_three_variables_and_what_is_given_none() {
        let given = Model::new("lewis", [("n", Value::Number(7.0))]);
        let fit_variables = variables(find("lewis").unwrap(), &given, true);
        let names: Vec<String> = fit_variables.iter().map(FitVariable::name).collect();
        assert_eq!(names, ["kd.r", "kd.g", "kd.b", "ks.r", "ks.g", "ks.b"]);
        let model = model(&given, &fit_variables, &[0.0; 6], 0.5);
        assert_eq!(
            model.to_string(),
            "lewis n = 7 kd = (0.25, 0.25, 0.25) ks = (0.25, 0.25, 0.25)"
        );
    }
}
