//! MERL's `.binary`: three sizes, and one number per bin and channel.
//!
//! W. Matusik, H. Pfister, M. Brand, L. McMillan, *A data-driven reflectance model*, SIGGRAPH 2003.

use crate::reading::bytes::Bytes;
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError, Warning};
use azulejo_scene::brdf::Merl;

/// Length of the three sizes in bytes.
const HEADER: usize = 12;

/// The scale factors of the channels.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// Whether bytes begin like such a file: with three small numbers, as no text does.
pub(super) fn is_merl(bytes: &[u8]) -> bool {
    let sizes = bytes.first_chunk::<HEADER>();
    sizes.is_some_and(|s| s.chunks_exact(4).all(|n| n[0] > 0 && n[1..] == [0; 3]))
}

/// Reads a table with the database's sizes.
///
/// # Errors
/// [`ReadError`]: other sizes, or fewer numbers than they require.
pub fn read(bytes: &[u8], name: &str) -> Result<(Merl, Vec<Warning>), ReadError> {
    read_sized(bytes, name, Merl::SIZES)
}

/// Reads a table with given sizes; files only have those of the database.
///
/// # Errors
/// As [`read`].
#[doc(hidden)]
pub fn read_sized(
    bytes: &[u8],
    name: &str,
    sizes: [usize; 3],
) -> Result<(Merl, Vec<Warning>), ReadError> {
    check_sizes(bytes, name, sizes)?;
    let count: usize = sizes.iter().product();
    let expected = HEADER + count * 3 * size_of::<f64>();
    if bytes.len() < expected {
        return Err(ReadError::at_byte(
            name,
            bytes.len() as u64,
            "the end of the file",
            format!("{expected} bytes in all, for {count} numbers of three channels"),
        ));
    }
    let (values, missing) = values(&bytes[HEADER..expected], count);
    let mut warnings = Warnings::default();
    let message = "negative numbers, which mark missing data: taken as 0".to_owned();
    if let Some(first) = missing.first {
        let place = || Position::Byte((HEADER + first * size_of::<f64>()) as u64);
        warnings.add_many(name, message, missing.count, place);
    }
    let rest = bytes.len() - expected;
    if rest > 0 {
        let message = format!("{rest} bytes after the table: skipped");
        warnings.add(name, message, || Position::Byte(expected as u64));
    }
    let merl = Merl::new(sizes, values).ok_or_else(|| {
        ReadError::whole(
            name,
            "an invalid table",
            "at least two bins in each dimension",
        )
    })?;
    Ok((merl, warnings.finish(name)))
}

fn check_sizes(bytes: &[u8], name: &str, sizes: [usize; 3]) -> Result<(), ReadError> {
    let mut header = Bytes::new(bytes);
    for (size, what) in sizes.into_iter().zip(["θ_h", "θ_d", "φ_d"]) {
        let place = header.offset();
        let expected = || format!("{size}, the bins of {what}");
        match header.u32_le() {
            Some(bins) if bins as usize == size => {}
            Some(bins) => {
                let found = bins.cast_signed().to_string();
                return Err(ReadError::at_byte(name, place, found, expected()));
            }
            None => {
                let found = "the end of the file";
                return Err(ReadError::at_byte(name, place, found, expected()));
            }
        }
    }
    Ok(())
}

/// The samples without data.
#[derive(Default)]
struct MissingSamples {
    count: usize,
    /// Index of the first one.
    first: Option<usize>,
}

/// Reorders values from channel by channel to entry by entry; non-finite numbers count as missing
/// data, too.
fn values(bytes: &[u8], count: usize) -> (Vec<[f32; 3]>, MissingSamples) {
    let mut values = vec![[0.0; 3]; count];
    let mut missing = MissingSamples::default();
    for (k, number) in bytes.chunks_exact(size_of::<f64>()).enumerate() {
        let channel = k / count;
        let number = number.try_into().map_or(f64::NAN, f64::from_le_bytes);
        let value = (number * SCALES[channel]) as f32;
        if value >= 0.0 && value.is_finite() {
            values[k % count][channel] = value;
        } else {
            missing.count += 1;
            missing.first.get_or_insert(k);
        }
    }
    (values, missing)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use azulejo_scene::Brdf;
    use azulejo_scene::brdf::HalfAngles;

    const SMALL: [usize; 3] = [6, 5, 8];

    /// A file with the values of a model.
    pub fn file(sizes: [usize; 3], model: &str) -> Vec<u8> {
        let model = Brdf::new(model.parse().unwrap()).unwrap();
        let table = Merl::tabulated(sizes, |wo, wi| model.eval(wo, wi)).unwrap();
        let mut bytes: Vec<u8> = sizes
            .iter()
            .flat_map(|n| (*n as u32).to_le_bytes())
            .collect();
        for (channel, scale) in SCALES.into_iter().enumerate() {
            for (_, value) in table.entries() {
                bytes.extend((value[channel] / scale).to_le_bytes());
            }
        }
        bytes
    }

    fn small() -> Vec<u8> {
        file(SMALL, "diffuse kd = (0.9, 0.5, 0.1)")
    }

    #[test]
    fn channels_are_scaled() {
        let (merl, warnings) = read_sized(&small(), "m.binary", SMALL).unwrap();
        let angles = HalfAngles {
            theta_h: 0.2,
            theta_d: 0.3,
            phi_d: 1.0,
        };
        let reflectance = merl.at(&angles) * std::f64::consts::PI;
        for (reflectance, expected) in reflectance.to_array().into_iter().zip([0.9, 0.5, 0.1]) {
            assert!((reflectance - expected).abs() < 1e-6, "{reflectance}");
        }
        assert!(warnings.is_empty());
    }

    #[test]
    fn no_data_is_counted() {
        let mut bytes = small();
        for at in [HEADER + 80, HEADER + 160] {
            bytes[at..at + 8].copy_from_slice(&(-1.0f64).to_le_bytes());
        }
        bytes.extend([0; 5]);
        let (_, warnings) = read_sized(&bytes, "m.binary", SMALL).unwrap();
        let told: Vec<String> = warnings.iter().map(Warning::to_string).collect();
        assert_eq!(
            told,
            [
                "m.binary: byte 92 (0x5c): negative numbers, which mark missing data: taken as 0 \
                 (2 times)",
                "m.binary: byte 5772 (0x168c): 5 bytes after the table: skipped"
            ]
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let check = |bytes: &[u8], expected: &str| {
            let error = read_sized(bytes, "m", SMALL).err().map(|e| e.to_string());
            assert_eq!(error.as_deref(), Some(expected));
        };
        let mut bytes = small();
        check(
            &bytes[..1000],
            "m: byte 1000 (0x3e8): found the end of the file, expected 5772 bytes in all, for 240 \
             numbers of three channels",
        );
        check(
            &bytes[..7],
            "m: byte 4 (0x4): found the end of the file, expected 5, the bins of θ_d",
        );
        bytes[4..8].copy_from_slice(&(-2i32).to_le_bytes());
        check(
            &bytes,
            "m: byte 4 (0x4): found -2, expected 5, the bins of θ_d",
        );
    }
}
