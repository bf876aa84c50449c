//! Conversion of MGF materials.

use super::color::Chroma;
use crate::surface::gloss::Gloss;
use azulejo_scene::brdf::Description;
use azulejo_scene::{Dielectric, Material, MaterialId, Rgb, Sidedness};
use std::f64::consts::PI;

/// Surfaces below this roughness (RMS facet slope) are perfect mirrors.
const SMOOTH: f64 = 1e-4;

/// The greatest roughness that the model supports.
const MOST: f64 = 10.0;

/// Reflectance of undefined materials.
const DEFAULT_REFLECTANCE: f64 = 0.5;

/// One of the five components of a material: reflection, transmission, emission.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MaterialComponent {
    /// Share of the incident light, or lm/m² for emittance; of equal-energy white.
    pub amount: f64,
    /// The current colour when the component was read.
    pub color: Chroma,
    /// RMS facet slope, for specular components.
    pub roughness: f64,
}

impl MaterialComponent {
    fn rgb(&self) -> Rgb {
        self.color.rgb(self.amount)
    }
}

/// A material as defined in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MgfMaterial {
    /// What `sides` says, if it is there; two sides are but the default.
    pub sidedness: Sidedness,
    /// `rd`: diffuse reflectance.
    pub rd: MaterialComponent,
    /// `td`: diffuse transmittance.
    pub td: MaterialComponent,
    /// `ed`: diffuse emittance.
    pub ed: MaterialComponent,
    /// `rs`: specular reflectance.
    pub rs: MaterialComponent,
    /// `ts`: specular transmittance.
    pub ts: MaterialComponent,
    /// `ir`: real part of the index of refraction; `None` for the default of 1.
    pub ior: Option<f64>,
    /// The scene's materials made from it, for open and for closed surfaces; any change resets
    /// them.
    pub made: [Option<MaterialId>; 2],
}

impl MgfMaterial {
    /// The default for an undefined material: grey.
    pub fn undefined() -> MgfMaterial {
        MgfMaterial {
            rd: MaterialComponent {
                amount: DEFAULT_REFLECTANCE,
                ..MaterialComponent::default()
            },
            ..MgfMaterial::default()
        }
    }

    /// Whether it transmits specularly.
    pub fn is_glass(&self) -> bool {
        self.ts.amount > 0.0
    }

    /// Whether the two sides differ in azulejo: only one of them emits, or it is glass.
    pub fn has_different_sides(&self) -> bool {
        let is_solid = self.is_one_sided() && self.is_glass() && self.ior.is_some();
        (self.is_one_sided() && self.ed.amount > 0.0) || is_solid
    }

    /// Whether it is `sides 1`.
    pub fn is_one_sided(&self) -> bool {
        self.sidedness == Sidedness::One
    }

    /// Converts it to an azulejo material, and collects what is lost. The back of a closed surface
    /// is never visible, so it does not emit.
    pub fn material(
        &self,
        name: &str,
        is_closed: bool,
        gloss: &mut Gloss,
    ) -> (Material, Vec<&'static str>) {
        let mut losses = Vec::new();
        let [rd, td, rs, ts] = self.shares(&mut losses);
        let mut material = Material {
            name: name.to_owned(),
            diffuse: rd,
            emission: self.ed.color.rgb(self.ed.amount / PI),
            emits_back: self.ed.amount > 0.0 && !self.is_one_sided() && !is_closed,
            sidedness: self.sidedness,
            ..Material::default()
        };
        if !td.is_black() {
            losses
                .push("diffuse transmittance (td) is not supported: transmitted light is absorbed");
        }
        if !ts.is_black() {
            self.glass(&mut material, rs, ts, &mut losses);
        } else if self.rs.roughness < SMOOTH {
            material.mirror = rs;
        } else if !rs.is_black() {
            let made = gloss.cover(&mut material, ward(self.rs.roughness.min(MOST), rs, rd));
            losses.extend(made.err());
        }
        // The shares sum to at most 1; this corrects the last bit.
        material.limit_reflectance();
        (material, losses)
    }

    /// rd, td, rs and ts as RGB, scaled down together if they sum to more than 1.
    fn shares(&self, losses: &mut Vec<&'static str>) -> [Rgb; 4] {
        let shares = [self.rd, self.td, self.rs, self.ts].map(|part| part.rgb());
        let total = shares
            .iter()
            .fold(Rgb::BLACK, |sum, &s| sum + s)
            .max_channel();
        // Shares rounded to three digits may sum to slightly more than 1.
        if total <= 1.0 + 1e-9 {
            return shares;
        }
        losses.push("material that reflects and transmits more than it receives: scaled down to 1");
        shares.map(|share| share / total)
    }

    /// Glass: a solid body if it is one-sided and refracts, otherwise a thin sheet without
    /// refraction.
    fn glass(&self, material: &mut Material, rs: Rgb, ts: Rgb, losses: &mut Vec<&'static str>) {
        if self.ts.roughness > SMOOTH {
            losses.push("rough transmission (ts with roughness) is not supported: taken as clear");
        }
        if !material.diffuse.is_black() {
            losses.push("diffuse reflection of glass is not supported: absorbed");
            material.diffuse = Rgb::BLACK;
        }
        let solid = self.ior.filter(|_| self.is_one_sided());
        material.mirror = Rgb::WHITE;
        material.dielectric = Some(match solid {
            Some(ior) => Dielectric {
                ior,
                transmittance: through_one_face(ior, ts),
                thin: false,
            },
            None => Dielectric {
                ior: 1.0,
                transmittance: ts,
                thin: false,
            },
        });
        if solid.is_none() && !rs.is_black() {
            losses.push("reflection of a sheet of glass (rs beside ts) is not supported: absorbed");
        }
    }
}

