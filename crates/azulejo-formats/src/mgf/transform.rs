//! Transform options, of `xf` and other entities: a sequence of maps, some of them repeated as
//! arrays.

use super::lines::number;
use glam::{DAffine3, DMat3, DVec3};
use std::fmt::Write;

/// A sequence of maps, applied one after the other.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MgfTransform {
    pieces: Vec<TransformFactor>,
}

/// A map that is applied several times, or in an array 0, 1, 2... times for its instances.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TransformFactor {
    map: DAffine3,
    count: u64,
    is_array: bool,
}

impl TransformFactor {
    const ONCE: TransformFactor = TransformFactor {
        map: DAffine3::IDENTITY,
        count: 1,
        is_array: false,
    };
}

impl MgfTransform {
    /// Parses options, and returns the error of the first invalid one; it and the following ones
    /// have no effect.
    pub fn parse(words: &[&[u8]]) -> (MgfTransform, Option<&'static str>) {
        let mut transform = MgfTransform {
            pieces: vec![TransformFactor::ONCE],
        };
        let mut rest = words;
        while !rest.is_empty() {
            match option(rest) {
                Ok((taken, TransformOption::Map(map))) => {
                    let last = transform.pieces.last_mut();
                    let last = last.expect("there is a piece from the start");
                    last.map = map * last.map;
                    rest = &rest[taken..];
                }
                Ok((taken, TransformOption::Piece(piece))) => {
                    transform.pieces.push(piece);
                    rest = &rest[taken..];
                }
                Err(wrong) => return (transform, Some(wrong)),
            }
        }
        (transform, None)
    }

    /// Whether it is an array, even with one instance only.
    pub fn is_array(&self) -> bool {
        self.pieces.iter().any(|p| p.is_array)
    }

    /// Number of instances; 1 without an array.
    pub fn instances(&self) -> u64 {
        let arrays = self.pieces.iter().filter(|p| p.is_array);
        arrays.fold(1, |product, p| product.saturating_mul(p.count))
    }

    /// The map of an instance, counted from 0; the last array varies fastest.
    pub fn map(&self, instance: u64) -> DAffine3 {
        let (mut whole, mut left) = (DAffine3::IDENTITY, instance);
        for piece in self.pieces.iter().rev() {
            let times = if piece.is_array {
                left % piece.count
            } else {
                piece.count
            };
            if piece.is_array {
                left /= piece.count;
            }
            whole *= power(piece.map, times);
        }
        whole
    }

    /// The name of an instance: `a2.0` for the third of the first array and the first of the
    /// second.
    pub fn name(&self, instance: u64) -> String {
        let (mut places, mut left) = (Vec::new(), instance);
        for piece in self.pieces.iter().rev().filter(|p| p.is_array) {
            places.push(left % piece.count);
            left /= piece.count;
        }
        let mut name = String::from("a");
        for (i, place) in places.iter().rev().enumerate() {
            let dot = if i > 0 { "." } else { "" };
            // Writing to a string cannot fail.
            let _ = write!(name, "{dot}{place}");
        }
        name
    }
}

/// A map applied `times` times.
fn power(map: DAffine3, mut times: u64) -> DAffine3 {
    let (mut result, mut square) = (DAffine3::IDENTITY, map);
    while times > 0 {
        if times & 1 == 1 {
            result = square * result;
        }
        square = square * square;
        times >>= 1;
    }
    result
}

/// A transform option.
enum TransformOption {
    /// A map applied after the previous ones.
    Map(DAffine3),
    /// The start of a repetition.
    Piece(TransformFactor),
}

impl TransformOption {
    fn map(matrix: DMat3) -> TransformOption {
        TransformOption::Map(DAffine3::from_mat3(matrix))
    }

    fn mirror(axis: DVec3) -> TransformOption {
        TransformOption::map(DMat3::from_diagonal(DVec3::ONE - 2.0 * axis))
    }

    /// A scale of the given axes.
    fn scale(axes: DVec3, arguments: &[&[u8]]) -> Result<TransformOption, &'static str> {
        match numbers(arguments)? {
            [0.0] => Err("scale of 0"),
            [f] => Ok(TransformOption::map(DMat3::from_diagonal(
                axes * f + (DVec3::ONE - axes),
            ))),
        }
    }

    /// `-i` or `-a`.
    fn repetition(is_array: bool, arguments: &[&[u8]]) -> Result<TransformOption, &'static str> {
        let [n] = numbers(arguments)?;
        let least = if is_array { 1.0 } else { 0.0 };
        if !(n >= least && n <= 1e15) {
            return Err("repetition that is not a count");
        }
        Ok(TransformOption::Piece(TransformFactor {
            count: n as u64,
            is_array,
            ..TransformFactor::ONCE
        }))
    }
}

/// The numbers at the start of `arguments`.
fn numbers<const N: usize>(arguments: &[&[u8]]) -> Result<[f64; N], &'static str> {
    let words = arguments.first_chunk::<N>();
    let words = words.ok_or("transform option without its numbers")?;
    let mut values = [0.0; N];
    for (value, word) in values.iter_mut().zip(words) {
        *value = number(word).ok_or("transform option without its numbers")?;
    }
    Ok(values)
}

