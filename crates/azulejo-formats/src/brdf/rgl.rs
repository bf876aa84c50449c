//! The RGL database's `.bsdf`: tables with a parameterization adapted to the material.
//!
//! J. Dupuy, W. Jakob, *An adaptive parameterization for efficient material acquisition and
//! rendering*, SIGGRAPH Asia 2018.

use super::tensors::{self, Tensor};
use crate::mgf::rgb_weights;
use crate::reading::warnings::Warnings;
use crate::{Position, ReadError, Warning};
use azulejo_scene::brdf::{Grid, Rgl, RglTensors};

/// The tensors of one file, and the collected warnings.
struct RglReader<'a> {
    file: &'a str,
    tensors: Vec<(String, Tensor<'a>)>,
    warnings: Warnings,
}

/// Reads what the model needs of a file; spectra are converted to RGB.
///
/// # Errors
/// [`ReadError`]: a truncated file, tensors that are missing or do not match.
pub fn read(bytes: &[u8], name: &str) -> Result<(Rgl, Vec<Warning>), ReadError> {
    let mut reader = RglReader {
        file: name,
        tensors: tensors::read(bytes, name)?,
        warnings: Warnings::default(),
    };
    let theta_i = reader.list("theta_i")?;
    let phi_i = reader.list("phi_i")?;
    let angles = [phi_i.len(), theta_i.len()];
    let tensors = RglTensors {
        ndf: reader.grid("ndf", &[])?,
        sigma: reader.grid("sigma", &[])?,
        vndf: reader.grid("vndf", &angles)?,
        luminance: reader.grid("luminance", &angles)?,
        rgb: reader.colors(angles)?,
        jacobian: reader.jacobian(),
        theta_i,
        phi_i,
    };
    let rgl = Rgl::new(tensors);
    let rgl = rgl.map_err(|e| ReadError::whole(name, e.to_string(), "a measured BRDF"))?;
    Ok((rgl, reader.warnings.finish(name)))
}

impl<'a> RglReader<'a> {
    fn find(&self, name: &str) -> Option<&Tensor<'a>> {
        let tensor = self.tensors.iter().find(|(known, _)| known == name);
        tensor.map(|(_, tensor)| tensor)
    }

    fn tensor(&self, name: &str) -> Result<&Tensor<'a>, ReadError> {
        self.find(name).ok_or_else(|| {
            let known: Vec<&str> = self.tensors.iter().map(|(name, _)| name.as_str()).collect();
            let found = format!("the tensors {}", known.join(", "));
            ReadError::whole(self.file, found, format!("one named `{name}`, too"))
        })
    }

    /// The numbers of a tensor with a given number of dimensions; non-finite ones, and negative
    /// ones where these are invalid, are taken as 0.
    fn floats(
        &mut self,
        name: &str,
        dimensions: usize,
    ) -> Result<(Vec<usize>, Vec<f32>), ReadError> {
        let tensor = self.tensor(name)?;
        let (shape, offset) = (tensor.shape.clone(), tensor.offset);
        let numbers = tensor.floats();
        // The sizes of an empty tensor are not limited by the file.
        let numbers = numbers.filter(|n| shape.len() == dimensions && !n.is_empty());
        let mut numbers = numbers.ok_or_else(|| {
            let found = format!("`{name}` of {:?} elements {shape:?}", tensor.kind);
            let expected =
                format!("floating-point numbers in {dimensions} dimensions, one or more");
            ReadError::at_byte(self.file, offset, found, expected)
        })?;
        let mut mended = 0;
        for number in &mut numbers {
            let is_good = number.is_finite() && (*number >= 0.0 || dimensions == 1);
            if !is_good {
                (*number, mended) = (0.0, mended + 1);
            }
        }
        let message = format!("negative or non-finite numbers in `{name}`: taken as 0");
        let place = || Position::Byte(offset);
        self.warnings.add_many(self.file, message, mended, place);
        Ok((shape, numbers))
    }

    fn list(&mut self, name: &str) -> Result<Vec<f32>, ReadError> {
        Ok(self.floats(name, 1)?.1)
    }

    /// A table for each index of the `leading` dimensions.
    fn grid(&mut self, name: &str, leading: &[usize]) -> Result<Grid, ReadError> {
        let (shape, values) = self.floats(name, leading.len() + 2)?;
        self.expect(name, &shape, leading)?;
        let [.., height, width] = shape[..] else {
            return Ok(Grid::default());
        };
        Ok(Grid {
            width,
            height,
            values,
        })
    }

    fn expect(&self, name: &str, shape: &[usize], leading: &[usize]) -> Result<(), ReadError> {
        if shape.starts_with(leading) {
            return Ok(());
        }
        let offset = self.find(name).map_or(0, |tensor| tensor.offset);
        Err(ReadError::at_byte(
            self.file,
            offset,
            format!("`{name}` with {shape:?} elements"),
            format!("{leading:?} first, as in other tensors"),
        ))
    }

    /// `rgb`, or `spectra` converted to RGB.
    fn colors(&mut self, [phi, theta]: [usize; 2]) -> Result<Grid, ReadError> {
        if self.find("rgb").is_some() {
            return self.grid("rgb", &[phi, theta, 3]);
        }
        let wavelengths = self.list("wavelengths")?;
        let spectra = self.grid("spectra", &[phi, theta, wavelengths.len()])?;
        let weights = rgb_weights(&wavelengths).ok_or_else(|| {
            let found = format!("{} wavelengths", wavelengths.len());
            ReadError::whole(
                self.file,
                found,
                "at least two in ascending order, some of them visible, in nm",
            )
        })?;
        Ok(seen(&spectra, &weights))
    }

    /// Whether values are relative to the microfacet distribution, as they are by default.
    fn jacobian(&self) -> bool {
        let first = self.find("jacobian").and_then(|t| t.data.first());
        first.is_none_or(|byte| *byte != 0)
    }
}

