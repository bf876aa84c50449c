//! The parameters of a description, checked against those of its model.

use super::description::{Parameter, Value};
use super::metals::find_metal;
use super::models::{ModelInfo, ParameterInfo, ParameterKind, nearest};
use super::{BrdfError, Fresnel};
use crate::Rgb;

/// Amount by which rounding may take sums of reflectances above 1.
const ROUNDING: f64 = 1e-9;

/// Parameters with known names, values of the right type and in range.
pub(super) struct Arguments<'a> {
    info: &'static ModelInfo,
    given: Vec<(&'static ParameterInfo, &'a Value)>,
}

impl<'a> Arguments<'a> {
    /// Checks the given parameters, and that required ones are given.
    pub fn new(
        info: &'static ModelInfo,
        parameters: &'a [Parameter],
    ) -> Result<Arguments<'a>, BrdfError> {
        let mut given: Vec<(&'static ParameterInfo, &Value)> = Vec::new();
        for Parameter { name, value } in parameters {
            let known = info.all_parameters().find(|p| p.is_called(name));
            let parameter = known.ok_or_else(|| unknown(info, name))?;
            if given.iter().any(|(p, _)| p.name == parameter.name) {
                return Err(BrdfError::Twice {
                    name: parameter.name,
                });
            }
            check(parameter, value)?;
            given.push((parameter, value));
        }
        let is_given = |p: &&ParameterInfo| given.iter().any(|(g, _)| g.name == p.name);
        let needed = |p: &&ParameterInfo| p.is_needed && !is_given(p);
        if let Some(missing) = info.parameters.iter().find(needed) {
            return Err(BrdfError::Missing {
                model: info.name,
                name: missing.name,
            });
        }
        Ok(Arguments { info, given })
    }

    fn value(&self, name: &str) -> Option<&'a Value> {
        let given = self.given.iter().find(|(p, _)| p.name == name);
        given.map(|(_, value)| *value)
    }

    /// Whether it was given.
    pub fn has(&self, name: &str) -> bool {
        self.value(name).is_some()
    }

    /// A colour parameter, as given or by default.
    pub fn color(&self, name: &str) -> Rgb {
        match self.value(name) {
            Some(Value::Number(value)) => Rgb::grey(*value),
            Some(Value::Color(value)) => *value,
            _ => {
                let known = self.info.all_parameters().find(|p| p.name == name);
                Rgb::grey(known.and_then(|p| p.default).unwrap_or(0.0))
            }
        }
    }

    /// A number parameter, as given or by default.
    pub fn number(&self, name: &str) -> f64 {
        self.color(name).r
    }

    /// Rejects two reflectances whose sum exceeds 1.
    pub fn bounded_sum(&self, first: &str, second: &str) -> Result<(), BrdfError> {
        let sum = (self.color(first) + self.color(second)).max_channel();
        if sum <= 1.0 + ROUNDING {
            return Ok(());
        }
        Err(BrdfError::Energy {
            what: format!("{first} + {second} of `{}`", self.info.name),
            sum,
        })
    }

    /// The given Fresnel term; 1 if there is none.
    pub fn fresnel(&self) -> Result<Fresnel, BrdfError> {
        let sets = [
            self.has("eta") || self.has("k"),
            self.has("metal"),
            self.has("f0") || self.has("tint"),
            self.has("F"),
        ];
        if sets.iter().filter(|given| **given).count() > 1 {
            return Err(BrdfError::Other(format!(
                "`{}` takes one Fresnel term: eta and k, or metal, or f0, or F",
                self.info.name
            )));
        }
        match sets {
            [true, ..] => self.indices(),
            [_, true, ..] => self.metal(),
            [_, _, true, _] => Ok(Fresnel::Schlick {
                f0: self.color("f0"),
                tint: self.given_or("tint", Rgb::WHITE),
            }),
            _ => Ok(Fresnel::Constant(self.given_or("F", Rgb::WHITE))),
        }
    }

    fn given_or(&self, name: &str, default: Rgb) -> Rgb {
        if self.has(name) {
            self.color(name)
        } else {
            default
        }
    }

    fn indices(&self) -> Result<Fresnel, BrdfError> {
        if !self.has("eta") {
            return Err(BrdfError::Missing {
                model: self.info.name,
                name: "eta",
            });
        }
        let (eta, k) = (self.color("eta"), self.color("k"));
        if k.is_black() && eta.is_grey() {
            return Ok(Fresnel::Dielectric { eta: eta.r });
        }
        Ok(Fresnel::Conductor { eta, k })
    }

    fn metal(&self) -> Result<Fresnel, BrdfError> {
        match self.value("metal") {
            Some(Value::Word(name)) => Ok(find_metal(name)?.fresnel()),
            _ => Err(BrdfError::WrongKind {
                name: "metal",
                expected: "the name of a metal".to_owned(),
            }),
        }
    }
}

fn unknown(info: &'static ModelInfo, name: &str) -> BrdfError {
    let known: Vec<&'static str> = info.all_parameters().map(|p| p.name).collect();
    let names = info.all_parameters();
    let names = names.flat_map(|p| [p.name].into_iter().chain(p.aliases.iter().copied()));
    BrdfError::UnknownParameter {
        model: info.name,
        name: name.to_owned(),
        nearest: nearest(name, names),
        known,
    }
}

fn check(parameter: &'static ParameterInfo, value: &Value) -> Result<(), BrdfError> {
    let name = parameter.name;
    let expected = |what: &str| BrdfError::WrongKind {
        name,
        expected: what.to_owned(),
    };
    let numbers = match (parameter.kind, value) {
        (ParameterKind::Word, Value::Word(_)) => return Ok(()),
        (ParameterKind::Word, _) => return Err(expected("a word")),
        (_, Value::Number(number)) => [*number; 3],
        (ParameterKind::Color, Value::Color(color)) => color.to_array(),
        (ParameterKind::Color, _) => return Err(expected("a number or (r, g, b)")),
        (ParameterKind::Number, _) => return Err(expected("one number")),
    };
    let (least, most) = (parameter.least, parameter.most);
    // NaN is in no range.
    let outside = numbers.into_iter().find(|n| !(least..=most).contains(n));
    outside.map_or(Ok(()), |value| {
        Err(BrdfError::Range {
            name,
            value,
            least,
            most,
        })
    })
}
