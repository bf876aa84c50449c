//! Arguments of `brdf`.

use azulejo_scene::brdf::MODELS;
use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Args, Subcommand, ValueHint};
use std::ffi::OsStr;
use std::path::PathBuf;

/// `brdf`
#[derive(Debug, Subcommand)]
pub enum BrdfCommand {
    /// List the models, or the parameters of one
    #[command(after_help = LIST_EXAMPLES)]
    List(ListArgs),
    /// Evaluate a model for pairs of directions
    #[command(after_help = EVAL_EXAMPLES)]
    Eval(EvalArgs),
    /// Plot a model: lobes, albedo, and a rendered sphere
    #[command(after_help = PLOT_EXAMPLES)]
    Plot(PlotArgs),
    /// Test reciprocity, energy conservation and sampling of a model
    #[command(after_help = CHECK_EXAMPLES)]
    Check(CheckArgs),
    /// Fit a model to measured data, or to another model
    #[command(after_help = FIT_EXAMPLES)]
    Fit(FitArgs),
}

/// A model with its parameters.
#[derive(Clone, Debug, Args)]
pub struct ModelArgs {
    /// Name of a model (`azulejo brdf list`), `combination`, or a file: a description, MERL
    /// .binary, RGL .bsdf
    #[arg(value_name = "MODEL", value_parser = ModelName, hide_possible_values = true)]
    pub model: String,
    /// Parameters: numbers, or colours as in ks=0.9,0.6,0.3. For a combination: weight=0.7 MODEL
    /// key=value ... weight=0.3 MODEL key=value ...
    #[arg(value_name = "KEY=VALUE")]
    pub parameters: Vec<String>,
}

/// Parser of the name of a model or a file: accepts any text; shells complete names of models.
#[derive(Clone, Copy, Debug)]
pub struct ModelName;

impl TypedValueParser for ModelName {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        clap::builder::StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |name| PossibleValue::new(name);
        let names = MODELS.iter().map(|m| m.name).chain(["combination"]);
        Some(Box::new(names.map(value)))
    }
}

/// `brdf list`
#[derive(Debug, Args)]
pub struct ListArgs {
    /// Show this model with all its parameters
    #[arg(value_name = "MODEL", value_parser = ModelName, hide_possible_values = true)]
    pub model: Option<String>,
}

/// A direction in spherical coordinates, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionAngles {
    /// Polar angle to the normal, 0..=90.
    pub theta: f64,
    /// Azimuth, from the tangent towards the bitangent.
    pub phi: f64,
}

impl std::str::FromStr for DirectionAngles {
    type Err = String;

    /// `60,180` or `60`.
    fn from_str(text: &str) -> Result<DirectionAngles, String> {
        let (theta, phi) = text.split_once(',').unwrap_or((text, "0"));
        let number = |text: &str| match text.trim().parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(format!("\"{text}\" is not a number of degrees")),
        };
        let (theta, phi) = (number(theta)?, number(phi)?);
        if (0.0..=90.0).contains(&theta) {
            Ok(DirectionAngles { theta, phi })
        } else {
            Err(format!(
                "{theta} degrees to the normal, expected 0 to 90: THETA,PHI as in 30,180"
            ))
        }
    }
}

/// `brdf eval`
#[derive(Debug, Args)]
pub struct EvalArgs {
    #[command(flatten)]
    pub model: ModelArgs,
    /// Direction to the light: polar angle to the normal and azimuth from the tangent, in degrees;
    /// can be repeated
    #[arg(
        long = "i",
        value_name = "THETA,PHI",
        required = true,
        allow_hyphen_values = true
    )]
    pub wi: Vec<DirectionAngles>,
    /// Direction to the viewer, likewise; as many as --i, or one for all
    #[arg(
        long = "o",
        value_name = "THETA,PHI",
        required = true,
        allow_hyphen_values = true
    )]
    pub wo: Vec<DirectionAngles>,
}

/// `brdf plot`
#[derive(Debug, Args)]
pub struct PlotArgs {
    #[command(flatten)]
    pub model: ModelArgs,
    /// Output file: .svg or .png; `-` writes SVG to standard output
    #[arg(long, short, value_name = "IMAGE", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Another model to compare with: "MODEL key=value ..."
    #[arg(long, value_name = "MODEL")]
    pub compare: Option<String>,
    /// Angles of incidence of the lobes, in degrees
    #[arg(long, value_name = "DEGREES", value_delimiter = ',', default_value = "0,30,60,80",
          value_parser = incidence)]
    pub angles: Vec<f64>,
    /// Azimuth of the plane of incidence, in degrees from the tangent
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true,
          value_parser = crate::values::number)]
    pub phi: f64,
    /// Width of a PNG in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 960,
          value_parser = clap::value_parser!(u32).range(240..=7680))]
    pub width: u32,
}

