//! Surfaces by the format's own rules, and as materials.

use super::document::SurfaceRecord;
use crate::surface::gloss::Gloss;
use crate::surface::phong::Highlight;
use azulejo_scene::brdf::Description;
use azulejo_scene::rtrace::{RtraceSource, RtraceSurface};
use azulejo_scene::{Dielectric, Material, Rgb};

/// Upper limit of specular reflection and transmission.
const MOST: f64 = 0.95;

/// Applies `f` to each channel of several colours.
fn each<const N: usize>(colors: [Rgb; N], f: impl Fn([f64; N]) -> f64) -> Rgb {
    Rgb::from([0, 1, 2].map(|k| f(colors.map(|c| c[k]))))
}

/// A surface with the parameters that RTRACE derives from its record.
pub(super) fn derived(record: &SurfaceRecord) -> RtraceSurface {
    let mut surface = RtraceSurface {
        color: record.color,
        is_emitter: record.is_emitter,
        is_unshadowed: record.is_unshadowed,
        source: record.source,
        ..RtraceSurface::default()
    };
    match record.source {
        RtraceSource::Phong {
            diffuse,
            specular,
            phong,
            metal,
            transparency,
        } => {
            surface.diffuse = diffuse;
            surface.specular = specular.map(|k| k.min(MOST));
            surface.transparency = transparency.map(|k| k.min(MOST));
            surface.phong = phong.max(3.0);
            surface.metal = Rgb::grey(metal);
            surface.diffuse_factor = Rgb::grey(1.0 - (1.0 - 3.0 / surface.phong) * metal);
        }
        RtraceSource::Strauss {
            smooth,
            metal,
            transparency,
        } => {
            surface.transparency = transparency.map(|k| k.min(MOST));
            let opaque = Rgb::WHITE - surface.transparency;
            surface.diffuse = each([smooth, opaque], |[s, o]| (1.0 - s * s * s) * o);
            surface.specular = opaque - surface.diffuse;
            surface.phong = 9.0 / (0.0001 + 3.0 - (smooth.r + smooth.g + smooth.b));
            surface.metal = metal;
            surface.diffuse_factor = each([smooth, metal], |[s, m]| 1.0 - s * m);
        }
    }
    surface
}

/// Specular reflectance at normal incidence: Ks, which metals tint by their colour.
pub(super) fn mirror(surface: &RtraceSurface) -> Rgb {
    let colors = [surface.specular, surface.metal, surface.color];
    each(colors, |[k, metal, c]| k * (1.0 + metal * (c - 1.0)))
}

/// Whether it transmits more than half of the light.
fn is_clear(surface: &RtraceSurface) -> bool {
    surface.transparency.mean() >= 0.5
}

/// Whether it transmits light that the material absorbs.
pub(super) fn is_dimmed(surface: &RtraceSurface) -> bool {
    !surface.is_emitter && !surface.transparency.is_black() && !is_clear(surface)
}

/// A surface as an energy-conserving material.
///
/// An emitter emits its colour from both sides; a surface that transmits half of the light or more
/// is clear glass tinted by Kt C; anything else is a model of [`reflection`].
///
/// # Errors
/// Beside the material: a warning that the model is dropped, and Ks is a mirror.
pub(super) fn material(
    surface: &RtraceSurface,
    ior: f64,
    name: String,
    gloss: &mut Gloss,
) -> (Material, Result<(), &'static str>) {
    if surface.is_emitter {
        let lamp = Material {
            emits_back: true,
            ..Material::emitter(name, surface.color)
        };
        return (lamp, Ok(()));
    }
    if is_clear(surface) {
        let transmittance = surface.transparency * surface.color;
        let glass = Material {
            dielectric: Some(Dielectric {
                ior,
                transmittance,
                thin: false,
            }),
            ..Material::mirror(name, Rgb::WHITE)
        };
        return (glass, Ok(()));
    }
    let mut material = Material {
        mirror: mirror(surface),
        ..Material::diffuse(name, surface.diffuse * surface.color)
    };
    material.limit_reflectance();
    if material.mirror.is_black() {
        return (material, Ok(()));
    }
    let model = reflection(surface, &material);
    let made = gloss.cover(&mut material, model);
    (material, made)
}