/// The internal transmittance per face of a solid, if `ts` is the transmittance of a plate with two
/// faces.
///
/// Fresnel at normal incidence: R = ((n − 1)/(n + 1))², and ts = ((1 − R) t)².
fn through_one_face(ior: f64, ts: Rgb) -> Rgb {
    let reflected = ((ior - 1.0) / (ior + 1.0)).powi(2);
    ts.map(|share| (share.sqrt() / (1.0 - reflected)).min(1.0))
}

/// Ward's model in the energy-conserving form; MGF's roughness is its α.
fn ward(roughness: f64, ks: Rgb, kd: Rgb) -> Description {
    let [ks, kd] = [ks, kd].map(|share| share.map(|c| c.min(1.0)));
    let parameters = [
        ("ax", roughness.into()),
        ("ks", ks.into()),
        ("kd", kd.into()),
    ];
    Description::model("ward_gmd", parameters)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(amount: f64, roughness: f64) -> MaterialComponent {
        MaterialComponent {
            amount,
            roughness,
            ..MaterialComponent::default()
        }
    }

    fn check(surface: MgfMaterial, expected: Material, losses: &[&str]) {
        let (material, lost) = surface.material("m", false, &mut Gloss::default());
        let close = |a: Rgb, b: Rgb| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12);
        assert!(
            close(material.diffuse, expected.diffuse)
                && close(material.mirror, expected.mirror)
                && close(material.emission, expected.emission),
            "{material:?}"
        );
        assert_eq!(material.emits_back, expected.emits_back);
        assert_eq!(material.dielectric, expected.dielectric);
        assert_eq!(lost.len(), losses.len(), "{lost:?}");
        for (loss, expected) in lost.iter().zip(losses) {
            assert!(loss.contains(expected), "{loss}");
        }
    }

    #[test]
    fn matt_mirror_gloss() {
        let surface = |rs| MgfMaterial {
            rd: part(0.3, 0.0),
            rs,
            ..MgfMaterial::default()
        };
        let matt = Material::diffuse("m", Rgb::grey(0.3));
        let mirror = Material {
            mirror: Rgb::grey(0.2),
            ..matt.clone()
        };
        check(surface(part(0.0, 0.0)), matt.clone(), &[]);
        check(surface(part(0.2, 0.0)), mirror, &[]);
        check(surface(part(0.2, 0.1)), matt, &[]);
        let glossy = surface(part(0.2, 0.1));
        let (glossy, _) = glossy.material("m", false, &mut Gloss::default());
        let model = glossy.brdf.map(|b| b.description().to_string());
        assert_eq!(
            model.as_deref(),
            Some("ward_gmd ax = 0.1 ks = 0.2 kd = 0.3")
        );
    }

    #[test]
    fn more_than_all_is_scaled() {
        let surface = MgfMaterial {
            rd: part(0.9, 0.0),
            rs: part(0.3, 0.0),
            ..MgfMaterial::default()
        };
        let expected = Material {
            mirror: Rgb::grey(0.25),
            ..Material::diffuse("m", Rgb::grey(0.75))
        };
        check(surface, expected, &["more than it receives"]);
    }

    #[test]
    fn glass_as_sheet_and_as_solid() {
        let sheet = MgfMaterial {
            rs: part(0.08, 0.0),
            ts: part(0.88, 0.0),
            ior: Some(1.52),
            ..MgfMaterial::default()
        };
        let pane = |ior, transmittance| Material {
            mirror: Rgb::WHITE,
            dielectric: Some(Dielectric {
                ior,
                transmittance,
                thin: false,
            }),
            ..Material::default()
        };
        check(
            sheet.clone(),
            pane(1.0, Rgb::grey(0.88)),
            &["sheet of glass"],
        );
        // 4.26% is lost at each face; the rest of the way to 0.88 is lost inside.
        let reflected = (0.52f64 / 2.52).powi(2);
        let t = 0.88f64.sqrt() / (1.0 - reflected);
        let solid = MgfMaterial {
            sidedness: Sidedness::One,
            ..sheet
        };
        check(solid, pane(1.52, Rgb::grey(t)), &[]);
    }

    #[test]
    fn emission_by_sides() {
        let lamp = |sidedness| MgfMaterial {
            sidedness,
            ed: part(PI, 0.0),
            td: part(0.5, 0.0),
            ..MgfMaterial::default()
        };
        let expected = |emits_back, sidedness| Material {
            emits_back,
            sidedness,
            ..Material::emitter("m", Rgb::WHITE)
        };
        check(
            lamp(Sidedness::Unsaid),
            expected(true, Sidedness::Unsaid),
            &["td"],
        );
        check(
            lamp(Sidedness::One),
            expected(false, Sidedness::One),
            &["td"],
        );
        assert!(
            !lamp(Sidedness::Unsaid)
                .material("m", true, &mut Gloss::default())
                .0
                .emits_back
        );
    }
}
