//! The roughness of highlights, in the parameters of each model.
//!
//! Models are compared by Beckmann's α, √2 times the root mean square slope of the facets. The
//! exponent of a lobe about the half vector is 2/α² − 2; that of a lobe about the mirror direction,
//! which moves twice as far as the half vector, a quarter of it.

use super::catalog::{as_color, set};
use azulejo::scene::brdf::{Model, Value, find};

/// What a number of roughness means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Measure {
    /// α itself.
    Slope,
    /// α/√2, the standard deviation of the slopes.
    Deviation,
    /// 1/α.
    Inverse,
    /// √α.
    Root,
    /// α².
    Square,
    /// The exponent of a cosine to the half vector.
    HalfVector,
    /// The exponent of a cosine to the mirror direction.
    Mirrored,
    /// 1 − 3/n, of such an exponent n.
    Smoothness,
}

/// The parameters of a model's roughness: along the tangent, and along the bitangent if it may
/// differ.
struct Roughness {
    names: [Option<&'static str>; 2],
    measure: Measure,
}

impl Roughness {
    fn of(model: &Model) -> Option<Roughness> {
        let both = |a, b, measure| (Some(a), Some(b), measure);
        let one = |a, measure| (Some(a), None, measure);
        let (first, second, measure) = match find(&model.name).ok()?.name {
            "ggx_smith" | "beckmann_smith" | "ward" | "ward_duer" | "ward_gmd" => {
                both("ax", "ay", Measure::Slope)
            }
            "ggx_ms" => one("ax", Measure::Slope),
            "cook_torrance" => one("m", Measure::Slope),
            "beard_maxwell" => one("sigma", Measure::Deviation),
            "torrance_sparrow_gauss" => one("c", Measure::Inverse),
            "gltf_mr" => one("roughness", Measure::Root),
            "schlick" => one("r", Measure::Square),
            "ashikhmin_shirley" => both("nu", "nv", Measure::HalfVector),
            "blinn" => one("n", Measure::HalfVector),
            "phong" | "lewis" | "lafortune" => one("n", Measure::Mirrored),
            "strauss" => one("smoothness", Measure::Smoothness),
            _ => return None,
        };
        Some(Roughness {
            names: [first, second],
            measure,
        })
    }

    /// α along the tangent and the bitangent.
    fn read(&self, model: &Model) -> Option<[f64; 2]> {
        let value = |name: Option<&str>| {
            let value = as_color(model.value(name?)?).mean();
            Some(self.measure.slope(value))
        };
        let first = value(self.names[0])?;
        Some([first, value(self.names[1]).unwrap_or(first)])
    }

    fn write(&self, model: &mut Model, slopes: [f64; 2]) {
        let Ok(info) = find(&model.name) else {
            return;
        };
        let both = self.names[1].is_some();
        let mean = (slopes[0] * slopes[1]).sqrt();
        let slopes = if both { slopes } else { [mean; 2] };
        for (name, slope) in self.names.iter().zip(slopes) {
            let Some(known) = info.parameters.iter().find(|p| Some(p.name) == *name) else {
                continue;
            };
            // The bitangent's is the tangent's where it is not given.
            let is_same = *name == self.names[1] && !known.is_needed && slopes[0] == slopes[1];
            let number = self.measure.value(slope).clamp(known.least, known.most);
            let number = Value::Number(rounded(number));
            set(model, known, (!is_same).then_some(number));
        }
    }
}

impl Measure {
    fn slope(self, value: f64) -> f64 {
        match self {
            Measure::Slope => value,
            Measure::Deviation => value * 2f64.sqrt(),
            Measure::Inverse => 1.0 / value,
            Measure::Root => value * value,
            Measure::Square => value.sqrt(),
            Measure::HalfVector => (2.0 / (value + 2.0)).sqrt(),
            Measure::Mirrored => Measure::HalfVector.slope(4.0 * value),
            Measure::Smoothness => Measure::Mirrored.slope(3.0 / (1.0 - value)),
        }
    }

    fn value(self, slope: f64) -> f64 {
        match self {
            Measure::Slope => slope,
            Measure::Deviation => slope / 2f64.sqrt(),
            Measure::Inverse => 1.0 / slope,
            Measure::Root => slope.sqrt(),
            Measure::Square => slope * slope,
            Measure::HalfVector => (2.0 / (slope * slope) - 2.0).max(0.0),
            Measure::Mirrored => Measure::HalfVector.value(slope) / 4.0,
            Measure::Smoothness => (1.0 - 3.0 / Measure::Mirrored.value(slope)).max(0.0),
        }
    }
}

/// Six digits, as files have them.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Gives `model` the roughness of `old`. Parameters that are the same in both have been copied.
pub(super) fn copy(old: &Model, model: &mut Model) {
    let (Some(from), Some(to)) = (Roughness::of(old), Roughness::of(model)) else {
        return;
    };
    let is_copied = from.names == to.names
        && to.names.iter().flatten().all(|name| {
            let has = old.value(name);
            has.is_some() && has == model.value(name)
        });
    if let Some(slopes) = from.read(old).filter(|_| !is_copied) {
        to.write(model, slopes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_go_there_and_back() {
        for measure in [
            Measure::Slope,
            Measure::Deviation,
            Measure::Inverse,
            Measure::Root,
            Measure::Square,
            Measure::HalfVector,
            Measure::Mirrored,
            Measure::Smoothness,
        ] {
            for slope in [0.05, 0.2, 0.35] {
                let again = measure.slope(measure.value(slope));
                assert!((again - slope).abs() < 1e-9, "{measure:?} {slope} {again}");
            }
        }
    }
}
