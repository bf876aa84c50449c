//! Complex indices of refraction of common metals, at the wavelengths of red, green and blue.

use super::models::{is_called, nearest};
use super::{BrdfError, Fresnel};
use crate::Rgb;

/// Wavelengths at which metals are tabulated and wave optics is evaluated, in micrometres.
pub const WAVELENGTHS: Rgb = Rgb::new(0.61, 0.55, 0.465);

/// A metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Its name.
    pub name: &'static str,
    /// Other accepted names; the chemical symbol first.
    pub aliases: &'static [&'static str],
    /// Real part of the index of refraction, at [`WAVELENGTHS`].
    pub eta: Rgb,
    /// Imaginary part.
    pub k: Rgb,
    /// Source of the measurement.
    pub source: &'static str,
}

const NOBLE: &str = "P. B. Johnson, R. W. Christy, Phys. Rev. B 6, 4370 (1972)";
const TRANSITION: &str = "P. B. Johnson, R. W. Christy, Phys. Rev. B 9, 5056 (1974)";

/// The metals that `metal = name` accepts. Measured values, interpolated linearly to the
/// wavelengths of red, green and blue; films at room temperature, without oxides.
pub static METALS: &[Metal] = &[
    Metal {
        name: "silver",
        aliases: &["Ag"],
        eta: Rgb::new(0.058, 0.060, 0.047),
        k: Rgb::new(4.094, 3.597, 2.803),
        source: NOBLE,
    },
    Metal {
        name: "gold",
        aliases: &["Au"],
        eta: Rgb::new(0.226, 0.424, 1.332),
        k: Rgb::new(3.192, 2.472, 1.869),
        source: NOBLE,
    },
    Metal {
        name: "copper",
        aliases: &["Cu"],
        eta: Rgb::new(0.378, 1.007, 1.247),
        k: Rgb::new(3.107, 2.582, 2.456),
        source: NOBLE,
    },
    Metal {
        name: "aluminium",
        aliases: &["Al", "aluminum"],
        eta: Rgb::new(1.314, 1.015, 0.686),
        k: Rgb::new(7.296, 6.627, 5.635),
        source: "A. D. Rakić, Appl. Opt. 34, 4755 (1995)",
    },
    Metal {
        name: "iron",
        aliases: &["Fe"],
        eta: Rgb::new(2.892, 2.950, 2.646),
        k: Rgb::new(3.038, 2.932, 2.805),
        source: TRANSITION,
    },
    Metal {
        name: "nickel",
        aliases: &["Ni"],
        eta: Rgb::new(1.984, 1.921, 1.765),
        k: Rgb::new(3.976, 3.616, 3.048),
        source: TRANSITION,
    },
    Metal {
        name: "chromium",
        aliases: &["Cr", "chrome"],
        eta: Rgb::new(3.180, 3.181, 2.456),
        k: Rgb::new(3.300, 3.329, 3.210),
        source: TRANSITION,
    },
    Metal {
        name: "cobalt",
        aliases: &["Co"],
        eta: Rgb::new(2.178, 2.052, 1.789),
        k: Rgb::new(4.080, 3.824, 3.371),
        source: TRANSITION,
    },
    Metal {
        name: "titanium",
        aliases: &["Ti"],
        eta: Rgb::new(2.656, 2.542, 2.305),
        k: Rgb::new(3.692, 3.435, 3.082),
        source: TRANSITION,
    },
    Metal {
        name: "platinum",
        aliases: &["Pt"],
        eta: Rgb::new(2.252, 2.091, 1.887),
        k: Rgb::new(4.039, 3.704, 3.224),
        source: "A. D. Rakić et al., Appl. Opt. 37, 5271 (1998), Lorentz–Drude fit",
    },
    Metal {
        name: "tungsten",
        aliases: &["W", "wolfram"],
        eta: Rgb::new(3.576, 3.522, 3.325),
        k: Rgb::new(2.879, 2.741, 2.574),
        source: "J. H. Weaver, C. G. Olson, D. W. Lynch, Phys. Rev. B 12, 1293 (1975)",
    },
    Metal {
        name: "zinc",
        aliases: &["Zn"],
        eta: Rgb::new(1.106, 0.929, 0.713),
        k: Rgb::new(5.521, 4.975, 4.160),
        source: "W. S. M. Werner et al., J. Phys. Chem. Ref. Data 38, 1013 (2009)",
    },
    Metal {
        name: "brass",
        aliases: &["CuZn"],
        eta: Rgb::new(0.452, 0.527, 0.947),
        k: Rgb::new(3.345, 2.765, 1.920),
        source: "M. R. Querry, Contractor Report CRDC-CR-85034 (1985), 70 % Cu, 30 % Zn",
    },
    Metal {
        name: "steel",
        aliases: &["stainless_steel"],
        eta: Rgb::new(2.272, 2.044, 1.736),
        k: Rgb::new(4.005, 3.673, 3.207),
        source: "B. Karlsson, C. G. Ribbing, J. Appl. Phys. 53, 6340 (1982), austenitic",
    },
];

impl Metal {
    /// Reflectance of its polished surface.
    pub fn fresnel(&self) -> Fresnel {
        Fresnel::Conductor {
            eta: self.eta,
            k: self.k,
        }
    }
}

/// The metal of that name, or of that chemical symbol.
///
/// # Errors
/// [`BrdfError::UnknownMetal`], with the most similar known name.
pub fn find_metal(name: &str) -> Result<&'static Metal, BrdfError> {
    let known = METALS.iter().find(|m| is_called(m.name, m.aliases, name));
    known.ok_or_else(|| {
        // Two letters are similar to many words; only full names are suggested.
        let names = METALS.iter().map(|m| m.name);
        BrdfError::UnknownMetal {
            name: name.to_owned(),
            nearest: nearest(name, names).unwrap_or("silver"),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_have_their_colours() {
        let mirrored = |name: &str| find_metal(name).unwrap().fresnel().at(1.0);
        let gold = mirrored("Gold");
        assert!(gold.r > 0.9 && gold.g < 0.85 && gold.b < 0.5, "{gold:?}");
        let copper = mirrored("cu");
        assert!(copper.r > 0.85 && copper.g < 0.7 && copper.b < 0.6);
        assert!(mirrored("silver").b > 0.95);
        // (n − 1)² + k² over (n + 1)² + k².
        let aluminium = mirrored("aluminum").g;
        assert!((aluminium - 0.915).abs() < 5e-4, "{aluminium}");
    }

    #[test]
    fn unknown_metals_are_refused_with_the_nearest() {
        let problem = find_metal("golf").unwrap_err().to_string();
        assert!(problem.contains("nearest name is `gold`"), "{problem}");
    }
}
