//! Axes along which a model repeats itself: `x,y`, or with lengths `x=96,y=64`.

use azulejo_trace::Tracer;
use glam::DVec3;
use std::str::FromStr;

/// Axes along which a model repeats itself without end, each with the distance from copy to copy if
/// one is given: `x,y` or `x=96,y=64`.
///
/// ```
/// use azulejo::periods::Periods;
///
/// let street: Periods = "x=96,y".parse()?;
/// assert_eq!(street.distances([80.0, 64.0, 20.0])?, [96.0, 64.0, 0.0]);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periods([Option<Period>; 3]);

/// The distance from copy to copy.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Period {
    /// The size of the model.
    Size,
    /// A length in the model's units.
    Length(f64),
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Periods {
    /// The distances for a model of that size along x, y and z; zero along axes without repetition.
    ///
    /// # Errors
    /// A sentence, if the size is to be the distance and is zero.
    pub fn distances(&self, size: [f64; 3]) -> Result<[f64; 3], String> {
        let mut lengths = [0.0; 3];
        for axis in 0..3 {
            lengths[axis] = match self.0[axis] {
                None => 0.0,
                Some(Period::Length(length)) => length,
                Some(Period::Size) if size[axis] > 0.0 => size[axis],
                Some(Period::Size) => {
                    let axis = AXES[axis];
                    return Err(format!(
                        "the model has no size along {axis}; give the distance, as in {axis}=10"
                    ));
                }
            };
        }
        Ok(lengths)
    }

    /// The tracer of a model repeated at these distances.
    ///
    /// # Errors
    /// A sentence, if copies would overlap or lie in one place.
    pub fn repeated(&self, tracer: Tracer) -> Result<Tracer, String> {
        let period = self.distances(tracer.bounds().size().to_array())?;
        let repeated = tracer.repeated(DVec3::from_array(period));
        repeated.map_err(|e| e.to_string())
    }
}

impl FromStr for Periods {
    type Err = String;

    fn from_str(text: &str) -> Result<Periods, String> {
        let mut periods = [None; 3];
        for part in text.split(',') {
            let (axis, period) = match part.split_once('=') {
                None => (part.trim(), Period::Size),
                Some((axis, length)) => (axis.trim(), Period::Length(positive(length.trim())?)),
            };
            let Some(index) = AXES.iter().position(|name| *name == axis) else {
                return Err(format!(
                    "\"{axis}\" is not an axis; expected x, y or z, each with or without a length, as in x,y \
                     or x=96,y=64"
                ));
            };
            if periods[index].replace(period).is_some() {
                return Err(format!("{axis} is there twice"));
            }
        }
        Ok(Periods(periods))
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err(format!("\"{text}\" is not a length above 0")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_with_and_without_lengths() {
        let of = |text: &str| text.parse::<Periods>().unwrap().distances([3.0, 4.0, 0.0]);
        assert_eq!(of("x,y"), Ok([3.0, 4.0, 0.0]));
        assert_eq!(of(" y = 9.5 "), Ok([0.0, 9.5, 0.0]));
        assert_eq!(of("z=1,x"), Ok([3.0, 0.0, 1.0]));
        assert!(of("z").unwrap_err().contains("no size along z"));
    }

    #[test]
    fn what_is_no_axis_or_length_is_refused() {
        for text in [
            "", "q", "x,x", "x=", "x=0", "x=-1", "x=nan", "x=inf", "x,,y", "X",
        ] {
            assert!(text.parse::<Periods>().is_err(), "{text}");
        }
    }
}