/// The model of a surface whose material already has the reflectances: Strauss' own if its
/// parameters are equal in all channels, otherwise a lobe with RTRACE's exponent around the
/// mirrored direction.
fn reflection(surface: &RtraceSurface, material: &Material) -> Description {
    if let RtraceSource::Strauss {
        smooth,
        metal,
        transparency,
    } = surface.source
        && [smooth, metal, transparency].iter().all(|c| c.is_grey())
    {
        let parameters = [
            ("color", unit(surface.color)),
            ("smoothness", unit(smooth)),
            ("metalness", unit(metal)),
            ("transparency", unit(surface.transparency)),
        ];
        return Description::model("strauss", parameters.map(|(name, c)| (name, c.into())));
    }
    lobe(surface.phong, material.mirror, material.diffuse)
}

/// A Phong lobe around the mirrored direction.
pub(super) fn lobe(n: f64, ks: Rgb, kd: Rgb) -> Description {
    let [ks, kd] = [ks, kd].map(unit);
    // Rounding of the sum must not make the model invalid.
    let ks = Rgb::from([0, 1, 2].map(|k| ks[k].min(1.0 - kd[k])));
    Highlight::mirrored(n, Rgb::BLACK).description(kd, ks)
}

fn unit(color: Rgb) -> Rgb {
    color.map(|c| c.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(surface: &RtraceSurface, ior: f64) -> Material {
        let (material, problem) = material(surface, ior, String::new(), &mut Gloss::default());
        problem.unwrap();
        material
    }

    fn phong(ks: f64, metal: f64, kt: f64) -> RtraceSurface {
        derived(&SurfaceRecord {
            color: Rgb::new(0.5, 0.25, 1.0),
            is_emitter: false,
            is_unshadowed: false,
            source: RtraceSource::Phong {
                diffuse: Rgb::grey(0.8),
                specular: Rgb::grey(ks),
                phong: 30.0,
                metal,
                transparency: Rgb::grey(kt),
            },
        })
    }

    #[test]
    fn mirrors_are_tinted_by_metals_and_limited() {
        let check = |ks, metal, mirror: [f64; 3], diffuse_blue: f64| {
            let m = made(&phong(ks, metal, 0.0), 1.0);
            let lobe = Highlight::of(&m).unwrap();
            assert_eq!((lobe.n, m.mirror), (30.0, Rgb::BLACK));
            let far = lobe.reflectance() - Rgb::from(mirror);
            assert!(far.map(f64::abs).max_channel() < 1e-12, "{lobe:?}");
            assert!(
                (m.diffuse.b - diffuse_blue).abs() < 1e-12,
                "{:?}",
                m.diffuse
            );
        };
        check(0.1, 0.0, [0.1, 0.1, 0.1], 0.8);
        check(0.1, 1.0, [0.05, 0.025, 0.1], 0.8);
        // 0.4, 0.2 and 0.8 of diffuse reflectance and the mirror's 0.95 are scaled to 1.
        let scaled = [0.95 / 1.35, 0.95 / 1.15, 0.95 / 1.75];
        check(1.0, 0.0, scaled, 0.8 / 1.75);
    }

    #[test]
    fn clear_surfaces_are_glass() {
        let clear = made(&phong(0.1, 0.0, 0.8), 1.5);
        assert_eq!(clear.dielectric.unwrap().ior, 1.5);
        assert_eq!(clear.dielectric.unwrap().transmittance.b, 0.8);
        assert!(clear.diffuse.is_black());
        let dim = phong(0.1, 0.0, 0.2);
        assert!(is_dimmed(&dim) && made(&dim, 1.5).dielectric.is_none());
    }

    #[test]
    fn strauss_surfaces_share_what_is_not_let_through() {
        let surface = derived(&SurfaceRecord {
            color: Rgb::WHITE,
            is_emitter: false,
            is_unshadowed: false,
            source: RtraceSource::Strauss {
                smooth: Rgb::grey(0.5),
                metal: Rgb::grey(1.0),
                transparency: Rgb::grey(0.2),
            },
        });
        assert!((surface.diffuse.g - 0.7).abs() < 1e-12);
        assert!((surface.specular.g - 0.1).abs() < 1e-12);
        assert!((surface.phong - 9.0 / 1.5001).abs() < 1e-12);
        assert_eq!(surface.diffuse_factor.g, 0.5);
    }
}