/// An angle of incidence: 0 to 89 degrees.
fn incidence(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if (0.0..=89.0).contains(&x) => Ok(x),
        _ => Err("expected degrees from 0 to 89".into()),
    }
}

/// `brdf check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    #[command(flatten)]
    pub model: ModelArgs,
    /// Samples per angle
    #[arg(long, value_name = "N", default_value_t = 100_000,
          value_parser = clap::value_parser!(u32).range(1000..=100_000_000))]
    pub samples: u32,
}

/// `brdf fit`
#[derive(Debug, Args)]
pub struct FitArgs {
    #[command(flatten)]
    pub target: ModelArgs,
    /// The model to fit, with parameters that are held fixed: ward_gmd, or "ward_gmd kd=0"
    #[arg(id = "fitted", long = "model", value_name = "MODEL", value_parser = ModelName, hide_possible_values = true)]
    pub model: String,
    /// Output file for the description of the fitted model (.brdf); `-` is standard output
    #[arg(long, short, value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    /// Number of starting points; the best result is kept
    #[arg(long, value_name = "N", default_value_t = 12,
          value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub starts: u32,
    /// Largest polar angle of directions that are fitted, in degrees; measurements near grazing
    /// angles are unreliable
    #[arg(long, value_name = "DEGREES", default_value_t = 80.0, value_parser = crate::values::degrees)]
    pub most_angle: f64,
}

pub const BRDF_EXAMPLES: &str = "\
Examples:
  azulejo brdf list ward_gmd
  azulejo brdf eval cook_torrance m=0.3 F=1 --i 30,0 --o 40,170
  azulejo brdf plot ward_gmd kd=0.1 ks=0.6 ax=0.1 ay=0.3 -o ward.svg
  azulejo brdf check lewis kd=0.3 ks=0.4 n=10
  azulejo brdf fit gold.binary --model ggx_smith -o gold.brdf";

const LIST_EXAMPLES: &str = "\
Examples:
  azulejo brdf list
  azulejo brdf list ward_gmd";

const EVAL_EXAMPLES: &str = "\
Examples:
  azulejo brdf eval cook_torrance m=0.3 F=1 --i 30,0 --o 40,170
  azulejo brdf eval gold.binary --i 30 --o 0 --o 30,180 --o 60,180
  azulejo brdf eval combination weight=0.5 diffuse kd=0.8 weight=0.5 lewis n=40 --i 30 --o 30,180

Prints f_r in 1/sr for each pair of directions, or for perfect mirrors the reflectance at the
angle of --i. --quiet prints the numbers only.";

const PLOT_EXAMPLES: &str = "\
Examples:
  azulejo brdf plot ward_gmd kd=0.1 ks=0.6 ax=0.1 ay=0.3 -o ward.svg
  azulejo brdf plot gold.binary -o gold.png --compare \"ggx_smith metal=gold ax=0.1 ay=0.1\"";

const CHECK_EXAMPLES: &str = "\
Examples:
  azulejo brdf check lewis kd=0.3 ks=0.4 n=10
  azulejo brdf check gold.binary --json

Exit codes: 0 the model has all properties that it claims, 1 it does not, 2 usage error.";

const FIT_EXAMPLES: &str = "\
Examples:
  azulejo brdf fit gold.binary --model ggx_smith -o gold.brdf
  azulejo brdf fit plastic.binary --model \"ward_gmd ax=0.1 ay=0.1\" --starts 30
  azulejo brdf fit cook_torrance m=0.3 F=1 --model ward_gmd";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_angles() {
        let check = |text: &str, theta: f64, phi: f64| {
            assert_eq!(text.parse(), Ok(DirectionAngles { theta, phi }), "{text}");
        };
        check("30,170", 30.0, 170.0);
        check("90", 90.0, 0.0);
        check("0, -45.5", 0.0, -45.5);
        for bad in ["", "x", "91", "-1,0", "30,", "NaN", "1,2,3"] {
            assert!(bad.parse::<DirectionAngles>().is_err(), "{bad}");
        }
    }
}
