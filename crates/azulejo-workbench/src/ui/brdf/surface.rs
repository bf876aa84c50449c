//! The kind of surface of a material, and the parameters of each kind.

use super::super::inputs;
use super::color;
use super::fields::{NumberRange, SHARE, color_row, number_row};
use super::theme::row;
use crate::variants::all;
use crate::words::Language;
use azulejo::scene::brdf::{Description, Value};
use azulejo::scene::{Brdf, Dielectric, Material, Rgb};
use clap::ValueEnum;
use egui::{ComboBox, Ui};
use glam::DVec3;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum SurfaceKind {
    Matt,
    Mirror,
    MattAndMirror,
    Glass,
    Model,
}

impl SurfaceKind {
    /// The kind of a material.
    pub fn of(material: &Material) -> SurfaceKind {
        match (&material.dielectric, &material.brdf) {
            (Some(_), _) => SurfaceKind::Glass,
            (None, Some(_)) => SurfaceKind::Model,
            _ if material.mirror.is_black() => SurfaceKind::Matt,
            _ if material.diffuse.is_black() => SurfaceKind::Mirror,
            _ => SurfaceKind::MattAndMirror,
        }
    }

    /// Whether a material may be edited as this kind: a black one is a dark mirror as well as a
    /// dark wall, and the fields must not change while a value is dragged to zero.
    pub fn is_compatible(self, material: &Material) -> bool {
        let plain = material.dielectric.is_none() && material.brdf.is_none();
        match self {
            SurfaceKind::Matt => plain && material.mirror.is_black(),
            SurfaceKind::Mirror => plain && material.diffuse.is_black(),
            SurfaceKind::MattAndMirror => plain,
            SurfaceKind::Glass | SurfaceKind::Model => SurfaceKind::of(material) == self,
        }
    }

    fn words(self, language: Language) -> &'static str {
        match self {
            SurfaceKind::Matt => language.tr("Matt surface"),
            SurfaceKind::Mirror => language.tr("Mirror"),
            SurfaceKind::MattAndMirror => language.tr("Matt and mirror"),
            SurfaceKind::Glass => language.tr("Glass"),
            SurfaceKind::Model => language.tr("Reflection model"),
        }
    }

    /// Converts a material to this kind in the same colour, if it has one; a reflection model is
    /// left to the caller.
    pub fn convert(self, material: &mut Material, color: Option<Rgb>) {
        let color = |other: f64| color.unwrap_or(Rgb::grey(other));
        (material.dielectric, material.brdf) = (None, None);
        (material.diffuse, material.mirror) = match self {
            SurfaceKind::Matt | SurfaceKind::Model => (color(0.5), Rgb::BLACK),
            SurfaceKind::Mirror => (Rgb::BLACK, color(0.9)),
            SurfaceKind::MattAndMirror => (color(0.5).map(|x| x.min(0.9)), Rgb::grey(0.1)),
            SurfaceKind::Glass => (Rgb::BLACK, Rgb::WHITE),
        };
        if self == SurfaceKind::Glass {
            material.dielectric = Some(Dielectric {
                ior: 1.5,
                transmittance: Rgb::WHITE,
                thin: false,
            });
        }
        // A reflection model may leave parts that together reflect too much.
        material.limit_reflectance();
    }

    /// Draws the choice of kinds.
    pub fn choose(self, ui: &mut Ui, language: Language) -> SurfaceKind {
        let mut chosen = self;
        row(
            ui,
            language.tr("Surface"),
            language.tr("How the surface reflects light."),
            |ui, name| {
                let combo = ComboBox::from_id_salt("kind").width(170.0);
                inputs::choice(combo, ui, &mut chosen, all(), |k: &SurfaceKind| {
                    k.words(language)
                })
                .accessible_name(name);
            },
        );
        chosen
    }
}

/// The model in a colour, if it can have one: a sum or a file only if it is of that colour already.
pub(super) fn recolored(description: Description, shade: Rgb) -> Option<Description> {
    match description {
        Description::Model(model) => Some(Description::Model(match color::model_color(&model) {
            Some(old) if color::is_near(old, shade) => model,
            _ => color::recolored(&model, shade),
        })),
        other => {
            let seen = Brdf::new(other.clone()).ok()?.albedo(DVec3::Z);
            color::is_near(seen, shade).then_some(other)
        }
    }
}

/// The simplest model of a colour.
pub(super) fn model_of(shade: Rgb, is_mirror: bool) -> Description {
    let (name, parameter) = if is_mirror {
        ("specular", "ks")
    } else {
        ("diffuse", "kd")
    };
    Description::model(name, [(parameter, Value::from(shade))])
}