/// The option at the start of `words`, and its number of words.
fn option(words: &[&[u8]]) -> Result<(usize, TransformOption), &'static str> {
    let (option, arguments) = (words[0], &words[1..]);
    let rotation = |about: fn(f64) -> DMat3| -> Result<_, &'static str> {
        let [degrees] = numbers(arguments)?;
        Ok(TransformOption::map(about(degrees.to_radians())))
    };
    Ok(match option {
        b"-t" => {
            let by = DVec3::from_array(numbers(arguments)?);
            (4, TransformOption::Map(DAffine3::from_translation(by)))
        }
        b"-rx" => (2, rotation(DMat3::from_rotation_x)?),
        b"-ry" => (2, rotation(DMat3::from_rotation_y)?),
        b"-rz" => (2, rotation(DMat3::from_rotation_z)?),
        b"-r" => {
            let [x, y, z, degrees] = numbers(arguments)?;
            let axis = DVec3::new(x, y, z).try_normalize();
            let axis = axis.ok_or("rotation about a zero axis")?;
            let turned = DMat3::from_axis_angle(axis, degrees.to_radians());
            (5, TransformOption::map(turned))
        }
        b"-s" => (2, TransformOption::scale(DVec3::ONE, arguments)?),
        b"-sx" => (2, TransformOption::scale(DVec3::X, arguments)?),
        b"-sy" => (2, TransformOption::scale(DVec3::Y, arguments)?),
        b"-sz" => (2, TransformOption::scale(DVec3::Z, arguments)?),
        b"-mx" => (1, TransformOption::mirror(DVec3::X)),
        b"-my" => (1, TransformOption::mirror(DVec3::Y)),
        b"-mz" => (1, TransformOption::mirror(DVec3::Z)),
        b"-i" | b"-a" => (2, TransformOption::repetition(option == b"-a", arguments)?),
        _ => return Err("unknown transform option"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(options: &str) -> (MgfTransform, Option<&'static str>) {
        let words: Vec<&[u8]> = options
            .split_ascii_whitespace()
            .map(str::as_bytes)
            .collect();
        MgfTransform::parse(&words)
    }

    /// Where each instance maps (1, 0, 0).
    fn check(options: &str, expected: &[(&str, [f64; 3])]) {
        let (transform, wrong) = parse(options);
        assert_eq!(wrong, None, "{options}");
        assert_eq!(transform.instances(), expected.len() as u64, "{options}");
        for (i, (name, place)) in (0..).zip(expected) {
            let p = transform.map(i).transform_point3(DVec3::X);
            assert!((p - DVec3::from(*place)).length() < 1e-12, "{options}: {p}");
            if transform.is_array() {
                assert_eq!(transform.name(i), *name);
            }
        }
    }

    #[test]
    fn options_act_in_their_order() {
        check("", &[("", [1.0, 0.0, 0.0])]);
        check("-t 1 2 3 -s 2", &[("", [4.0, 4.0, 6.0])]);
        check("-s -2 -t 1 2 3", &[("", [-1.0, 2.0, 3.0])]);
        check("-rz 90 -rx 90", &[("", [0.0, 0.0, 1.0])]);
        check("-ry 90", &[("", [0.0, 0.0, -1.0])]);
        check("-mx -t 0 1 0 -my", &[("", [-1.0, -1.0, 0.0])]);
        check("-sx 3 -sy 5 -sz 7", &[("", [3.0, 0.0, 0.0])]);
        check("-r 0 0 2 90", &[("", [0.0, 1.0, 0.0])]);
    }

    #[test]
    fn repetitions() {
        check("-i 3 -t 1 0 0", &[("", [4.0, 0.0, 0.0])]);
        check("-i 0 -t 1 0 0 -i 1 -t 0 0 1", &[("", [1.0, 0.0, 1.0])]);
        check(
            "-t 0 0 1 -a 2 -t 1 0 0 -a 2 -t 0 5 0 -i 1 -s 2",
            &[
                ("a0.0", [2.0, 0.0, 2.0]),
                ("a0.1", [2.0, 10.0, 2.0]),
                ("a1.0", [4.0, 0.0, 2.0]),
                ("a1.1", [4.0, 10.0, 2.0]),
            ],
        );
        check(
            "-a 4 -rz 90",
            &[
                ("a0", [1.0, 0.0, 0.0]),
                ("a1", [0.0, 1.0, 0.0]),
                ("a2", [-1.0, 0.0, 0.0]),
                ("a3", [0.0, -1.0, 0.0]),
            ],
        );
        assert_eq!(
            parse(&"-a 100000000 -mx ".repeat(3)).0.instances(),
            u64::MAX
        );
    }

    #[test]
    fn what_is_wrong() {
        let check = |options, expected| {
            let (transform, wrong) = parse(options);
            assert_eq!(wrong, Some(expected), "{options}");
            // The preceding options still apply.
            let x = transform.map(0).transform_point3(DVec3::ZERO).x;
            assert_eq!(x, f64::from(options.starts_with("-t 1")), "{options}");
        };
        check("-t 1 0 0 -q", "unknown transform option");
        check("-t 1 0 0 -t 1 0", "transform option without its numbers");
        check("-rx ninety", "transform option without its numbers");
        check("-s 0", "scale of 0");
        check("-a 0", "repetition that is not a count");
        check("-a -1", "repetition that is not a count");
        check("-i 1e300", "repetition that is not a count");
        check("-r 0 0 0 5", "rotation about a zero axis");
    }
}
