//! The things that a machine may lack.

use std::collections::BTreeSet;
use std::fmt;

/// Something that a test needs and that a machine may lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Need {
    /// Reference data, scenes and the corpus of models, in the folder `AZULEJO_DATA`.
    Data,
    /// A graphics driver for Vulkan or OpenGL; a software driver counts.
    Gpu,
    /// An X11 or Wayland display for windows; one without a screen counts.
    Display,
    /// Intel's ray tracing kernels as a shared library.
    Embree,
    /// A font installed below `/usr/share/fonts`.
    Fonts,
    /// A Python interpreter with NumPy and SciPy.
    Python,
    /// Node.js and Chromium, and the packages of web viewers that are compared with.
    Browser,
    /// MPI's launcher, `mpiexec`.
    Mpi,
}

impl Need {
    /// All of them, in the order in which messages list them.
    pub const ALL: [Need; 8] = [
        Need::Data,
        Need::Gpu,
        Need::Display,
        Need::Embree,
        Need::Fonts,
        Need::Python,
        Need::Browser,
        Need::Mpi,
    ];

    /// The word for it in `AZULEJO_REQUIRE`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Need::Data => "data",
            Need::Gpu => "gpu",
            Need::Display => "display",
            Need::Embree => "embree",
            Need::Fonts => "fonts",
            Need::Python => "python",
            Need::Browser => "browser",
            Need::Mpi => "mpi",
        }
    }

    /// A sentence on how to make it available.
    pub(crate) fn how_to_get_it(self) -> &'static str {
        match self {
            Need::Data => {
                "Set AZULEJO_DATA to a folder with reference/, scenes/ and corpus/; it is not part \
                 of the repository."
            }
            Need::Gpu => {
                "Install the driver of the graphics card, or Mesa's software drivers (Debian and \
                 Ubuntu: apt install mesa-vulkan-drivers libvulkan1 libegl1 libgl1-mesa-dri)."
            }
            Need::Display => {
                "Log in to a desktop, or run the tests under xvfb-run (Debian and Ubuntu: apt install \
                 xvfb libxkbcommon-x11-0)."
            }
            Need::Embree => "Install Embree 3 or 4 (Debian and Ubuntu: apt install libembree-dev).",
            Need::Fonts => {
                "Install the fonts (Debian and Ubuntu: apt install fonts-dejavu-core \
                 fonts-dejavu-extra fonts-urw-base35)."
            }
            Need::Python => {
                "Install NumPy and SciPy for python3, or set AZULEJO_PYTHON to a Python that has \
                 them."
            }
            Need::Browser => {
                "Install Node.js and Chromium (Debian and Ubuntu: apt install nodejs chromium), or \
                 set AZULEJO_CHROMIUM to a Chromium or Chrome; run `npm install three babylonjs \
                 babylonjs-loaders` in a folder of its own and set AZULEJO_VIEWERS to it."
            }
            Need::Mpi => {
                "Install an MPI (Debian and Ubuntu: apt install libopenmpi-dev openmpi-bin, or \
                 libmpich-dev mpich)."
            }
        }
    }
}

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The needs listed in the value of `AZULEJO_REQUIRE`.
///
/// # Errors
/// A word that names no need; the message lists those that exist.
pub(crate) fn required(variable: Option<&str>) -> Result<BTreeSet<Need>, String> {
    let words = variable.unwrap_or("").split(',').map(str::trim);
    words
        .filter(|word| !word.is_empty())
        .map(|word| {
            let need = Need::ALL.into_iter().find(|need| need.name() == word);
            need.ok_or_else(|| {
                let known = Need::ALL.map(Need::name).join(", ");
                format!("AZULEJO_REQUIRE has `{word}`, which is none of {known}")
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_needs() {
        let check = |variable: Option<&str>, expected: &[Need]| {
            let needs = required(variable).map(Vec::from_iter);
            assert_eq!(needs.as_deref(), Ok(expected), "{variable:?}");
        };
        check(None, &[]);
        check(Some(""), &[]);
        check(Some("data"), &[Need::Data]);
        check(Some(" gpu, data,"), &[Need::Data, Need::Gpu]);
        check(
            Some("mpi,browser,python,fonts,embree,display,gpu,data"),
            &Need::ALL,
        );
    }

    #[test]
    fn an_unknown_word_names_those_that_exist() {
        assert_eq!(
            required(Some("data,gpus")).unwrap_err(),
            "AZULEJO_REQUIRE has `gpus`, which is none of data, gpu, display, embree, fonts, python, browser, mpi"
        );
    }
}