/// The parameters of kinds without a reflection model.
pub(super) fn fields(ui: &mut Ui, language: Language, kind: SurfaceKind, material: &mut Material) {
    let room = |other: Rgb| 1.0 - other.max_channel();
    if matches!(kind, SurfaceKind::Matt | SurfaceKind::MattAndMirror) {
        let about = language.tr("Diffuse reflectance; together with mirror reflectance at most 1.");
        let span = SHARE.up_to(room(material.mirror));
        color_row(
            ui,
            language.tr("Diffuse"),
            about,
            span,
            &mut material.diffuse,
        );
    }
    if matches!(kind, SurfaceKind::Mirror | SurfaceKind::MattAndMirror) {
        let about = language.tr("Mirror reflectance; together with diffuse reflectance at most 1.");
        let span = SHARE.up_to(room(material.diffuse));
        color_row(
            ui,
            language.tr("Specular"),
            about,
            span,
            &mut material.mirror,
        );
    }
    if let Some(glass) = &mut material.dielectric {
        glass_fields(ui, language, glass, &mut material.mirror);
    }
    if kind != SurfaceKind::Model {
        material.diffuse = material.diffuse.map(|x| x.clamp(0.0, 1.0));
        material.mirror = material.mirror.map(|x| x.clamp(0.0, 1.0));
    }
}

fn glass_fields(ui: &mut Ui, language: Language, glass: &mut Dielectric, mirror: &mut Rgb) {
    let about = language
        .tr("Index of refraction relative to the outside: water 1.33, glass 1.5, diamond 2.4.");
    let span = NumberRange {
        least: 0.3,
        most: 4.0,
        ..SHARE
    };
    number_row(
        ui,
        language.tr("Refractive index"),
        about,
        span,
        &mut glass.ior,
    );
    let about = language.tr("Scales the transmitted light; white for clear glass.");
    color_row(
        ui,
        language.tr("Transmission"),
        about,
        SHARE,
        &mut glass.transmittance,
    );
    let about = language.tr("Scales the reflected light; white for Fresnel's equations alone.");
    color_row(ui, language.tr("Specular"), about, SHARE, mirror);
    let about = language.tr("A complete pane: both of its surfaces in one face.");
    row(ui, "", "", |ui, _| {
        ui.checkbox(&mut glass.thin, language.tr("Thin pane"))
            .on_hover_text(about)
    });
}

/// Emission as a strength and a colour; `last` is the colour while the strength is zero.
pub(super) fn emission(
    ui: &mut Ui,
    language: Language,
    is_photometric: bool,
    material: &mut Material,
    last: &mut Rgb,
) {
    let mut strength = material.emission.max_channel();
    if strength > 0.0 {
        *last = material.emission / strength;
    }
    let old = (strength, *last);
    let mut shade = *last;
    let unit = if is_photometric {
        " cd/m²"
    } else {
        " W/(sr·m²)"
    };
    let about = language.tr("Radiance of the front in the brightest channel; 0 for no emission.");
    row(ui, language.tr("Emission"), about, |ui, name| {
        let speed = (0.01 * strength).max(0.01);
        let drag = inputs::number(&mut strength, 0.0..=1e12)
            .speed(speed)
            .max_decimals(4)
            .suffix(unit);
        ui.add(drag).accessible_name(name);
        if strength > 0.0 {
            ui.checkbox(&mut material.emits_back, language.tr("Two-sided"));
        }
    });
    if strength > 0.0 {
        let about = language.tr("Colour of the emitted light.");
        color_row(ui, language.tr("Emission colour"), about, SHARE, &mut shade);
    }
    if (strength, shade) == old {
        return;
    }
    // Black has no hue: keep the last one.
    *last = inputs::hue(shade).unwrap_or(*last);
    material.emission = *last * strength;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn every_kind_becomes_every_other() {
        let brdf = Brdf::new(
            "gltf_mr base = 1 metallic = 0.5 roughness = 1"
                .parse()
                .unwrap(),
        )
        .unwrap();
        let model = Material::with_brdf("", Arc::new(brdf));
        let start = [
            Material::default(),
            Material::mirror("", Rgb::WHITE),
            Material::pane("", 1.5),
            model,
        ];
        for material in start {
            for kind in [
                SurfaceKind::Matt,
                SurfaceKind::Mirror,
                SurfaceKind::MattAndMirror,
                SurfaceKind::Glass,
            ] {
                let mut material = material.clone();
                let color = color::material_color(&material);
                kind.convert(&mut material, color);
                assert_eq!(SurfaceKind::of(&material), kind);
                assert!(kind.is_compatible(&material));
                assert!(material.limit_reflectance(), "{kind:?} of {material:?}");
            }
        }
    }

    #[test]
    fn a_colour_survives_every_kind() {
        let red = Rgb::new(0.7, 0.1, 0.05);
        for kind in [
            SurfaceKind::Matt,
            SurfaceKind::Mirror,
            SurfaceKind::MattAndMirror,
            SurfaceKind::Glass,
        ] {
            let mut material = Material::diffuse("", red);
            kind.convert(&mut material, Some(red));
            let seen = color::material_color(&material);
            assert!(seen.is_none_or(|c| c == red), "{kind:?}: {seen:?}");
            SurfaceKind::Matt.convert(&mut material, seen.or(Some(red)));
            assert_eq!(material.diffuse, red, "{kind:?}");
        }
    }

    #[test]
    fn a_dark_mirror_stays_one() {
        let black = Material::default();
        assert!(
            SurfaceKind::Mirror.is_compatible(&black) && SurfaceKind::Matt.is_compatible(&black)
        );
        assert!(!SurfaceKind::Mirror.is_compatible(&Material::diffuse("", Rgb::WHITE)));
    }
}
