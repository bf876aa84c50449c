//! Validation of RTRACE's parameters.

use super::{Check, ensure, is_light};
use crate::rtrace::{
    Rtrace, RtraceLight, RtraceLightKind, RtraceMaterial, RtraceSurface, RtraceTexture,
    RtraceTextureKind,
};
use crate::{Scene, Shape};
use std::f64::consts::{FRAC_PI_2, PI};

/// RTRACE's own limit for the samples along a side of a light.
const MOST_SAMPLES: u32 = 256;

pub(super) fn validate(rtrace: &Rtrace, scene: &Scene) -> Check {
    validate_view(rtrace)?;
    for (i, light) in rtrace.lights.iter().enumerate() {
        ensure(
            is_lamp(light),
            || format!("rtrace: lights[{i}]"),
            || format!("{light:?}: expected finite numbers, brightness >= 0, unit directions"),
        )?;
    }
    for (i, surface) in rtrace.surfaces.iter().enumerate() {
        ensure(
            is_surface(surface),
            || format!("rtrace: surfaces[{i}]"),
            || format!("{surface:?}: expected finite numbers >= 0"),
        )?;
    }
    validate_materials(rtrace, scene)?;
    validate_corner_surfaces(rtrace, scene)
}

fn validate_view(rtrace: &Rtrace) -> Check {
    let gaze = rtrace.look - rtrace.eye;
    let points = [rtrace.eye, rtrace.look, rtrace.up];
    let seen = points.iter().all(|p| p.is_finite()) && gaze.cross(rtrace.up).length() > 0.0;
    let angles = rtrace.half_angles;
    ensure(
        seen && angles.iter().all(|a| *a > 0.0 && *a < FRAC_PI_2),
        || "rtrace: view".into(),
        || format!("{points:?} and half angles {angles:?} do not define a view"),
    )?;
    ensure(
        is_light(rtrace.background) && is_light(rtrace.ambient),
        || "rtrace: colours".into(),
        || "background or ambient light is not a finite number >= 0".into(),
    )
}

fn is_lamp(light: &RtraceLight) -> bool {
    let kind = match light.kind {
        RtraceLightKind::Point => true,
        RtraceLightKind::Spot {
            direction,
            half_angle,
            factor,
        } => {
            (direction.length() - 1.0).abs() < 1e-3
                && (0.0..=PI).contains(&half_angle)
                && factor > 0.0
                && factor.is_finite()
        }
        RtraceLightKind::Extended { radius, samples } => {
            radius >= 0.0 && radius.is_finite() && samples <= MOST_SAMPLES
        }
        RtraceLightKind::Planar { edges, samples } => {
            edges.iter().all(|e| e.is_finite()) && samples.iter().all(|s| *s <= MOST_SAMPLES)
        }
    };
    kind && light.position.is_finite() && is_light(light.brightness)
}

fn is_surface(s: &RtraceSurface) -> bool {
    let colors = [
        s.color,
        s.diffuse,
        s.specular,
        s.metal,
        s.transparency,
        s.diffuse_factor,
    ];
    colors.into_iter().all(is_light) && s.phong >= 0.0 && s.phong.is_finite()
}

fn validate_materials(rtrace: &Rtrace, scene: &Scene) -> Check {
    let (known, count) = (rtrace.materials.len(), scene.materials.len());
    ensure(
        known <= count,
        || "rtrace: materials".into(),
        || format!("{known}, more than the scene's {count}"),
    )?;
    for (i, material) in rtrace.materials.iter().enumerate() {
        ensure(
            is_material(material, rtrace.surfaces.len()),
            || format!("rtrace: materials[{i}]"),
            || {
                format!(
                    "an index of refraction below 1, or a number that is not finite, or a surface out of range: {material:?}"
                )
            },
        )?;
    }
    Ok(())
}

fn is_material(material: &RtraceMaterial, surfaces: usize) -> bool {
    let mut textures = material
        .inline_textures
        .iter()
        .chain(&material.section_textures);
    (material.surface as usize) < surfaces
        && material.ior >= 1.0
        && material.ior.is_finite()
        && textures.all(|t| is_texture(t, surfaces))
}

