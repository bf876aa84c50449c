//! Options of readers, and limits on how much a file may expand to.

use crate::ReadError;
use std::str::FromStr;

/// Options of readers. The default suits scenes that are to be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadOptions {
    /// Which level of detail is read, in formats that have them (OpenFlight, VRML, X3D,
    /// CityJSON).
    pub lod: Lod,
    /// Most vertices, corners of faces and nodes that a model may expand to. Instances, arrays
    /// and curves expand a small file, and every instance of a mesh has its own vertices here.
    pub most_elements: u64,
    /// Most bytes that a compressed file may decompress to.
    pub most_unpacked: u64,
    /// Whether what instances, arrays and curves expand to is kept. If not, the reader only counts it,
    /// and its scene has no objects, or not all.
    pub keeps: bool,
    /// Whether white surfaces whose pictures are missing get a middle reflectance, as they would otherwise
    /// reflect all light. What is only converted stays as it is.
    pub darkens_unpainted: bool,
    /// What the colours of vertices, and of faces of PLY, are in OBJ and PLY; without it they are linear unless
    /// Blender wrote the file, which writes sRGB.
    pub vertex_colors: Option<VertexColors>,
    /// Facets around the axis y for each edge of axisymmetric elements (Abaqus), >= 3; without it they are sheets in their
    /// plane.
    pub sectors: Option<u32>,
    /// The set of lamps of a luminaire in EULUMDAT, from 1; without it the first, with a warning if there are more.
    pub lamp_set: Option<usize>,
    /// The page of a PDF, from 1; without it the first, with a warning if there are more.
    pub page: Option<usize>,
}

/// What the numbers of vertex colours are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexColors {
    /// Shares of light.
    Linear,
    /// Shares as screens show them.
    Srgb,
}

impl FromStr for VertexColors {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<VertexColors, &'static str> {
        match text {
            "linear" => Ok(VertexColors::Linear),
            "srgb" => Ok(VertexColors::Srgb),
            _ => Err("expected linear or srgb"),
        }
    }
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
    /// The level with this number, >= 0, or else the highest one below it: levels have numbers in
    /// CityJSON. Other formats read the finest one.
    Numbered(f64),
}

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        ReadOptions {
            lod: Lod::Finest,
            most_elements: 1 << 26,
            most_unpacked: 1 << 30,
            keeps: true,
            darkens_unpainted: true,
            vertex_colors: None,
            sectors: None,
            lamp_set: None,
            page: None,
        }
    }
}

/// What is said of colours that are sRGB because Blender wrote them.
pub(crate) const BLENDER_COLORS: &str =
    "vertex colour by Blender: taken as sRGB, as it writes them by default, not as linear";

/// Elements that any file may expand to before they are counted: about 70 MB.
const UNCOUNTED: u64 = 1 << 20;

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

/// Runs `read` so that it fails before it takes the memory for more than `options` allow.
///
/// What a file of `length` bytes may contain without instances is read at once. If it expands to more,
/// that is counted first, without keeping it.
///
/// # Errors
/// Those of `read`.
pub(crate) fn counted_first<T>(
    length: usize,
    options: &ReadOptions,
    read: impl Fn(&ReadOptions) -> Result<T, ReadError>,
) -> Result<T, ReadError> {
    let few = ReadOptions {
        most_elements: UNCOUNTED + length as u64,
        ..*options
    };
    if !options.keeps || options.most_elements <= few.most_elements {
        return read(options);
    }
    match read(&few) {
        Err(error) if Exhausted::is_reason_of(&error) => {}
        other => return other,
    }
    let counting = ReadOptions {
        keeps: false,
        ..*options
    };
    drop(read(&counting)?);
    read(options)
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
    keeps: bool,
}

impl Budget {
    /// The whole budget that `options` allow.
    pub fn new(options: &ReadOptions) -> Budget {
        Budget {
            most: options.most_elements,
            left: options.most_elements,
            keeps: options.keeps,
        }
    }

    /// Whether what is counted is also kept.
    pub fn keeps(&self) -> bool {
        self.keeps
    }

    /// What is left of it.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Checks that at least `elements` are left, where it is known that this many will be created.
    ///
    /// # Errors
    /// [`Exhausted`] if fewer are left.
    pub fn check(&self, elements: u64) -> Result<(), Exhausted> {
        if elements > self.left {
            return Err(Exhausted(self.most));
        }
        Ok(())
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
        let found = format!("{EXPANDS} {} vertices and corners", self.0);
        let expected = "a smaller model, or a higher limit (ReadOptions::most_elements)";
        ReadError::whole(file, found, expected)
    }

    /// Whether an error is this one.
    fn is_reason_of(error: &ReadError) -> bool {
        error.found.starts_with(EXPANDS)
    }
}

/// What the error begins with.
const EXPANDS: &str = "instances, arrays or curves that expand to more than";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expansion_is_counted_before_it_is_kept() {
        use std::cell::RefCell;
        let check = |elements: u64, most: u64, expected: &[(u64, bool)]| {
            let runs = RefCell::new(Vec::new());
            let options = ReadOptions {
                most_elements: most,
                ..ReadOptions::default()
            };
            let result = counted_first(1000, &options, |options| {
                runs.borrow_mut()
                    .push((options.most_elements, options.keeps));
                let spent = Budget::new(options).spend(elements);
                spent.map_err(|e| e.error("a.mgf"))
            });
            assert_eq!(result.is_ok(), elements <= most);
            assert_eq!(runs.into_inner(), expected);
        };
        let few = UNCOUNTED + 1000;
        check(few, 1 << 26, &[(few, true)]);
        check(
            few + 1,
            1 << 26,
            &[(few, true), (1 << 26, false), (1 << 26, true)],
        );
        check(1 << 27, 1 << 26, &[(few, true), (1 << 26, false)]);
        check(1 << 27, few, &[(few, true)]);
        // Other errors are reported at once.
        let result = counted_first(0, &ReadOptions::default(), |_| {
            Err::<(), _>(ReadError::whole("a.mgf", "nothing", "something"))
        });
        assert_eq!(&*result.unwrap_err().found, "nothing");
    }

    #[test]
    fn a_budget_ends() {
        let mut budget = Budget::new(&ReadOptions {
            most_elements: 10,
            ..ReadOptions::default()
        });
        assert_eq!(budget.spend(7), Ok(()));
        assert_eq!(budget.check(3), Ok(()));
        assert!(budget.check(4).is_err());
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
