//! What a reader may be told, and how much a file may unfold to.

use crate::ReadError;

/// Choices for readers. The default suits a scene that is to be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadOptions {
    /// Which of several versions of the same thing is taken, in formats that have levels of
    /// detail (OpenFlight, VRML, X3D).
    pub lod: Lod,
    /// Most vertices, corners of faces and nodes that a model may unfold to. Instances, arrays
    /// and curves make much of little, and every placed mesh has its own vertices here.
    pub most_elements: u64,
    /// Most bytes that a compressed file may unpack to.
    pub most_unpacked: u64,
}

/// Which level of detail is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lod {
    /// The finest.
    #[default]
    Finest,
    /// The coarsest that is not empty.
    Coarsest,
    /// What a viewer sees from this distance, in the file's units, >= 0.
    Distance(f64),
    /// All of them, one inside the other.
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
    /// Limits in proportion to a file of `length` bytes that nobody trusts: what it unfolds to
    /// takes at most about 64 times its memory.
    pub fn in_proportion(length: usize) -> ReadOptions {
        let length = length as u64;
        ReadOptions {
            // An element takes up to a hundred bytes, and the smallest files may unfold too.
            most_elements: 64 * length / 100 + 10_000,
            most_unpacked: 64 * length + 10_000,
            ..ReadOptions::default()
        }
    }
}

/// Refuses files in which corners or vertices could not be counted in 32 bits.
pub(crate) fn check_length(bytes: &[u8], file: &str) -> Result<(), ReadError> {
    if bytes.len() <= u32::MAX as usize {
        return Ok(());
    }
    let found = format!("{} bytes", bytes.len());
    Err(ReadError::whole(file, found, "less than 4 GiB"))
}

/// Counts what a file unfolds to, so that a small file cannot fill memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    most: u64,
    left: u64,
}

impl Budget {
    /// All that `options` allow.
    pub fn new(options: &ReadOptions) -> Budget {
        Budget {
            most: options.most_elements,
            left: options.most_elements,
        }
    }

    /// Takes `elements` away, before they are made.
    ///
    /// # Errors
    /// [`Exhausted`] when there are not so many left.
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

/// The model unfolds to more than the options allow; holds how much that is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Exhausted(u64);

impl Exhausted {
    /// The error for a person.
    pub fn error(self, file: &str) -> ReadError {
        ReadError::whole(
            file,
            format!(
                "instances, arrays or curves that unfold to more than {} vertices and corners",
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