fn is_texture(texture: &RtraceTexture, surfaces: usize) -> bool {
    use RtraceTextureKind::*;
    let kind = match &texture.kind {
        Checker { surface } | Blotch { surface, .. } => (*surface as usize) < surfaces,
        ImageMap { axes, image, .. } => {
            axes.iter().all(|a| *a < 3)
                && axes[0] != axes[1]
                && image.width >= 2
                && image.height >= 2
        }
        _ => true,
    };
    kind && texture.texture_from_point.is_finite()
}

fn validate_corner_surfaces(rtrace: &Rtrace, scene: &Scene) -> Check {
    for (&object, faces) in &rtrace.corner_surfaces {
        let place = || format!("rtrace: corner_surfaces[{object}]");
        let mesh = match scene.objects.get(object as usize).map(|o| &o.shape) {
            Some(Shape::Mesh(mesh)) => mesh,
            _ => return ensure(false, place, || "there is no such mesh".into()),
        };
        ensure(
            mesh.faces.len() == faces.len() && mesh.faces.iter().all(|f| f.len() == 3),
            place,
            || "expected one entry for each face, all of them triangles".into(),
        )?;
        let known = rtrace.surfaces.len();
        let mut surfaces = faces.iter().flatten();
        ensure(surfaces.all(|s| (*s as usize) < known), place, || {
            format!("a surface is out of range: there are {known}")
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Material, Rgb, Scene};
    use glam::{DMat4, DVec3};

    fn scene(change: impl Fn(&mut Rtrace)) -> Scene {
        let mut scene = Scene::default();
        scene.add_material(Material::diffuse("a", Rgb::grey(0.5)));
        let mut rtrace = Rtrace {
            look: -DVec3::Z,
            up: DVec3::Y,
            half_angles: [0.4, 0.3],
            surfaces: vec![RtraceSurface::default()],
            materials: vec![RtraceMaterial {
                ior: 1.0,
                ..RtraceMaterial::default()
            }],
            ..Rtrace::default()
        };
        change(&mut rtrace);
        scene.rtrace = Some(Box::new(rtrace));
        scene
    }

    #[test]
    fn what_is_drawn_may_be_relied_on() {
        let check = |change: fn(&mut Rtrace), expected: Option<&str>| {
            let place = scene(change).validate().err().map(|e| e.place);
            assert_eq!(place.as_deref(), expected);
        };
        check(|_| {}, None);
        check(|r| r.up = DVec3::Z, Some("rtrace: view"));
        check(|r| r.half_angles[1] = 2.0, Some("rtrace: view"));
        check(|r| r.ambient.g = -1.0, Some("rtrace: colours"));
        check(
            |r| r.surfaces[0].phong = f64::NAN,
            Some("rtrace: surfaces[0]"),
        );
        check(|r| r.materials.clear(), None);
        check(
            |r| r.materials.push(r.materials[0].clone()),
            Some("rtrace: materials"),
        );
        check(|r| r.materials[0].surface = 1, Some("rtrace: materials[0]"));
        check(
            |r| {
                r.materials[0].inline_textures.push(RtraceTexture {
                    texture_from_point: DMat4::IDENTITY,
                    matrix: DMat4::IDENTITY,
                    file: String::new(),
                    kind: RtraceTextureKind::Checker { surface: 9 },
                });
            },
            Some("rtrace: materials[0]"),
        );
        check(
            |r| {
                r.lights.push(RtraceLight {
                    position: DVec3::ZERO,
                    brightness: Rgb::new(0.0, -1.0, 0.0),
                    fades: [true; 3],
                    kind: RtraceLightKind::Point,
                });
            },
            Some("rtrace: lights[0]"),
        );
        check(
            |r| {
                r.corner_surfaces.insert(0, vec![[0; 3]]);
            },
            Some("rtrace: corner_surfaces[0]"),
        );
    }
}
