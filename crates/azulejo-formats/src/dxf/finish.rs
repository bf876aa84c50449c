//! MATERIALs, and materials of entities without one.

use super::color::{FOREGROUND, Paint};
use super::drawing::Finish;
use super::record::Record;
use azulejo_scene::{Dielectric, Material, Rgb};

impl Finish {
    /// Reads a MATERIAL, and the names of its properties that are not used.
    pub fn read(record: &Record) -> (Finish, Vec<&'static str>) {
        let name = record.text(1);
        let reserved = match name.to_ascii_lowercase().as_str() {
            "bylayer" => Some(Finish::ByLayer),
            "byblock" => Some(Finish::ByBlock),
            "global" => Some(Finish::Plain),
            _ => None,
        };
        if let Some(reserved) = reserved {
            return (reserved, Vec::new());
        }
        let has_own_color = record.integer(71, 0) == 1;
        let color = record.find(91).and_then(|value| record.whole(value));
        let is_clear = record.real(140, 1.0) < 1.0;
        let ior = record.real(145, 1.0);
        let finish = Finish::Described {
            name: name.into_owned(),
            paint: color.filter(|_| has_own_color).map(Paint::of_material),
            factor: record.real(41, 1.0).clamp(0.0, 1.0),
            ior: (is_clear && ior > 1.0).then_some(ior),
        };
        let losses = [
            (
                is_clear && ior <= 1.0,
                "opacity below 1 and no index of refraction (opaque)",
            ),
            (!record.bytes(3).is_empty(), "a picture"),
            (record.real(464, 0.0) > 0.0, "luminance"),
        ];
        let lost = losses.iter().filter(|(is_lost, _)| *is_lost);
        (finish, lost.map(|(_, what)| *what).collect())
    }
}

/// The material of a surface on a layer, in the layer's colour or its own, with or without
/// a MATERIAL.
pub(super) fn material(
    layer: &str,
    layer_paint: Paint,
    paint: Paint,
    finish: Option<&Finish>,
) -> Material {
    let Some(Finish::Described {
        name,
        paint: own,
        factor,
        ior,
    }) = finish
    else {
        let name = if paint == layer_paint {
            layer.to_owned()
        } else {
            format!("{layer}/{paint}")
        };
        return Material::diffuse(name, paint.reflectance());
    };
    if let Some(ior) = *ior {
        return glass(name, ior);
    }
    // White set explicitly by a MATERIAL is white.
    let color = match own {
        Some(FOREGROUND) => Rgb::WHITE,
        Some(own) => own.reflectance(),
        None => paint.reflectance(),
    };
    Material::diffuse(name.as_str(), color * *factor)
}

fn glass(name: &str, ior: f64) -> Material {
    Material {
        name: name.to_owned(),
        mirror: Rgb::WHITE,
        dielectric: Some(Dielectric {
            ior,
            transmittance: Rgb::WHITE,
            thin: false,
        }),
        ..Material::default()
    }
}