/// Converts spectra, one table per wavelength, to tables of red, green and blue. Out-of-gamut
/// values are clamped to 0.
fn seen(spectra: &Grid, weights: &[[f64; 3]]) -> Grid {
    let size = spectra.width * spectra.height;
    let mut values = Vec::new();
    for spectrum in spectra.values.chunks_exact((size * weights.len()).max(1)) {
        for channel in 0..3 {
            let mut sum = vec![0.0; size];
            for (table, weight) in spectrum.chunks_exact(size).zip(weights) {
                let table = table.iter().map(|v| f64::from(*v) * weight[channel]);
                sum.iter_mut().zip(table).for_each(|(sum, v)| *sum += v);
            }
            values.extend(sum.iter().map(|v| v.clamp(0.0, f64::from(f32::MAX)) as f32));
        }
    }
    Grid { values, ..*spectra }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use azulejo_scene::Brdf;
    use azulejo_scene::brdf::{Content, Description, Measured};
    use glam::DVec3;
    use std::sync::Arc;

    /// Name, shape, numbers.
    type RglField = (&'static str, Vec<u64>, Vec<f32>);

    /// A diffuse surface with reflectance ½: the microfacet density is that of the visible
    /// directions.
    pub fn fields() -> Vec<RglField> {
        let (n, tables) = (5, 2);
        let ones = |count: u64, value: f32| vec![value; count as usize];
        let grid = |lead: &[u64]| [lead, &[n, n]].concat();
        let count = |lead: &[u64]| grid(lead).iter().product();
        vec![
            ("theta_i", vec![tables], vec![0.0, 1.5]),
            ("phi_i", vec![1], vec![0.0]),
            ("ndf", grid(&[]), ones(count(&[]), 1.0)),
            ("sigma", grid(&[]), ones(count(&[]), 0.25)),
            ("vndf", grid(&[1, tables]), ones(count(&[1, tables]), 1.0)),
            (
                "luminance",
                grid(&[1, tables]),
                ones(count(&[1, tables]), 1.0),
            ),
            ("wavelengths", vec![3], vec![400.0, 550.0, 700.0]),
            (
                "spectra",
                grid(&[1, tables, 3]),
                ones(count(&[1, tables, 3]), 0.125),
            ),
        ]
    }

    pub fn file(fields: &[RglField]) -> Vec<u8> {
        let head: usize = fields
            .iter()
            .map(|(name, shape, _)| 13 + name.len() + 8 * shape.len())
            .sum();
        let (mut bytes, mut data) = (MAGIC_VERSION.to_vec(), Vec::new());
        bytes.extend((fields.len() as u32).to_le_bytes());
        let start = bytes.len() + head;
        for (name, shape, numbers) in fields {
            bytes.extend((name.len() as u16).to_le_bytes());
            bytes.extend(name.as_bytes());
            bytes.extend((shape.len() as u16).to_le_bytes());
            bytes.push(10);
            bytes.extend(((start + data.len()) as u64).to_le_bytes());
            shape.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
            numbers.iter().for_each(|n| data.extend(n.to_le_bytes()));
        }
        bytes.extend(data);
        bytes
    }

    const MAGIC_VERSION: &[u8] = b"tensor_file\0\x01\0";

    fn brdf(bytes: &[u8]) -> Brdf {
        let (rgl, warnings) = read(bytes, "r.bsdf").unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        let content = Content::Measured(Arc::new(Measured::Rgl(Box::new(rgl))));
        let file = Description::File {
            path: "r.bsdf".to_owned(),
            content: Some(Arc::new(content)),
        };
        Brdf::new(file).unwrap()
    }

    /// Constant spectra become grey.
    #[test]
    fn spectra_become_colours() {
        let (wo, wi) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 0.8, 0.6));
        let value = brdf(&file(&fields())).eval(wo, wi);
        // 0.125 × ndf/(4 sigma)/cos θi
        for value in value.to_array() {
            assert!((value - 0.125 / 0.6).abs() < 1e-5, "{value:?}");
        }
    }

    #[test]
    fn colours_are_read_as_they_are() {
        let mut fields = fields();
        fields.truncate(6);
        let rgb = (0..150).map(|k| [0.3, 0.2, 0.1][k / 25 % 3]).collect();
        fields.push(("rgb", vec![1, 2, 3, 5, 5], rgb));
        let value = brdf(&file(&fields)).eval(DVec3::Z, DVec3::Z);
        assert!(
            (value.r - 0.3).abs() < 1e-6 && (value.b - 0.1).abs() < 1e-6,
            "{value:?}"
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let check = |change: &dyn Fn(&mut Vec<RglField>), expected: &str| {
            let mut fields = fields();
            change(&mut fields);
            let error = read(&file(&fields), "r").err().map(|e| e.to_string());
            let error = error.unwrap_or_default();
            assert!(error.contains(expected), "{error}");
        };
        check(&|f| drop(f.remove(3)), "expected one named `sigma`, too");
        check(&|f| f[0].1[0] = 1 << 40, "a tensor `theta_i`");
        check(&|f| f[0].1[0] = u64::MAX, "ends before the file");
        check(&|f| f[0].2[1] = -1.0, "`theta_i` must be angles that rise");
        check(
            &|f| f[4].1 = vec![2, 1, 5, 5],
            "`vndf` with [2, 1, 5, 5] elements, expected [1, 2] first",
        );
        check(&|f| f[6].2[1] = 100.0, "3 wavelengths");
        check(
            &|f| f[2].1 = vec![25, 1],
            "`ndf` must be 1 tables of at least 2 × 2",
        );
    }

    #[test]
    fn every_end_is_found_early() {
        let bytes = file(&fields());
        for length in (0..bytes.len()).step_by(7) {
            assert!(read(&bytes[..length], "r").is_err(), "{length}");
        }
    }

    /// Any corrupted byte leads to an error or a model, but not to a panic.
    #[test]
    fn every_byte_may_be_another() {
        let bytes = file(&fields());
        for k in 0..bytes.len() {
            for byte in [0, 1, 0x7f, 0x80, 0xff] {
                let mut bytes = bytes.clone();
                bytes[k] = byte;
                let _ = read(&bytes, "r");
            }
        }
    }

    #[test]
    fn tensors_without_elements_are_refused() {
        let mut fields = fields();
        fields[1] = ("phi_i", vec![0], Vec::new());
        fields[7] = ("spectra", vec![0, 2, 3, 1 << 40, 1 << 40], Vec::new());
        let error = read(&file(&fields), "r").err().map(|e| e.to_string());
        let error = error.unwrap_or_default();
        assert!(error.contains("`phi_i` of Float elements [0]"), "{error}");
    }

    #[test]
    fn negative_numbers_are_counted() {
        let mut fields = fields();
        (fields[7].2[3], fields[7].2[4]) = (-0.1, f32::NAN);
        let (_, warnings) = read(&file(&fields), "r").unwrap();
        assert_eq!((warnings.len(), warnings[0].count), (1, 2));
    }
}
