//! Options of readers, and limits on how much a file may expand to.

use crate::ReadError;

/// Options of readers. The default suits scenes that are to be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadOptions {
    /// Which level of detail is read, in formats that have them (OpenFlight, VRML, X3D).
    pub lod: Lod,
    /// Most vertices, corners of faces and nodes that a model may expand to. Instances, arrays
    /// and curves expand a small file, and every instance of a mesh has its own vertices here.
    pub most_elements: u64,
    /// Most bytes that a compressed file may decompress to.
    pub most_unpacked: u64,
}

/// Which level of detail is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lod {
    /// The finest level.
    #[default]
    Finest,
    /// The coarsest level that is not empty.
    Coarsest,
    /// The level that a viewer shows at this distance, in the file's units, >= 0.
    Distance(f64),
    /// All levels together.
    All,
}

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        ReadOptions {
            lod: Lod::Finest,
            most_elements: 1 << 26,
            most_unpacked: 1 << 30,
        }
    }
}

impl ReadOptions {
    /// Limits in proportion to an untrusted file of `length` bytes: what it expands to
    /// takes at most about 64 times its memory.
    pub fn in_proportion(length: usize) -> ReadOptions {
        let length = length as u64;
        ReadOptions {
            // An element takes up to a hundred bytes, and even the smallest files may expand a little.
            most_elements: 64 * length / 100 + 10_000,
            most_unpacked: 64 * length + 10_000,
            ..ReadOptions::default()
        }
    }
}

/// Rejects files whose corners or vertices might not be countable in 32 bits.
pub(crate) fn check_length(bytes: &[u8], file: &str) -> Result<(), ReadError> {
    if bytes.len() <= u32::MAX as usize {
        return Ok(());
    }
    let found = format!("{} bytes", bytes.len());
    Err(ReadError::whole(file, found, "less than 4 GiB"))
}

/// Counts the elements that a file expands to, so that a small file cannot fill memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    most: u64,
    left: u64,
}

impl Budget {
    /// The whole budget that `options` allow.
    pub fn new(options: &ReadOptions) -> Budget {
        Budget {
            most: options.most_elements,
            left: options.most_elements,
        }
    }

    /// Subtracts `elements`, before they are created.
    ///
    /// # Errors
    /// [`Exhausted`] if fewer are left.
    pub fn spend(&mut self, elements: u64) -> Result<(), Exhausted> {
        match self.left.checked_sub(elements) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => {
                self.left = 0;
                Err(Exhausted(self.most))
            }
        }
    }
}

/// The model expands to more elements than the options allow; holds that limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Exhausted(u64);

impl Exhausted {
    /// The error to report for `file`.
    pub fn error(self, file: &str) -> ReadError {
        ReadError::whole(
            file,
            format!(
                "instances, arrays or curves that expand to more than {} vertices and corners",
                self.0
            ),
            "a smaller model, or a higher limit (ReadOptions::most_elements)",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_ends() {
        let mut budget = Budget::new(&ReadOptions {
            most_elements: 10,
            ..ReadOptions::default()
        });
        assert_eq!(budget.spend(7), Ok(()));
        assert_eq!(budget.spend(3), Ok(()));
        assert_eq!(budget.spend(0), Ok(()));
        let error = budget.spend(1).unwrap_err().error("a.mgf").to_string();
        assert!(error.contains("more than 10"), "{error}");
        let mut tiny = Budget::new(&ReadOptions::in_proportion(100));
        assert_eq!(tiny.spend(10_064), Ok(()));
        assert!(tiny.spend(1).is_err());
        assert!(
            Budget::new(&ReadOptions::default())
                .spend(u64::MAX)
                .is_err()
        );
    }
}
